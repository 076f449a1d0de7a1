//! Equality in numbers: both versions with bounds of their rounding.
//!
//! A field has neither signs nor domains of functions, and constants may vanish
//! in it. So both versions are also evaluated over the real numbers, in
//! double-double with a bound of its error, at states near and far, whole and
//! not, positive and negative, and near the constants of the versions, where
//! roots and quotients change their sign. Outputs whose bounds do not touch are
//! different numbers.

use super::failure::{Failed, Values};
use super::pairing::Pairs;
use super::states::{SCALES, StatePlace, StateScale};
use robovec_analysis::reference::{ReferenceEffort, ReferenceEvaluator};
use robovec_ir::Function;
use robovec_ir::plan::EvaluationPlan;
use robovec_ir::states::States;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::ball::{Ball, Balls};
use std::array;

/// States evaluated at a time: one of each scale.
pub(super) const LANES: usize = SCALES.len();

/// The observations when all outputs agreed.
#[derive(Clone, Default, Debug)]
pub(super) struct NumbersAgree {
    /// The number of states at which outputs were compared.
    pub(super) states: u32,
    /// For every output the number of states that decided: its values are
    /// known there well enough to show a wrong term.
    pub(super) decided: Vec<u32>,
    /// The largest change of an output, relative to the largest element of its
    /// array.
    pub(super) distance: f64,
}

/// The states and outputs to compare.
pub(super) struct Survey {
    pub(super) rounds: Vec<[StatePlace; LANES]>,
    /// One pair of [`Pairs::list`], or all.
    pub(super) only: Option<usize>,
}

pub(super) fn every_scale(round: u32) -> [StatePlace; LANES] {
    SCALES.map(|scale| StatePlace {
        scale,
        number: round,
    })
}

/// All states with zeros, then rounds of every scale.
pub(super) fn everywhere(pairs: &Pairs<'_>, rounds: u32) -> Vec<[StatePlace; LANES]> {
    let zeros = (0..pairs.zero_states().div_ceil(LANES as u32)).map(|round| {
        array::from_fn(|lane| StatePlace {
            scale: StateScale::Zero,
            number: round * LANES as u32 + lane as u32,
        })
    });
    zeros.chain((0..rounds).map(every_scale)).collect()
}

/// Rounds of usual states alone.
pub(super) fn usual(rounds: u32) -> Vec<[StatePlace; LANES]> {
    let round =
        |round| array::from_fn(|lane| StatePlace::usual(round * LANES as u32 + lane as u32));
    (0..rounds).map(round).collect()
}

/// The part of an output within which it must be known to decide anything.
const DECIDES: f64 = 1e-6;
/// The bound within which an output that may be zero must be known.
const DECIDES_ZERO: f64 = 1e-12;

/// Compares the outputs, those before being computed with an arithmetic of
/// the caller's.
pub(super) fn compare<A>(
    pairs: &Pairs<'_>,
    arithmetic: &A,
    source: &States,
    survey: Survey,
) -> Result<NumbersAgree, Failed>
where
    A: Arithmetic<Number = Ball<LANES>>,
{
    let mut comparison = OutputComparison::new(pairs, survey.only);
    let plan = |function: &Function, places: &[usize]| {
        EvaluationPlan::of(function, |place| places.binary_search(&place).is_ok())
    };
    let before = plan(pairs.before.function, &comparison.places[0]);
    let after = plan(pairs.after.function, &comparison.places[1]);
    let mut memory = Vec::new();
    for states in survey.rounds {
        let inputs = states.map(|state| pairs.numbers(source, state));
        let lanes = |version: usize| -> Vec<Ball<LANES>> {
            let count = inputs[0][version].len();
            (0..count)
                .map(|index| Ball::exact(array::from_fn(|lane| inputs[lane][version][index])))
                .collect()
        };
        let old = before.run(arithmetic, &lanes(0), &mut memory);
        let new = after.run(&Balls::<LANES>, &lanes(1), &mut memory);
        comparison.round(states, &inputs, [&old, &new])?;
    }
    Ok(comparison.agreement)
}

/// The comparison of the outputs of two versions, round after round.
struct OutputComparison<'a> {
    pairs: &'a Pairs<'a>,
    /// Of [`Pairs::list`], those that are compared.
    wanted: Vec<usize>,
    /// By version: the assignments they are, in ascending order.
    places: [Vec<usize>; 2],
    /// Outputs that may still be evaluated in arbitrary precision.
    precise: u32,
    agreement: NumbersAgree,
}

