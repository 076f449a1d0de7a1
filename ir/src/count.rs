//! Counts of a function: operations and longest chain.
//!
//! The tables of the thesis count an operation for every `+ - * /`, every
//! square root and every minus sign before a term; sines and cosines come
//! from the host and are not counted. Robotran's own "flops" add one for each
//! of them.

use crate::entity::Operand;
use crate::function::{Assignment, Function, Level};
use robovec_num::operation::Operation;
use serde::Serialize;

/// The numbers of a function's operations.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Serialize)]
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
    /// Fused multiply-adds, each one operation.
    #[serde(skip)]
    pub fused: usize,
    /// Sines and cosines.
    pub sin_cos: usize,
    /// Signs: negations, or subtractions from a literal zero.
    pub negations: usize,
    /// The thesis' "vectors": the number of groups of equations when each group
    /// depends only on those before it. This is the number of equations on the
    /// longest chain of equations, outputs included, sines and cosines (which
    /// the host prepares) not.
    pub vectors: usize,
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
                Operation::Fma | Operation::Fms | Operation::Fnma => counts.fused += 1,
            }
        }
        for assignment in &function.assignments {
            counts.equations += usize::from(!is_same_equation(function, assignment));
        }
        counts.operations = Counts::operations_of(function);
        counts.vectors = vectors(function);
        counts
    }

    /// The operations alone ([`Counts::operations`]), for a fraction of the
    /// time that all counts take.
    pub fn operations_of(function: &Function) -> usize {
        // A negation is an operation of the machine only where it is a
        // subtraction from zero still to be written.
        let signs = function.level == Level::Equations;
        let counts = |operation: Operation| match operation {
            Operation::Copy | Operation::Sin | Operation::Cos => false,
            Operation::Neg => signs,
            _ => true,
        };
        let nodes = function.nodes().iter();
        nodes.filter(|node| counts(node.operation)).count()
    }
}

/// The longest chain of equations; see [`Counts::vectors`].
fn vectors(function: &Function) -> usize {
    let mut levels: Vec<u32> = Vec::with_capacity(function.nodes().len());
    for node in function.nodes() {
        let inside = node.values().map(|value| levels[value.index()]);
        let inside = inside.fold(0, u32::max);
        let counts = !node.name.is_none() && !node.operation.is_trigonometric();
        levels.push(inside + u32::from(counts));
    }
    let outputs = function.assignments.iter().map(|assignment| {
        let own = !is_same_equation(function, assignment);
        assignment.operand.entry_or_default(&levels) + u32::from(own)
    });
    let longest = outputs.chain(levels.iter().copied());
    longest.fold(0, u32::max) as usize
}

/// True when an output element takes the value of a named node that was made
/// by the very same equation (`frc[1][6] = ...`, read back further down).
fn is_same_equation(function: &Function, assignment: &Assignment) -> bool {
    let named = |operand: Operand| {
        let node = function.node(operand.value()?);
        (!node.name.is_none()).then_some(node)
    };
    named(assignment.operand).is_some_and(|node| node.sources == assignment.sources)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::function::{Node, Shape};
    use crate::source::SourceSet;
    use crate::symbol::{Name, Symbols};
    use crate::{Input, Output, Value};

    fn node<const COUNT: usize>(
        name: Name,
        operation: Operation,
        operands: [Operand; COUNT],
    ) -> Node {
        Node {
            name,
            sources: SourceSet::EMPTY,
            operands: Operand::list(operands),
            operation,
        }
    }

    #[test]
    fn equations_operations_and_vectors_are_counted_as_the_thesis_does() {
        let mut symbols = Symbols::default();
        let mut function = Function::new("f", Level::Equations);
        function.add_input(symbols.intern("q"), Shape::Vector(1));
        function.add_output(symbols.intern("c"), Shape::Vector(1));
        let q = Operand::from(Input(0));
        // S = sin(q); A = -(S*q); c = A + q.
        let sine = Name::plain(symbols.intern("S"));
        let sine = function.push(node(sine, Operation::Sin, [q]));
        let product = function.push(node(Name::NONE, Operation::Mul, [sine.into(), q]));
        let minus = Name::plain(symbols.intern("A"));
        let minus = node(minus, Operation::Neg, [product.into()]);
        let minus: Value = function.push(minus);
        let sum = function.push(node(Name::NONE, Operation::Add, [minus.into(), q]));
        function.assign(Output(0), sum.into(), SourceSet::EMPTY);
        let counts = Counts::of(&function);
        assert_eq!(counts.equations, 3);
        assert_eq!(counts.operations, 3);
        assert_eq!((counts.add_sub, counts.mul, counts.negations), (1, 1, 1));
        assert_eq!(counts.sin_cos, 1);
        assert_eq!(counts.vectors, 2);
    }
}
