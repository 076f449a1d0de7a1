//! The largest errors of a program's own rounding: of its operations and, for
//! data that are real numbers, of its inputs and literals.

use super::climb::GENERATION;
use super::{Climbs, ROUND, RoundingGuide, StateBreeder};
use crate::yardstick::{LANES, QuickMemory, QuickYardstick};
use robovec_analysis::adjoint::half_ulp;
use robovec_analysis::interval::GivenData;
use robovec_ir::{Format, View};
use robovec_num::interval::Interval;
use robovec_num::random::{mix, unit};
use robovec_num::soft_float::FormatArithmetic;

/// Number of operations that a search evaluates for one unit of effort.
const WORK: u64 = 1 << 30;

/// Maximum number of states for one unit of effort.
const STATES: u64 = 1 << 18;

/// Part of the work that goes into adjoints.
const GUIDED: u64 = 8;

/// Number of states that a search begins from.
const STARTS: u64 = 64;

/// The subject of a search.
#[derive(Clone, Copy)]
pub struct SearchSubject<'a> {
    /// The program.
    pub view: View<'a>,
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
    /// Largest absolute error of every output, in the order of assignments.
    pub errors: Vec<f64>,
    /// The states at which they were found; empty where every result is exact.
    pub states: Vec<Vec<f64>>,
    /// Number of states that were tried.
    pub tried: u64,
}

/// Searches for the largest error of every output; states grow with effort.
///
/// # Panics
///
/// Panics when there is not one range per input element.
pub fn largest_errors(subject: SearchSubject<'_>, seed: u64, effort: u32) -> FoundErrors {
    let quick = subject.yardstick();
    let states = quick.states_of(WORK).min(STATES) * u64::from(effort);
    subject.search(&quick, seed, states)
}

impl<'a> SearchSubject<'a> {
    fn yardstick(&self) -> QuickYardstick<'a> {
        let count = self.view.function.input_len();
        assert_eq!(self.inputs.len(), count, "one range per input element");
        QuickYardstick::own((self.view, self.format), self.data, self.inputs)
    }

    /// The search with a number of states, rounded up to whole generations.
    #[cfg(test)]
    pub(super) fn largest_of(self, seed: u64, states: u64) -> FoundErrors {
        self.search(&self.yardstick(), seed, states)
    }

    fn search(self, quick: &QuickYardstick<'a>, seed: u64, states: u64) -> FoundErrors {
        let outputs = quick.outputs();
        let mut found = FoundErrors {
            errors: vec![0.0; outputs],
            states: vec![Vec::new(); outputs],
            tried: 0,
        };
        let Some(ranges) = self.ranges().filter(|_| outputs > 0) else {
            return found;
        };
        let breeder = StateBreeder::new((self.view, self.format), |input| {
            let Interval { low, high } = ranges[input as usize];
            Some([low, high])
        });
        let draw = |number: u64| {
            let place = |input: usize| unit(mix(seed ^ mix(number << 32 | input as u64)));
            let numbers = ranges.iter().enumerate();
            let numbers =
                numbers.map(|(input, range)| range.low + (range.high - range.low) * place(input));
            let state = numbers.collect();
            match number % 4 {
                3 => breeder.corner(state, mix(seed ^ mix(!number))),
                _ => state,
            }
        };
        let mut starts: Vec<Vec<f64>> = (0..STARTS).map(draw).collect();
        let mut guide = RoundingGuide::new(quick);
        let guided = guide.climb(&breeder, &starts, (states / GUIDED, seed));
        starts = RoundingGuide::beside(guided.clone(), &starts);
        let begin = |number: u64| match guided.len() as u64 {
            len if len > 0 && number.is_multiple_of(3) => {
                guided[(mix(number) % len) as usize].clone()
            }
            _ => draw(number),
        };
        let mut climbs = Climbs::new((quick, &breeder), &starts, begin, seed);
        while found.tried < states.max(GENERATION) {
            let left = (states - found.tried.min(states)).clamp(GENERATION, ROUND);
            let generations = left.div_ceil(GENERATION);
            climbs.round_of(generations);
            found.tried += generations * GENERATION;
        }
        let records = climbs.records().iter();
        let states: Vec<Vec<f64>> = records
            .filter_map(|(_, state)| Some(state.as_deref()?.clone()))
            .collect();
        // Climbs measure quickly; what they found is measured exactly.
        let exact = self.yardstick().exactly();
        let mut memory = QuickMemory::default();
        for group in states.chunks(LANES) {
            for (output, errors) in exact.shares(group, &mut memory).into_iter().enumerate() {
                for (state, error) in group.iter().zip(errors) {
                    if error.is_finite() && error > found.errors[output] {
                        found.errors[output] = error;
                        found.states[output].clone_from(state);
                    }
                }
            }
        }
        found
    }

    /// Ranges of the numbers of inputs: those of the format for held data.
    fn ranges(&self) -> Option<Vec<Interval>> {
        if self.data == GivenData::Real {
            return Some(self.inputs.to_vec());
        }
        let arithmetic = FormatArithmetic::new(self.format);
        let inner = |range: &Interval| {
            let step = |number| 2.0 * half_ulp(self.format, number);
            let [mut low, mut high] = [range.low, range.high].map(|end| arithmetic.convert(end));
            if low < range.low {
                low = arithmetic.convert(low + step(low));
            }
            if high > range.high {
                high = arithmetic.convert(high - step(high));
            }
            (low <= high).then(|| Interval::new(low, high))
        };
        self.inputs.iter().map(inner).collect()
    }
}
