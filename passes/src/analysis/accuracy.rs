//! Rounding errors: every output in binary32 and binary64 against
//! double-double, over seeded random states.
//!
//! Three measures, since each alone misleads (an element that is nearly zero
//! has a huge relative error and does no harm, a sum of large elements hides
//! a small wrong one):
//!
//! - *relative*: `|computed - exact| / |exact|`, element by element;
//! - *ulps*: the same distance in units in the last place of the exact value,
//!   in the format computed with;
//! - *normwise*: the largest error of an array over its largest element.
//!
//! An element that is below 2⁻⁷⁰ of the largest of its array is zero but for
//! the reference's own rounding (an entry of a mass matrix that vanishes by
//! symmetry): it has no relative error and *vanishes* in that state, and only
//! the normwise measure sees it. A computed number that is not finite where
//! the exact one is has an infinite error. States in which the exact
//! value is itself not finite say nothing and are left out; an output without
//! any other state has the error NaN. Inputs are representable in binary32
//! ([`States`]), so what is measured is the rounding of the program, not of
//! its data; literals that a format cannot hold do count.

use robovec_ir::arithmetic::{Arithmetic, Binary32, Binary64};
use robovec_ir::batch::Batch;
use robovec_ir::double_double::{Double, DoubleDouble};
use robovec_ir::evaluate::evaluate;
use robovec_ir::format::Format;
use robovec_ir::states::States;
use robovec_ir::{Output, View};
use std::array;

/// Median and worst case of an error over all states.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Spread {
    /// Half of the states are at or below it.
    pub median: f64,
    /// The largest.
    pub worst: f64,
}

/// The error of one output element.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ElementError {
    /// Which element.
    pub output: Output,
    /// Relative to the exact value.
    pub relative: Spread,
    /// In units in the last place of the exact value.
    pub ulps: Spread,
    /// The number of the state with the largest relative error, as
    /// [`States::draw`] counts.
    pub worst_state: u32,
    /// In how many states it vanishes without being computed as zero.
    pub vanishing: u32,
}

/// The error of one output array.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ArrayError {
    /// Index into [`robovec_ir::Function::outputs`].
    pub array: usize,
    /// Largest error over largest element.
    pub normwise: Spread,
}

/// The errors in one number format.
#[derive(Clone, PartialEq, Debug)]
pub struct FormatAccuracy {
    /// What was computed with.
    pub format: Format,
    /// One entry per assignment, in the function's order.
    pub elements: Vec<ElementError>,
    /// One entry per output array that has an assignment.
    pub arrays: Vec<ArrayError>,
}

/// The errors of a function.
#[derive(Clone, PartialEq, Debug)]
pub struct Accuracy {
    /// How many states were drawn.
    pub states: u32,
    /// From which seed.
    pub seed: u64,
    /// One entry per format, in the order they were asked for.
    pub formats: Vec<FormatAccuracy>,
}

impl Accuracy {
    /// The errors in a format; `None` when it was not measured.
    pub fn of(&self, format: Format) -> Option<&FormatAccuracy> {
        self.formats.iter().find(|entry| entry.format == format)
    }
}

/// The errors of a whole function in a few numbers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Summary {
    /// The median over all outputs of their median relative error.
    pub median_relative: f64,
    /// The largest normwise error of any array in any state.
    pub worst_normwise: f64,
    /// The largest error in ulps of any output in any state.
    pub worst_ulps: f64,
    /// The output with the largest error in ulps; `None` without outputs.
    pub worst_output: Option<Output>,
}

