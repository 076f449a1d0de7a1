//! Extents that the reader would not find out by itself.
//!
//! Robotran's files do not declare their arrays: the reader knows those with
//! an element per joint and takes the others to end where their use ends. An
//! array of another extent is named in a line of the header, which means
//! nothing to Robotran.

use super::arrays::{Arrays, FileArray, Role};
use crate::robotran::storage::known_extent;
use hashbrown::HashMap;
use robovec_ir::{Function, Input, OperandKind, Shape, Symbol};
use rustc_hash::FxBuildHasher;
use std::fmt::Write;

/// The entry of the header, `dpt(3,12) h(4)`; `None` when nothing needs to be
/// said.
pub(super) fn line(functions: &[&Function], arrays: &Arrays, joints: u32) -> Option<String> {
    let used = used(functions);
    let mut line = String::new();
    for array in &arrays.all {
        let Some(&(rows, columns)) = used.get(&array.symbol) else {
            continue;
        };
        let (known_rows, known_columns) = known_extent(&array.name, joints).unwrap_or((0, 0));
        let nine = if is_force(functions, array) { 9 } else { 0 };
        let rows = rows.max(known_rows).max(nine).max(1);
        let columns = columns.max(known_columns).max(1);
        // Writing to a string cannot fail.
        let _ = match array.shape {
            Shape::Vector(length) if length != rows => write!(line, " {}({length})", array.name),
            Shape::Matrix(m, n) if (m, n) != (rows, columns) => {
                write!(line, " {}({m},{n})", array.name)
            }
            Shape::Scalar | Shape::Vector(_) | Shape::Matrix(..) => Ok(()),
        };
    }
    (!line.is_empty()).then(|| line.trim_start().to_owned())
}

/// The largest indices of every array that is used at all.
fn used(functions: &[&Function]) -> HashMap<Symbol, (u32, u32), FxBuildHasher> {
    let mut used: HashMap<Symbol, (u32, u32), FxBuildHasher> = HashMap::default();
    let mut note = |symbol: Symbol, indices: [u32; 2]| {
        let largest = used.entry(symbol).or_default();
        largest.0 = largest.0.max(indices[0]);
        largest.1 = largest.1.max(indices[1]);
    };
    for function in functions {
        let mut read = vec![false; function.input_len()];
        let nodes = function.nodes().iter().flat_map(|node| node.operands());
        let outputs = function.assignments.iter().map(|output| &output.operand);
        for operand in nodes.chain(outputs) {
            if let OperandKind::Input(input) = operand.kind() {
                read[input.index()] = true;
            }
        }
        for place in (0..read.len()).filter(|&place| read[place]) {
            let (array, indices, _) = function.input_element(Input(place as u32));
            note(array.name, indices);
        }
        for assignment in &function.assignments {
            let (array, indices, _) = function.output_element(assignment.output);
            note(array.name, indices);
        }
    }
    used
}

/// True for the result of an external force, which has nine numbers.
fn is_force(functions: &[&Function], array: &FileArray) -> bool {
    array.role == Role::Result
        && functions
            .iter()
            .flat_map(|function| &function.boundaries)
            .any(|call| {
                call.result.as_deref() == Some(&array.name)
                    && matches!(
                        call.callee.as_str(),
                        "user_ExtForces" | "user_call_ExtForces" | "usrfun.fext"
                    )
            })
}
