//! A model as a tree of joints with numbers, and its state.

use super::Real;
use super::spatial::{Matrix3, Vector3, apply, identity, product, scale, transpose, zeros};
use robovec::model::{Axis, JointKind, JointMounting, Model};
use std::array::from_fn;

/// A joint with the (perhaps massless) body beyond it.
pub(crate) struct Link<T> {
    /// The joint before it; `None` for the base.
    pub(crate) parent: Option<usize>,
    /// Kind and axis.
    pub(crate) kind: JointKind,
    /// Its attachment, in the frame of the parent.
    pub(crate) offset: Vector3<T>,
    /// The constant rotation that comes before the joint's: `x = R x_parent`.
    pub(crate) turn: Matrix3<T>,
    /// `-1` for a joint that moves against its axis, else `1`.
    pub(crate) sign: f64,
    /// Mass.
    pub(crate) mass: T,
    /// Centre of mass, in the frame beyond the joint.
    pub(crate) center: Vector3<T>,
    /// Inertia about the centre of mass.
    pub(crate) inertia: Matrix3<T>,
    /// Inertia of the rotor that the joint turns.
    pub(crate) armature: T,
}

/// The joints of a model; parents come first.
pub(crate) struct Tree<T> {
    /// Gravity in the base frame.
    pub(crate) gravity: Vector3<T>,
    /// The joints, in the model's order.
    pub(crate) links: Vec<Link<T>>,
}

/// Positions, velocities, accelerations, and the external force and torque on
/// each body: at its centre of mass, along its axes.
#[derive(Clone)]
pub(crate) struct State<T> {
    /// Positions.
    pub(crate) q: Vec<T>,
    /// Velocities.
    pub(crate) qd: Vec<T>,
    /// Accelerations.
    pub(crate) qdd: Vec<T>,
    /// Forces, one per joint.
    pub(crate) frc: Vec<Vector3<T>>,
    /// Torques, one per joint.
    pub(crate) trq: Vec<Vector3<T>>,
}

impl<T: Real> Tree<T> {
    /// The tree of a model.
    pub(crate) fn new(model: &Model) -> Tree<T> {
        let links = model.joints.iter().enumerate().map(|(index, joint)| {
            let offset = joint
                .point
                .map_or([0.0; 3], |point| model.points[point].coordinates);
            let body = model.body_of(index);
            let inertia = body.map_or([0.0; 9], |body| body.inertia_matrix());
            Link {
                parent: joint.parent,
                kind: joint.kind,
                offset: offset.map(T::from),
                turn: turned(&joint.mounting),
                sign: joint.mounting.sign(),
                mass: T::from(body.map_or(0.0, |body| body.mass)),
                center: body.map_or([0.0; 3], |body| body.center).map(T::from),
                inertia: from_fn(|i| from_fn(|j| T::from(inertia[3 * i + j]))),
                armature: T::from(joint.armature),
            }
        });
        Tree {
            gravity: model.gravity.map(T::from),
            links: links.collect(),
        }
    }

    /// The joints from one to the base, itself first.
    pub(crate) fn path(&self, joint: Option<usize>) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(joint, |&joint| self.links[joint].parent)
    }
}

impl<T: Real> Link<T> {
    /// The unit vector along which the joint moves, in its own frame.
    pub(crate) fn axis(&self) -> Vector3<T> {
        let along = |i| f64::from(u8::from(i == self.kind.axis().index()));
        from_fn(|i| T::from(self.sign * along(i)))
    }

    /// The way a prismatic joint has gone, in the frame of the parent.
    pub(crate) fn slide(&self, q: T) -> Vector3<T> {
        apply(&transpose(&self.turn), scale(q, self.axis()))
    }

    /// The rotation into the frame beyond the joint: `x_i = R x_parent`.
    pub(crate) fn rotation(&self, q: T) -> Matrix3<T> {
        match self.kind {
            JointKind::Revolute(axis) => product(&about(axis, T::from(self.sign) * q), &self.turn),
            JointKind::Prismatic(_) => self.turn,
        }
    }
}

/// The rotation about an axis of a frame.
fn about<T: Real>(axis: Axis, angle: T) -> Matrix3<T> {
    let (o, l) = (T::zero(), T::from(1.0));
    let (s, c) = angle.sin_cos();
    match axis {
        Axis::X => [[l, o, o], [o, c, s], [o, -s, c]],
        Axis::Y => [[c, o, -s], [o, l, o], [s, o, c]],
        Axis::Z => [[c, s, o], [-s, c, o], [o, o, l]],
    }
}

/// The constant rotations of a joint, one after the other.
fn turned<T: Real>(mounting: &JointMounting) -> Matrix3<T> {
    let turns = mounting.turns.iter();
    turns.fold(identity(), |before, turn| {
        product(&about(turn.axis, T::from(turn.angle)), &before)
    })
}

impl<T: Real> State<T> {
    /// The state as the equations see it: velocities and accelerations that
    /// the model gives no symbol are zero, and massless frames carry no
    /// force.
    pub(crate) fn seen_by(mut self, model: &Model) -> State<T> {
        for (index, joint) in model.joints.iter().enumerate() {
            if !joint.has_velocity {
                self.qd[index] = T::zero();
            }
            if !joint.has_acceleration {
                self.qdd[index] = T::zero();
            }
            if model.body_of(index).is_none() {
                self.frc[index] = zeros();
                self.trq[index] = zeros();
            }
        }
        self
    }

    /// The same state in another kind of number.
    pub(crate) fn convert<U: Real>(&self, convert: impl Fn(T) -> U + Copy) -> State<U> {
        let list = |numbers: &[T]| numbers.iter().map(|&x| convert(x)).collect();
        let vectors = |vectors: &[Vector3<T>]| vectors.iter().map(|v| v.map(convert)).collect();
        State {
            q: list(&self.q),
            qd: list(&self.qd),
            qdd: list(&self.qdd),
            frc: vectors(&self.frc),
            trq: vectors(&self.trq),
        }
    }
}