impl FormatAccuracy {
    /// The whole function in a few numbers; all 0 for one without outputs.
    pub fn summary(&self) -> Summary {
        let medians = self.elements.iter().map(|element| element.relative.median);
        let mut medians: Vec<f64> = medians.filter(|median| !median.is_nan()).collect();
        let worst = self
            .elements
            .iter()
            .filter(|element| !element.ulps.worst.is_nan())
            .max_by(|a, b| {
                let order = a.ulps.worst.total_cmp(&b.ulps.worst);
                // The first of equals, so that the choice is stable.
                order.then(b.output.cmp(&a.output))
            });
        Summary {
            median_relative: spread(&mut medians).map_or(0.0, |spread| spread.median),
            worst_normwise: self
                .arrays
                .iter()
                .map(|array| array.normwise.worst)
                .fold(0.0, f64::max),
            worst_ulps: worst.map_or(0.0, |element| element.ulps.worst),
            worst_output: worst.map(|element| element.output),
        }
    }
}

/// Measures the errors of a function in the given formats over the first
/// `count` states.
pub fn accuracy(view: View<'_>, states: &States, count: u32, formats: &[Format]) -> Accuracy {
    let mut samples: Vec<Samples> = formats
        .iter()
        .map(|&format| Samples::new(view, format))
        .collect();
    for_each_batch(view, states, count, |inputs, exact| {
        for samples in &mut samples {
            let computed = evaluate_in(view, samples.format, inputs);
            samples.add_batch(view, exact, &computed);
        }
    });
    Accuracy {
        states: count,
        seed: states.seed(),
        formats: samples.iter().map(|samples| samples.finish(view)).collect(),
    }
}

/// The errors in one format, state by state.
pub(super) fn samples(view: View<'_>, states: &States, count: u32, format: Format) -> Samples {
    let mut samples = Samples::new(view, format);
    for_each_batch(view, states, count, |inputs, exact| {
        let computed = evaluate_in(view, format, inputs);
        samples.add_batch(view, exact, &computed);
    });
    samples
}

/// Draws states and evaluates them exactly, some at a time. The exact outputs
/// of every lane that is wanted are handed on: the last batch may hold more
/// states.
fn for_each_batch(
    view: View<'_>,
    states: &States,
    count: u32,
    mut use_batch: impl FnMut(&[Vec<f64>; LANES], &[Vec<Double>]),
) {
    for first in (0..count).step_by(LANES) {
        let inputs: [Vec<f64>; LANES] =
            array::from_fn(|lane| states.draw(view, first + lane as u32));
        let exact = evaluate_lanes(view, DoubleDouble, &inputs);
        let wanted = LANES.min((count - first) as usize);
        let exact: Vec<Vec<Double>> = (0..wanted)
            .map(|lane| exact.iter().map(|lanes| lanes[lane]).collect())
            .collect();
        use_batch(&inputs, &exact);
    }
}

/// The outputs of all lanes in a format, as binary64 numbers.
fn evaluate_in(view: View<'_>, format: Format, inputs: &[Vec<f64>; LANES]) -> Vec<[f64; LANES]> {
    match format {
        Format::BINARY64 => evaluate_lanes(view, Binary64, inputs),
        Format::BINARY32 => evaluate_lanes(view, Binary32, inputs)
            .into_iter()
            .map(|lanes| lanes.map(f64::from))
            .collect(),
        // No number is what an arithmetic that is not there computes.
        _ => vec![[f64::NAN; LANES]; view.function.assignments.len()],
    }
}

/// The outputs of a function in a state, in the order of its assignments.
pub fn evaluate_at<A: Arithmetic>(
    view: View<'_>,
    arithmetic: &A,
    inputs: &[f64],
) -> Vec<A::Number> {
    let inputs: Vec<A::Number> = inputs
        .iter()
        .map(|&number| arithmetic.literal(number))
        .collect();
    evaluate(view.function, arithmetic, &inputs)
}

/// Elements smaller than this part of their array's largest are zero but for
/// rounding: 2⁻⁷⁰, far above the rounding of double-double and far below that
/// of binary64.
const VANISHING: f64 = 1.0 / (1u128 << 70) as f64;

/// Marks an element that vanishes: no error is negative.
const VANISHED: (f64, f64) = (-1.0, -1.0);

