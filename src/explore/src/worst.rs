//! The largest errors of programs over all states in the ranges of their
//! inputs: found by a directed search, a lower bound, and proved, an upper one.
//!
//! Errors are those of an output over the largest element of its array in the
//! same state, or over the usual size of the array where that is larger: an
//! array that vanishes has no relative error. The rounding of inputs counts.

use crate::program::view;
use robovec_analysis::adjoint::Tape;
use robovec_analysis::interval::{GivenData, input_ranges};
use robovec_analysis::norms::norm_bounds;
use robovec_error::adversary::{Climbs, ROUND, StateBreeder};
use robovec_error::yardstick::{QuickYardstick, Unmeasurable};
use robovec_framework::scene::{Allowed, ArraySizes, Scene};
use robovec_ir::states::States;
use robovec_ir::{Format, Input, Module};
use robovec_num::interval::Interval;

/// Operations that a search evaluates, about a second.
const WORK: u64 = 300_000_000;

/// Maximum number of states of a search.
const STATES: u64 = 1 << 18;

/// Number of drawn states that a search begins from.
const STARTS: u64 = 64;

/// Maximum number of operations of a program that is bounded, about a second.
const LARGEST: usize = 6000;

/// Largest errors of a program.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub(crate) struct WorstErrors {
    /// The largest error that was found.
    pub(crate) found: f64,
    /// Bound for all states; `None` where there is none.
    pub(crate) proved: Option<f64>,
}

impl WorstErrors {
    /// The larger of the error that the search found and that of random states; the
    /// latter counts up to the bound, which is not relative to vanishing arrays.
    pub(crate) fn with_sampled(self, sampled: f64) -> f64 {
        self.found
            .max(sampled.min(self.proved.unwrap_or(f64::INFINITY)))
    }
}

/// The largest errors of a program in a number format for the function `exact`,
/// in the ranges of the states. Sizes of arrays are those of the scene, or
/// estimated. Fails when the program computes other arrays.
pub(crate) fn worst(
    exact: &Module,
    (program, format): (&Module, Format),
    states: &States,
    scene: Option<&Scene>,
) -> Result<WorstErrors, Unmeasurable> {
    let (exact, program) = (view(exact), view(program));
    let sizes = ArraySizes::of(exact, scene);
    let allowed = Allowed::new(program, None, 1.0, &sizes);
    let least = allowed.of(&vec![0.0; program.function.assignments.len()]);
    let quick = QuickYardstick::new(exact, (program, format), allowed)?;
    let ranges_of = |view| -> Vec<Interval> {
        let inputs = input_ranges(view, states).into_iter();
        inputs.map(|input| input.range).collect()
    };
    let ranges = ranges_of(exact);
    let breeder = StateBreeder::new((exact, format), |input| {
        let (array, indices, _) = exact.function.input_element(Input(input));
        let name = exact.tables.symbols.text(array.name);
        let is_given = states.ranges().get(name, indices).is_some();
        // Inertia tensors that are drawn are symmetric, which climbs do not keep.
        let Interval { low, high } = ranges[input as usize];
        (is_given || name != "In").then_some([low, high])
    });
    let seed = states.seed();
    let draw = |number: u64| states.draw(exact, number as u32);
    let starts: Vec<Vec<f64>> = (0..STARTS).map(draw).collect();
    let mut climbs = Climbs::new((&quick, &breeder), &starts, draw, seed);
    for _ in 0..(quick.states_of(WORK).min(STATES) / ROUND).max(1) {
        climbs.round();
    }
    let is_plain = program.function.formats.is_none()
        && program.function.trigonometry_unit().is_none()
        && program.function.nodes().len() <= LARGEST;
    let proved = is_plain.then(|| {
        let tape = Tape::new(program.function);
        let bounds = norm_bounds(&tape, &ranges_of(program), format, GivenData::Real);
        let outputs = least.iter().enumerate();
        let shares = outputs.map(|(output, least)| {
            let error = bounds.error[tape.output_slot(output)];
            if error == 0.0 { 0.0 } else { error / least }
        });
        shares.fold(0.0, f64::max)
    });
    Ok(WorstErrors {
        found: climbs.worst(),
        proved: proved.filter(|bound| bound.is_finite()),
    })
}
