//! Every output's error at one state, by several methods.

use super::heat::{Heat, blame, blame_of};
use super::proof::{ProofRow, prove};
use super::view::{place, small};
use robovec_analysis::adjoint::{AdjointRun, Tape};
use robovec_analysis::interval::{
    Alarm, ConeWindow, GivenData, Leaves, WindowLeaves, integer_bits, largest_seen, subdivide,
};
use robovec_analysis::reference::{ExactOutput, ReferenceEffort, ReferenceEvaluator};
use robovec_analysis::stochastic::{Unsupported, stochastic};
use robovec_framework::trail::TrackedItem;
use robovec_ir::diagnostic::counted;
use robovec_ir::print::print_output;
use robovec_ir::states::States;
use robovec_ir::{Format, Operation, View};
use robovec_num::double_double::Double;
use robovec_present::number::percent;
use serde::Serialize;
use std::fmt::Write;
use std::slice;

/// Maximum enclosures of windows, times operations and leaves: some seconds.
const ENCLOSED: usize = 1 << 25;

/// The maximum number of states at which the error of a window is looked for.
const STATES: usize = 4096;

/// The maximum number of states of all windows, times operations and leaves.
const RUN: usize = 1 << 23;

/// A method to estimate or bound an error.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, clap::ValueEnum)]
pub enum ErrorMethod {
    /// Ranges and errors proved for all states over the whole function, and the largest error that
    /// a directed search finds
    Proof,
    /// The sum of the largest possible rounding errors of all operations,
    /// weighted by adjoints
    Bound,
    /// The sum of the actual rounding errors of all operations, with signs
    Predict,
    /// The standard deviation when every operation is rounded up or down at
    /// random
    Stochastic,
    /// Ranges and errors for all states, over the last operations before the
    /// output
    Interval,
}

/// Settings of the question.
#[derive(Clone, Debug)]
pub struct ErrorSettings {
    /// The number format of the run.
    pub format: Format,
    /// Origin of the states.
    pub states: States,
    /// The state of the table.
    pub state: u32,
    /// States from that one on which blame is averaged over.
    pub blamed: u32,
    /// Methods in use.
    pub methods: Vec<ErrorMethod>,
    /// The outputs requested, by their places among the assignments.
    pub outputs: Vec<usize>,
    /// Equations named as the hottest.
    pub most_equations: usize,
    /// Operations of a window.
    pub window: usize,
    /// States from which ranges inside a function are assumed.
    pub samples: u32,
    /// Enclosures of a window at most.
    pub boxes: usize,
    /// Number of times the usual number of states of a search.
    pub effort: u32,
    /// Kind of inputs and literals before the run.
    pub data: GivenData,
}

/// The errors of a function's outputs.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ErrorTable {
    /// The function.
    pub function: String,
    /// The number format.
    pub format: String,
    /// The seed of the states.
    pub seed: u64,
    /// The number of the state.
    pub state: u32,
    /// The largest error of a divisor or radicand in this run, relative to its
    /// exact value: bounds are of first order, and their error grows with this.
    pub weakest_divisor: f64,
    /// States of the search beside the proofs.
    pub searched: u64,
    /// One row per output requested.
    pub outputs: Vec<OutputRow>,
    /// Place where the errors come from.
    pub heat: Heat,
}

/// Errors of one output.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct OutputRow {
    /// The element (`M[1,2]`).
    pub name: String,
    /// The exact value, to binary64; an estimate unless `certified`.
    pub exact: f64,
    /// True when `exact` is proved to be the nearest binary64 number.
    pub certified: bool,
    /// The computed value.
    pub computed: f64,
    /// Computed less exact.
    pub error: f64,
    /// The error predicted from the rounding error of every operation.
    pub predicted: Option<f64>,
    /// The error when all operations lose most, to first order about this run.
    pub bound: Option<f64>,
    /// The standard deviation under random rounding.
    pub sigma: Option<f64>,
    /// Bounds for all states, over the whole function.
    pub proof: Option<ProofRow>,
    /// Bounds for all states, over a window.
    pub interval: Option<IntervalRow>,
}