/// States evaluated at a time.
const LANES: usize = 4;

fn evaluate_lanes<A: Arithmetic + Copy>(
    view: View<'_>,
    arithmetic: A,
    inputs: &[Vec<f64>; LANES],
) -> Vec<[A::Number; LANES]> {
    let inputs: [Vec<A::Number>; LANES] = array::from_fn(|lane| {
        let numbers = inputs[lane].iter();
        numbers.map(|&number| arithmetic.literal(number)).collect()
    });
    let inputs = Batch::<A, LANES>::gather(&inputs);
    evaluate(view.function, &Batch([arithmetic; LANES]), &inputs)
}

/// Errors of one format, state after state.
pub(super) struct Samples {
    format: Format,
    /// For each state the relative errors and the errors in ulps of all
    /// assignments.
    states: Vec<Vec<(f64, f64)>>,
    /// For each state the largest error and the largest exact value of every
    /// output array.
    norms: Vec<Vec<(f64, f64)>>,
    /// The output array of every assignment.
    arrays: Vec<usize>,
}

impl Samples {
    fn new(view: View<'_>, format: Format) -> Samples {
        let outputs = view.function.outputs();
        let holds = |output: Output| {
            // As in the function: empty arrays share an offset with the next.
            outputs.partition_point(|array| array.offset <= output.0) - 1
        };
        let assignments = view.function.assignments.iter();
        Samples {
            format,
            states: Vec::new(),
            norms: Vec::new(),
            arrays: assignments.map(|a| holds(a.output)).collect(),
        }
    }

    fn add_batch(&mut self, view: View<'_>, exact: &[Vec<Double>], computed: &[[f64; LANES]]) {
        for (lane, exact) in exact.iter().enumerate() {
            self.add(view, exact, computed.iter().map(|lanes| lanes[lane]));
        }
    }

    fn add(&mut self, view: View<'_>, exact: &[Double], computed: impl Iterator<Item = f64>) {
        let mut norms = vec![(0.0f64, 0.0f64); view.function.outputs().len()];
        let mut distances = Vec::with_capacity(exact.len());
        for ((&exact, computed), &array) in exact.iter().zip(computed).zip(&self.arrays) {
            let distance = match (exact.high.is_finite(), computed.is_finite()) {
                (false, _) => f64::NAN,
                (true, false) => f64::INFINITY,
                (true, true) => exact.distance(computed),
            };
            distances.push(distance);
            if !distance.is_nan() {
                let norm = &mut norms[array];
                *norm = (norm.0.max(distance), norm.1.max(exact.high.abs()));
            }
        }
        let mut errors = Vec::with_capacity(exact.len());
        for ((&exact, &distance), &array) in exact.iter().zip(&distances).zip(&self.arrays) {
            let size = exact.high.abs();
            errors.push(if distance > 0.0 && size <= norms[array].1 * VANISHING {
                VANISHED
            } else {
                (quotient(distance, size), distance / self.ulp(size))
            });
        }
        self.states.push(errors);
        self.norms.push(norms);
    }

