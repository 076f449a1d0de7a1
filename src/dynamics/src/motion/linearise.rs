//! Equations of motion for small motions around a state, with loops and laws.
//!
//! With the independent coordinates u, all positions `q(u)` close the loops,
//! and `T = dq/du`. The residual of the equations is `T^T (M qdd + c - Q)`;
//! multipliers `lambda` with `Jv^T lambda = (M qdd + c - Q)_v` take the rest.
//! Small motions satisfy
//!
//! ```text
//! Mr du'' + D du' + K du = T^T dQ
//! ```
//!
//! Column by column, the generated functions are evaluated in dual numbers along
//! the motion that the loops allow, so that nothing is rounded but the numbers
//! themselves. The change of `T^T` acts on the forces that the multipliers
//! balance, so that `K` is `T^T (d(M qdd + c - Q) - dJ^T lambda)` plus the
//! contribution of changed dependent accelerations.

use super::MotionError;
use super::system::MultibodySystem;
use super::{Spring, Support};
use crate::kinematics::linear::{DenseMatrix, column, dot, largest, solve_square};
use crate::kinematics::{MotionState, Partition, stack};

/// Small motions around a state. Rows and columns are the independent joints.
#[derive(Clone, PartialEq, Debug)]
pub struct SmallMotions {
    /// The independent joints, indices of the model's.
    pub joints: Vec<usize>,
    /// `Mr`.
    pub mass: DenseMatrix,
    /// `D`.
    pub damping: DenseMatrix,
    /// `K`.
    pub stiffness: DenseMatrix,
    /// The motion of all joints for each of the independent ones, `T`.
    pub transform: DenseMatrix,
    /// Residual of the equations at the state.
    pub residual: Vec<f64>,
    /// Part of it that may be rounding, by the sizes of its terms: an estimate.
    pub rounding: Vec<f64>,
}

/// Part of a sum that may be rounding, after some dozens of operations.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Quantities that are the same for all directions.
struct LinearisedState<'s> {
    state: &'s MotionState,
    /// The state without forces of links and external forces.
    bare: MotionState,
    jacobian: DenseMatrix,
    transform: DenseMatrix,
    multipliers: Vec<f64>,
}

