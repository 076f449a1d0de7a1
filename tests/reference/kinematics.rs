//! Motion of frames and points.

use super::spatial::*;
use super::{Real, State, Tree};
use robovec::model::Anchor;

/// A frame beyond a joint. Spatial vectors are about its origin and along its
/// axes.
#[derive(Clone, Copy)]
pub(crate) struct Frame<T> {
    /// Rows are the axes, in the base frame.
    pub(crate) rotation: Matrix3<T>,
    /// The origin, in the base frame.
    pub(crate) origin: Vector3<T>,
    /// The Plücker transform from the parent's frame.
    pub(crate) from_parent: Matrix6<T>,
    /// The direction of the joint.
    pub(crate) subspace: Vector6<T>,
    /// Spatial velocity.
    pub(crate) velocity: Vector6<T>,
    /// Spatial acceleration.
    pub(crate) acceleration: Vector6<T>,
}

/// A point on a frame, in the base frame.
#[derive(Clone)]
pub(crate) struct Point<T> {
    /// Position.
    pub(crate) position: Vector3<T>,
    /// Rows are the axes of the frame.
    pub(crate) rotation: Matrix3<T>,
    /// Velocity.
    pub(crate) velocity: Vector3<T>,
    /// Angular velocity of the frame.
    pub(crate) angular_velocity: Vector3<T>,
    /// Acceleration.
    pub(crate) acceleration: Vector3<T>,
    /// Angular acceleration of the frame.
    pub(crate) angular_acceleration: Vector3<T>,
    /// Rows: velocity, then angular velocity; one column per joint.
    pub(crate) jacobian: [Vec<T>; 6],
}

/// A frame at rest, except that it accelerates.
pub(crate) fn base<T: Real>(acceleration: Vector3<T>) -> Frame<T> {
    Frame {
        rotation: identity(),
        origin: zeros(),
        from_parent: identity(),
        subspace: zeros(),
        velocity: zeros(),
        acceleration: join(zeros(), acceleration),
    }
}

/// The frames beyond all joints, on a base that accelerates.
pub(crate) fn frames<T: Real>(
    tree: &Tree<T>,
    state: &State<T>,
    acceleration: Vector3<T>,
) -> Vec<Frame<T>> {
    let ground = base(acceleration);
    let mut frames: Vec<Frame<T>> = Vec::with_capacity(tree.links.len());
    for (i, link) in tree.links.iter().enumerate() {
        let parent = link.parent.map_or(&ground, |parent| &frames[parent]);
        let revolute = link.kind.is_revolute();
        let (slide, subspace) = if revolute {
            (zeros(), join(link.axis(), zeros()))
        } else {
            (link.slide(state.q[i]), join(zeros(), link.axis()))
        };
        let place = add(link.offset, slide);
        let rotation = link.rotation(state.q[i]);
        let from_parent = plucker(&rotation, place);
        let joint_velocity = scale(state.qd[i], subspace);
        let velocity = add(apply(&from_parent, parent.velocity), joint_velocity);
        let joint_acceleration = add(
            scale(state.qdd[i], subspace),
            cross_motion(velocity, joint_velocity),
        );
        frames.push(Frame {
            rotation: product(&rotation, &parent.rotation),
            origin: add(parent.origin, apply(&transpose(&parent.rotation), place)),
            from_parent,
            subspace,
            velocity,
            acceleration: add(apply(&from_parent, parent.acceleration), joint_acceleration),
        });
    }
    frames
}

/// The velocity of a frame per unit velocity of each joint before it, as
/// spatial vectors in that frame: pairs of joint and column.
pub(crate) fn body_jacobian<T: Real>(
    tree: &Tree<T>,
    frames: &[Frame<T>],
    joint: Option<usize>,
) -> Vec<(usize, Vector6<T>)> {
    let mut from_joint: Matrix6<T> = identity();
    let mut columns = Vec::new();
    for k in tree.path(joint) {
        columns.push((k, apply(&from_joint, frames[k].subspace)));
        from_joint = product(&from_joint, &frames[k].from_parent);
    }
    columns
}

/// The motion of a point given in the frame beyond a joint (`None`: the base).
pub(crate) fn point<T: Real>(
    tree: &Tree<T>,
    frames: &[Frame<T>],
    joint: Option<usize>,
    place: Vector3<T>,
) -> Point<T> {
    let frame = joint.map_or(base(zeros()), |joint| frames[joint]);
    let outward = transpose(&frame.rotation);
    let at_place = |v: Vector6<T>| add(linear(v), cross(angular(v), place));
    let velocity = at_place(frame.velocity);
    // The spatial acceleration is that of the field of velocities at a fixed
    // place; the point moves through it.
    let acceleration = add(
        at_place(frame.acceleration),
        cross(angular(frame.velocity), velocity),
    );
    let mut jacobian: [Vec<T>; 6] = std::array::from_fn(|_| vec![T::zero(); tree.links.len()]);
    for (k, column) in body_jacobian(tree, frames, joint) {
        let moved = join(
            apply(&outward, at_place(column)),
            apply(&outward, angular(column)),
        );
        for (row, &entry) in jacobian.iter_mut().zip(&moved) {
            row[k] = entry;
        }
    }
    Point {
        position: add(frame.origin, apply(&outward, place)),
        rotation: frame.rotation,
        velocity: apply(&outward, velocity),
        angular_velocity: apply(&outward, angular(frame.velocity)),
        acceleration: apply(&outward, acceleration),
        angular_acceleration: apply(&outward, angular(frame.acceleration)),
        jacobian,
    }
}

/// The frame and the place that an anchor of a model means.
pub(crate) fn anchor<T: Real>(
    model: &robovec::model::Model,
    anchor: &Anchor,
) -> (Option<usize>, Vector3<T>) {
    let coordinates = anchor
        .point
        .map_or([0.0; 3], |point| model.points[point].coordinates);
    (model.last_joint(anchor.body), coordinates.map(T::from))
}
