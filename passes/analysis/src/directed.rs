//! Directed search for the states with the largest errors.
//!
//! States are drawn in the ranges, some of them with elements at the ends of
//! their ranges and at zero, and then bred from the worst state of every
//! output. Rounding errors jump from one number to the next, so there is no
//! gradient: a child is measured, and the worse of parent and child continues.
//! A found error is a lower bound of the worst one, no more.
//!
//! Errors are differences from double-double. Every state is counted in
//! operations, so that the same search gives the same states everywhere.

use crate::adjoint::Tape;
use crate::interval::{GivenData, between, exact_literal};
use robovec_ir::Format;
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::interval::Interval;
use robovec_num::random::{Random, mix};
use robovec_num::soft_float::FormatArithmetic;

/// Number of operations that a search evaluates.
const WORK: usize = 1 << 27;

/// Minimum and maximum number of states.
const STATES: [usize; 2] = [64, 1 << 18];

/// Number of every eight states that are drawn; the others are bred.
const DRAWN_OF_EIGHT: usize = 3;

/// The subject of a search.
#[derive(Clone, Copy, Debug)]
pub struct SearchSubject<'a> {
    /// The function.
    pub tape: &'a Tape,
    /// The range of every input element.
    pub inputs: &'a [Interval],
    /// The format of the computation.
    pub format: Format,
    /// Kind of inputs before the run.
    pub data: GivenData,
}

/// Errors that a search found.
#[derive(Clone, PartialEq, Debug)]
pub struct FoundErrors {
    /// The largest error of every output, by its place among the assignments.
    pub errors: Vec<f64>,
    /// The states, as exact numbers, at which they were found.
    pub states: Vec<Vec<f64>>,
    /// Number of states that gave finite results.
    pub tried: usize,
}

/// Searches for the largest error of every output.
///
/// # Panics
///
/// Panics when there is not one range per input element.
pub fn largest_errors(subject: SearchSubject<'_>, seed: u64) -> FoundErrors {
    let [least, most] = STATES;
    let states = (WORK / (subject.tape.slots() + 1)).clamp(least, most);
    search(subject, seed, states)
}

/// The search with a number of states.
pub(crate) fn search(subject: SearchSubject<'_>, seed: u64, states: usize) -> FoundErrors {
    let tape = subject.tape;
    assert_eq!(
        subject.inputs.len(),
        tape.inputs(),
        "one range per input element"
    );
    let drawn = states / 8 * DRAWN_OF_EIGHT;
    let mut found = FoundErrors {
        errors: vec![0.0; tape.outputs()],
        states: vec![Vec::new(); tape.outputs()],
        tried: 0,
    };
    let free: Vec<usize> = (0..subject.inputs.len())
        .filter(|&input| subject.inputs[input].low < subject.inputs[input].high)
        .collect();
    let literals = tape.constants().iter();
    let literals: Vec<Double> = literals
        .map(|&number| exact_literal(number, subject.data))
        .collect();
    for number in 0..states {
        let mut random = Random::new(mix(seed ^ mix(number as u64)));
        let parents = found.states.len().max(1);
        let parent = found.states.get(number % parents);
        let state = match parent {
            Some(parent) if number >= drawn && !parent.is_empty() && !free.is_empty() => {
                subject.child(parent, &free, &mut random)
            }
            _ => subject.drawn(number, &mut random),
        };
        let (state, errors) = subject.errors(state, &literals, &mut random);
        if errors.iter().all(|error| error.is_finite()) {
            found.tried += 1;
        }
        for (output, error) in errors.into_iter().enumerate() {
            // Equal ones move on, so that a search does not stay in one place.
            if error.is_finite() && error >= found.errors[output] {
                found.errors[output] = error;
                found.states[output].clone_from(&state);
            }
        }
    }
    found
}

impl SearchSubject<'_> {
    /// A state within the ranges; in every fourth one most elements are at the
    /// ends of their ranges or zero.
    fn drawn(&self, number: usize, random: &mut Random) -> Vec<f64> {
        let draw = |range: &Interval| {
            let place = random.unit();
            if number % 4 == 3 && place < 0.75 {
                match (place * 4.0) as u32 {
                    0 => range.low,
                    1 => range.high,
                    _ => 0f64.clamp(range.low, range.high),
                }
            } else {
                range.low + (range.high - range.low) * random.unit()
            }
        };
        self.inputs.iter().map(draw).collect()
    }

    /// A state with up to three elements changed.
    fn child(&self, parent: &[f64], free: &[usize], random: &mut Random) -> Vec<f64> {
        let mut state = parent.to_vec();
        for _ in 0..1 + random.below(3) {
            let input = free[random.below(free.len())];
            let Interval { low, high } = self.inputs[input];
            let (place, depth) = (random.unit(), random.below(40));
            let number = match random.below(8) {
                0 => low,
                1 => high,
                2 => 0.0,
                3 => low + (high - low) * place,
                // From half of the range down to the last digits.
                _ => state[input] + (high - low) * 0.5f64.powi(depth as i32) * (place - 0.5),
            };
            state[input] = number.clamp(low, high);
        }
        state
    }

    /// The errors of all outputs at a state, and the state as it was taken:
    /// data that are held are numbers of the format, real ones lie anywhere
    /// between those of binary64.
    fn errors(
        &self,
        mut state: Vec<f64>,
        literals: &[Double],
        random: &mut Random,
    ) -> (Vec<f64>, Vec<f64>) {
        let arithmetic = FormatArithmetic::new(self.format);
        let held: Vec<f64> = state.iter().map(|&x| arithmetic.convert(x)).collect();
        let mut inside = true;
        if self.data == GivenData::Held {
            let mut ranges = self.inputs.iter().zip(&held);
            inside = ranges.all(|(range, &number)| range.contains(number));
            state.clone_from(&held);
        }
        let tape = self.tape;
        let mut errors = vec![f64::NAN; tape.outputs()];
        if inside {
            let inputs = state.iter().zip(self.inputs).map(|(&number, &range)| {
                if self.data == GivenData::Held {
                    Double::from(number)
                } else {
                    between(self.format, number, range, random.unit())
                }
            });
            let exact = tape.evaluate_numbers(&DoubleDouble, inputs, literals.iter().copied());
            let computed = tape.evaluate(&arithmetic, &held);
            for (output, error) in errors.iter_mut().enumerate() {
                let slot = tape.output_slot(output);
                *error = (Double::from(computed[slot]) - exact[slot]).high.abs();
            }
        }
        (state, errors)
    }
}
