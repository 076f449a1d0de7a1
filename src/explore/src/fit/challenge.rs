//! The search for the state at which a choice is worst.
//!
//! A choice that held at some states may fail at others. Here it is tried at
//! many states that nothing has seen, at corners of the ranges, and then by
//! climbs from the worst of them and from states at which roundings can move
//! outputs most ([`robovec_error::adversary`]), and by others from the worst of
//! them alone. Climbs measure quickly; the worst states that they find are
//! measured again with double-double.
//!
//! **Invariants.** Every state lies in the ranges of the scene. Numbers are
//! those of binary64, not only those that narrower formats hold, since the
//! inputs of a user are not rounded either. Work is counted in operations: the
//! same task gives the same states on any number of threads.

use super::format::shares;
use super::{FitError, FitProgram, FitTask};
use crate::program::view;
use rayon::prelude::*;
use robovec_error::adversary::{Climbs, ROUND, RoundingGuide, StateBreeder};
use robovec_error::yardstick::{QuickYardstick, Yardstick, results};
use robovec_framework::scene::Allowed;
use robovec_ir::count::Counts;
use robovec_ir::{Format, Input};
use robovec_num::random::mix;
use serde::Serialize;

/// Operations for one unit of effort, exact and rounded ones, at drawn states.
const WORK: u64 = 150_000_000;

/// Minimum and maximum number of drawn states for one unit of effort.
const STATES: [u64; 2] = [3072, 3 << 18];

/// Number of drawn states for one corner of the ranges.
const CORNERS: u64 = 12;

/// Operations evaluated by climbs of each kind, for one unit of effort.
const CLIMBED_WORK: u64 = 4_000_000_000;

/// Minimum and maximum states of climbs of each kind for one unit of effort.
const CLIMBED: [u64; 2] = [ROUND, 1 << 20];

/// Part of the states of climbs whose time goes into adjoints.
const GUIDED: u64 = 16;

/// States measured between two tests for a failure.
const BATCH: usize = 4096;

/// States evaluated by one thread at a time.
const CHUNK: usize = 256;

/// Maximum number of states that climbs begin from.
const PARENTS: usize = 64;

/// Maximum number of failing states that are returned for a choice.
const TOLD: usize = 16;

/// Result of trying a choice.
#[derive(Clone, PartialEq, Default, Debug, Serialize)]
pub struct Challenge {
    /// The seed that the fresh states come from.
    pub seed: u64,
    /// Fresh states, drawn from the ranges of the scene.
    pub fresh: u64,
    /// The largest error at them over what is allowed.
    pub fresh_used: f64,
    /// States at corners of the ranges, and of climbs from the worst ones.
    pub directed: u64,
    /// The largest error anywhere over what is allowed.
    pub used: f64,
    /// The largest that is accepted.
    pub accepted: f64,
    /// The worst states, the worst first: inputs of the general function.
    #[serde(skip)]
    pub worst: Vec<Vec<f64>>,
}

impl Challenge {
    /// True when no error was larger than what is accepted of the tolerance.
    pub fn holds(&self) -> bool {
        self.used <= self.accepted
    }

    /// The part of the states in the ranges, drawn uniformly, at which the
    /// choice holds at least, with a confidence of 95 %: when none of n
    /// independent states fails, `p` with `p^n = 0.05`.
    pub fn share(&self) -> f64 {
        0.05f64.powf(1.0 / self.fresh as f64)
    }
}

/// A state with its error over what is allowed.
type JudgedState = (f64, Vec<f64>);

/// A choice that is tried.
struct ChallengeRun<'t> {
    task: &'t FitTask<'t>,
    program: &'t FitProgram,
    format: Format,
    result: Challenge,
    /// The worst states, the worst first.
    worst: Vec<JudgedState>,
}

