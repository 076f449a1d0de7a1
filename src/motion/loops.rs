//! Closing loops: positions and velocities of dependent joints.

use super::linear::{DenseMatrix, dot, solve_positive, solve_square};
use super::system::MultibodySystem;
use super::{MotionError, MotionState, Partition};
use crate::model::Nature;

/// Newton steps before giving up; from a predicted position three suffice.
const NEWTON_STEPS: usize = 25;
/// Steps of the search for a closed position.
const ASSEMBLY_STEPS: usize = 200;

/// The largest magnitude.
pub(super) fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, x| {
        if x.is_nan() {
            f64::INFINITY
        } else {
            x.abs().max(most)
        }
    })
}

impl MultibodySystem<'_> {
    /// A residual that the arithmetic cannot make smaller.
    fn tight(&self) -> f64 {
        8.0 * self.equations.epsilon()
    }

    /// A residual that still counts as closed.
    fn loose(&self) -> f64 {
        1e4 * self.equations.epsilon()
    }

    /// The fraction of the largest pivot that counts as zero in the Jacobian.
    pub(super) fn rank_threshold(&self) -> f64 {
        self.equations.epsilon().sqrt()
    }

    /// Moves the dependent joints until the loops are closed, and gives them
    /// the velocities that keep them so.
    ///
    /// # Errors
    ///
    /// [`MotionError::OpenLoop`] and [`MotionError::NotFinite`].
    pub(super) fn close(
        &self,
        state: &mut MotionState,
        partition: &Partition,
    ) -> Result<(), MotionError> {
        if self.equations.rows() == 0 {
            return Ok(());
        }
        let jacobian = self.close_positions(state, partition)?;
        let dependent = jacobian.select(&partition.rows, &partition.dependent);
        let mut others = state.qd.clone();
        for &joint in &partition.dependent {
            others[joint] = 0.0;
        }
        let right: Vec<f64> = partition
            .rows
            .iter()
            .map(|&row| -dot(jacobian.row(row), &others))
            .collect();
        let Some(velocities) = solve_square(dependent, column(&right)) else {
            return Err(self.open(state, &self.equations.constraints(state).0));
        };
        for (place, &joint) in partition.dependent.iter().enumerate() {
            state.qd[joint] = velocities[(place, 0)];
        }
        Ok(())
    }

    /// Newton's method; the Jacobian at the closed position.
    fn close_positions(
        &self,
        state: &mut MotionState,
        partition: &Partition,
    ) -> Result<DenseMatrix, MotionError> {
        let mut before = f64::INFINITY;
        for _ in 0..NEWTON_STEPS {
            let (residual, jacobian) = self.equations.constraints(state);
            let gap = largest(&residual);
            let stalled = gap >= 0.5 * before && gap <= self.loose();
            if gap <= self.tight() || stalled {
                return Ok(jacobian);
            }
            before = gap;
            let right: Vec<f64> = partition.rows.iter().map(|&row| -residual[row]).collect();
            let square = jacobian.select(&partition.rows, &partition.dependent);
            let Some(step) = solve_square(square, column(&right)) else {
                break;
            };
            for (place, &joint) in partition.dependent.iter().enumerate() {
                state.q[joint] += step[(place, 0)];
            }
        }
        Err(self.open(state, &self.equations.constraints(state).0))
    }

    /// Moves the joints of some natures, as little as possible, until the
    /// loops are closed: steps of least squares (Levenberg's method). Unlike
    /// Newton's it does not mind rows that say the same.
    ///
    /// # Errors
    ///
    /// [`MotionError::OpenLoop`].
    pub(super) fn assemble(
        &self,
        state: &mut MotionState,
        natures: &[Nature],
    ) -> Result<(), MotionError> {
        let movable: Vec<usize> = (0..self.model.joints.len())
            .filter(|&joint| natures.contains(&self.model.joints[joint].nature))
            .collect();
        let all_rows: Vec<usize> = (0..self.equations.rows()).collect();
        let mut damping = 1e-3;
        let (mut residual, mut jacobian) = self.equations.constraints(state);
        for _ in 0..ASSEMBLY_STEPS {
            if largest(&residual) <= self.loose() {
                return Ok(());
            }
            let moving = jacobian.select(&all_rows, &movable);
            let mut normal = moving.product(&moving.transposed());
            let scale = (0..all_rows.len()).fold(1e-30, |most, i| normal[(i, i)].max(most));
            for row in 0..all_rows.len() {
                normal[(row, row)] += damping * scale;
            }
            let right = residual.iter().map(|h| -h).collect();
            let mut tried = state.clone();
            if let Ok(multipliers) = solve_positive(normal, right, 0.0) {
                let step = moving.transposed_times(&multipliers);
                for (&joint, step) in movable.iter().zip(step) {
                    tried.q[joint] += step;
                }
            }
            let (next, next_jacobian) = self.equations.constraints(&tried);
            if dot(&next, &next) < dot(&residual, &residual) {
                *state = tried;
                (residual, jacobian) = (next, next_jacobian);
                damping = (damping * 0.2).max(1e-14);
            } else {
                damping *= 4.0;
                if damping > 1e12 {
                    break;
                }
            }
        }
        if largest(&residual) <= self.loose() {
            return Ok(());
        }
        Err(self.open(state, &residual))
    }

    /// The error of the cut with the largest residual.
    fn open(&self, state: &MotionState, residual: &[f64]) -> MotionError {
        let gaps = residual.iter().map(|h| h.abs()).enumerate();
        let worst = gaps.max_by(|a, b| a.1.total_cmp(&b.1));
        let (row, gap) = worst.unwrap_or((0, 0.0));
        if !gap.is_finite() {
            return MotionError::NotFinite {
                what: "the residual of a loop".to_owned(),
                time: state.time,
            };
        }
        MotionError::OpenLoop {
            cut: self.model.cuts[self.equations.cut_of(row)].name.clone(),
            gap,
            time: state.time,
        }
    }
}

/// A matrix of one column.
pub(super) fn column(numbers: &[f64]) -> DenseMatrix {
    let mut matrix = DenseMatrix::zeros(numbers.len(), 1);
    for (row, &number) in numbers.iter().enumerate() {
        matrix[(row, 0)] = number;
    }
    matrix
}
