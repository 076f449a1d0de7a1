//! Rounding errors: every output in any number formats against the exact
//! value, over seeded random states.
//!
//! Several measures, since each alone misleads (an element that is nearly
//! zero has a huge relative error and does no harm, a sum of large elements
//! hides a small wrong one). With `e = |computed - y|`, element by element:
//!
//! - *absolute*: `e`;
//! - *relative*: `e / |y|`;
//! - *ulps*: `e` in units in the last place of `y`, in the format computed
//!   with; as *bits* `log2(1 + ulps)`, how many of them are wrong;
//! - *mixed*: `e / (|y| + s)`, where `s` is the root mean square of the changes
//!   of `y` for independent relative changes of size 1 in all inputs, to first
//!   order ([`Sensitivities`]). A result that is zero by cancellation is
//!   measured relative to the cancelling terms, so that zeros do not dominate.
//!
//! And array by array:
//!
//! - *normwise*: the largest error over the largest element;
//! - *componentwise*: the largest relative error of an element.
//!
//! An element that is below 2⁻⁷⁰ of the largest of its array is zero except for
//! the reference's own rounding (an entry of a mass matrix that vanishes by
//! symmetry): where it is computed otherwise it *vanishes*, and then it has no
//! relative or mixed error in any such state; only the absolute and normwise
//! measures see it. A computed number that is not finite where the exact one is
//! has an infinite error. States in which the exact value is itself not finite
//! have no meaning and are left out; an output without any other state has the
//! error NaN. Inputs are representable in binary32 ([`States`]), so the
//! measured error is the rounding of the program, not of its data, unless a
//! narrower format rounds that; literals that a format cannot represent do
//! count. Values with their own format keep it for any requested format.

mod samples;
mod spread;

use super::adjoint::Tape;
use super::condition::{Judgement, Sensitivities, conditions, spectral};
use super::reference::{ExactEvidence, ExactOutput, LANES, ReferenceEffort, ReferenceEvaluator};
use robovec_ir::evaluate::{evaluate, evaluate_mixed};
use robovec_ir::plan::EvaluationPlan;
use robovec_ir::states::States;
use robovec_ir::{Function, Output, Shape, View};
use robovec_num::arithmetic::{Arithmetic, Binary32, Binary64};
use robovec_num::batch::Batch;
use robovec_num::format::Format;
use robovec_num::soft_float::{FormatArithmetic, FormatLanes};
use robovec_num::trigonometry::host;
pub(super) use samples::Samples;
pub use samples::{VANISHING, distance};
pub use spread::StateSpread;
use std::array;

/// The error of one output element.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ElementError {
    /// The element.
    pub output: Output,
    /// The distance from the exact value, in its unit.
    pub absolute: StateSpread,
    /// Relative to the exact value.
    pub relative: StateSpread,
    /// In units in the last place of the exact value.
    pub ulps: StateSpread,
    /// Error relative to the exact value and its sensitivity.
    pub mixed: StateSpread,
    /// The median over the states of the estimated condition number for
    /// independent errors of the inputs; 0 where it was not requested.
    pub sensitivity: f64,
    /// The number of the state with the largest relative error, in the
    /// numbering of [`States::draw`].
    pub worst_state: u32,
    /// Number of states in which it vanishes without being computed as zero.
    pub vanishing: u32,
    /// Number of states in which the computed number is below the normal ones
    /// of the format, without being zero exactly.
    pub subnormal: u32,
    /// Number of states in which the computed number is not finite but the
    /// exact one is.
    pub overflowed: u32,
    /// The part of the largest relative error that lies in the problem; `None`
    /// where it was not requested.
    pub conditioned: Option<Conditioned>,
}

/// An error with the condition number of its computation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Conditioned {
    /// The componentwise condition number of the element in the state of its
    /// largest relative error.
    pub condition: f64,
    /// That error divided by the condition number and the unit roundoff of the
    /// format: the number of input roundings with the same effect.
    pub backward: f64,
    /// The judgement that follows.
    pub judgement: Judgement,
}

