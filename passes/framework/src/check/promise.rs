//! The promises of approximating passes about the outputs, and their verdicts.

use super::failure::{Failed, Values};
use super::numbers::{self, LANES, Survey};
use super::pairing::Pairs;
use super::states::StatePlace;
use crate::scene::Allowed;
use robovec_ir::evaluate::{evaluate, evaluate_mixed};
use robovec_ir::states::{Ranges, States};
use robovec_ir::{Format, View};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::ball::{Ball, Balls};
use robovec_num::double_double::DoubleDouble;
use std::sync::Arc;

/// The promise of a pass about the function it gives.
#[derive(Clone, Debug)]
pub enum Promise {
    /// Sines and cosines are within these absolute errors while the inputs
    /// lie within their ranges.
    Waves {
        /// The ranges of the inputs of angles.
        ranges: Arc<Ranges>,
        /// The largest proved errors of sine and cosine.
        errors: [f64; 2],
    },
    /// Outputs computed in the formats of their values have at most certain
    /// errors at the states at which the pass measured them.
    Outputs {
        /// The errors.
        allowed: Allowed,
        /// The states.
        states: States,
        /// The numbers of the first state and of the one after the last.
        numbers: [u32; 2],
    },
}

impl Promise {
    /// The states at which the promise holds.
    pub(super) fn states(&self, states: &States) -> States {
        match self {
            Promise::Waves { ranges, .. } => {
                let mut all = states.ranges().clone();
                for (array, indices, [low, high]) in ranges.iter() {
                    all.set(array, indices, low, high);
                }
                states.clone().within(Arc::new(all))
            }
            Promise::Outputs { .. } => states.clone(),
        }
    }

    /// The number of states at which the promise was found to hold, or an
    /// output for which it does not.
    pub(super) fn keeps(
        &self,
        pairs: &Pairs<'_>,
        states: &States,
        rounds: u32,
    ) -> Result<u32, Failed> {
        match self {
            Promise::Waves { errors, .. } => {
                let waves = Waves { errors: *errors };
                let survey = Survey {
                    rounds: numbers::usual(rounds),
                    only: None,
                };
                numbers::compare(pairs, &waves, states, survey).map(|found| found.states)
            }
            Promise::Outputs {
                allowed,
                states,
                numbers: [first, end],
            } => {
                let end = first.saturating_add(rounds.saturating_mul(8)).min(*end);
                for number in *first..end {
                    measured(pairs, states, allowed, number)?;
                }
                Ok(end - first)
            }
        }
    }
}

/// One state of a measured promise.
fn measured(
    pairs: &Pairs<'_>,
    states: &States,
    allowed: &Allowed,
    number: u32,
) -> Result<(), Failed> {
    let [old, new] = pairs.state(states, number);
    let View { function, .. } = pairs.before;
    let literals: Vec<_> = old.iter().map(|&x| DoubleDouble.literal(x)).collect();
    let before = evaluate(function, &DoubleDouble, &literals);
    let after = evaluate_mixed(pairs.after.function, Format::BINARY64, &new);
    let exact: Vec<f64> = before.iter().map(|number| number.high).collect();
    let allowed = allowed.of(&exact);
    let state = StatePlace::usual(number);
    for (index, pair) in pairs.list.iter().enumerate() {
        let (before, after) = (before[pair.before], after[pair.after]);
        let limit = allowed[pair.before];
        let kept = !before.high.is_finite() || before.distance(after) <= limit;
        if !kept {
            let values = Values {
                state,
                before: before.high,
                after,
                allowed: limit,
            };
            return Err(Failed {
                pair: index,
                values,
                inputs: Some(old),
            });
        }
    }
    Ok(())
}

/// The numbers with bounds, in which sines and cosines may be off by an
/// error.
struct Waves {
    errors: [f64; 2],
}

impl Waves {
    fn widened(mut ball: Ball<LANES>, error: f64) -> Ball<LANES> {
        for radius in &mut ball.radius {
            *radius += error;
        }
        ball
    }
}

impl Arithmetic for Waves {
    type Number = Ball<LANES>;

    fn literal(&self, number: f64) -> Ball<LANES> {
        Balls.literal(number)
    }
    fn neg(&self, a: Ball<LANES>) -> Ball<LANES> {
        Balls.neg(a)
    }
    fn add(&self, a: Ball<LANES>, b: Ball<LANES>) -> Ball<LANES> {
        Balls.add(a, b)
    }
    fn sub(&self, a: Ball<LANES>, b: Ball<LANES>) -> Ball<LANES> {
        Balls.sub(a, b)
    }
    fn mul(&self, a: Ball<LANES>, b: Ball<LANES>) -> Ball<LANES> {
        Balls.mul(a, b)
    }
    fn div(&self, a: Ball<LANES>, b: Ball<LANES>) -> Ball<LANES> {
        Balls.div(a, b)
    }
    fn sin(&self, a: Ball<LANES>) -> Ball<LANES> {
        Waves::widened(Balls.sin(a), self.errors[0])
    }
    fn cos(&self, a: Ball<LANES>) -> Ball<LANES> {
        Waves::widened(Balls.cos(a), self.errors[1])
    }
    fn sqrt(&self, a: Ball<LANES>) -> Ball<LANES> {
        Balls.sqrt(a)
    }
    fn fma(&self, a: Ball<LANES>, b: Ball<LANES>, c: Ball<LANES>) -> Ball<LANES> {
        Balls.fma(a, b, c)
    }
}
