//! Extents that the reader could not infer.
//!
//! Robotran's files do not declare their arrays: the reader knows those with an
//! element per joint and infers the size of the others from the largest index
//! used. An array of another extent is named in a line of the header, which
//! Robotran ignores.

use super::arrays::{ArrayRole, FileArrays};
use crate::conventions::least_extent;
use hashbrown::HashSet;
use robovec_ir::{Function, Shape};
use rustc_hash::FxBuildHasher;
use std::fmt::Write;

/// The entry of the header, `dpt(3,12) h(4)`; `None` when no entry is needed.
pub(super) fn line(functions: &[&Function], arrays: &FileArrays, joints: u32) -> Option<String> {
    let forces = forces(functions);
    let mut line = String::new();
    for array in arrays.all.iter().filter(|array| array.is_used()) {
        let (rows, columns) = array.largest;
        let (known_rows, known_columns) = least_extent(&array.name, joints);
        let force = array.role == ArrayRole::Result && forces.contains(array.name.as_str());
        let nine = if force { 9 } else { 0 };
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

/// The results of external forces, which have nine numbers.
fn forces<'a>(functions: &[&'a Function]) -> HashSet<&'a str, FxBuildHasher> {
    let calls = functions.iter().flat_map(|function| &function.boundaries);
    let external = calls.filter(|call| {
        matches!(
            call.callee.as_str(),
            "user_ExtForces" | "user_call_ExtForces" | "usrfun.fext"
        )
    });
    external.filter_map(|call| call.result.as_deref()).collect()
}
