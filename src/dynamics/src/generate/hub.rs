//! The frames that common-frame formulations refer their quantities to.
//!
//! Moments about the base of a vehicle that is far from it are large, and so
//! are their rounding errors; and six joints without mass only change the
//! frame. So the common frame is not the base's but that of the first joint on
//! a path that moves mass, or where the tree branches: the *hub*. The joints
//! before it form the *stem*, which is worked off in body frames.

use super::algebra::Scalar;
use super::equations::{Equations, QuantityLabel};
use super::parameters::ModelParameters;
use super::vector::{
    AxisRotation, Matrix, SumVector, Vector, ZERO, add_cross, cyclic, define, sums,
};

/// The frame whose origin moments are about.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub enum MomentOrigin {
    /// The base.
    Base,
    /// The first body with mass on each path: it moves with the system, so
    /// that moments stay small and short number formats keep small entries.
    #[default]
    Body,
}

/// For every joint its hub: itself for a hub, none for joints of a stem.
pub(super) fn hubs(parameters: &ModelParameters<'_>) -> Vec<Option<usize>> {
    let mut hubs: Vec<Option<usize>> = Vec::with_capacity(parameters.joints());
    for (joint, children) in parameters.children().iter().enumerate() {
        let before = parameters.parent(joint).and_then(|parent| hubs[parent]);
        let carries =
            !parameters.masses[joint].is_zero() || parameters.inertias[joint] != [ZERO; 3];
        let own = (carries || children.len() != 1).then_some(joint);
        hubs.push(before.or(own));
    }
    hubs
}

/// Pose of a frame, seen from its hub.
#[derive(Clone, Copy)]
pub(super) struct Pose {
    /// The frame's axes (rows).
    pub(super) axes: Matrix,
    /// From the hub's origin to the frame's.
    pub(super) origin: Vector,
}

impl Pose {
    /// The hub itself.
    pub(super) const HERE: Pose = Pose {
        axes: [
            [Scalar::ONE, Scalar::ZERO, Scalar::ZERO],
            [Scalar::ZERO, Scalar::ONE, Scalar::ZERO],
            [Scalar::ZERO, Scalar::ZERO, Scalar::ONE],
        ],
        origin: ZERO,
    };

    /// The frame beyond a joint.
    pub(super) fn behind(
        &self,
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        joint: usize,
        offset: &Vector,
    ) -> Pose {
        let lever = self.lever(offset);
        let lever = define(equations, "RL", joint, 0, lever);
        let mut origin = sums();
        for ((sum, &before), &step) in origin.iter_mut().zip(&self.origin).zip(&lever) {
            sum.add(&[before]).add(&[step]);
        }
        Pose {
            axes: turned(equations, "RO", joint, &self.axes, &parameters.turns[joint]),
            origin: define(equations, "PO", joint, 0, origin),
        }
    }

    /// A vector of the frame in the hub's axes.
    pub(super) fn lever(&self, vector: &Vector) -> SumVector {
        let mut sum = sums();
        for (component, sum) in sum.iter_mut().enumerate() {
            for (axis, length) in self.axes.iter().zip(vector) {
                sum.add(&[axis[component], *length]);
            }
        }
        sum
    }
}

pub(super) fn turned(
    equations: &mut Equations,
    name: &'static str,
    joint: usize,
    axes: &Matrix,
    turn: &AxisRotation,
) -> Matrix {
    let mut turned = *axes;
    let (b, c) = cyclic(turn.axis);
    for component in 0..3 {
        let column = [0, 1, 2].map(|row| axes[row][component]);
        let down = turn.down(&column);
        for row in [b, c] {
            let label = QuantityLabel::new(name, 3 * row + component + 1, joint + 1);
            turned[row][component] = equations.define(label, down[row].clone());
        }
    }
    turned
}

/// Effect of a unit of a joint's velocity, in its hub's axes, about its origin.
#[derive(Clone, Copy)]
pub(super) struct Twist {
    pub(super) angular: Vector,
    /// Velocity of the point at the hub's origin.
    pub(super) linear: Vector,
}

impl Twist {
    /// The twist of a joint whose frame has a pose.
    pub(super) fn new(
        equations: &mut Equations,
        parameters: &ModelParameters<'_>,
        joint: usize,
        pose: &Pose,
    ) -> Twist {
        let axis = pose.axes[parameters.axis(joint)];
        if !parameters.is_revolute(joint) {
            return Twist {
                angular: ZERO,
                linear: axis,
            };
        }
        let mut linear = sums();
        add_cross(&mut linear, &pose.origin, &axis, false);
        Twist {
            angular: axis,
            linear: define(equations, "VZ", joint, 0, linear),
        }
    }
}
