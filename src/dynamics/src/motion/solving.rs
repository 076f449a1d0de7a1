//! Accelerations: from equations, or solved for by coordinate partitioning.

use super::MotionError;
use super::system::MultibodySystem;
use crate::kinematics::linear::{DenseMatrix, column, dot, largest, solve_positive, solve_square};
use crate::kinematics::{MotionState, Partition, stack};

/// Results of the equations in a state.
pub(super) struct SystemMotion {
    pub(super) accelerations: Vec<f64>,
    /// Power of dampers, constant forces and drives, W.
    pub(super) power: f64,
}

impl MultibodySystem<'_> {
    /// Accelerations, and the power of nonconservative forces.
    pub(super) fn motion(&self, state: &mut MotionState) -> Result<SystemMotion, MotionError> {
        let mut power = self.load(state);
        let accelerations = match self.equations.accelerations(state) {
            Some(accelerations) => accelerations,
            None => self.solve(state)?,
        };
        if !largest(&accelerations).is_finite() {
            return Err(MotionError::not_finite("an acceleration", state.time));
        }
        // A joint that is held takes no power.
        let moves = |&joint: &usize| self.model.joints[joint].has_velocity;
        if self.partition.driven.iter().any(moves) {
            power += self.drive_power(state, &accelerations);
        }
        Ok(SystemMotion {
            accelerations,
            power,
        })
    }

    fn solve(&self, state: &MotionState) -> Result<Vec<f64>, MotionError> {
        let (matrix, bias) = self.equations.dynamics(state);
        if !largest(&bias).is_finite() {
            return Err(MotionError::not_finite("a force", state.time));
        }
        let Partition {
            independent: u,
            dependent: v,
            driven: c,
            rows,
            ..
        } = &self.partition;
        // Dependent accelerations: B (independent ones) + b.
        let mut given = vec![0.0; bias.len()];
        for &joint in c {
            given[joint] = state.qdd[joint];
        }
        let (slopes, offset) = if rows.is_empty() {
            (DenseMatrix::zeros(0, u.len()), Vec::new())
        } else {
            let jacobian = self.equations.constraints().evaluate(state).1;
            let quadratic = self.equations.quadratic(state);
            self.dependence(state, &jacobian, &quadratic, &given)?
        };
        for (&joint, &part) in v.iter().zip(&offset) {
            given[joint] = part;
        }
        let rest: Vec<f64> = (0..bias.len())
            .map(|i| state.joint_forces[i] - bias[i] - dot(matrix.row(i), &given))
            .collect();
        // M reduced to the independent joints: T' M T with T = [1; B].
        let transform = stack(u, v, &slopes, bias.len());
        let (reduced, right) = if rows.is_empty() {
            (matrix.select(u, u), u.iter().map(|&i| rest[i]).collect())
        } else {
            let reduced = transform.transposed().product(&matrix.product(&transform));
            (reduced, transform.transposed_times(&rest))
        };
        let threshold = 16.0 * self.equations.epsilon();
        let singular = reduced.clone();
        let free = solve_positive(reduced, right, threshold).map_err(|_| {
            let joint = |place: usize| self.model.joints[u[place]].name.clone();
            let joints = undetermined(&singular, threshold).into_iter().map(joint);
            MotionError::Singular {
                joints: joints.collect(),
                time: state.time,
            }
        })?;
        let mut accelerations = transform.times(&free);
        for (sum, given) in accelerations.iter_mut().zip(&given) {
            *sum += given;
        }
        Ok(accelerations)
    }

    /// `B` and `b` of the dependent accelerations.
    pub(super) fn dependence(
        &self,
        state: &MotionState,
        jacobian: &DenseMatrix,
        quadratic: &[f64],
        given: &[f64],
    ) -> Result<(DenseMatrix, Vec<f64>), MotionError> {
        let Partition {
            independent: u,
            dependent: v,
            rows,
            ..
        } = &self.partition;
        let mut right = DenseMatrix::zeros(rows.len(), u.len() + 1);
        for (place, &row) in rows.iter().enumerate() {
            for (column, &joint) in u.iter().enumerate() {
                right[(place, column)] = -jacobian[(row, joint)];
            }
            right[(place, u.len())] = -quadratic[row] - dot(jacobian.row(row), given);
        }
        let square = jacobian.select(rows, v);
        let solution = solve_square(square, right).ok_or_else(|| {
            MotionError::not_finite("the motion of a dependent joint", state.time)
        })?;
        let every: Vec<usize> = (0..rows.len()).collect();
        let columns: Vec<usize> = (0..u.len()).collect();
        let offset = (0..rows.len()).map(|row| solution[(row, u.len())]);
        Ok((solution.select(&every, &columns), offset.collect()))
    }

    /// Power of drives: forces on driven joints, less those of loops.
    fn drive_power(&self, state: &MotionState, accelerations: &[f64]) -> f64 {
        let Partition {
            dependent: v,
            driven: c,
            rows,
            ..
        } = &self.partition;
        let (matrix, bias) = self.equations.dynamics(state);
        let needed: Vec<f64> = (0..bias.len())
            .map(|i| dot(matrix.row(i), accelerations) + bias[i] - state.joint_forces[i])
            .collect();
        let mut of_loops = vec![0.0; bias.len()];
        if !rows.is_empty() {
            let jacobian = self.equations.constraints().evaluate(state).1;
            let all: Vec<usize> = (0..bias.len()).collect();
            let right: Vec<f64> = v.iter().map(|&joint| needed[joint]).collect();
            let square = jacobian.select(rows, v).transposed();
            if let Some(solution) = solve_square(square, column(&right)) {
                let multipliers: Vec<f64> = (0..rows.len()).map(|k| solution[(k, 0)]).collect();
                of_loops = jacobian.select(rows, &all).transposed_times(&multipliers);
            }
        }
        // A law on a driven joint only shares the work with the drive; its
        // spring does not.
        let share = |joint: usize| {
            let law = &self.laws.joints[joint];
            law.force - law.damping * state.qd[joint] - law.dry(state.qd[joint])
        };
        c.iter()
            .map(|&joint| (needed[joint] - of_loops[joint] + share(joint)) * state.qd[joint])
            .sum()
    }
}

/// Unknowns of a symmetric system without which it is positive definite.
fn undetermined(matrix: &DenseMatrix, threshold: f64) -> Vec<usize> {
    let mut places: Vec<usize> = (0..matrix.rows()).collect();
    let mut left = Vec::new();
    loop {
        let rest = matrix.select(&places, &places);
        match solve_positive(rest, vec![0.0; places.len()], threshold) {
            Ok(_) => return left,
            Err(place) => left.push(places.remove(place)),
        }
    }
}
