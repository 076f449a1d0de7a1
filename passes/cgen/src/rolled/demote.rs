//! The outputs that statements set themselves.
//!
//! A statement sets the output that is its value's alone if it does so in
//! every pass of its loop, and always in the same array. Otherwise the output
//! becomes a copy, made when everything is computed.

use super::nest::Nest;
use super::program::coordinates;
use super::statements::{StatementTarget, Statements};
use robovec_ir::{Function, Output, Value};

/// For each value the output its statement sets.
pub(super) struct Outputs {
    elements: Vec<Option<(usize, [i64; 2])>>,
}

impl Outputs {
    /// Chooses the outputs of statements, and appends copies of the others.
    pub(super) fn new(
        function: &Function,
        statements: &mut Statements,
        nest: &mut Nest,
    ) -> Outputs {
        let mut elements = vec![None; function.nodes().len()];
        let mut demoted: Vec<(Output, Value)> = Vec::new();
        for position in &nest.positions {
            let outputs: Vec<(Value, Option<Output>)> = position
                .statements
                .iter()
                .filter_map(
                    |&statement| match statements.list[statement as usize].target {
                        StatementTarget::Value(value) => Some((value, statements.primary(value))),
                        StatementTarget::Output(_) => None,
                    },
                )
                .collect();
            let first = outputs.first().and_then(|(_, output)| *output);
            let first = first.map(|output| element(function, output).0);
            let one_array = first.is_some()
                && outputs
                    .iter()
                    .all(|(_, output)| output.map(|output| element(function, output).0) == first);
            for (value, output) in outputs {
                let Some(output) = output else { continue };
                if one_array {
                    elements[value.index()] = Some(element(function, output));
                } else {
                    demoted.push((output, value));
                }
            }
        }
        demoted.sort_unstable();
        for (output, value) in demoted {
            let statement = statements.append(output, value.into());
            nest.append(statement);
        }
        Outputs { elements }
    }

    /// The output array and element that a value's statement sets.
    pub(super) fn element(&self, value: Value) -> Option<(usize, [i64; 2])> {
        self.elements[value.index()]
    }
}

/// An output as array and element.
pub(super) fn element(function: &Function, output: Output) -> (usize, [i64; 2]) {
    let (array, indices, _) = function.output_element(output);
    (function.output_array(output), coordinates(array, indices))
}
