//! Exact results of a function at states, and distances of programs from them.
//!
//! Programs made from one another keep the names of their arrays, but a
//! specialised one has lost inputs and outputs, one with series has other
//! sines, one of another formulation other equations. Programs are therefore
//! matched with their yardstick by names, and the measured error is the total
//! of model, series and rounding. [`account`] prints it.

pub mod account;
mod quick;

pub use quick::{QuickMemory, QuickYardstick};

use robovec_analysis::reference::{ExactOutput, ReferenceEffort, ReferenceEvaluator};
use robovec_framework::scene::Allowed;
use robovec_ir::evaluate::evaluate_mixed;
use robovec_ir::plan::EvaluationPlan;
use robovec_ir::print::{print_operand, print_output};
use robovec_ir::states::States;
use robovec_ir::{Format, Input, Output, View};
use robovec_num::arithmetic::{Arithmetic, Binary32, Binary64};
use robovec_num::batch::Batch;
use robovec_num::double_double::Double;
use robovec_num::soft_float::{FormatArithmetic, FormatLanes};
use std::array;
use std::collections::BTreeMap;

/// States evaluated at a time.
pub const LANES: usize = 8;

/// An element below this part of the largest of its array is zero but for the
/// reference's rounding, as in [`robovec_analysis::accuracy`].
const VANISHING: f64 = 1.0 / (1u128 << 70) as f64;

/// Exact results at states.
pub struct Yardstick {
    /// Place where each input element of the exact function lies in a state.
    places: BTreeMap<String, usize>,
    /// Numbers of all input elements, state by state.
    states: Vec<Vec<f64>>,
    /// The exact results, state by state, and the place of each output in them.
    outputs: BTreeMap<String, usize>,
    exact: Vec<Vec<Double>>,
    /// The names of the output arrays.
    arrays: Vec<String>,
}

/// Place of an output of a program in the exact results.
#[derive(Clone, Copy)]
struct ExactPlace {
    /// Its place; `None` for an element that is zero by structure.
    exact: Option<usize>,
    /// Its array, as a place among those of the exact function.
    array: usize,
}

impl ExactPlace {
    fn of(self, exact: &[Double]) -> Double {
        self.exact.map_or(Double::from(0.0), |place| exact[place])
    }
}

/// Reason why a program cannot be measured.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Unmeasurable {
    /// It reads an input that the yardstick's function does not have.
    #[error("the program reads '{0}', which the function it is measured by does not have")]
    Input(String),
    /// It computes an output that the yardstick's function does not have.
    #[error("the program computes '{0}', which the function it is measured by does not")]
    Output(String),
}

/// Three places in a distribution of errors.
#[derive(Clone, Copy, PartialEq, Default, Debug, serde::Serialize, serde::Deserialize)]
pub struct ErrorSpread {
    /// Half of the errors are at or below it.
    #[serde(deserialize_with = "infinite_where_null")]
    pub median: f64,
    /// 99 of 100 errors are at or below it.
    #[serde(deserialize_with = "infinite_where_null")]
    pub percentile_99: f64,
    /// The largest; infinite when a result was not finite.
    #[serde(deserialize_with = "infinite_where_null")]
    pub worst: f64,
}

/// JSON has no infinite numbers: they are null, and no error is NaN.
fn infinite_where_null<'de, D: serde::Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    let error: Option<f64> = serde::Deserialize::deserialize(source)?;
    Ok(error.unwrap_or(f64::INFINITY))
}

/// Distance of a program from the exact results.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct MeasuredErrors {
    /// Of every element in every state, relative to its exact value, without
    /// zeros; infinite where all elements in error are zero.
    pub relative: ErrorSpread,
    /// Of every array in every state: its largest error over its largest
    /// element. Arrays of zeros alone are left out.
    pub normwise: ErrorSpread,
    /// The same of every array of the exact function, in all states.
    pub arrays: Vec<ErrorSpread>,
    /// For every output of the program its largest normwise error in any state.
    pub outputs: Vec<LargestErrors>,
}