impl MultibodySystem<'_> {
    /// Small motions around a state with closed loops, at accelerations `qdd`,
    /// under laws that move nothing ([`Laws::at_rest`](super::Laws::at_rest)).
    ///
    /// # Errors
    ///
    /// [`MotionError::State`] where something is not finite or not determined.
    pub fn linearise(&self, state: &MotionState) -> Result<SmallMotions, MotionError> {
        let mut loaded = state.clone();
        self.load(&mut loaded);
        let (matrix, bias) = self.equations.dynamics(&loaded);
        let jacobian = self.equations.constraints().evaluate(state).1;
        let Partition {
            independent: u,
            dependent: v,
            rows,
            ..
        } = &self.partition;
        let slopes = self.follow(state, &jacobian)?;
        let transform = stack(u, v, &slopes, bias.len());
        let left = |i: usize| dot(matrix.row(i), &state.qdd) + bias[i] - loaded.joint_forces[i];
        let left: Vec<f64> = (0..bias.len()).map(left).collect();
        let mut bare = loaded.clone();
        bare.frc.fill([0.0; 3]);
        bare.trq.fill([0.0; 3]);
        let sizes = self.bias_sizes(&bare);
        let terms = |i: usize| {
            let moved = matrix.row(i).iter().zip(&state.qdd);
            let moved: f64 = moved.map(|(mass, rate)| (mass * rate).abs()).sum();
            moved + sizes[i] + loaded.joint_forces[i].abs()
        };
        let terms: Vec<f64> = (0..bias.len()).map(|i| ROUNDING * terms(i)).collect();
        let rounding = (0..u.len()).map(|place| {
            let entries = terms.iter().enumerate();
            entries
                .map(|(joint, term)| transform[(joint, place)].abs() * term)
                .sum()
        });
        let right: Vec<f64> = v.iter().map(|&joint| left[joint]).collect();
        let multipliers = if rows.is_empty() {
            Vec::new()
        } else {
            let square = jacobian.select(rows, v).transposed();
            let solution =
                solve_square(square, column(&right)).ok_or_else(|| undetermined(state))?;
            (0..rows.len()).map(|row| solution[(row, 0)]).collect()
        };
        let residual = transform.transposed_times(&left);
        let rounding: Vec<f64> = rounding.collect();
        if !largest(&residual).is_finite() {
            return Err(MotionError::not_finite("a force", state.time));
        }
        let around = LinearisedState {
            state: &loaded,
            bare,
            jacobian,
            transform,
            multipliers,
        };
        let mut stiffness = DenseMatrix::zeros(u.len(), u.len());
        let mut damping = DenseMatrix::zeros(u.len(), u.len());
        for place in 0..u.len() {
            for (by_velocity, entries) in [(false, &mut stiffness), (true, &mut damping)] {
                let direction = self.direction(&around, (place, by_velocity))?;
                let change = self.change(&around, &matrix, direction)?;
                for (row, &value) in change.iter().enumerate() {
                    entries[(row, place)] = value;
                }
            }
        }
        let transform = around.transform;
        let mass = transform.transposed().product(&matrix.product(&transform));
        Ok(SmallMotions {
            joints: u.clone(),
            mass,
            damping,
            stiffness,
            transform,
            residual,
            rounding,
        })
    }

    /// Sizes of the terms of the bias, by joint: weights, and forces on bodies.
    fn bias_sizes(&self, bare: &MotionState) -> Vec<f64> {
        let mut unloaded = bare.clone();
        unloaded.links.fill(0.0);
        unloaded.external.fill([0.0; 9]);
        let weights = self.equations.dynamics(&unloaded).1;
        let mut sizes: Vec<f64> = weights.iter().map(|weight| weight.abs()).collect();
        let mut add = |one: &MotionState| {
            let bias = self.equations.dynamics(one).1;
            for ((size, bias), weight) in sizes.iter_mut().zip(bias).zip(&weights) {
                *size += (bias - weight).abs();
            }
        };
        for (index, &force) in bare
            .links
            .iter()
            .enumerate()
            .filter(|(_, force)| **force != 0.0)
        {
            let mut one = unloaded.clone();
            one.links[index] = force;
            self.equations.add_links(&mut one);
            add(&one);
        }
        for (index, numbers) in bare.external.iter().enumerate() {
            let mut one = unloaded.clone();
            one.external[index] = *numbers;
            self.equations.add_forces(&mut one);
            add(&one);
        }
        sizes
    }

    /// `B` of the dependent joints, a row for each.
    fn follow(
        &self,
        state: &MotionState,
        jacobian: &DenseMatrix,
    ) -> Result<DenseMatrix, MotionError> {
        let u = &self.partition.independent;
        if self.partition.rows.is_empty() {
            return Ok(DenseMatrix::zeros(0, u.len()));
        }
        let nothing = vec![0.0; jacobian.rows()];
        let still = vec![0.0; jacobian.columns()];
        Ok(self.dependence(state, jacobian, &nothing, &still)?.0)
    }

    /// `-Jv^-1` times numbers of the rows that count; none without loops.
    fn dependent(
        &self,
        around: &LinearisedState<'_>,
        numbers: &[f64],
    ) -> Result<Vec<f64>, MotionError> {
        let Partition {
            dependent: v, rows, ..
        } = &self.partition;
        if rows.is_empty() {
            return Ok(Vec::new());
        }
        let right: Vec<f64> = rows.iter().map(|&row| -numbers[row]).collect();
        let square = around.jacobian.select(rows, v);
        let solution =
            solve_square(square, column(&right)).ok_or_else(|| undetermined(around.state))?;
        Ok((0..rows.len()).map(|row| solution[(row, 0)]).collect())
    }

    /// Change of the motion of all joints with that of an independent one.
    fn direction(
        &self,
        around: &LinearisedState<'_>,
        (place, by_velocity): (usize, bool),
    ) -> Result<MotionState, MotionError> {
        let mut direction = MotionState::none(self.model);
        let all = 0..self.model.joints.len();
        let moved: Vec<f64> = all.map(|joint| around.transform[(joint, place)]).collect();
        if by_velocity {
            direction.qd = moved;
            return Ok(direction);
        }
        direction.q = moved;
        let constraints = self.equations.constraints();
        let turned = constraints.jacobian_along(around.state, &direction);
        let faster = self.dependent(around, &turned.times(&around.state.qd))?;
        for (&joint, faster) in self.partition.dependent.iter().zip(faster) {
            direction.qd[joint] = faster;
        }
        Ok(direction)
    }

    /// Change of the residual of the reduced equations.
    fn change(
        &self,
        around: &LinearisedState<'_>,
        matrix: &DenseMatrix,
        mut direction: MotionState,
    ) -> Result<Vec<f64>, MotionError> {
        self.load_along(around, &mut direction);
        let state = around.state;
        let (matrix_slope, bias_slope) = self.equations.dynamics_along(state, &direction);
        let constraints = self.equations.constraints();
        let turned = constraints.jacobian_along(state, &direction);
        let mut quadratic = self.equations.quadratic_along(state, &direction);
        for (sum, more) in quadratic.iter_mut().zip(turned.times(&state.qdd)) {
            *sum += more;
        }
        // Dependent joints accelerate otherwise though independent ones do not.
        let mut accelerated = vec![0.0; state.q.len()];
        let dependent = self.dependent(around, &quadratic)?;
        for (&joint, value) in self.partition.dependent.iter().zip(dependent) {
            accelerated[joint] = value;
        }
        let every: Vec<usize> = (0..state.q.len()).collect();
        let held = turned.select(&self.partition.rows, &every);
        let held = held.transposed_times(&around.multipliers);
        let left = (0..state.q.len()).map(|i| {
            dot(matrix_slope.row(i), &state.qdd) + bias_slope[i] - direction.joint_forces[i]
                + dot(matrix.row(i), &accelerated)
                - held[i]
        });
        let left: Vec<f64> = left.collect();
        if !largest(&left).is_finite() {
            return Err(MotionError::not_finite(
                "the derivative of a force",
                state.time,
            ));
        }
        Ok(around.transform.transposed_times(&left))
    }

    /// Derivatives of all forces along a direction, which they complete.
    fn load_along(&self, around: &LinearisedState<'_>, direction: &mut MotionState) {
        let state = around.state;
        for (index, law) in self.laws.joints.iter().enumerate() {
            let slope = law.damping + law.dry_slope(state.qd[index]);
            direction.joint_forces[index] =
                -law.stiffness * direction.q[index] - slope * direction.qd[index];
        }
        let mut bare = around.bare.clone();
        if self.laws.links.iter().any(Spring::acts) {
            let rates = self.equations.link_lengths(state);
            let slopes = self.equations.link_lengths_along(state, direction);
            assert_eq!(
                slopes.len(),
                self.laws.links.len(),
                "every link has a length"
            );
            for (index, ([length, rate], law)) in slopes.iter().zip(&self.laws.links).enumerate() {
                let sign = self.lengths[index].signum();
                let damping = law.damping + law.dry_slope(rates[index][1] * sign);
                direction.links[index] = law.stiffness * length + damping * rate;
            }
            self.equations.add_links_along(&bare, direction);
            self.equations.add_links(&mut bare);
        }
        if self.laws.forces.iter().any(Support::acts) {
            let motions = self.equations.force_motion(state);
            let slopes = self.equations.force_motion_along(state, direction);
            assert_eq!(
                motions.len(),
                self.laws.forces.len(),
                "every force has a point that moves"
            );
            assert_eq!(slopes.len(), motions.len(), "every motion has a slope");
            let forces = motions.iter().zip(&slopes).zip(&self.laws.forces);
            for (index, ((motion, slope), law)) in forces.enumerate() {
                let ground = law.ground_force(&motion.along(slope));
                for k in 0..3 {
                    let held = law.stiffness[k] * slope.place[k];
                    let damped = law.damping[k] * slope.velocity[k];
                    direction.external[index][k] = ground.force[k].slope - held - damped;
                    direction.external[index][3 + k] = ground.torque[k].slope;
                }
            }
            self.equations.add_forces_along(&bare, direction);
        }
    }
}

fn undetermined(state: &MotionState) -> MotionError {
    MotionError::not_finite("the motion of a dependent joint", state.time)
}
