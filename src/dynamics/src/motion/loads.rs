//! The forces that laws give in a state, their power and their energies.

use super::energy::{self, dot};
use super::system::MultibodySystem;
use super::{Spring, Support};
use crate::kinematics::MotionState;
use robovec_model::Nature;

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

impl MultibodySystem<'_> {
    /// Sets all forces; the power of those that are no springs.
    pub(super) fn load(&self, state: &mut MotionState) -> f64 {
        let mut power = 0.0;
        for (index, law) in self.laws.joints.iter().enumerate() {
            let neutral = law.neutral_or(self.initial[index]);
            let rate = state.qd[index];
            let outside = law.force - law.damping * rate - law.dry(rate);
            state.joint_forces[index] = outside - law.stiffness * (state.q[index] - neutral);
            // What moves a driven joint is its drive, whatever the law says.
            if self.model.joints[index].nature != Nature::Driven {
                power += outside * rate;
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
        assert_eq!(
            lengths.len(),
            self.laws.links.len(),
            "every link has a length"
        );
        for (index, ([length, rate], law)) in lengths.iter().zip(&self.laws.links).enumerate() {
            let start = self.lengths[index];
            let (length, rate) = (length * start.signum(), rate * start.signum());
            let outside = law.force + law.damping * rate + law.dry(rate);
            let neutral = law.neutral_or(start.abs());
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
        assert_eq!(
            motions.len(),
            self.laws.forces.len(),
            "every force has a point that moves"
        );
        for (index, (motion, law)) in motions.iter().zip(&self.laws.forces).enumerate() {
            let point = &self.model.points[self.model.forces[index].point];
            let (place, velocity) = (motion.place, motion.velocity);
            let [moved, rate] = law.ground(state.time);
            let ground = law.ground_force(&motion.fixed());
            let mut outside = [0.0; 3];
            for k in 0..3 {
                outside[k] = law.force[k] - law.damping[k] * (velocity[k] - rate[k]);
                let held = self.places[index][k] + moved[k];
                let spring = law.stiffness[k] * (place[k] - held);
                // What moves the place works on the spring.
                power -= spring * rate[k];
                state.external[index][k] = outside[k] - spring + ground.force[k].value;
                state.external[index][3 + k] = law.torque[k] + ground.torque[k].value;
                state.external[index][6 + k] = point.coordinates[k];
            }
            if point.body.is_some() {
                power += dot(outside, velocity) + dot(law.torque, motion.spin) + ground.power;
            }
        }
        self.equations.add_forces(state);
        power
    }

    /// The state with every force of the laws.
    pub fn loaded(&self, state: &MotionState) -> MotionState {
        let mut loaded = state.clone();
        self.load(&mut loaded);
        loaded
    }

    /// The energies of a state, from the model and the laws.
    pub fn energy(&self, state: &MotionState) -> Energy {
        let (kinetic, gravity) = energy::energies(self.model, state);
        let of = |stiffness: f64, stretch: f64| 0.5 * stiffness * stretch * stretch;
        let mut springs = 0.0;
        for (index, law) in self.laws.joints.iter().enumerate() {
            let neutral = law.neutral_or(self.initial[index]);
            springs += of(law.stiffness, state.q[index] - neutral);
        }
        let lengths = energy::lengths(self.model, state);
        for (index, law) in self.laws.links.iter().enumerate() {
            let neutral = law.neutral_or(self.lengths[index].abs());
            springs += of(law.stiffness, lengths[index] - neutral);
        }
        let motions = energy::point_motions(self.model, state);
        for (index, law) in self.laws.forces.iter().enumerate() {
            let [ground, _] = law.ground(state.time);
            for (k, moved) in ground.iter().enumerate() {
                let held = self.places[index][k] + moved;
                springs += of(law.stiffness[k], motions[index].place[k] - held);
            }
            springs += law.ground_energy(&motions[index]);
        }
        Energy {
            kinetic,
            gravity,
            springs,
        }
    }
}