/// The error of one output array.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ArrayError {
    /// Index into [`robovec_ir::Function::outputs`].
    pub array: usize,
    /// Largest error over largest element.
    pub normwise: StateSpread,
    /// Largest relative error of an element.
    pub componentwise: StateSpread,
    /// Largest mixed error of an element.
    pub mixed: StateSpread,
}

/// The errors in one number format.
#[derive(Clone, PartialEq, Debug)]
pub struct FormatAccuracy {
    /// The format that was computed with.
    pub format: Format,
    /// All outputs in all states as one population.
    pub relative: StateSpread,
    /// The same, mixed.
    pub mixed: StateSpread,
    /// The part of all outputs in all states whose computed number is below
    /// the normal ones, and not exactly zero.
    pub subnormal: f64,
    /// The share of states in which the computed number is not finite but the
    /// exact one is.
    pub overflowed: f64,
    /// One entry per assignment, in the function's order.
    pub elements: Vec<ElementError>,
    /// One entry per output array that has an assignment.
    pub arrays: Vec<ArrayError>,
}

/// The condition of an output array that is a symmetric matrix.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MatrixCondition {
    /// Index into [`robovec_ir::Function::outputs`].
    pub array: usize,
    /// Its condition number in the 2-norm.
    pub condition: StateSpread,
}

/// The evidence for the exact values.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Certainty {
    /// Outputs, in all states, whose nearest binary64 number is proved by
    /// double-double.
    pub double_double: u64,
    /// By arbitrary precision.
    pub precise: u64,
    /// Zero by an identity.
    pub zero: u64,
    /// Not proved, or not tested.
    pub uncertain: u64,
}

/// The errors of a function.
#[derive(Clone, PartialEq, Debug)]
pub struct Accuracy {
    /// The number of states that were drawn.
    pub states: u32,
    /// From which seed.
    pub seed: u64,
    /// The reference that the outputs were compared with.
    pub effort: ReferenceEffort,
    /// The certainty of that reference.
    pub certainty: Certainty,
    /// One entry per format, in the order they were requested.
    pub formats: Vec<FormatAccuracy>,
    /// The output arrays that are symmetric matrices, when conditions were
    /// requested.
    pub matrices: Vec<MatrixCondition>,
}

/// The errors of a whole function in a few numbers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ErrorSummary {
    /// The median over all outputs of their median relative error.
    pub median_relative: f64,
    /// The largest normwise error of any array in any state.
    pub worst_normwise: f64,
    /// The largest error in ulps of any output in any state.
    pub worst_ulps: f64,
    /// The output with the largest error in ulps; `None` without outputs.
    pub worst_output: Option<Output>,
}

/// The measurement, and the effort it may take.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Measurement {
    /// The effort for the exact values.
    pub effort: ReferenceEffort,
    /// True if mixed errors get their floor; without, they are the relative
    /// ones.
    pub sensitivities: bool,
    /// The number of steps of reverse sweeps (operations times outputs) that
    /// may be spent on condition numbers; the outputs with the largest errors
    /// come first. About a nanosecond each.
    pub condition_work: u64,
}

impl Measurement {
    /// Errors alone, as fast as possible.
    pub const QUICK: Measurement = Measurement {
        effort: ReferenceEffort::DoubleDouble,
        sensitivities: false,
        condition_work: 0,
    };
}

impl Default for Measurement {
    /// All errors against double-double.
    fn default() -> Measurement {
        Measurement {
            sensitivities: true,
            ..Measurement::QUICK
        }
    }
}

impl FormatAccuracy {
    /// The errors of the whole function in a few numbers; those of relative
    /// errors are NaN where no element has one.
    pub fn summary(&self) -> ErrorSummary {
        let medians = self
            .elements
            .iter()
            .map(|element| (0, element.relative.median));
        let medians = StateSpread::of(medians);
        let worst = self
            .elements
            .iter()
            .filter(|element| !element.ulps.worst.is_nan())
            .max_by(|a, b| {
                let order = a.ulps.worst.total_cmp(&b.ulps.worst);
                // The first of equals, so that the choice is stable.
                order.then(b.output.cmp(&a.output))
            });
        ErrorSummary {
            median_relative: medians.median,
            worst_normwise: self
                .arrays
                .iter()
                .map(|array| array.normwise.worst)
                .fold(0.0, f64::max),
            worst_ulps: worst.map_or(f64::NAN, |element| element.ulps.worst),
            worst_output: worst.map(|element| element.output),
        }
    }
}

