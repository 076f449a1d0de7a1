//! The search for the state at which a choice is worst.
//!
//! A choice that held at some states may fail at others. Here it is tried at
//! many states that nothing has seen, at corners of the ranges, and then at
//! states that are bred from the worst of them: nearer and further, with inputs
//! of one instead of another's, with inputs at the ends of their ranges and at
//! zero. Rounding errors jump
//! from one number to the next, so that there is no slope to go down; what a
//! state is worth is measured, and the worse of parent and child continues.
//!
//! **Invariants.** Every state lies in the ranges of the scene. Numbers are
//! those of binary64, not only those that narrower formats hold, since the
//! inputs of a user are not rounded either. Work is counted in operations: the
//! same task gives the same states on any number of threads.

use super::format::shares;
use super::{ACCEPTED, FitError, FitProgram, FitTask};
use crate::program::view;
use rayon::prelude::*;
use robovec_error::yardstick::{Yardstick, results};
use robovec_ir::count::Counts;
use robovec_ir::states::States;
use robovec_ir::{Format, Input};
use robovec_num::random::{mix, unit};
use serde::Serialize;

/// Operations evaluated for one unit of effort, exact and rounded ones alike.
const WORK: u64 = 200_000_000;

/// States tried at least, and at most for one unit of effort.
const STATES: [u64; 2] = [4096, 1 << 20];

/// Of eight states this number of are drawn; the others are directed.
const DRAWN_OF_EIGHT: u64 = 6;

/// Of the directed states one in this number is a corner of the ranges; the
/// others are bred.
const CORNERS: u64 = 4;

/// States measured before the next look at what was found.
const BATCH: usize = 4096;

/// States evaluated by one thread at a time.
const CHUNK: usize = 256;

/// States that breed.
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
    /// States at corners of the ranges, and bred from the worst ones.
    pub directed: u64,
    /// The largest error anywhere over what is allowed.
    pub used: f64,
    /// The worst states, the worst first: inputs of the general function.
    #[serde(skip)]
    pub worst: Vec<Vec<f64>>,
}

