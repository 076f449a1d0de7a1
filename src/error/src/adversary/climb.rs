//! Climbs to states with larger errors, step by step.
//!
//! Rounding errors jump from one number to the next, so that there is no
//! gradient. A climb measures some children of its state at a time and
//! continues from the worst of them if its error is not smaller; after many
//! generations in vain it begins anew. Every other climb follows one output.
//!
//! **Invariant.** Climbs meet only between rounds: the same task gives the same
//! states on any number of threads.

use super::breed::StateBreeder;
use crate::yardstick::{LANES, QuickMemory, QuickYardstick};
use rayon::prelude::*;
use robovec_num::random::mix;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Number of climbs side by side.
const CLIMBS: u64 = 16;

/// Generations of a climb in one round.
const GENERATIONS: u64 = 32;

/// Generations without a larger error after which a climb begins anew.
const PATIENCE: u32 = 250;

/// Number of states of one generation of all climbs.
pub(super) const GENERATION: u64 = CLIMBS * LANES as u64;

/// Number of states of one round of all climbs.
pub const ROUND: u64 = GENERATIONS * GENERATION;

/// Climbs from bad states.
pub struct Climbs<'c, D> {
    quick: &'c QuickYardstick<'c>,
    breeder: &'c StateBreeder,
    /// A new state to begin from, by a number.
    draw: D,
    seed: u64,
    climbs: Vec<Climb>,
    rounds: u64,
    /// For every output the largest error of all rounds, and its state.
    records: Vec<ErrorRecord>,
}

/// Largest ratio of an error to the allowed one, and the state that has it.
pub type ErrorRecord = (f64, Option<Arc<Vec<f64>>>);

struct Climb {
    number: u64,
    /// The output whose error it follows, by place; `None` for the worst.
    output: Option<usize>,
    state: Vec<f64>,
    /// Ratio of the error of the state to the allowed one.
    share: f64,
    /// Generations since the error grew.
    since: u32,
    /// The largest error of any output that was ever met.
    worst: f64,
    /// Its state, if it was met in this round.
    found: Option<Vec<f64>>,
    /// Records of outputs in this round.
    records: BTreeMap<usize, (f64, Arc<Vec<f64>>)>,
    memory: QuickMemory,
}

impl<'c, D: Fn(u64) -> Vec<f64> + Sync> Climbs<'c, D> {
    /// Climbs from these states, of which there is one at least.
    pub fn new(
        (quick, breeder): (&'c QuickYardstick<'c>, &'c StateBreeder),
        states: &[Vec<f64>],
        draw: D,
        seed: u64,
    ) -> Climbs<'c, D> {
        let climb = |number: u64| {
            let state = states[number as usize % states.len()].clone();
            Climb {
                number,
                output: (number % 2 == 1).then(|| (number / 2) as usize % quick.outputs().max(1)),
                worst: 0.0,
                found: None,
                state,
                share: 0.0,
                since: 0,
                records: BTreeMap::new(),
                memory: QuickMemory::default(),
            }
        };
        Climbs {
            quick,
            breeder,
            draw,
            seed,
            climbs: (0..CLIMBS).map(climb).collect(),
            rounds: 0,
            records: vec![(0.0, None); quick.outputs()],
        }
    }

    /// One round of all climbs: its states that are worse than all before.
    pub fn round(&mut self) -> Vec<Vec<f64>> {
        self.round_of(GENERATIONS)
    }

    /// The same in a round of at most the usual number of generations.
    pub(super) fn round_of(&mut self, generations: u64) -> Vec<Vec<f64>> {
        let others: Vec<Vec<f64>> = (self.climbs.iter())
            .map(|climb| climb.state.clone())
            .collect();
        let mut climbs = std::mem::take(&mut self.climbs);
        climbs.par_iter_mut().for_each(|climb| {
            for generation in 0..generations {
                let number = (self.rounds * GENERATIONS + generation) * CLIMBS + climb.number;
                self.step(climb, &others, number);
            }
        });
        self.climbs = climbs;
        self.rounds += 1;
        for climb in &mut self.climbs {
            for (output, (error, state)) in std::mem::take(&mut climb.records) {
                if error > self.records[output].0 {
                    self.records[output] = (error, Some(state));
                }
            }
        }
        let found = self.climbs.iter_mut();
        found.filter_map(|climb| climb.found.take()).collect()
    }

    /// For every output, in their order, the largest error of all rounds.
    pub fn records(&self) -> &[ErrorRecord] {
        &self.records
    }

    /// The largest ratio of an error to the allowed one in all rounds.
    pub fn worst(&self) -> f64 {
        self.climbs
            .iter()
            .map(|climb| climb.worst)
            .fold(0.0, f64::max)
    }

    /// One generation of a climb; `number` is its own among all.
    fn step(&self, climb: &mut Climb, others: &[Vec<f64>], number: u64) {
        if climb.since > PATIENCE {
            (climb.share, climb.since) = (0.0, 0);
            climb.output = climb
                .output
                .map(|output| (output + CLIMBS as usize / 2) % self.quick.outputs());
            let known = climb
                .output
                .and_then(|output| self.records[output].1.as_deref());
            climb.state = match known {
                Some(known) if (number / CLIMBS).is_multiple_of(2) => known.clone(),
                _ => (self.draw)(number),
            };
        }
        let child = |lane: usize| {
            let seed = self.seed ^ mix(number * LANES as u64 + lane as u64);
            self.breeder.child(&climb.state, others, seed)
        };
        let children: Vec<Vec<f64>> = (0..LANES).map(child).collect();
        let shares = self.quick.shares(&children, &mut climb.memory);
        climb.since += 1;
        for (lane, child) in children.into_iter().enumerate() {
            let all = shares
                .iter()
                .fold(0.0, |most: f64, lanes| most.max(lanes[lane]));
            let share = climb.output.map_or(all, |output| shares[output][lane]);
            if all > climb.worst {
                (climb.worst, climb.found) = (all, Some(child.clone()));
            }
            self.record(climb, &shares, lane, &child);
            // Equal ones move on, so that a climb does not stay in one place.
            if share >= climb.share {
                if share > climb.share {
                    climb.since = 0;
                }
                (climb.share, climb.state) = (share, child);
            }
        }
    }
    /// Keeps the errors of a child that are larger than all before.
    fn record(&self, climb: &mut Climb, shares: &[[f64; LANES]], lane: usize, child: &[f64]) {
        let mut state = None;
        for (output, lanes) in shares.iter().enumerate() {
            let own = climb.records.get(&output).map_or(0.0, |record| record.0);
            if lanes[lane] > own.max(self.records[output].0) && lanes[lane].is_finite() {
                let state = state.get_or_insert_with(|| Arc::new(child.to_vec()));
                let record = (lanes[lane], Arc::clone(state));
                climb.records.insert(output, record);
            }
        }
    }
}