/// Tries a program in a format; ends at the first batch with an error larger
/// than accepted. `number`: that of the attempt, each with other states.
pub(super) fn challenge(
    task: &FitTask<'_>,
    (program, format): (&FitProgram, Format),
    number: u32,
) -> Result<Challenge, FitError> {
    let seed = task.seed.wrapping_add(2 + u64::from(number));
    let source = task.scene.states(seed);
    let general = view(task.general);
    let breeder = StateBreeder::new((general, format), |input| {
        let (array, indices, _) = general.function.input_element(Input(input));
        let name = general.tables.symbols.text(array.name);
        source.ranges().get(name, indices)
    });
    let draw = |number: u64| {
        let state = source.draw(general, number as u32);
        breeder.refined(state, mix(seed ^ mix(number)))
    };
    let corner = |number: u64| breeder.corner(draw(number), mix(seed ^ mix(!number)));
    let mut trial = ChallengeRun {
        task,
        program,
        format,
        result: Challenge {
            seed,
            accepted: task.accepted(),
            ..Challenge::default()
        },
        worst: Vec::new(),
    };
    let [fresh, corners] = measured_states(task, program);
    trial.result.fresh = trial.all(fresh, draw)?;
    trial.result.fresh_used = trial.result.used;
    trial.result.directed = trial.all(corners, corner)?;
    let program = view(&program.module);
    let allowed = Allowed::new(program, Some(task.scene), f64::INFINITY, &task.sizes);
    let quick = QuickYardstick::new(general, (program, format), allowed)?;
    let states = quick.states_of(CLIMBED_WORK).clamp(CLIMBED[0], CLIMBED[1]);
    let worst: Vec<Vec<f64>> = trial.worst.iter().map(|one| one.1.clone()).collect();
    let guided = if trial.is_open() {
        let mut guide = RoundingGuide::new(&quick);
        guide.climb(&breeder, &worst, (states / GUIDED, seed))
    } else {
        Vec::new()
    };
    let guided = RoundingGuide::beside(guided, &worst);
    // What adjoints show is not all: others begin without them.
    for (starts, seed) in [(guided, seed), (worst, mix(seed))] {
        let begin = |number: u64| match number % 3 {
            0 => draw(number),
            1 => corner(number),
            _ => starts[(mix(number) % starts.len() as u64) as usize].clone(),
        };
        let mut climbs = Climbs::new((&quick, &breeder), &starts, begin, seed);
        for _ in 0..states * u64::from(task.effort) / ROUND {
            if !trial.is_open() {
                break;
            }
            trial.measure(climbs.round())?;
            trial.result.directed += ROUND;
        }
    }
    trial.worst.truncate(TOLD);
    trial.result.worst = trial.worst.into_iter().map(|(_, state)| state).collect();
    Ok(trial.result)
}

/// Fresh states and corners.
fn measured_states(task: &FitTask<'_>, program: &FitProgram) -> [u64; 2] {
    let operations = |module| Counts::of(view(module).function).operations as u64;
    let each = operations(task.general) + operations(&program.module);
    let [least, most] = STATES;
    let states = (WORK / each.max(1)).clamp(least, most) * u64::from(task.effort);
    // The generator of states numbers them by 32 bits.
    [states, states / CORNERS].map(|count| count.min(u64::from(u32::MAX)))
}

impl ChallengeRun<'_> {
    /// True while climbs may find a failure: there are errors, but no failure.
    fn is_open(&self) -> bool {
        self.result.holds() && self.result.used > 0.0
    }

    /// Measures states until the choice does not hold; the number measured.
    fn all(
        &mut self,
        count: u64,
        state: impl Fn(u64) -> Vec<f64> + Sync + Send,
    ) -> Result<u64, FitError> {
        let mut tried = 0;
        while tried < count && self.result.holds() {
            let numbers = tried..count.min(tried + BATCH as u64);
            tried = numbers.end;
            self.measure(numbers.into_par_iter().map(&state).collect())?;
        }
        Ok(tried)
    }

    /// Measures states and keeps the worst ones.
    fn measure(&mut self, states: Vec<Vec<f64>>) -> Result<(), FitError> {
        let measure = |chunk: &[Vec<f64>]| -> Result<Vec<f64>, FitError> {
            let yardstick = Yardstick::at(view(self.task.general), chunk.to_vec());
            let view = view(&self.program.module);
            let inputs = yardstick.inputs(view)?;
            let results = results(view, self.format, &inputs);
            shares(self.task, self.program, &yardstick, &results)
        };
        let found: Result<Vec<Vec<f64>>, FitError> =
            states.par_chunks(CHUNK).map(measure).collect();
        self.worst.extend(found?.into_iter().flatten().zip(states));
        // Equally bad ones stay in their order.
        self.worst.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.worst.truncate(PARENTS);
        self.result.used = self.worst.first().map_or(0.0, |worst| worst.0);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_what_independent_states_establish() {
        let tried = |fresh| Challenge {
            fresh,
            ..Challenge::default()
        };
        // The rule of three: 1 - 3/n.
        assert!((tried(1000).share() - (1.0 - 2.9957 / 1000.0)).abs() < 1e-5);
        assert!(tried(1_000_000).share() > 0.999_996);
    }
}