/// The largest error of one output.
#[derive(Clone, PartialEq, Debug)]
pub struct LargestErrors {
    /// Its name, as `qdd[3]`.
    pub name: String,
    /// Over the largest computed element of its array, in the same state.
    pub normwise: f64,
    /// The state of the largest normwise error, counted from 0.
    pub worst_state: usize,
}

impl Yardstick {
    /// Evaluates a function exactly at a number of states. Where a scene binds
    /// an input, its states have exactly that number, not rounded.
    pub fn new(view: View<'_>, source: &States, count: u32) -> Yardstick {
        let states = (0..count).map(|index| source.draw(view, index));
        Yardstick::at(view, states.collect())
    }

    /// Evaluates a function exactly at states: numbers of all its inputs.
    pub fn at(view: View<'_>, states: Vec<Vec<f64>>) -> Yardstick {
        let names = input_names(view);
        let name = |symbol| view.tables.symbols.text(symbol).to_owned();
        let arrays = view.function.outputs().iter();
        let assignments = view.function.assignments.iter().enumerate();
        Yardstick {
            places: names
                .into_iter()
                .enumerate()
                .map(|(i, name)| (name, i))
                .collect(),
            exact: exact(view, &states),
            states,
            outputs: assignments
                .map(|(index, assignment)| (print_output(view, assignment.output), index))
                .collect(),
            arrays: arrays.map(|array| name(array.name)).collect(),
        }
    }

    /// Adds states of the same function: numbers of all its input elements.
    pub fn extend(&mut self, view: View<'_>, states: Vec<Vec<f64>>) {
        self.exact.extend(exact(view, &states));
        self.states.extend(states);
    }

    /// The number of states.
    pub fn len(&self) -> usize {
        self.states.len()
    }

    /// True without states.
    pub fn is_empty(&self) -> bool {
        self.states.is_empty()
    }

    /// The inputs of a program in every state.
    pub fn inputs(&self, view: View<'_>) -> Result<Vec<Vec<f64>>, Unmeasurable> {
        let places = self.input_places(view)?;
        let pick = |state: &Vec<f64>| places.iter().map(|&place| state[place]).collect();
        Ok(self.states.iter().map(pick).collect())
    }

    /// The place in a state of every input of a program.
    fn input_places(&self, view: View<'_>) -> Result<Vec<usize>, Unmeasurable> {
        let place = |name: String| {
            let place = self.places.get(&name).copied();
            place.ok_or(Unmeasurable::Input(name))
        };
        input_names(view).into_iter().map(place).collect()
    }

    /// The errors of a program computed in a format.
    pub fn errors(&self, view: View<'_>, format: Format) -> Result<MeasuredErrors, Unmeasurable> {
        let inputs = self.inputs(view)?;
        self.judge(view, &results(view, format, &inputs))
    }

    /// The errors of results that were computed elsewhere: for each state the
    /// outputs of a program, in the order of its assignments.
    pub fn judge(
        &self,
        view: View<'_>,
        results: &[Vec<f64>],
    ) -> Result<MeasuredErrors, Unmeasurable> {
        assert_eq!(
            results.len(),
            self.exact.len(),
            "every state has its results"
        );
        let rows = self.rows(view)?;
        let names = view.function.assignments.iter();
        let names = names.map(|a| print_output(view, a.output));
        let mut tally = ErrorTally {
            relative: Vec::new(),
            vanishes: false,
            normwise: Vec::new(),
            arrays: vec![Vec::new(); self.arrays.len()],
            outputs: names.map(LargestErrors::none).collect(),
        };
        for (state, (exact, computed)) in self.exact.iter().zip(results).enumerate() {
            tally.add(state, &rows, exact, computed);
        }
        if tally.relative.is_empty() && tally.vanishes {
            tally.relative.push(f64::INFINITY);
        }
        Ok(MeasuredErrors {
            relative: ErrorSpread::of(&mut tally.relative),
            normwise: ErrorSpread::of(&mut tally.normwise),
            arrays: (tally.arrays.iter_mut())
                .map(|errors| ErrorSpread::of(errors))
                .collect(),
            outputs: tally.outputs,
        })
    }