impl Challenge {
    /// True when no error was larger than what is accepted of the tolerance.
    pub fn holds(&self) -> bool {
        self.used <= ACCEPTED
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

/// Tries a program in a format; ends at the first batch in which an error is
/// larger than what is accepted. `number` is the number of the attempt: each attempt
/// draws other states.
pub(super) fn challenge(
    task: &FitTask<'_>,
    (program, format): (&FitProgram, Format),
    number: u32,
) -> Result<Challenge, FitError> {
    let (fresh, directed) = budget(task, program);
    let seed = task.seed.wrapping_add(2 + u64::from(number));
    let source = task.scene.states(seed);
    let breed = Breed::new(task, &source);
    let mut result = Challenge {
        seed,
        ..Challenge::default()
    };
    let mut parents: Vec<JudgedState> = Vec::new();
    let draw = |number: u64| {
        let state = source.draw(view(task.general), number as u32);
        breed.refined(state, mix(seed ^ mix(number)))
    };
    let corner = |number: u64| breed.corner(draw(number), mix(seed ^ mix(!number)));
    while result.directed < directed && result.holds() {
        let is_fresh = result.fresh < fresh;
        let (tried, wanted) = if is_fresh {
            (result.fresh, fresh)
        } else {
            (result.directed, directed / CORNERS)
        };
        if tried >= wanted {
            break;
        }
        let numbers = tried..wanted.min(tried + BATCH as u64);
        let count = numbers.end - numbers.start;
        let states: Vec<Vec<f64>> = if is_fresh {
            numbers.into_par_iter().map(draw).collect()
        } else {
            numbers.into_par_iter().map(corner).collect()
        };
        parents.extend(judged(task, (program, format), states)?);
        keep_worst(&mut parents);
        result.used = parents.first().map_or(0.0, |worst| worst.0);
        if is_fresh {
            result.fresh += count;
            result.fresh_used = result.used;
        } else {
            result.directed += count;
        }
    }
    let mut generation = 0;
    while result.directed < directed && result.holds() {
        let children: Vec<Vec<f64>> = (0..parents.len())
            .map(|parent| breed.child(&parents, parent, mix(seed ^ mix(generation))))
            .collect();
        result.directed += children.len() as u64;
        generation += 1;
        let children = judged(task, (program, format), children)?;
        for (parent, child) in parents.iter_mut().zip(children) {
            if child.0 >= parent.0 {
                *parent = child;
            }
        }
        let shares = parents.iter().map(|parent| parent.0);
        result.used = shares.fold(0.0, f64::max);
    }
    keep_worst(&mut parents);
    parents.truncate(TOLD);
    result.worst = parents.into_iter().map(|(_, state)| state).collect();
    Ok(result)
}

/// Fresh and directed states.
fn budget(task: &FitTask<'_>, program: &FitProgram) -> (u64, u64) {
    let operations = |module| Counts::of(view(module).function).operations as u64;
    let each = operations(task.general) + operations(&program.module);
    let [least, most] = STATES;
    let states = (WORK / each.max(1)).clamp(least, most) * u64::from(task.effort);
    // The generator of states numbers them by 32 bits.
    let fresh = (states / 8 * DRAWN_OF_EIGHT).min(u64::from(u32::MAX));
    (fresh, states / 8 * (8 - DRAWN_OF_EIGHT))
}

/// States with their errors over what is allowed.
fn judged(
    task: &FitTask<'_>,
    (program, format): (&FitProgram, Format),
    states: Vec<Vec<f64>>,
) -> Result<Vec<JudgedState>, FitError> {
    let measure = |chunk: &[Vec<f64>]| -> Result<Vec<f64>, FitError> {
        let yardstick = Yardstick::at(view(task.general), chunk.to_vec());
        let view = view(&program.module);
        let inputs = yardstick.inputs(view)?;
        shares(task, program, &yardstick, &results(view, format, &inputs))
    };
    let found: Result<Vec<Vec<f64>>, FitError> = states.par_chunks(CHUNK).map(measure).collect();
    Ok(found?.into_iter().flatten().zip(states).collect())
}

/// Keeps the worst states, the worst first; equally bad ones in their order.
fn keep_worst(states: &mut Vec<JudgedState>) {
    states.sort_by(|a, b| b.0.total_cmp(&a.0));
    states.truncate(PARENTS);
}

/// Way in which states are bred.
struct Breed {
    /// The range of every input; `None` for inputs without one, which keep the
    /// values that are drawn.
    ranges: Vec<Option<[f64; 2]>>,
    /// The array of every input.
    arrays: Vec<usize>,
    /// The inputs with a range of more than one number.
    free: Vec<usize>,
}

impl Breed {
    fn new(task: &FitTask<'_>, source: &States) -> Breed {
        let function = view(task.general).function;
        let tables = &task.general.tables;
        let inputs = 0..function.input_len() as u32;
        let range = |input: u32| {
            let (array, indices, _) = function.input_element(Input(input));
            let name = tables.symbols.text(array.name);
            source.ranges().get(name, indices)
        };
        let ranges: Vec<Option<[f64; 2]>> = inputs.clone().map(range).collect();
        let array = |input: u32| {
            let (own, _, _) = function.input_element(Input(input));
            let same = |array: &robovec_ir::Array| array.name == own.name;
            function.inputs().iter().position(same)
        };
        let is_free = |input: &usize| ranges[*input].is_some_and(|[low, high]| low < high);
        Breed {
            arrays: inputs
                .map(|input| array(input).expect("an input belongs to an array"))
                .collect(),
            free: (0..ranges.len()).filter(is_free).collect(),
            ranges,
        }
    }

    /// A state whose numbers use all digits of binary64: what is drawn is
    /// rounded to binary32.
    fn refined(&self, mut state: Vec<f64>, seed: u64) -> Vec<f64> {
        for &input in &self.free {
            let step = state[input].abs() * f64::from(f32::EPSILON);
            let place = unit(mix(seed ^ input as u64)) - 0.5;
            self.set(&mut state, input, |number| number + step * place);
        }
        state
    }

    /// A state with inputs at the ends of their ranges and at zero: all of
    /// them, or a part.
    fn corner(&self, mut state: Vec<f64>, seed: u64) -> Vec<f64> {
        let kinds = 2 + seed % 3;
        for &input in &self.free {
            let [low, high] = self.ranges[input].expect("a free input has a range");
            let kind = mix(seed ^ mix(input as u64)) % kinds;
            self.set(&mut state, input, |number| {
                [low, high, 0.0, number][kind as usize]
            });
        }
        state
    }

    /// A new state from the worst ones.
    fn child(&self, parents: &[JudgedState], parent: usize, seed: u64) -> Vec<f64> {
        let mut random = mix(seed ^ mix(parent as u64));
        let mut next = || {
            random = mix(random);
            random
        };
        let mut state = parents[parent].1.clone();
        if self.free.is_empty() || next().is_multiple_of(8) {
            // Whole arrays of another state: what belongs together stays so.
            let other = &parents[(next() % parents.len() as u64) as usize].1;
            let taken = next();
            for (input, number) in state.iter_mut().enumerate() {
                if mix(taken ^ self.arrays[input] as u64).is_multiple_of(2) {
                    *number = other[input];
                }
            }
            return state;
        }
        for _ in 0..1 + next() % 3 {
            let input = self.free[(next() % self.free.len() as u64) as usize];
            let [low, high] = self.ranges[input].expect("a free input has a range");
            let (kind, place, depth) = (next() % 8, unit(next()), next() % 40);
            let other = &parents[(next() % parents.len() as u64) as usize].1;
            self.set(&mut state, input, |number| match kind {
                0 => low,
                1 => high,
                2 => 0.0,
                3 => low + (high - low) * place,
                4 => other[input],
                // From half of the range down to the last digits.
                _ => number + (high - low) * 0.5f64.powi(depth as i32) * (place - 0.5),
            });
        }
        state
    }

    /// Changes an input within its range.
    fn set(&self, state: &mut [f64], input: usize, change: impl FnOnce(f64) -> f64) {
        let [low, high] = self.ranges[input].expect("a free input has a range");
        state[input] = change(state[input]).clamp(low, high);
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
