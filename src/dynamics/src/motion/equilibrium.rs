//! Equilibria of a model under its laws.
//!
//! Newton's method on the reduced equations `T^T (c - Q) = 0` at rest, with
//! their derivative `K` ([`super::linearise`]). Steps are halved until the
//! residual is smaller. Coordinates without stiffness (a car may be anywhere
//! along the road) keep their value, as long as no force acts on them.

use super::MotionError;
use super::linearise::SmallMotions;
use super::system::MultibodySystem;
use crate::kinematics::MotionState;
use crate::kinematics::linear::{DenseMatrix, Pivot, column, eliminate, largest, solve_square};

/// A state of rest.
#[derive(Clone, PartialEq, Debug)]
pub struct Equilibrium {
    /// The state: velocities and accelerations are zero.
    pub state: MotionState,
    /// Small motions around it.
    pub motions: SmallMotions,
    /// Bound of each independent joint's distance from its position without
    /// rounding, m or rad; `None` for a coordinate without stiffness.
    pub errors: Vec<Option<f64>>,
    /// Rounds of Newton's method.
    pub rounds: u32,
}

/// Maximum number of rounds of the search.
const ROUNDS: u32 = 200;

/// Maximum number of halvings of a step.
const HALVINGS: u32 = 30;

/// Pivots of the stiffness below this, relative to the largest, are rounding.
const RANK: f64 = 1e-12;

impl MultibodySystem<'_> {
    /// The equilibrium near a state, nothing moved ([`super::Laws::at_rest`]).
    ///
    /// # Errors
    ///
    /// [`MotionError::NoEquilibrium`] where the search does not end, or a force
    /// moves a coordinate without stiffness; otherwise as a simulation.
    pub fn equilibrium(&mut self, near: &MotionState) -> Result<Equilibrium, MotionError> {
        let mut here = self.at_rest(near, &near.q)?;
        let mut motions = self.linearise(&here)?;
        let mut rounds = 0;
        let mut pivots = held(&motions);
        let mut step = newton(&motions, &pivots, &motions.residual)
            .ok_or(MotionError::NoEquilibrium { free: None })?;
        // Steps help until rounding is all that is left over.
        while rounds < ROUNDS && self.advance(&mut here, &mut motions, &step)? {
            rounds += 1;
            pivots = held(&motions);
            step = newton(&motions, &pivots, &motions.residual)
                .ok_or(MotionError::NoEquilibrium { free: None })?;
        }
        let scale = largest(&here.q).max(1.0);
        if largest(&step) > NEAR * scale {
            return Err(MotionError::NoEquilibrium { free: None });
        }
        // Nothing moves a coordinate that nothing holds.
        let most = SLACK * largest(&motions.rounding);
        for (place, left) in motions.residual.iter().enumerate() {
            let balanced = pivots.iter().any(|pivot| pivot.row == place);
            if !balanced && left.abs() > most {
                let joint = &self.model.joints[motions.joints[place]].name;
                return Err(MotionError::NoEquilibrium {
                    free: Some(joint.clone()),
                });
            }
        }
        let bound: Vec<f64> = (motions.residual.iter().zip(&motions.rounding))
            .map(|(left, rounding)| left.abs() + rounding)
            .collect();
        let errors = uncertainty(&motions, &pivots, &bound);
        Ok(Equilibrium {
            state: here,
            motions,
            errors,
            rounds,
        })
    }

    /// Takes a step or the longest halved one that decreases the residual.
    fn advance(
        &mut self,
        here: &mut MotionState,
        motions: &mut SmallMotions,
        step: &[f64],
    ) -> Result<bool, MotionError> {
        let weight = weights(motions);
        let before = size(&motions.residual, &weight);
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let mut moved = here.q.clone();
            for (&joint, step) in motions.joints.iter().zip(step) {
                moved[joint] -= share * step;
            }
            // A step may lead to where the loops cannot be closed.
            if let Ok(next) = self.at_rest(here, &moved)
                && let Ok(next_motions) = self.linearise(&next)
                && next_motions.joints == motions.joints
                && size(&next_motions.residual, &weight) < before
            {
                (*here, *motions) = (next, next_motions);
                return Ok(true);
            }
            share *= 0.5;
        }
        Ok(false)
    }

    /// A state at rest with its loops closed.
    fn at_rest(
        &mut self,
        near: &MotionState,
        positions: &[f64],
    ) -> Result<MotionState, MotionError> {
        let joints = self.model.joints.len();
        let mut packed = positions.to_vec();
        packed.resize(2 * joints + 1, 0.0);
        let mut state = self.unpack(near.time, &packed)?;
        state.qd.fill(0.0);
        state.qdd.fill(0.0);
        Ok(state)
    }
}