/// Measures the errors of a function in the given formats over the first
/// `count` states.
pub fn measure(
    view: View<'_>,
    states: &States,
    count: u32,
    formats: &[Format],
    measurement: Measurement,
) -> Accuracy {
    let mut samples: Vec<Samples> = formats
        .iter()
        .map(|&format| Samples::new(view, format))
        .collect();
    let mut certainty = Certainty::default();
    let mut matrices = Matrices::new(view, measurement.condition_work > 0);
    let mut sensitivities = Sensitivities::new(view.function);
    let mut evaluators: Vec<FormatEvaluator> = formats
        .iter()
        .map(|&format| FormatEvaluator::new(view, format))
        .collect();
    for_each_batch(
        view,
        states,
        count,
        measurement.effort,
        |first, batch, exact| {
            let floors: Vec<Vec<f64>> = if measurement.sensitivities {
                (first..)
                    .zip(&batch[..exact.len()])
                    .map(|(state, inputs)| sensitivities.at(inputs, state))
                    .collect()
            } else {
                vec![Vec::new(); exact.len()]
            };
            for (evaluator, samples) in evaluators.iter_mut().zip(&mut samples) {
                let computed = evaluator.run(batch);
                for (lane, exact) in exact.iter().enumerate() {
                    let exact = exact.iter().map(|exact| exact.value);
                    let computed = computed.iter().map(|lanes| lanes[lane]);
                    samples.add(view, exact, computed, &floors[lane]);
                }
            }
            for (state, exact) in (first..).zip(exact) {
                certainty.count(exact);
                matrices.add(view, state, exact);
            }
        },
    );
    let mut result = Accuracy {
        states: count,
        seed: states.seed(),
        effort: measurement.effort,
        certainty,
        formats: (samples.iter_mut())
            .map(|samples| samples.finish(view))
            .collect(),
        matrices: matrices.finish(),
    };
    if measurement.condition_work > 0 {
        let tape = Tape::new(view.function);
        for (accuracy, samples) in result.formats.iter_mut().zip(&samples) {
            let work = measurement.condition_work / formats.len() as u64;
            add_conditions(view, &tape, states, accuracy, samples, work);
        }
    }
    result
}

/// The errors in one format, state by state, against certified values if the
/// size of the function permits them.
pub(super) fn samples(view: View<'_>, states: &States, count: u32, format: Format) -> Samples {
    let mut samples = Samples::new(view, format);
    let mut evaluator = FormatEvaluator::new(view, format);
    for_each_batch(
        view,
        states,
        count,
        ReferenceEffort::of_size(view.function.nodes().len()),
        |_, batch, exact| {
            let computed = evaluator.run(batch);
            for (lane, exact) in exact.iter().enumerate() {
                let exact = exact.iter().map(|exact| exact.value);
                samples.add(view, exact, computed.iter().map(|lanes| lanes[lane]), &[]);
            }
        },
    );
    samples.settle();
    samples
}

/// Draws states and evaluates them exactly, some at a time. Handed on are the
/// number of the first state, the inputs of all lanes, and the exact outputs
/// of every lane that is wanted: the last batch may hold more states.
fn for_each_batch(
    view: View<'_>,
    states: &States,
    count: u32,
    effort: ReferenceEffort,
    mut use_batch: impl FnMut(u32, &[Vec<f64>; LANES], &[Vec<ExactOutput>]),
) {
    let mut reference = ReferenceEvaluator::new(view.function, effort);
    for first in (0..count).step_by(LANES) {
        let wanted = LANES.min((count - first) as usize);
        let last = first + wanted as u32 - 1;
        let inputs: [Vec<f64>; LANES] =
            array::from_fn(|lane| states.draw(view, (first + lane as u32).min(last)));
        let exact = reference.evaluate(&inputs[..wanted]);
        use_batch(first, &inputs, &exact);
    }
}

/// Evaluates a function in a format, state after state.
struct FormatEvaluator<'a> {
    function: &'a Function,
    plan: EvaluationPlan,
    memory: FormatMemory,
}