    /// The relative errors of a state, of the outputs that have one.
    pub(super) fn relative(&self, state: usize) -> impl Iterator<Item = f64> + '_ {
        let errors = self.states[state].iter().map(|(relative, _)| *relative);
        errors.filter(|error| *error >= 0.0)
    }

    /// The normwise errors of a state, of the arrays that have one.
    pub(super) fn normwise(&self, state: usize) -> impl Iterator<Item = f64> + '_ {
        // Arrays without an assignment, and those that are all zero, have
        // none.
        let norms = self.norms[state].iter();
        let present = norms.filter(|(error, size)| *error > 0.0 || *size > 0.0);
        present.map(|&(error, size)| quotient(error, size))
    }

    /// The unit in the last place of a number.
    fn ulp(&self, size: f64) -> f64 {
        let float = match self.format {
            Format::Float(float) => float,
            Format::Fixed(fixed) => return 2f64.powi(-(fixed.fraction as i32)),
        };
        let smallest = float.smallest_exponent();
        let exponent = match size.to_bits() >> 52 {
            // Zero and subnormals.
            0 => smallest,
            biased => (biased as i32 - 1023).max(smallest),
        };
        2f64.powi(exponent - float.mantissa as i32)
    }

    fn finish(&self, view: View<'_>) -> FormatAccuracy {
        let nowhere = Spread {
            median: f64::NAN,
            worst: f64::NAN,
        };
        let column = |pick: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..self.states.len())
                .map(pick)
                .filter(|error| *error >= 0.0)
                .collect()
        };
        let element = |index: usize, output: Output| {
            let mut relative = column(&|state| self.states[state][index].0);
            let mut ulps = column(&|state| self.states[state][index].1);
            let relative = spread(&mut relative).unwrap_or(nowhere);
            let worst = |errors: &Vec<(f64, f64)>| errors[index].0 == relative.worst;
            ElementError {
                output,
                relative,
                ulps: spread(&mut ulps).unwrap_or(nowhere),
                worst_state: self.states.iter().position(worst).unwrap_or(0) as u32,
                vanishing: self
                    .states
                    .iter()
                    .filter(|errors| errors[index] == VANISHED)
                    .count() as u32,
            }
        };
        let array = |array: usize| {
            let mut normwise = column(&|state| {
                let (error, size) = self.norms[state][array];
                quotient(error, size)
            });
            ArrayError {
                array,
                normwise: spread(&mut normwise).unwrap_or(nowhere),
            }
        };
        let assignments = view.function.assignments.iter().enumerate();
        let mut present = vec![false; view.function.outputs().len()];
        for &array in &self.arrays {
            present[array] = true;
        }
        FormatAccuracy {
            format: self.format,
            elements: assignments.map(|(i, a)| element(i, a.output)).collect(),
            arrays: (0..present.len())
                .filter(|&index| present[index])
                .map(array)
                .collect(),
        }
    }
}

/// The error over the size; no error is 0 whatever the size.
fn quotient(error: f64, size: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / size }
}