    /// For every state the largest error of an output over the allowed one, for
    /// results as for [`Yardstick::judge`]; `allowed` is the program's.
    pub fn shares(
        &self,
        view: View<'_>,
        results: &[Vec<f64>],
        allowed: &Allowed,
    ) -> Result<Vec<f64>, Unmeasurable> {
        let rows = self.rows(view)?;
        let share = |(exact, computed): (&Vec<Double>, &Vec<f64>)| {
            assert_eq!(computed.len(), rows.len(), "one result per output");
            let exact: Vec<Double> = rows.iter().map(|row| row.of(exact)).collect();
            let values: Vec<f64> = exact.iter().map(|value| value.high).collect();
            let shares = exact.iter().zip(computed).zip(allowed.of(&values));
            // Nothing can be said of a state without an exact result.
            let shares = shares.filter(|((exact, _), _)| exact.high.is_finite());
            let shares = shares
                .map(|((exact, computed), allowed)| quotient(distance(*exact, *computed), allowed));
            shares.fold(0.0, f64::max)
        };
        Ok(self.exact.iter().zip(results).map(share).collect())
    }

    /// Places of the outputs of a program in the exact results.
    fn rows(&self, view: View<'_>) -> Result<Vec<ExactPlace>, Unmeasurable> {
        let row = |output: Output| {
            let name = print_output(view, output);
            let (array, _, _) = view.function.output_element(output);
            let own = view.tables.symbols.text(array.name);
            let array = self.arrays.iter().position(|array| array == own);
            Ok(ExactPlace {
                exact: self.outputs.get(&name).copied(),
                array: array.ok_or(Unmeasurable::Output(name))?,
            })
        };
        let assignments = view.function.assignments.iter();
        assignments
            .map(|assignment| row(assignment.output))
            .collect()
    }
}

/// Distance of a result from the exact number; infinite for NaN.
fn distance(exact: Double, computed: f64) -> f64 {
    if computed.is_finite() {
        exact.distance(computed)
    } else {
        f64::INFINITY
    }
}

/// Errors, state after state.
struct ErrorTally {
    relative: Vec<f64>,
    /// True when an element that is zero but for rounding differs.
    vanishes: bool,
    normwise: Vec<f64>,
    arrays: Vec<Vec<f64>>,
    outputs: Vec<LargestErrors>,
}

impl ErrorTally {
    fn add(&mut self, state: usize, rows: &[ExactPlace], exact: &[Double], computed: &[f64]) {
        assert_eq!(computed.len(), rows.len(), "one result per output");
        let mut norms: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for (row, &computed) in rows.iter().zip(computed) {
            let exact = row.of(exact);
            if exact.high.is_finite() {
                let norm = norms.entry(row.array).or_default();
                norm.0 = norm.0.max(distance(exact, computed));
                norm.1 = norm.1.max(exact.high.abs());
            }
        }
        for ((row, &computed), output) in rows.iter().zip(computed).zip(&mut self.outputs) {
            let Some(&(_, size)) = norms.get(&row.array) else {
                continue;
            };
            let exact = row.of(exact);
            if !exact.high.is_finite() {
                continue;
            }
            let absolute = distance(exact, computed);
            let own = exact.high.abs();
            let normwise = quotient(absolute, size);
            if normwise > output.normwise {
                (output.normwise, output.worst_state) = (normwise, state);
            }
            if absolute == 0.0 || own > size * VANISHING {
                self.relative.push(quotient(absolute, own));
            } else {
                self.vanishes = true;
            }
        }
        for (&array, &(error, size)) in &norms {
            self.arrays[array].push(quotient(error, size));
        }
        let norms = norms
            .values()
            .filter(|(error, size)| *error > 0.0 || *size > 0.0);
        self.normwise
            .extend(norms.map(|&(error, size)| quotient(error, size)));
    }
}

