//! States at which roundings can move outputs most, by adjoints.
//!
//! Errors at neighbouring states differ by chance, and what roundings can do
//! changes slowly with the state: that is climbed first. Roundings of inputs
//! can be chosen one by one, so their effects add up; those of operations come
//! as they come, and a search finds some times their root mean square.

use super::StateBreeder;
use crate::yardstick::QuickYardstick;
use robovec_analysis::adjoint::{Adjoint, LANES, Tape, Workspace, half_ulp};
use robovec_num::arithmetic::Binary64;
use robovec_num::random::mix;

/// Maximum number of states whose outputs are compared to choose climbed ones.
const COMPARED: u64 = 32;

/// Number of evaluations that take the time of one with adjoints.
const ADJOINT: u64 = 10;

/// Root mean squares that a search over roundings of operations finds.
const FOUND: f64 = 4.0;

/// The squared root mean square of an error that is evenly distributed up to 1.
const EVEN: f64 = 1.0 / 3.0;

/// The effects of roundings at states of one program.
pub struct RoundingGuide<'a> {
    quick: &'a QuickYardstick<'a>,
    tape: Tape,
    workspace: Workspace,
}

/// Effects of roundings on some outputs, lane by lane.
struct RoundingEffects {
    /// Ratio of the error that a search may find to the allowed one.
    size: [f64; LANES],
    /// Derivatives by the numbers of a state.
    slopes: Vec<[f64; LANES]>,
}

impl<'a> RoundingGuide<'a> {
    /// Prepares the program of a yardstick.
    pub fn new(quick: &'a QuickYardstick<'a>) -> RoundingGuide<'a> {
        RoundingGuide {
            tape: Tape::new(quick.program.function),
            quick,
            workspace: Workspace::default(),
        }
    }

    /// States to begin climbs from: those of the guide for climbs with even
    /// numbers, which follow the worst of all outputs, others beside them.
    pub fn beside(guided: Vec<Vec<f64>>, others: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut starts = Vec::with_capacity(guided.len() + others.len());
        let mut others = others.iter().cloned();
        for state in guided {
            starts.push(state);
            starts.extend(others.next());
        }
        starts.extend(others);
        starts
    }

    /// Climbs from states for the outputs that roundings can move most, at most
    /// [`LANES`], in the time of some evaluations, if that is enough. Real
    /// inputs are rounded to the side that adds to the error.
    pub fn climb(
        &mut self,
        breeder: &StateBreeder,
        starts: &[Vec<f64>],
        (evaluations, seed): (u64, u64),
    ) -> Vec<Vec<f64>> {
        // Half of them for the choice of outputs.
        let steps = evaluations / ADJOINT / 2;
        let sweeps = self.tape.outputs().div_ceil(LANES).max(1) as u64;
        let compared = (steps / sweeps).min(COMPARED).min(starts.len() as u64);
        let outputs = self.outputs(&starts[..compared as usize]);
        if compared == 0 || outputs.is_empty() {
            return Vec::new();
        }
        let mut best: Vec<(f64, usize, Vec<f64>)> = outputs
            .iter()
            .map(|_| (f64::NEG_INFINITY, 0, starts[0].clone()))
            .collect();
        let lanes = outputs.len() as u64;
        for step in 0..steps.max(compared) {
            let state = match starts.get(step as usize) {
                Some(start) => start.clone(),
                None => {
                    let parent = &best[(step % lanes) as usize].2;
                    breeder.child(parent, starts, mix(seed ^ mix(step)))
                }
            };
            let effects = self.effects(&outputs, &state);
            for (lane, best) in best.iter_mut().enumerate() {
                if effects.size[lane].is_finite() && effects.size[lane] > best.0 {
                    *best = (effects.size[lane], lane, state.clone());
                }
            }
        }
        best.retain(|(size, _, _)| size.is_finite());
        let aligned = best.into_iter().map(|(_, lane, state)| {
            if self.quick.is_held() {
                return state;
            }
            let slopes = self.effects(&outputs, &state).slopes;
            let slopes: Vec<f64> = slopes.iter().map(|lanes| lanes[lane]).collect();
            breeder.aligned(state, &slopes)
        });
        aligned.collect()
    }

    /// The outputs that roundings can move most at these states.
    fn outputs(&mut self, states: &[Vec<f64>]) -> Vec<usize> {
        let all: Vec<usize> = (0..self.tape.outputs()).collect();
        let mut most = vec![0.0f64; all.len()];
        for state in states {
            for (group, most) in all.chunks(LANES).zip(most.chunks_mut(LANES)) {
                let effects = self.effects(group, state);
                for (most, size) in most.iter_mut().zip(effects.size) {
                    *most = most.max(size);
                }
            }
        }
        let mut sorted = all;
        sorted.sort_by(|&a, &b| most[b].total_cmp(&most[a]));
        sorted.truncate(LANES);
        sorted
    }

    fn effects(&mut self, outputs: &[usize], state: &[f64]) -> RoundingEffects {
        let (tape, format) = (&self.tape, self.quick.format);
        let places = &self.quick.inputs;
        let own: Vec<f64> = places.iter().map(|&place| state[place]).collect();
        let values = tape.evaluate(&Binary64, &own);
        let inputs = tape.nodes()..tape.nodes() + tape.inputs();
        let mut chosen = [0.0; LANES];
        let mut squares = [0.0; LANES];
        let mut slopes = vec![[0.0; LANES]; state.len()];
        let adjoint = Adjoint::at(tape, &values);
        adjoint.sweep_lanes(&mut self.workspace, outputs, |slot, gradient| {
            let half = half_ulp(format, values[slot]);
            if inputs.contains(&slot) {
                slopes[places[slot - inputs.start]] = gradient.0;
                if !self.quick.is_held() {
                    (0..LANES).for_each(|lane| chosen[lane] += (half * gradient.0[lane]).abs());
                }
            } else if slot < inputs.start {
                (0..LANES).for_each(|lane| squares[lane] += (half * gradient.0[lane]).powi(2));
            }
        });
        let results = 0..tape.outputs();
        let results: Vec<f64> = results.map(|one| values[tape.output_slot(one)]).collect();
        let allowed = self.quick.allowed(&results);
        let size = |lane: usize| {
            let error = chosen[lane] + FOUND * (EVEN * squares[lane]).sqrt();
            outputs
                .get(lane)
                .map_or(0.0, |&output| error / allowed[output])
        };
        RoundingEffects {
            size: std::array::from_fn(size),
            slopes,
        }
    }
}
