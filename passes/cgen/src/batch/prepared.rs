//! The numbers that all states share, computed once.
//!
//! Of the operations of a real file a tenth combines parameters only. They are
//! computed as plain numbers, in parts like the others; values that a part
//! reads from an earlier one are prepared as well, so that no second array is
//! needed.

use super::plan::BatchPlan;
use robovec_analysis::slice::slice;
use robovec_ir::{Function, Value};

/// The code that prepares numbers for all states.
pub(super) struct Prepared {
    /// For each part the values it computes.
    pub(super) parts: Vec<Vec<Value>>,
    /// For each value the part that computes it, if any.
    pub(super) part_of: Vec<Option<usize>>,
}

impl Prepared {
    /// Divides the prepared values into parts. Adds to the prepared numbers
    /// those that cross from part to part.
    pub(super) fn new(function: &Function, plan: &mut BatchPlan, part: u32) -> Prepared {
        let values = slice(function, &plan.prepared);
        let mut part_of = vec![None; function.nodes().len()];
        let size = part.max(1) as usize;
        for (index, value) in values.iter().enumerate() {
            part_of[value.index()] = Some(index / size);
        }
        for &value in &values {
            for &operand in function.node(value).operands() {
                let crosses = |other: Value| part_of[other.index()] != part_of[value.index()];
                if operand.value().is_some_and(crosses) {
                    plan.share(function, operand);
                }
            }
        }
        Prepared {
            parts: values.chunks(size).map(<[Value]>::to_vec).collect(),
            part_of,
        }
    }
}