/// The longest step left where none is better, relative to positions.
const NEAR: f64 = 1e-9;

/// Factor between the possible rounding error of the largest component and the
/// largest force that a coordinate without stiffness may have.
const SLACK: f64 = 1e3;

/// Rows of the residual by their stiffness, so that m and rad count alike.
fn weights(motions: &SmallMotions) -> Vec<f64> {
    let row = |place: usize| largest(motions.stiffness.row(place));
    let most = (0..motions.joints.len()).map(row).fold(0.0, f64::max);
    let weight = |place: usize| match row(place) {
        size if size > RANK * most => 1.0 / size,
        _ => 1.0,
    };
    (0..motions.joints.len()).map(weight).collect()
}

fn size(residual: &[f64], weights: &[f64]) -> f64 {
    assert_eq!(residual.len(), weights.len(), "one weight per row");
    let scaled = residual
        .iter()
        .zip(weights)
        .map(|(left, weight)| left * weight);
    scaled.map(|x| x * x).sum::<f64>().sqrt()
}

/// The coordinates with stiffness, as pivots of the stiffness matrix.
fn held(motions: &SmallMotions) -> Vec<Pivot> {
    // Rows are scaled, so that a soft bush beside a hard spring is no rounding.
    let weight = weights(motions);
    let count = motions.joints.len();
    let mut scaled = DenseMatrix::zeros(count, count);
    for row in 0..count {
        for column in 0..count {
            scaled[(row, column)] = motions.stiffness[(row, column)] * weight[row];
        }
    }
    eliminate(scaled, &vec![1.0; count], RANK)
}

/// `K^-1 numbers` for the coordinates with stiffness, zero for others.
fn newton(motions: &SmallMotions, pivots: &[Pivot], numbers: &[f64]) -> Option<Vec<f64>> {
    assert_eq!(
        numbers.len(),
        motions.joints.len(),
        "one number per coordinate"
    );
    let mut step = vec![0.0; motions.joints.len()];
    if pivots.is_empty() {
        return Some(step);
    }
    let (rows, columns): (Vec<usize>, Vec<usize>) =
        pivots.iter().map(|pivot| (pivot.row, pivot.column)).unzip();
    let right: Vec<f64> = rows.iter().map(|&row| numbers[row]).collect();
    let solution = solve_square(motions.stiffness.select(&rows, &columns), column(&right))?;
    for (place, &column) in columns.iter().enumerate() {
        step[column] = solution[(place, 0)];
    }
    Some(step)
}

/// Possible errors of coordinates when each row errs up to its bound.
fn uncertainty(motions: &SmallMotions, pivots: &[Pivot], bound: &[f64]) -> Vec<Option<f64>> {
    let mut errors: Vec<Option<f64>> = vec![None; motions.joints.len()];
    for pivot in pivots {
        errors[pivot.column] = Some(0.0);
    }
    for row in 0..bound.len() {
        let mut side = vec![0.0; bound.len()];
        side[row] = bound[row];
        let Some(moved) = newton(motions, pivots, &side) else {
            return vec![None; motions.joints.len()];
        };
        for (error, moved) in errors.iter_mut().zip(moved) {
            *error = error.map(|error| error + moved.abs());
        }
    }
    errors
}