impl LargestErrors {
    fn none(name: String) -> LargestErrors {
        LargestErrors {
            name,
            normwise: 0.0,
            worst_state: 0,
        }
    }
}

impl ErrorSpread {
    /// The places in a population, which is reordered; zero for an empty one.
    pub fn of(errors: &mut [f64]) -> ErrorSpread {
        errors.sort_unstable_by(f64::total_cmp);
        let place = |part: usize, of: usize| match errors.len() {
            0 => 0.0,
            count => errors[(count * part).div_ceil(of) - 1],
        };
        ErrorSpread {
            median: place(1, 2),
            percentile_99: place(99, 100),
            worst: place(1, 1),
        }
    }
}

/// The error over the size; no error is 0 for any size.
fn quotient(error: f64, size: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / size }
}

/// The names of all input elements, in order.
pub fn input_names(view: View<'_>) -> Vec<String> {
    let inputs = 0..view.function.input_len() as u32;
    inputs
        .map(|index| print_operand(view, Input(index).into()))
        .collect()
}

/// The outputs of a program at states, in a format, as binary64 numbers.
pub fn results(view: View<'_>, format: Format, states: &[Vec<f64>]) -> Vec<Vec<f64>> {
    // A function whose values have their own formats computes in them.
    if view.function.formats.is_some() {
        let run = |state: &Vec<f64>| evaluate_mixed(view.function, format, state);
        return states.iter().map(run).collect();
    }
    let single = FormatArithmetic::new(format);
    if let Some(unit) = view.function.trigonometry_unit() {
        let unit = unit.expect("the verifier accepts only names of units");
        let lanes = Batch([unit.within(single); LANES]);
        return in_lanes(view, &lanes, |number| single.convert(number), states);
    }
    match format {
        Format::BINARY64 => in_lanes(view, &Batch([Binary64; LANES]), |number| number, states),
        Format::BINARY32 => {
            let lanes = Batch([Binary32; LANES]);
            let results = in_lanes(view, &lanes, |number| number as f32, states);
            let wide = |row: Vec<f32>| row.into_iter().map(f64::from).collect();
            results.into_iter().map(wide).collect()
        }
        _ => {
            let lanes = FormatLanes::<LANES>(single);
            in_lanes(view, &lanes, |number| single.convert(number), states)
        }
    }
}

fn exact(view: View<'_>, states: &[Vec<f64>]) -> Vec<Vec<Double>> {
    let mut reference = ReferenceEvaluator::new(view.function, ReferenceEffort::DoubleDouble);
    let results = reference.evaluate(states).into_iter();
    let values = |row: Vec<ExactOutput>| row.into_iter().map(|exact| exact.value).collect();
    results.map(values).collect()
}

/// The outputs of a function at states, a few at a time.
fn in_lanes<N: Copy, A: Arithmetic<Number = [N; LANES]>>(
    view: View<'_>,
    arithmetic: &A,
    input: impl Fn(f64) -> N,
    states: &[Vec<f64>],
) -> Vec<Vec<N>> {
    let plan = EvaluationPlan::new(view.function);
    let mut memory = Vec::new();
    let mut results = Vec::with_capacity(states.len());
    for group in states.chunks(LANES) {
        let inputs = gathered(group, &input);
        let outputs = plan.run(arithmetic, &inputs, &mut memory);
        for lane in 0..group.len() {
            results.push(outputs.iter().map(|lanes| lanes[lane]).collect());
        }
    }
    results
}

/// The inputs of a group of states, by inputs; the first fills up a group.
fn gathered<N: Copy>(group: &[Vec<f64>], input: impl Fn(f64) -> N) -> Vec<[N; LANES]> {
    let number = |place: usize, lane: usize| group.get(lane).unwrap_or(&group[0])[place];
    let inputs = 0..group[0].len();
    inputs
        .map(|place| array::from_fn(|lane| input(number(place, lane))))
        .collect()
}