/// Bounds for all states in the ranges of the leaves of a window.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct IntervalRow {
    /// The smallest value.
    pub low: f64,
    /// The greatest value.
    pub high: f64,
    /// The most that the window's operations lose together.
    pub error: f64,
    /// The part of the ranges, by volume, in which the bound is finite.
    pub share: f64,
    /// The most that they lose in that part.
    pub finite: f64,
    /// Bound at the worst state tested, the best that more boxes could give.
    pub at_a_state: f64,
    /// The largest error seen at random states in the ranges.
    pub seen: f64,
    /// The number of these states.
    pub states: usize,
    /// Boxes that cover the ranges.
    pub boxes: usize,
    /// Number of operations the window has.
    pub operations: usize,
    /// Basis of the weakest range of a leaf: `given` for inputs, `drawn` from
    /// the states' distribution, `assumed` from samples.
    pub ranges: &'static str,
    /// A harmful consequence of the range in the format, if any.
    pub alarm: Option<&'static str>,
    /// Bits before the point that a fixed-point number needs.
    pub integer_bits: Option<u32>,
}

impl ErrorTable {
    /// Measures the requested errors.
    ///
    /// # Errors
    ///
    /// Fails when roundings of the format cannot be sampled.
    pub fn measure(view: View<'_>, settings: &ErrorSettings) -> Result<ErrorTable, Unsupported> {
        let tape = Tape::new(view.function);
        let inputs = settings.states.draw(view, settings.state);
        let run = AdjointRun::of(view.function, &tape, settings.format, &inputs);
        let effort = ReferenceEffort::of_size(view.function.nodes().len());
        let mut reference = ReferenceEvaluator::new(view.function, effort);
        let exact = reference.evaluate(slice::from_ref(&inputs)).remove(0);
        let mut rows: Vec<OutputRow> = settings
            .outputs
            .iter()
            .map(|&output| row(view, &run, output, exact[output]))
            .collect();
        let asked = |method| settings.methods.contains(&method);
        if asked(ErrorMethod::Bound) || asked(ErrorMethod::Predict) {
            let errors = run.outputs(&settings.outputs);
            assert_eq!(errors.len(), rows.len(), "every row has its error");
            for (row, error) in rows.iter_mut().zip(errors) {
                row.predicted = asked(ErrorMethod::Predict).then_some(error.predicted);
                row.bound = asked(ErrorMethod::Bound).then_some(error.bound);
            }
        }
        let slots = settings
            .outputs
            .iter()
            .map(|&output| tape.output_slot(output));
        let slots: Vec<usize> = slots.collect();
        if asked(ErrorMethod::Stochastic) {
            let seed = settings.states.seed();
            let sampled = stochastic(&tape, settings.format, &inputs, seed, &slots)?;
            assert_eq!(sampled.len(), rows.len(), "every row has its samples");
            for (row, sampled) in rows.iter_mut().zip(sampled) {
                row.sigma = Some(sampled.sigma);
            }
        }
        if asked(ErrorMethod::Interval) {
            let leaves = Leaves::new(view, &tape, &settings.states, settings.samples);
            for (row, &slot) in rows.iter_mut().zip(&slots) {
                let window = ConeWindow::new(&tape, slot, settings.window);
                row.interval = Some(interval(&tape, &window, settings, &leaves));
            }
        }
        let mut searched = 0;
        if asked(ErrorMethod::Proof) {
            let (proofs, tried) = prove(view, &tape, settings);
            searched = tried;
            for (row, proof) in rows.iter_mut().zip(proofs) {
                row.proof = Some(proof);
            }
        }
        let states = settings.state..settings.state.saturating_add(settings.blamed);
        let (count, outputs) = (states.len() as u32, settings.outputs.len());
        let (format, all) = (settings.format, &settings.outputs);
        let blame = blame_of(view, &tape, format, &settings.states, states, all, outputs);
        let about = (settings.states.seed(), count, outputs);
        Ok(ErrorTable {
            function: view.function.name.clone(),
            format: format.to_string(),
            seed: settings.states.seed(),
            state: settings.state,
            weakest_divisor: weakest_divisor(&run),
            searched,
            outputs: rows,
            heat: Heat::new(view, &tape, format, &blame, about, settings.most_equations),
        })
    }
}