impl<'a> OutputComparison<'a> {
    fn new(pairs: &'a Pairs<'a>, only: Option<usize>) -> OutputComparison<'a> {
        let all = 0..pairs.list.len();
        let wanted: Vec<usize> = all
            .filter(|&pair| only.is_none_or(|only| only == pair))
            .collect();
        let sorted = |mut places: Vec<usize>| {
            places.sort_unstable();
            places
        };
        let before = wanted.iter().map(|&pair| pairs.list[pair].before).collect();
        let after = wanted.iter().map(|&pair| pairs.list[pair].after).collect();
        OutputComparison {
            pairs,
            places: [sorted(before), sorted(after)],
            wanted,
            precise: MAX_PRECISE,
            agreement: NumbersAgree {
                decided: vec![0; pairs.list.len()],
                ..NumbersAgree::default()
            },
        }
    }

    /// Compares the outputs of both versions at the states of a round.
    fn round(
        &mut self,
        states: [StatePlace; LANES],
        inputs: &[[Vec<f64>; 2]; LANES],
        [old, new]: [&[Ball<LANES>]; 2],
    ) -> Result<(), Failed> {
        let pairs = self.pairs;
        let function = pairs.before.function;
        if states[0].scale == StateScale::Zero {
            // Where numbers are lost at zeros, none overflow.
            self.precise = MAX_PRECISE;
        }
        let mut norms = vec![[(0.0f64, 0.0f64); LANES]; function.outputs().len()];
        for at in 0..self.wanted.len() {
            let index = self.wanted[at];
            let pair = &pairs.list[index];
            let array = function.output_array(pair.output);
            let place = |version: usize, place: usize| {
                self.places[version]
                    .binary_search(&place)
                    .expect("every pair has its places in the plans")
            };
            let outputs = [&old[place(0, pair.before)], &new[place(1, pair.after)]];
            for (lane, &state) in states.iter().enumerate() {
                let norm = &mut norms[array][lane];
                self.lane(index, outputs, (lane, state), &inputs[lane], norm)?;
            }
        }
        self.agreement.states += LANES as u32;
        for &(apart, size) in norms.as_flattened() {
            if apart > 0.0 {
                self.agreement.distance = self.agreement.distance.max(apart / size);
            }
        }
        Ok(())
    }

    /// Compares an output at one state; `norm` is the largest distance and the
    /// largest size of an element of its array so far.
    fn lane(
        &mut self,
        pair: usize,
        [old, new]: [&Ball<LANES>; 2],
        (lane, state): (usize, StatePlace),
        inputs: &[Vec<f64>; 2],
        (apart, size): &mut (f64, f64),
    ) -> Result<(), Failed> {
        let mut after = new.value.high[lane];
        let differs = match (old.is_known(lane), new.is_known(lane)) {
            (true, true) if old.touches(new, lane) => {
                let largest = old.value.high[lane].abs().max(new.value.high[lane].abs());
                let allowed = old.radius[lane] + new.radius[lane];
                let needed = if largest <= allowed {
                    DECIDES_ZERO
                } else {
                    DECIDES * largest
                };
                if allowed <= needed {
                    self.agreement.decided[pair] += 1;
                    *apart = apart.max(old.distance(new, lane));
                    *size = size.max(old.value.high[lane].abs());
                }
                false
            }
            (true, true) => true,
            // What may be beyond the range is no number in binary64.
            (true, false) if self.precise > 0 && old.reach(lane).is_finite() => {
                self.precise -= 1;
                let place = self.pairs.list[pair].after;
                // What is computed there without a bound is no value.
                after = f64::NAN;
                is_lost(self.pairs.after.function, &[place], &inputs[1])
            }
            _ => false,
        };
        if differs {
            Err(Failed {
                pair,
                values: Values {
                    state,
                    before: old.value.high[lane],
                    after,
                    allowed: old.radius[lane] + new.radius[lane],
                },
                inputs: None,
            })
        } else {
            Ok(())
        }
    }
}

/// Number of outputs that are evaluated in arbitrary precision to find out
/// whether a number was lost or only overflowed, and those of larger functions
/// never.
pub(super) const MAX_PRECISE: u32 = 4;
const LARGEST_PRECISE: usize = 20_000;

/// Tests whether one of the outputs of a function, by their places among its
/// assignments, is no number: over the real numbers, and not because an
/// intermediate result was too large.
pub(super) fn is_lost(function: &Function, places: &[usize], inputs: &[f64]) -> bool {
    if function.nodes().len() > LARGEST_PRECISE {
        return false;
    }
    let mut reference = ReferenceEvaluator::new(function, ReferenceEffort::Audit);
    let exact = reference.evaluate_places(inputs, places);
    exact.iter().any(|exact| !exact.value.high.is_finite())
}
