//! The differential equation of a model.
//!
//! The state of the integrator holds all positions, all velocities and the
//! work done so far. Dependent and driven joints are put where the loops and
//! their laws want them before anything is computed; what the integrator
//! predicts for them only serves as a start.

use super::equations::EquationSetting;
use super::{Laws, MotionEquations, MotionError, Spring, Support, energy};
use crate::kinematics::linear::{DenseMatrix, column, dot, largest, solve_positive, solve_square};
use crate::kinematics::{LoopClosure, MotionState, Partition, StateError};
use crate::model::{Model, Nature};

/// A model with its equations and the laws of its forces.
pub struct MultibodySystem<'m> {
    pub(super) model: &'m Model,
    pub(super) equations: MotionEquations,
    laws: Laws,
    /// The positions that joints start from.
    initial: Vec<f64>,
    /// The lengths of links there, as the equations give them. Along one axis
    /// of the common frame they have the axis' sign, and keep it.
    lengths: Vec<f64>,
    /// Where springs hold the points of external forces.
    places: Vec<[f64; 3]>,
    partition: Partition,
}

/// Energies of a state, J.
#[derive(Clone, Copy, PartialEq, Default, Debug)]
pub struct Energy {
    /// Of motion.
    pub kinetic: f64,
    /// In gravity.
    pub gravity: f64,
    /// In springs.
    pub springs: f64,
}

impl Energy {
    /// The sum.
    pub fn total(&self) -> f64 {
        self.kinetic + self.gravity + self.springs
    }
}

/// What the equations say of a state.
struct SystemMotion {
    accelerations: Vec<f64>,
    /// What dampers, constant forces and drives put in, W.
    power: f64,
}

impl<'m> MultibodySystem<'m> {
    /// Makes the equations of a model and closes its loops; the system and
    /// its initial state.
    ///
    /// # Errors
    ///
    /// See [`MotionError`]: equations that cannot be made, loops that cannot
    /// be closed.
    pub fn new(
        model: &'m Model,
        laws: Laws,
        setting: &EquationSetting<'_>,
    ) -> Result<(MultibodySystem<'m>, MotionState), MotionError> {
        let mut state = MotionState::initial(model);
        let mut system = MultibodySystem {
            model,
            equations: MotionEquations::new(model, setting)?,
            laws,
            initial: state.q.clone(),
            lengths: Vec::new(),
            places: Vec::new(),
            partition: Partition::default(),
        };
        system.drive(&mut state);
        system.partition = system.loops().start(&mut state)?;
        system.initial.clone_from(&state.q);
        system.places = energy::force_points(model, &state);
        for (place, law) in system.places.iter_mut().zip(&system.laws.forces) {
            *place = law.place.unwrap_or(*place);
        }
        let lengths = system.equations.link_lengths(&state);
        system.lengths = lengths.into_iter().map(|[length, _]| length).collect();
        Ok((system, state))
    }

    /// The laws of a model as [`MultibodySystem::settled_laws`] has them.
    ///
    /// # Errors
    ///
    /// As [`MultibodySystem::new`].
    pub fn settled(model: &'m Model, laws: Laws) -> Result<Laws, MotionError> {
        let (system, _) = MultibodySystem::new(model, laws, &EquationSetting::default())?;
        Ok(system.settled_laws())
    }

    /// The laws with every place that is by default the initial one as a
    /// number, so that they stay the same for another initial state.
    pub fn settled_laws(&self) -> Laws {
        let mut laws = self.laws.clone();
        for (law, &initial) in laws.joints.iter_mut().zip(&self.initial) {
            law.neutral.get_or_insert(initial);
        }
        for (law, length) in laws.links.iter_mut().zip(&self.lengths) {
            law.neutral.get_or_insert(length.abs());
        }
        for (law, &place) in laws.forces.iter_mut().zip(&self.places) {
            law.place.get_or_insert(place);
        }
        for (law, &initial) in laws.drives.iter_mut().zip(&self.initial) {
            law.offset.get_or_insert(initial);
        }
        laws
    }

    /// The roles of the joints.
    pub fn partition(&self) -> &Partition {
        &self.partition
    }