/// The largest relative error of a divisor or a radicand.
fn weakest_divisor(run: &AdjointRun<'_>) -> f64 {
    let tape = run.tape();
    let divisors = (0..tape.nodes()).filter_map(|node| {
        let place = match tape.operation(node) {
            Operation::Div => 1,
            Operation::Sqrt => 0,
            _ => return None,
        };
        let slot = tape.operands(node)[place];
        let (error, exact) = (run.computed()[slot] - run.exact()[slot], run.exact()[slot]);
        let relative = (error / exact).abs();
        // A zero that is exact has no error.
        Some(if error == 0.0 { 0.0 } else { relative })
    });
    divisors.fold(0.0, f64::max)
}

fn row(view: View<'_>, run: &AdjointRun<'_>, output: usize, exact: ExactOutput) -> OutputRow {
    let computed = run.computed()[run.tape().output_slot(output)];
    OutputRow {
        name: print_output(view, view.function.assignments[output].output),
        exact: exact.value.high,
        certified: exact.is_certain(),
        computed,
        error: (Double::from(computed) - exact.value).high,
        predicted: None,
        bound: None,
        sigma: None,
        proof: None,
        interval: None,
    }
}

pub(super) fn interval(
    tape: &Tape,
    window: &ConeWindow,
    settings: &ErrorSettings,
    leaves: &Leaves<'_>,
) -> IntervalRow {
    let format = settings.format;
    let leaves = WindowLeaves::new(tape, window, format, settings.data, leaves);
    let size = window.nodes.len() + leaves.ranges.len() + 1;
    let size = size * settings.outputs.len().max(1);
    let most = settings.boxes.min(ENCLOSED / size).max(1);
    let found = subdivide(tape, window, &leaves, most);
    let (seed, states) = (settings.states.seed(), STATES.min(RUN / size).max(16));
    let (seen, states) = largest_seen(tape, window, &leaves, &found.worst, seed, states);
    IntervalRow {
        low: found.range.low,
        high: found.range.high,
        error: found.error,
        share: found.share,
        finite: found.finite,
        at_a_state: found.at_a_state,
        seen,
        states,
        boxes: found.boxes,
        operations: window.nodes.len(),
        ranges: leaves.knowledge.name(),
        alarm: Alarm::of(found.range, format).map(Alarm::name),
        integer_bits: integer_bits(found.range),
    }
}

/// Number of equations named as the origin of an output's error.
const MOST: usize = 5;

/// Effect of rounding on a value or an output: its error in the first state,
/// its bound, the part that its operation adds, and its share in the errors of
/// the outputs; `None` when the function has no such value.
pub fn explain(
    view: View<'_>,
    item: TrackedItem,
    format: Format,
    states: &States,
) -> Option<String> {
    let function = view.function;
    let tape = Tape::new(function);
    let (slot, output) = match item {
        TrackedItem::Value(name) => {
            let mut nodes = function.nodes().iter();
            (nodes.position(|node| node.name == name)?, None)
        }
        TrackedItem::Output(output) => {
            let mut assignments = function.assignments.iter();
            let place = assignments.position(|assignment| assignment.output == output)?;
            (tape.output_slot(place), Some(place))
        }
    };
    let run = AdjointRun::of(function, &tape, format, &states.draw(view, 0));
    // One slot was asked for.
    let error = run.slots(&[slot]).into_iter().next()?;
    let mut text = format!(
        "rounding in {format}, at state 0 of seed {}\n",
        states.seed()
    );
    let _ = writeln!(
        text,
        "    {:.6e}, with an error of {}, at most {}",
        error.exact,
        small(error.actual),
        small(error.bound)
    );
    match output {
        None => {
            let (lost, most) = (run.local_errors()[slot], run.local_bounds()[slot]);
            let _ = writeln!(
                text,
                "    its last operation adds {}, and at most {}",
                small(lost),
                small(most)
            );
            let (blame, count, outputs) = blame(view, &tape, format, states);
            let share = percent(blame.share(slot));
            let _ = writeln!(
                text,
                "    that is {share} of the errors of {}, over {}",
                counted(outputs, "output"),
                counted(count, "state")
            );
        }
        Some(output) => {
            let blame = blame_of(view, &tape, format, states, 0..1, &[output], 1);
            let about = (states.seed(), 1, 1);
            let heat = Heat::new(view, &tape, format, &blame, about, MOST);
            for equation in &heat.equations {
                let name = equation.name.as_deref().unwrap_or("the output");
                let share = percent(equation.share);
                let _ = writeln!(text, "    {share} from {name} at {}", place(equation));
            }
        }
    }
    Some(text)
}
