//! Errors relative to the allowed ones.

use crate::accurate::measure::reference_states;
use robovec_analysis::accuracy::distance;
use robovec_framework::scene::Allowed;
use robovec_ir::evaluate::evaluate_nodes_in;
use robovec_ir::states::States;
use robovec_ir::{Format, Function, OperandKind, ValueFormats, View};
use robovec_num::double_double::Double;

/// Exact outputs at some states, and their allowed errors.
pub(super) struct AccuracyCheck {
    inputs: Vec<Vec<f64>>,
    exact: Vec<Vec<Double>>,
    allowed: Vec<Vec<f64>>,
}

impl AccuracyCheck {
    /// Evaluates the function in double-double at `count` states from
    /// `first` on.
    pub(super) fn new(
        view: View<'_>,
        states: &States,
        [first, count]: [u32; 2],
        allowed: &Allowed,
    ) -> AccuracyCheck {
        let (inputs, exact) = reference_states(view, states, first..first + count);
        let allowed = exact.iter().map(|outputs| {
            let values: Vec<f64> = outputs.iter().map(|output| output.high).collect();
            allowed.of(&values)
        });
        AccuracyCheck {
            allowed: allowed.collect(),
            inputs,
            exact,
        }
    }

    /// For every assignment the largest ratio of an error to the allowed one.
    pub(super) fn ratios(&self, function: &Function, formats: &ValueFormats) -> Vec<f64> {
        let mut ratios = vec![0.0f64; function.assignments.len()];
        for ((inputs, exact), allowed) in self.inputs.iter().zip(&self.exact).zip(&self.allowed) {
            // Inputs are numbers of binary32, so that of the run changes none.
            let values = evaluate_nodes_in(function, Some(formats), Format::BINARY64, inputs);
            for (place, assignment) in function.assignments.iter().enumerate() {
                let OperandKind::Value(value) = assignment.operand.kind() else {
                    continue;
                };
                let ratio = ratio(exact[place], values[value.index()], allowed[place]);
                ratios[place] = ratios[place].max(ratio);
            }
        }
        ratios
    }

    /// The largest ratio of an error to the allowed one.
    pub(super) fn worst(&self, function: &Function, formats: &ValueFormats) -> f64 {
        self.ratios(function, formats)
            .into_iter()
            .fold(0.0, f64::max)
    }
}

/// An error divided by the allowed one; undefined where the exact number is not
/// finite.
fn ratio(exact: Double, computed: f64, allowed: f64) -> f64 {
    let distance = distance(exact, computed);
    if distance == 0.0 || distance.is_nan() {
        0.0
    } else {
        distance / allowed
    }
}