    /// The loops of the model.
    fn loops(&self) -> LoopClosure<'_> {
        LoopClosure {
            model: self.model,
            constraints: self.equations.constraints(),
        }
    }

    /// Puts driven joints where they are at the state's time.
    fn drive(&self, state: &mut MotionState) {
        for (index, joint) in self.model.joints.iter().enumerate() {
            if joint.nature != Nature::Driven {
                continue;
            }
            let [q, qd, qdd] = if joint.has_velocity && joint.has_acceleration {
                self.laws.drives[index].at(state.time, joint.initial[0])
            } else {
                [joint.initial[0], 0.0, 0.0]
            };
            (state.q[index], state.qd[index], state.qdd[index]) = (q, qd, qdd);
        }
    }

    /// Sets all forces; the power of those that are no springs.
    fn load(&self, state: &mut MotionState) -> f64 {
        let mut power = 0.0;
        for (index, law) in self.laws.joints.iter().enumerate() {
            let neutral = law.neutral.unwrap_or(self.initial[index]);
            let outside = law.force - law.damping * state.qd[index];
            state.joint_forces[index] = outside - law.stiffness * (state.q[index] - neutral);
            // What moves a driven joint is its drive, whatever the law says.
            if self.model.joints[index].nature != Nature::Driven {
                power += outside * state.qd[index];
            }
        }
        if self.laws.links.iter().any(Spring::acts) {
            power += self.load_links(state);
        }
        if self.laws.forces.iter().any(Support::acts) {
            power += self.load_points(state);
        }
        power
    }

    fn load_links(&self, state: &mut MotionState) -> f64 {
        let mut power = 0.0;
        let lengths = self.equations.link_lengths(state);
        for (index, ([length, rate], law)) in lengths.iter().zip(&self.laws.links).enumerate() {
            let start = self.lengths[index];
            let (length, rate) = (length * start.signum(), rate * start.signum());
            let outside = law.force + law.damping * rate;
            let neutral = law.neutral.unwrap_or(start.abs());
            let pull = outside + law.stiffness * (length - neutral);
            state.links[index] = pull * start.signum();
            power -= outside * rate;
        }
        self.equations.add_links(state);
        power
    }

    fn load_points(&self, state: &mut MotionState) -> f64 {
        let mut power = 0.0;
        let motions = self.equations.force_motion(state);
        for (index, (motion, law)) in motions.iter().zip(&self.laws.forces).enumerate() {
            let point = &self.model.points[self.model.forces[index].point];
            let [place, velocity, spin] = motion;
            let [ground, rate] = law.ground(state.time);
            let mut outside = [0.0; 3];
            for k in 0..3 {
                outside[k] = law.force[k] - law.damping[k] * (velocity[k] - rate[k]);
                let held = self.places[index][k] + ground[k];
                let spring = law.stiffness[k] * (place[k] - held);
                // What moves the place works on the spring.
                power -= spring * rate[k];
                state.external[index][k] = outside[k] - spring;
                state.external[index][3 + k] = law.torque[k];
                state.external[index][6 + k] = point.coordinates[k];
            }
            if point.body.is_some() {
                power += dot(&outside, velocity) + dot(&law.torque, spin);
            }
        }
        self.equations.add_forces(state);
        power
    }

    /// The state with every force that the laws give in it.
    pub fn loaded(&self, state: &MotionState) -> MotionState {
        let mut loaded = state.clone();
        self.load(&mut loaded);
        loaded
    }

    /// Accelerations, and the power of what is not conservative.
    fn motion(&self, state: &mut MotionState) -> Result<SystemMotion, MotionError> {
        let mut power = self.load(state);
        let accelerations = match self.equations.accelerations(state) {
            Some(accelerations) => accelerations,
            None => self.solve(state)?,
        };
        if !largest(&accelerations).is_finite() {
            return Err(not_finite("an acceleration", state.time));
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

    /// Solves the equations of motion for the accelerations.
    fn solve(&self, state: &MotionState) -> Result<Vec<f64>, MotionError> {
        let (matrix, bias) = self.equations.dynamics(state);
        if !largest(&bias).is_finite() {
            return Err(not_finite("a force", state.time));
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
        let free =
            solve_positive(reduced, right, threshold).map_err(|place| MotionError::Singular {
                joint: self.model.joints[u[place]].name.clone(),
                time: state.time,
            })?;
        let mut accelerations = transform.times(&free);
        for (sum, given) in accelerations.iter_mut().zip(&given) {
            *sum += given;
        }
        Ok(accelerations)
    }

    /// `B` and `b` of the dependent accelerations.
    fn dependence(
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
        let solution = solve_square(square, right)
            .ok_or_else(|| not_finite("the motion of a dependent joint", state.time))?;
        let every: Vec<usize> = (0..rows.len()).collect();
        let columns: Vec<usize> = (0..u.len()).collect();
        let offset = (0..rows.len()).map(|row| solution[(row, u.len())]);
        Ok((solution.select(&every, &columns), offset.collect()))
    }

    /// What the drives put in: the forces that the equations leave open on
    /// driven joints, less those of the loops.
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
            law.force - law.damping * state.qd[joint]
        };
        c.iter()
            .map(|&joint| (needed[joint] - of_loops[joint] + share(joint)) * state.qd[joint])
            .sum()
    }

    /// Positions, velocities and work, as the integrator holds them.
    pub(super) fn pack(state: &MotionState, work: f64) -> Vec<f64> {
        let mut packed = state.q.clone();
        packed.extend_from_slice(&state.qd);
        packed.push(work);
        packed
    }

    /// The state of an integrator's numbers: driven joints driven, loops
    /// closed.
    pub(super) fn unpack(&self, time: f64, packed: &[f64]) -> Result<MotionState, MotionError> {
        let joints = self.model.joints.len();
        if !largest(packed).is_finite() {
            return Err(not_finite("a position or velocity", time));
        }
        let mut state = MotionState::initial(self.model);
        state.time = time;
        state.q.copy_from_slice(&packed[..joints]);
        state.qd.copy_from_slice(&packed[joints..2 * joints]);
        self.drive(&mut state);
        self.loops().close(&mut state, &self.partition)?;
        Ok(state)
    }

    /// The right-hand side of the differential equation.
    pub(super) fn slope(&self, time: f64, packed: &[f64]) -> Result<Vec<f64>, MotionError> {
        let mut state = self.unpack(time, packed)?;
        let motion = self.motion(&mut state)?;
        let mut slope = state.qd;
        slope.extend_from_slice(&motion.accelerations);
        slope.push(motion.power);
        Ok(slope)
    }

    /// Chooses other dependent joints when those in use have come near a dead
    /// point.
    pub(super) fn renew(&mut self, state: &MotionState) {
        if self.equations.constraints().rows() > 0 {
            let jacobian = self.equations.constraints().evaluate(state).1;
            if !self.partition.holds(&jacobian) {
                self.partition = self.loops().divide(state);
            }
        }
    }

    /// The energies of a state, from the model and the laws.
    pub fn energy(&self, state: &MotionState) -> Energy {
        let (kinetic, gravity) = energy::energies(self.model, state);
        let of = |stiffness: f64, stretch: f64| 0.5 * stiffness * stretch * stretch;
        let mut springs = 0.0;
        for (index, law) in self.laws.joints.iter().enumerate() {
            let neutral = law.neutral.unwrap_or(self.initial[index]);
            springs += of(law.stiffness, state.q[index] - neutral);
        }
        let lengths = energy::lengths(self.model, state);
        for (index, law) in self.laws.links.iter().enumerate() {
            let neutral = law.neutral.unwrap_or(self.lengths[index].abs());
            springs += of(law.stiffness, lengths[index] - neutral);
        }
        let places = energy::force_points(self.model, state);
        for (index, law) in self.laws.forces.iter().enumerate() {
            let [ground, _] = law.ground(state.time);
            for k in 0..3 {
                let held = self.places[index][k] + ground[k];
                springs += of(law.stiffness[k], places[index][k] - held);
            }
        }
        Energy {
            kinetic,
            gravity,
            springs,
        }
    }

    /// The largest residual of the constraints.
    pub fn gap(&self, state: &MotionState) -> f64 {
        largest(&self.equations.constraints().evaluate(state).0)
    }
}

/// The matrix that takes the independent motions to all motions.
fn stack(u: &[usize], v: &[usize], slopes: &DenseMatrix, joints: usize) -> DenseMatrix {
    let mut matrix = DenseMatrix::zeros(joints, u.len());
    for (place, &joint) in u.iter().enumerate() {
        matrix[(joint, place)] = 1.0;
    }
    for (row, &joint) in v.iter().enumerate() {
        for place in 0..u.len() {
            matrix[(joint, place)] = slopes[(row, place)];
        }
    }
    matrix
}

fn not_finite(what: &str, time: f64) -> MotionError {
    MotionError::State(StateError::NotFinite {
        what: what.to_owned(),
        time,
    })
}
