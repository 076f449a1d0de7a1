//! The reasons that keep a function from being placed.

use robovec_ir::machine::BUILT_IN;
use robovec_ir::{Level, Machine, Value};

/// The reason why a function cannot be placed on a machine.
///
/// Nodes are named by their [`Value`]; the caller has the tables that turn
/// one into a name and a place in the user's file.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum PlaceError {
    /// Placement takes atomic functions (or places a placed one again).
    #[error("placement takes a function at level atomic, not {level}")]
    NotAtomic {
        /// The function's level.
        level: Level,
    },
    /// The machine has no kind of element for an operation.
    #[error(
        "no processing element of the machine '{machine}' performs {operation}; {}",
        performers(operation)
    )]
    NotPerformed {
        /// The node.
        value: Value,
        /// Name of the operation.
        operation: &'static str,
        /// Name of the machine.
        machine: String,
    },
    /// The host evaluates sine and cosine before the run, so their argument
    /// cannot be computed by the machine.
    #[error(
        "the host evaluates {operation} before the run, but its argument is computed during the run"
    )]
    ComputedAngle {
        /// The sine or cosine.
        value: Value,
        /// Name of the operation.
        operation: &'static str,
    },
    /// The machine's memories cannot be written.
    #[error("the memories of the machine '{machine}' take no writes")]
    NoWritePorts {
        /// Name of the machine.
        machine: String,
    },
    /// The number of words alive at once exceeds the size of a memory.
    #[error("the memory of {element} needs {needed} words but has {available}")]
    MemoryTooSmall {
        /// The memory as in the text form, such as `add0` or `multi3.left`.
        element: String,
        /// Words alive at once.
        needed: u32,
        /// Number of available words.
        available: u32,
    },
    /// Numbers of cycles, or the tables over them, would become too large.
    #[error(
        "the longest chain takes {path} cycles, beyond the {limit} a schedule of this function \
         on this machine may have"
    )]
    TooLong {
        /// Cycles of the longest chain.
        path: u64,
        /// The largest length supported.
        limit: u64,
    },
}

/// Shipped machines that perform an operation, in words.
fn performers(operation: &str) -> String {
    let performs = |name: &str| {
        let machine = Machine::built_in(name).expect("it ships");
        let mut known = machine.elements.iter().flat_map(|kind| &kind.operations);
        known.any(|known| known == operation)
    };
    let names = BUILT_IN.iter().map(|(name, _)| *name);
    let names: Vec<&str> = names.filter(|name| performs(name)).collect();
    if names.is_empty() {
        "no shipped machine does".to_owned()
    } else {
        format!("{} does", names.join(", "))
    }
}
