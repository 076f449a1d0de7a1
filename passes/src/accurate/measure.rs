//! Measured errors of a function and of its new version.
//!
//! Passes that promise equality over the real numbers share one reference: the
//! outputs of the function they were given, in double-double. An element counts
//! relative to itself unless it is only rounding beside the largest of its
//! array, an array by its largest error over its largest element, as in
//! [`robovec_analysis::accuracy`].

use robovec_analysis::accuracy::{VANISHING, distance, evaluate_at};
use robovec_analysis::rounding::quantile;
use robovec_ir::states::States;
use robovec_ir::{Format, Function, View};
use robovec_num::arithmetic::{Binary32, Binary64};
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::soft_float::FormatArithmetic;
use std::ops::Range;

/// Inputs and exact outputs in some states.
pub(crate) struct ReferenceOutputs {
    inputs: Vec<Vec<f64>>,
    exact: Vec<Vec<Double>>,
    /// The output array of every assignment.
    arrays: Vec<usize>,
    count: usize,
}

/// The inputs of a function in some states, and its outputs there in
/// double-double.
pub(crate) fn reference_states(
    view: View<'_>,
    states: &States,
    numbers: Range<u32>,
) -> (Vec<Vec<f64>>, Vec<Vec<Double>>) {
    let inputs: Vec<Vec<f64>> = numbers.map(|number| states.draw(view, number)).collect();
    let exact = |state: &Vec<f64>| evaluate_at(view.function, &DoubleDouble, state);
    let exact = inputs.iter().map(exact).collect();
    (inputs, exact)
}

/// Errors over all states, relative to the numbers themselves (no units).
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub(crate) struct Errors {
    /// The median over all elements and states, relative to the element.
    pub(crate) relative: f64,
    /// Median, 90th and 99th percentile and largest over all arrays and
    /// states, relative to the array's largest element.
    pub(crate) normwise: [f64; 4],
}

impl ReferenceOutputs {
    /// Evaluates a function in double-double at some states.
    pub(crate) fn new(view: View<'_>, states: &States, first: u32, count: u32) -> ReferenceOutputs {
        let (inputs, exact) = reference_states(view, states, first..first + count);
        let function = view.function;
        let assignments = function.assignments.iter();
        ReferenceOutputs {
            exact,
            inputs,
            arrays: assignments
                .map(|a| function.output_array(a.output))
                .collect(),
            count: function.outputs().len(),
        }
    }

    pub(crate) fn errors(&self, function: &Function, format: Format) -> Errors {
        match format {
            Format::BINARY32 => self.errors_of(|state| {
                let outputs = evaluate_at(function, &Binary32, state);
                outputs.into_iter().map(f64::from).collect()
            }),
            Format::BINARY64 => self.errors_of(|state| evaluate_at(function, &Binary64, state)),
            _ => {
                let arithmetic = FormatArithmetic::new(format);
                self.errors_of(|state| evaluate_at(function, &arithmetic, state))
            }
        }
    }

    /// The errors of outputs, computed from the inputs of each state.
    fn errors_of(&self, outputs: impl Fn(&[f64]) -> Vec<f64>) -> Errors {
        let (mut relative, mut normwise) = (Vec::new(), Vec::new());
        for (state, exact) in self.inputs.iter().zip(&self.exact) {
            let computed = outputs(state);
            let mut norms = vec![(0.0f64, 0.0f64); self.count];
            let mut distances = Vec::with_capacity(exact.len());
            for ((exact, computed), &array) in exact.iter().zip(computed).zip(&self.arrays) {
                let distance = distance(*exact, computed);
                distances.push(distance);
                if !distance.is_nan() {
                    let norm = &mut norms[array];
                    *norm = (norm.0.max(distance), norm.1.max(exact.high.abs()));
                }
            }
            for ((exact, &distance), &array) in exact.iter().zip(&distances).zip(&self.arrays) {
                let size = exact.high.abs();
                if !distance.is_nan() && size > norms[array].1 * VANISHING {
                    relative.push(distance / size);
                }
            }
            let present = norms.iter().filter(|(_, size)| *size > 0.0);
            normwise.extend(present.map(|(error, size)| error / size));
        }
        Errors {
            relative: quantile(&mut relative, 1, 2).unwrap_or(0.0),
            normwise: [(1, 2), (9, 10), (99, 100), (1, 1)]
                .map(|(part, of)| quantile(&mut normwise, part, of).unwrap_or(0.0)),
        }
    }
}

impl Errors {
    /// Tests whether these are no worse than others: neither the medians nor
    /// the 90th percentile grow by more than two per cent, which may be chance,
    /// and together they do not grow.
    pub(crate) fn no_worse_than(&self, other: &Errors) -> bool {
        let pairs = [
            (self.relative, other.relative),
            (self.normwise[0], other.normwise[0]),
            (self.normwise[1], other.normwise[1]),
        ];
        let each = pairs.iter().all(|(new, old)| *new <= old * 1.02);
        each && self.score() <= other.score()
    }

    /// One number to choose by: the geometric mean of the two medians and of
    /// the 90th percentile of the normwise error (the 99th is that of a few
    /// numbers, and so is mostly chance).
    pub(crate) fn score(&self) -> f64 {
        // Zeros must not hide the others.
        let [median, most, ..] = self.normwise.map(|error| error.max(1e-40));
        let logarithms = self.relative.max(1e-40).log2() + median.log2() + most.log2();
        (logarithms / 3.0).exp2()
    }
}