/// The arithmetic of a format, and its values.
enum FormatMemory {
    Binary32(Vec<[f32; LANES]>),
    Binary64(Vec<[f64; LANES]>),
    Soft(FormatArithmetic, Vec<[f64; LANES]>),
    /// Some values have their own formats, the others this one.
    Mixed(Format),
}

/// True when a function fixes how its values are computed: each in its own
/// format, or with sines and cosines of the host.
fn needs_mixed(view: View<'_>) -> bool {
    view.function.formats.is_some() || view.function.metadata(host::KEY).is_some()
}

impl<'a> FormatEvaluator<'a> {
    fn new(view: View<'a>, format: Format) -> FormatEvaluator<'a> {
        FormatEvaluator {
            function: view.function,
            plan: EvaluationPlan::new(view.function),
            memory: match format {
                format if needs_mixed(view) => FormatMemory::Mixed(format),
                Format::BINARY32 => FormatMemory::Binary32(Vec::new()),
                Format::BINARY64 => FormatMemory::Binary64(Vec::new()),
                format => FormatMemory::Soft(FormatArithmetic::new(format), Vec::new()),
            },
        }
    }

    /// The outputs of all lanes, as binary64 numbers.
    fn run(&mut self, inputs: &[Vec<f64>; LANES]) -> Vec<[f64; LANES]> {
        let plan = &self.plan;
        match &mut self.memory {
            FormatMemory::Binary32(memory) => {
                let lanes = Batch([Binary32; LANES]);
                let results = run_lanes(plan, &lanes, |number| number as f32, inputs, memory);
                let results = results.into_iter();
                results.map(|lanes| lanes.map(f64::from)).collect()
            }
            FormatMemory::Binary64(memory) => {
                let lanes = Batch([Binary64; LANES]);
                run_lanes(plan, &lanes, |number| number, inputs, memory)
            }
            FormatMemory::Soft(single, memory) => {
                let lanes = FormatLanes::<LANES>(*single);
                run_lanes(
                    plan,
                    &lanes,
                    |number| single.convert(number),
                    inputs,
                    memory,
                )
            }
            FormatMemory::Mixed(format) => {
                let lanes = inputs
                    .each_ref()
                    .map(|inputs| evaluate_mixed(self.function, *format, inputs));
                (0..lanes[0].len())
                    .map(|place| array::from_fn(|lane| lanes[lane][place]))
                    .collect()
            }
        }
    }
}

fn run_lanes<N: Copy, A: Arithmetic<Number = [N; LANES]>>(
    plan: &EvaluationPlan,
    arithmetic: &A,
    input: impl Fn(f64) -> N,
    states: &[Vec<f64>; LANES],
    memory: &mut Vec<[N; LANES]>,
) -> Vec<[N; LANES]> {
    let inputs: Vec<[N; LANES]> = (0..states[0].len())
        .map(|place| array::from_fn(|lane| input(states[lane][place])))
        .collect();
    plan.run(arithmetic, &inputs, memory)
}

/// The outputs of a function in a state, in the order of its assignments.
pub fn evaluate_at<A: Arithmetic>(
    function: &Function,
    arithmetic: &A,
    inputs: &[f64],
) -> Vec<A::Number> {
    let inputs = inputs.iter().map(|&number| arithmetic.literal(number));
    evaluate(function, arithmetic, &inputs.collect::<Vec<_>>())
}

impl Certainty {
    fn count(&mut self, exact: &[ExactOutput]) {
        for value in exact {
            *match value.kind {
                ExactEvidence::DoubleDouble => &mut self.double_double,
                ExactEvidence::Precise(_) => &mut self.precise,
                ExactEvidence::Zero => &mut self.zero,
                ExactEvidence::Unproved | ExactEvidence::Uncertain => &mut self.uncertain,
            } += 1;
        }
    }
}

/// Adds condition numbers to the elements with the largest relative errors,
/// each in the state of that error.
fn add_conditions(
    view: View<'_>,
    tape: &Tape,
    states: &States,
    accuracy: &mut FormatAccuracy,
    samples: &Samples,
    work: u64,
) {
    let operations = view.function.nodes().len().max(1) as u64;
    let affordable = usize::try_from(work / operations).unwrap_or(usize::MAX);
    let elements = &mut accuracy.elements;
    // An error of zero is explained by anything.
    let mut places: Vec<usize> = (0..elements.len())
        .filter(|&place| elements[place].relative.worst > 0.0)
        .collect();
    let error = |place: usize| elements[place].relative.worst;
    places.sort_by(|&a, &b| error(b).total_cmp(&error(a)).then(a.cmp(&b)));
    places.truncate(affordable);
    places.sort_by_key(|&place| (elements[place].worst_state, place));
    let unit = accuracy.format.unit_roundoff();
    let same_state = |a: &usize, b: &usize| elements[*a].worst_state == elements[*b].worst_state;
    let groups: Vec<Vec<usize>> = places.chunk_by(same_state).map(<[usize]>::to_vec).collect();
    for group in groups {
        let state = elements[group[0]].worst_state;
        let inputs = states.draw(view, state);
        for (&place, sum) in group.iter().zip(conditions(tape, &inputs, &group)) {
            let condition = sum / samples.size(state, place);
            let relative = elements[place].relative.worst;
            elements[place].conditioned = Some(Conditioned {
                condition,
                backward: relative / (condition * unit),
                judgement: Judgement::of(relative, condition, unit),
            });
        }
    }
}

/// Matrices beyond this order are left out: the work grows with its cube.
const LARGEST_ORDER: u32 = 256;

/// A symmetric matrix among the outputs: array, order, offset of its first
/// element, and the condition numbers found.
type SymmetricMatrix = (usize, usize, u32, Vec<(u32, f64)>);

/// The condition numbers of output arrays that are symmetric matrices.
struct Matrices {
    found: Vec<SymmetricMatrix>,
}

impl Matrices {
    fn new(view: View<'_>, wanted: bool) -> Matrices {
        let arrays = view.function.outputs().iter().enumerate();
        let square = arrays.filter_map(|(index, array)| match array.shape {
            Shape::Matrix(rows, columns)
                if rows == columns && (2..=LARGEST_ORDER).contains(&rows) =>
            {
                Some((index, rows as usize, array.offset, Vec::new()))
            }
            _ => None,
        });
        Matrices {
            found: square.filter(|_| wanted).collect(),
        }
    }

