//! Starts at which a reduced scene is compared with the full one: corners of
//! the ranges, draws inside, and a directed search from the worst of them.

use super::judge::{ReducedScene, Start};
use super::search::NeglectSearch;
use crate::scene::SceneMotion;
use rayon::prelude::*;
use robovec_dynamics::motion::SimulationRun;
use robovec_num::random::Random;

/// Maximum number of free start values whose corners are all searched.
const ALL_CORNERS: usize = 6;

/// Draws inside the ranges: the first, and the first that is not searched.
const INSIDE: std::ops::Range<u32> = 2..18;

/// Maximum number of rounds of the directed search from the worst start.
const ROUNDS: usize = 4;

/// Number of steps of motions, full and reduced, after which the search ends.
const WORK: u64 = 2_000_000;

/// Number of steps of the full motions after which no corner or draw is added.
const LISTED_WORK: u64 = WORK / 8;

/// Number of starts that parts are left out by, added by each refusal.
const ADDED: usize = 3;

/// Extent of the search for the worst start.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub struct StartSearch {
    /// Number of starts at which the reduced motion was compared.
    pub starts: usize,
    /// Number of steps of all motions.
    pub steps: u64,
    /// The largest error of the reduced scene at any of them.
    pub worst: f64,
}

/// Corners of the ranges, or a seeded selection, zero and draws inside.
fn listed(wish: &SceneMotion) -> Vec<Start> {
    let free = wish.start.iter().filter(|(_, [low, high])| low < high);
    let free = free.count();
    let mut random = Random::new(1);
    let corner = |number: usize| {
        let mut bit = 0;
        let ends = wish.start.iter().map(|&(joint, [low, high])| {
            let is_low = if low == high {
                true
            } else if free > ALL_CORNERS {
                random.signed() < 0.0
            } else {
                bit += 1;
                number >> (bit - 1) & 1 == 1
            };
            (joint, if is_low { low } else { high })
        });
        ends.collect()
    };
    let mut starts: Vec<Start> = (0..1 << free.min(ALL_CORNERS)).map(corner).collect();
    let zero = wish.start.iter();
    starts.push(
        zero.map(|&(joint, [low, high])| (joint, 0f64.clamp(low, high)))
            .collect(),
    );
    starts.extend(INSIDE.map(|draw| wish.start(draw)));
    starts
}

/// Starts that differ from one in a single value, near or from another.
fn neighbours(wish: &SceneMotion, from: &Start, other: &Start) -> Vec<Start> {
    let mut starts = Vec::new();
    for (place, &(_, [low, high])) in wish.start.iter().enumerate() {
        let (at, quarter) = (from[place].1, (high - low) / 4.0);
        let values = [
            low,
            high,
            low + 2.0 * quarter,
            at - quarter,
            at + quarter,
            other[place].1,
        ];
        for value in values {
            let mut start = from.clone();
            start[place].1 = value.clamp(low, high);
            starts.push(start);
        }
    }
    starts
}

impl NeglectSearch<'_> {
    /// Adds the full motions from corners, zero and draws to the known ones.
    pub(super) fn learn_listed(&mut self) {
        self.learn(listed(self.judge.wish), LISTED_WORK);
    }

    /// Adds the full motions from starts to the known ones, up to a limit.
    fn learn(&mut self, starts: Vec<Start>, limit: u64) {
        let mut new: Vec<Start> = Vec::new();
        for start in starts {
            if !new.contains(&start) && self.known.iter().all(|(known, _)| *known != start) {
                new.push(start);
            }
        }
        // Batches, so that the count of steps decides the same for any number of threads.
        for batch in new.chunks(16) {
            if self.steps > limit {
                return;
            }
            let runs = batch
                .par_iter()
                .map(|start| self.run(&self.full.scene, start).ok());
            let runs: Vec<Option<SimulationRun>> = runs.collect();
            for (start, run) in batch.iter().zip(runs) {
                self.steps += run.as_ref().map_or(0, |run| run.steps + run.rejected);
                self.known.extend(run.map(|run| (start.clone(), run)));
            }
        }
    }

    /// Errors of a scene at known starts from a place on; infinite if unmoved.
    fn errors_from(&mut self, scene: &ReducedScene, place: usize) -> Vec<f64> {
        let errors = self.known[place..].par_iter().map(|(start, run)| {
            let other = self.run(scene, start);
            other.map_or((f64::INFINITY, 0), |other| {
                (
                    self.full.watched.share(run, &other),
                    other.steps + other.rejected,
                )
            })
        });
        let errors: Vec<(f64, u64)> = errors.collect();
        self.steps += errors.iter().map(|(_, steps)| steps).sum::<u64>();
        errors.into_iter().map(|(error, _)| error).collect()
    }

    /// The largest error of a scene at the known starts and at those that a
    /// directed search from the worst adds. The worst starts that exceed the
    /// allowed error are added to those for the selection of omissions.
    pub(super) fn worst(&mut self, scene: &ReducedScene) -> f64 {
        if self.known.is_empty() {
            return 0.0;
        }
        let allowed = self.judge.wish.error;
        let mut errors = self.errors_from(scene, 0);
        let ordered = |errors: &[f64]| {
            let mut order: Vec<usize> = (0..errors.len()).collect();
            order.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]));
            order
        };
        for _ in 0..ROUNDS {
            let order = ordered(&errors);
            let (first, second) = (order[0], order[1.min(order.len() - 1)]);
            if errors[first] > allowed {
                break;
            }
            let next = neighbours(self.judge.wish, &self.known[first].0, &self.known[second].0);
            self.learn(next, WORK);
            let further = self.errors_from(scene, errors.len());
            let is_better = further.iter().any(|&error| error > errors[first]);
            errors.extend(further);
            if !is_better {
                break;
            }
        }
        let order = ordered(&errors);
        let over = order
            .iter()
            .copied()
            .filter(|&place| errors[place] > allowed);
        for place in over.take(ADDED) {
            if self
                .full
                .runs
                .iter()
                .all(|(start, _)| *start != self.known[place].0)
            {
                self.full.runs.push(self.known[place].clone());
            }
        }
        errors[order[0]]
    }

    /// True when the search has used up its steps.
    pub(super) fn is_exhausted(&self) -> bool {
        self.steps > WORK
    }
}
