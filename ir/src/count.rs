//! What a function costs, counted.
//!
//! The tables of the thesis count an operation for every `+ - * /`, every
//! square root and every minus sign before a term; sines and cosines come
//! from the host and are not counted. Robotran's own "flops" add one for each
//! of them.

use crate::entity::Operand;
use crate::function::{Function, Level};
use crate::operation::Operation;

/// The numbers of a function's operations.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Counts {
    /// Assignments: named values and output elements. An output element that
    /// is one and the same equation as the value it takes counts once.
    pub equations: usize,
    /// Everything but sines, cosines and copies.
    pub operations: usize,
    /// Additions and subtractions; below the equations level this includes
    /// negations, which are subtractions from zero there.
    pub add_sub: usize,
    /// Multiplications.
    pub mul: usize,
    /// Divisions.
    pub div: usize,
    /// Square roots.
    pub sqrt: usize,
    /// Sines and cosines.
    pub sin_cos: usize,
    /// Signs: negations, or subtractions from a literal zero.
    pub negations: usize,
}

impl Counts {
    /// Counts a function.
    pub fn of(function: &Function) -> Counts {
        let mut counts = Counts::default();
        for node in function.nodes() {
            counts.equations += usize::from(!node.name.is_none());
            match node.operation {
                Operation::Copy => {}
                Operation::Neg => counts.negations += 1,
                Operation::Add => counts.add_sub += 1,
                Operation::Sub => {
                    counts.add_sub += 1;
                    if function.number(node.operands[0]) == Some(0.0) {
                        counts.negations += 1;
                    }
                }
                Operation::Mul => counts.mul += 1,
                Operation::Div => counts.div += 1,
                Operation::Sin | Operation::Cos => counts.sin_cos += 1,
                Operation::Sqrt => counts.sqrt += 1,
            }
        }
        for assignment in &function.assignments {
            counts.equations += usize::from(!is_same_equation(function, assignment));
        }
        counts.operations = counts.add_sub + counts.mul + counts.div + counts.sqrt;
        if function.level == Level::Equations {
            counts.operations += function
                .nodes()
                .iter()
                .filter(|node| node.operation == Operation::Neg)
                .count();
        }
        counts
    }
}

/// True when an output element takes the value of a named node that was made
/// by the very same equation (`frc[1][6] = ...`, read back further down).
fn is_same_equation(function: &Function, assignment: &crate::Assignment) -> bool {
    let named = |operand: Operand| {
        let node = function.node(operand.value()?);
        (!node.name.is_none()).then_some(node)
    };
    named(assignment.operand).is_some_and(|node| node.sources == assignment.sources)
}