    fn add(&mut self, view: View<'_>, state: u32, exact: &[ExactOutput]) {
        assert_eq!(
            exact.len(),
            view.function.assignments.len(),
            "every output has an exact number"
        );
        for (_, order, offset, conditions) in &mut self.found {
            let range = *offset..*offset + (*order * *order) as u32;
            let mut matrix = vec![f64::NAN; *order * *order];
            for (assignment, exact) in view.function.assignments.iter().zip(exact) {
                if range.contains(&assignment.output.0) {
                    matrix[(assignment.output.0 - *offset) as usize] = exact.value.high;
                }
            }
            if complete(&mut matrix, *order) {
                conditions.push((state, spectral::condition(&matrix, *order)));
            }
        }
    }

    fn finish(self) -> Vec<MatrixCondition> {
        let found = self.found.into_iter();
        found
            .filter(|(.., conditions)| !conditions.is_empty())
            .map(|(array, _, _, conditions)| MatrixCondition {
                array,
                condition: StateSpread::of(conditions.into_iter()),
            })
            .collect()
    }
}

/// Fills in unset elements (NaN) from the other half, and zeros where neither
/// is set; false for a matrix that is not symmetric to rounding.
fn complete(matrix: &mut [f64], order: usize) -> bool {
    let mut symmetric = true;
    for row in 0..order {
        for column in 0..=row {
            let (one, other) = (row * order + column, column * order + row);
            let (a, b) = (matrix[one], matrix[other]);
            match (a.is_nan(), b.is_nan()) {
                (true, true) => (matrix[one], matrix[other]) = (0.0, 0.0),
                (true, false) => matrix[one] = b,
                (false, true) => matrix[other] = a,
                (false, false) => {
                    symmetric &= (a - b).abs() <= 1e-9 * (a.abs() + b.abs());
                }
            }
        }
    }
    symmetric
}

#[cfg(test)]
mod tests;
