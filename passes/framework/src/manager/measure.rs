//! The measurements around a pass: time, memory, size, change.

use crate::pass::{PassError, PassInfo, Property};
use robovec_analysis::critical_path::{Weights, arrivals, longest};
use robovec_ir::{Function, Machine, Node, Operation, ValueFormats};
use rustc_hash::FxHasher;
use std::hash::{Hash, Hasher};

/// Measures CPU time from its start.
pub(super) struct Meter {
    start: f64,
}

impl Meter {
    pub(super) fn start() -> Meter {
        Meter { start: usage().0 }
    }

    /// CPU seconds since the start, and the largest memory so far in MB.
    pub(super) fn stop(self) -> (f64, f64) {
        let (now, peak) = usage();
        (now - self.start, peak)
    }
}

/// CPU seconds and peak memory (MB of 10^6 bytes) of the process so far.
#[cfg(unix)]
pub fn usage() -> (f64, f64) {
    use nix::sys::resource::{UsageWho, getrusage};
    use nix::sys::time::TimeValLike;
    let usage = getrusage(UsageWho::RUSAGE_SELF).expect("a process may ask for its own usage");
    let microseconds =
        usage.user_time().num_microseconds() + usage.system_time().num_microseconds();
    // Kilobytes of 1024 bytes, except on macOS, which counts bytes.
    let unit = if cfg!(target_os = "macos") {
        1.0
    } else {
        1024.0
    };
    (
        microseconds as f64 * 1e-6,
        usage.max_rss() as f64 * unit * 1e-6,
    )
}

/// CPU seconds and peak memory of the process: zeros where the system does
/// not show.
#[cfg(not(unix))]
pub fn usage() -> (f64, f64) {
    (0.0, 0.0)
}

/// A hash of the operations and outputs alone, on which every number depends.
pub(super) fn computation(function: &Function) -> u64 {
    let mut hasher = FxHasher::default();
    for node in function.nodes() {
        hash_operation(node, &mut hasher);
    }
    hash_outputs(function, &mut hasher);
    hasher.finish()
}

fn hash_operation(node: &Node, hasher: &mut FxHasher) {
    let [a, b, c] = node.operands.map(|operand| u64::from(operand.bits()));
    hasher.write_u64((node.operation as u64) << 32 | a);
    hasher.write_u64(b << 32 | c);
}

/// Hash of all that decides the numbers beside the operations.
fn hash_outputs(function: &Function, hasher: &mut FxHasher) {
    for assignment in &function.assignments {
        (assignment.output, assignment.operand).hash(hasher);
    }
    for constant in function.constants() {
        constant.to_bits().hash(hasher);
    }
    for format in function.formats.iter().flat_map(ValueFormats::iter) {
        format.hash(hasher);
    }
}

/// A hash of all that a pass can change, to test whether it did.
pub(super) fn fingerprint(function: &Function) -> u64 {
    // Two hashes in one walk over the nodes: neither waits for the other.
    let (mut computed, mut hasher) = (FxHasher::default(), FxHasher::default());
    for node in function.nodes() {
        hash_operation(node, &mut computed);
        hasher.write_u64(u64::from(node.name.base.0) << 32 | u64::from(node.name.suffix));
        node.sources.hash(&mut hasher);
    }
    hash_outputs(function, &mut computed);
    computed.finish().hash(&mut hasher);
    function.level.hash(&mut hasher);
    for assignment in &function.assignments {
        assignment.sources.hash(&mut hasher);
    }
    for timing in function.timing.iter().flatten() {
        (
            timing.asap,
            timing.alap,
            timing.asap_cycle,
            timing.alap_cycle,
        )
            .hash(&mut hasher);
    }
    if let Some(schedule) = &function.schedule {
        for slot in &schedule.slots {
            slot.map(|slot| (slot.cycle, slot.element))
                .hash(&mut hasher);
        }
    }
    if let Some(placement) = &function.placement {
        (placement.reads.as_slice(), placement.buffers.as_slice()).hash(&mut hasher);
        for write in &placement.writes {
            (write.word, write.cycle).hash(&mut hasher);
        }
    }
    hasher.finish()
}

/// Operations (everything but sines, cosines and copies) and the longest
/// chain in cycles.
pub(super) fn size(function: &Function, machine: &Machine) -> (u64, u32) {
    let operations = function
        .nodes()
        .iter()
        .filter(|node| !node.operation.is_trigonometric() && node.operation != Operation::Copy)
        .count();
    let arrivals = arrivals(function, &Weights::cycles(machine));
    (operations as u64, longest(&arrivals))
}

/// Refuses the result of a pass that rewrote the function without reporting the
/// new number formats of its values.
pub(super) fn check_formats(had: bool, function: &Function) -> Result<(), PassError> {
    if !had || function.formats.is_some() {
        return Ok(());
    }
    let error = PassError::new("the number formats of the values would be lost");
    Err(error.help("give values their formats after this pass"))
}

/// Removes attributes that a pass has made untrue.
pub(super) fn forget_stale_properties(info: &PassInfo, function: &mut Function) {
    if info.destroys.contains(&Property::Timed) {
        function.timing = None;
    }
}