/// Median (the lower one of an even number) and maximum; `None` of nothing.
fn spread(errors: &mut [f64]) -> Option<Spread> {
    errors.sort_unstable_by(f64::total_cmp);
    let worst = *errors.last()?;
    Some(Spread {
        median: errors[(errors.len() - 1) / 2],
        worst,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::{
        Assignment, Function, Input, Level, Name, Node, Operand, Operation, Shape, SourceSet,
        Tables,
    };

    /// Inputs `x[1..2]`, outputs `y[1..length]` and the scalars `z` and `w`.
    fn function(tables: &mut Tables, length: u32) -> Function {
        let mut function = Function::new("sample", Level::Atomic);
        function.add_input(tables.symbols.intern("x"), Shape::Vector(2));
        function.add_output(tables.symbols.intern("y"), Shape::Vector(length));
        function.add_output(tables.symbols.intern("z"), Shape::Scalar);
        function.add_output(tables.symbols.intern("w"), Shape::Scalar);
        function
    }

    fn push(function: &mut Function, operation: Operation, a: Operand, b: Operand) -> Operand {
        let node = Node {
            name: Name::NONE,
            sources: SourceSet::EMPTY,
            operands: Operand::list([a, b]),
            operation,
        };
        function.push(node).into()
    }

    fn assign(function: &mut Function, operand: Operand) {
        function.assignments.push(Assignment {
            output: Output(function.assignments.len() as u32),
            operand,
            sources: SourceSet::EMPTY,
        });
    }

    fn measured(view: View<'_>, count: u32) -> Accuracy {
        let formats = [Format::BINARY32, Format::BINARY64];
        accuracy(view, &States::new(3), count, &formats)
    }

    #[test]
    fn one_rounding_costs_at_most_half_an_ulp_and_a_copy_nothing() {
        let mut tables = Tables::default();
        let mut function = function(&mut tables, 2);
        let (a, b) = (Operand::from(Input(0)), Operand::from(Input(1)));
        let product = push(&mut function, Operation::Mul, a, b);
        assign(&mut function, product);
        assign(&mut function, a);
        let view = View {
            tables: &tables,
            function: &function,
        };
        let accuracy = measured(view, 40);
        let narrow = &accuracy.formats[0];
        let product = narrow.elements[0];
        assert!(product.ulps.worst <= 0.5 && product.ulps.worst > 0.4);
        assert!(product.ulps.median > 0.1 && product.ulps.median < 0.4);
        assert!(product.relative.worst <= 2f64.powi(-24));
        assert_eq!(narrow.elements[1].relative.worst, 0.0);
        // Products of two binary32 numbers are exact in binary64.
        assert_eq!(accuracy.formats[1].elements[0].ulps.worst, 0.0);
        assert_eq!(narrow.summary().worst_output, Some(Output(0)));
        assert!(narrow.arrays[0].normwise.worst <= 2f64.powi(-24));
    }

    #[test]
    fn cancellation_overflow_and_undefined_values_show() {
        let mut tables = Tables::default();
        let mut function = function(&mut tables, 1);
        let (a, b) = (Operand::from(Input(0)), Operand::from(Input(1)));
        let large = Operand::from(function.constant(1e30));
        let zero = Operand::from(function.constant(0.0));
        let sum = push(&mut function, Operation::Add, a, large);
        let difference = push(&mut function, Operation::Sub, sum, large);
        assign(&mut function, difference);
        let square = push(&mut function, Operation::Mul, large, large);
        assign(&mut function, square);
        let undefined = push(&mut function, Operation::Div, b, zero);
        assign(&mut function, undefined);
        let view = View {
            tables: &tables,
            function: &function,
        };
        let accuracy = measured(view, 5);
        let errors = |format: &FormatAccuracy| {
            let worst = |index: usize| format.elements[index].relative.worst;
            (worst(0), worst(1), worst(2))
        };
        let (cancelled, overflown, undefined) = errors(&accuracy.formats[0]);
        assert!(cancelled >= 1.0 && overflown == f64::INFINITY && undefined.is_nan());
        let (cancelled, square, undefined) = errors(&accuracy.formats[1]);
        assert!(cancelled == 1.0 && square < 1e-15 && undefined.is_nan());
        assert_eq!(
            accuracy.formats[1].summary().worst_output,
            Some(Output(0)),
            "an undefined output is not the worst"
        );
    }

    #[test]
    fn an_element_that_vanishes_has_no_relative_error() {
        let mut tables = Tables::default();
        let mut function = function(&mut tables, 2);
        let (a, b) = (Operand::from(Input(0)), Operand::from(Input(1)));
        // (a*b)/b - a is zero, but neither binary32 nor double-double know.
        let third = Operand::from(function.constant(3.0));
        let thirds = push(&mut function, Operation::Div, a, third);
        let product = push(&mut function, Operation::Mul, thirds, b);
        let quotient = push(&mut function, Operation::Div, product, b);
        let nothing = push(&mut function, Operation::Sub, quotient, thirds);
        assign(&mut function, nothing);
        assign(&mut function, a);
        let view = View {
            tables: &tables,
            function: &function,
        };
        let accuracy = measured(view, 40).formats[0].clone();
        let element = accuracy.elements[0];
        assert!(element.vanishing > 0 && element.vanishing < 40);
        assert_eq!(element.relative.worst, 0.0, "the other states are exact");
        assert!(accuracy.arrays[0].normwise.worst > 1e-9);
        assert_eq!(accuracy.elements[1].vanishing, 0);
    }
}
