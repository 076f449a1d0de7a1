//! Counting equations and operations.

use robovec_ir::{Function, Operand, Operation};
use serde::Serialize;

/// How much a function computes.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Serialize)]
pub struct Counts {
    /// Definitions and output assignments.
    pub equations: usize,
    /// Everything a processing element does: additions, subtractions,
    /// multiplications, divisions, square roots and minus signs.
    pub operations: usize,
    /// Additions and subtractions.
    pub add_sub: usize,
    /// Multiplications.
    pub mul: usize,
    /// Divisions.
    pub div: usize,
    /// Square roots.
    pub sqrt: usize,
    /// Sines and cosines, which the host evaluates.
    pub sin_cos: usize,
    /// Minus signs, `0 - x` among them.
    pub negations: usize,
    /// Vectors of mutually independent equations: how many equations the
    /// longest chain of equations has.
    pub vectors: usize,
}

impl Counts {
    /// Counts in one sweep.
    pub fn of(function: &Function) -> Counts {
        let mut counts = Counts {
            equations: function.assignments.len(),
            ..Counts::default()
        };
        let mut levels: Vec<usize> = Vec::with_capacity(function.nodes().len());
        for node in function.nodes() {
            let named = !node.name.is_none();
            counts.equations += usize::from(named);
            match node.operation {
                Operation::Copy => {}
                Operation::Neg => counts.negations += 1,
                Operation::Sub if is_zero(function, node.operands[0]) => counts.negations += 1,
                Operation::Add | Operation::Sub => counts.add_sub += 1,
                Operation::Mul => counts.mul += 1,
                Operation::Div => counts.div += 1,
                Operation::Sqrt => counts.sqrt += 1,
                Operation::Sin | Operation::Cos => counts.sin_cos += 1,
            }
            let operands = node.operands().iter().filter_map(|operand| operand.value());
            let before = operands.map(|value| levels[value.index()]).max();
            levels.push(before.unwrap_or(0) + usize::from(named));
        }
        counts.operations =
            counts.add_sub + counts.mul + counts.div + counts.sqrt + counts.negations;
        counts.vectors = levels.into_iter().max().unwrap_or(0);
        counts
    }
}

fn is_zero(function: &Function, operand: Operand) -> bool {
    function.number(operand) == Some(0.0)
}
