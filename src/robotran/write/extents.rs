//! Extents that the reader would not find out by itself.
//!
//! Robotran's files do not declare their arrays: the reader knows those with
//! an element per joint and takes the others to end where their use ends. An
//! array of another extent is named in a line of the header, which means
//! nothing to Robotran.

use super::arrays::{Arrays, FileArray, Role};
use crate::robotran::storage::known_extent;
use robovec_ir::{Function, Shape};
use std::fmt::Write;

/// The entry of the header, `dpt(3,12) h(4)`; `None` when nothing needs to be
/// said.
pub(super) fn line(functions: &[&Function], arrays: &Arrays, joints: u32) -> Option<String> {
    let mut line = String::new();
    for array in arrays.all.iter().filter(|array| array.is_used()) {
        let (rows, columns) = array.largest;
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
