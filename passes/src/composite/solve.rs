//! Accelerations of a tree of bodies for given forces, over any ring that
//! divides: articulated bodies, or the factorised mass matrix.
//!
//! An articulated body is the composite of a joint in which the joints beyond
//! it are free (Featherstone, Rigid Body Dynamics Algorithms, 2008, section
//! 7.3). With U the wrench of the joint's unit acceleration and D the part of U
//! along the joint, the bodies before the joint feel
//!
//! ```text
//! IA - U U' / D        p + U u / D,  u = Qq - c - p along the joint
//! ```
//!
//! `c` holds everything that velocities, gravity and loads need at zero
//! accelerations, so that all wrenches p come from the forces u alone.

use super::bodies::{CompositeInertia, JointAxis, RingVector, UnitWrench, cross};
use super::forces::{MovingSystem, sum};
use super::matrix::JointPlacement;

/// A system whose numbers can be divided.
pub(super) trait SolvingSystem: MovingSystem {
    fn one(&mut self) -> Self::Number;
    fn div(&mut self, a: Self::Number, b: Self::Number) -> Self::Number;
}

/// A joint of an articulated body.
#[derive(Clone, Copy)]
struct ArticulatedJoint<N> {
    /// U / D, the wrench per force along the joint.
    share: UnitWrench<N>,
    /// u / D, the acceleration of the joint on a frame at rest.
    own: N,
}

/// Accelerations of the joints by articulated bodies, for forces from which
/// those of motion and loads are subtracted.
pub(super) fn articulated<S: SolvingSystem>(
    system: &mut S,
    places: &[JointPlacement],
    forces: &[S::Number],
) -> Vec<S::Number> {
    let zero = system.zero();
    let none = CompositeInertia::none(system);
    let nothing = UnitWrench {
        force: [zero; 3],
        torque: [zero; 3],
    };
    let mut carried = vec![(none, nothing); places.len()];
    let mut joints = Vec::with_capacity(places.len());
    for (joint, place) in places.iter().enumerate().rev() {
        system.enter(joint);
        let body = system.body(joint, place);
        let (inertia, wrench) = carried[joint];
        let inertia = CompositeInertia::of(system, &body).plus(system, &inertia);
        let unit = inertia.wrench(place.joint);
        let along = unit.along(place.joint);
        let one = system.one();
        let inverse = system.div(one, along);
        let share = unit.map(|part| system.mul(part, inverse));
        let share = share.with(place.joint, one);
        let force = system.sub(forces[joint], wrench.along(place.joint));
        let own = system.mul(force, inverse);
        joints.push(ArticulatedJoint { share, own });
        let Some(parent) = place.parent else {
            continue;
        };
        let free = inertia.without(system, place.joint, &unit, &share);
        let passed = share.map(|part| system.mul(part, force));
        // Along the joint the wrench is the force upon it.
        let passed = sum(system, wrench, passed).with(place.joint, forces[joint]);
        let stand = system.stand(joint, place);
        let free = stand.symmetric_inertia(system, &free);
        let passed = stand.wrench(system, passed);
        let (others, wrenches) = carried[parent];
        carried[parent] = (others.plus(system, &free), sum(system, wrenches, passed));
    }
    joints.reverse();
    outwards(system, places, &joints)
}

/// Accelerations from the base outwards.
fn outwards<S: SolvingSystem>(
    system: &mut S,
    places: &[JointPlacement],
    joints: &[ArticulatedJoint<S::Number>],
) -> Vec<S::Number> {
    let zero = system.zero();
    let mut frames: Vec<[RingVector<S::Number>; 2]> = Vec::with_capacity(places.len());
    let mut accelerations = Vec::with_capacity(places.len());
    for (joint, place) in places.iter().enumerate() {
        system.enter(joint);
        let [linear, angular] = place.parent.map_or([[zero; 3]; 2], |parent| frames[parent]);
        let stand = system.stand(joint, place);
        let arm = stand.arm(system);
        let swing = cross(system, angular, arm);
        let linear = [0, 1, 2].map(|i| system.add(linear[i], swing[i]));
        let mut linear = stand.turn(system, linear);
        let mut angular = stand.turn(system, angular);
        let ArticulatedJoint { share, own } = joints[joint];
        let (part, at) = match place.joint {
            JointAxis::Revolute(axis) => (&mut angular, axis),
            JointAxis::Prismatic(axis) => (&mut linear, axis),
        };
        let carried = std::mem::replace(&mut part[at], zero);
        let mut total = own;
        for (share, part) in share.parts().zip(linear.into_iter().chain(angular)) {
            let less = system.mul(share, part);
            total = system.sub(total, less);
        }
        let (JointAxis::Revolute(axis) | JointAxis::Prismatic(axis)) = place.joint;
        match place.joint {
            JointAxis::Revolute(_) => angular[axis] = total,
            JointAxis::Prismatic(_) => linear[axis] = total,
        }
        accelerations.push(system.sub(total, carried));
        frames.push([linear, angular]);
    }
    accelerations
}

/// Accelerations by the factors `M = L' D L` of the mass matrix, row by row,
/// from the leaves on: elements of joints on different branches remain zero
/// (Featherstone, section 6.5).
pub(super) fn factorised<S: SolvingSystem>(
    system: &mut S,
    places: &[JointPlacement],
    mut matrix: Vec<S::Number>,
    mut forces: Vec<S::Number>,
) -> Vec<S::Number> {
    let count = forces.len();
    for joint in (0..count).rev() {
        system.enter(joint);
        let pivot = matrix[joint * count + joint];
        let one = system.one();
        let inverse = system.div(one, pivot);
        let before: Vec<usize> = before(places, joint).collect();
        for (place, &row) in before.iter().enumerate() {
            let factor = system.mul(matrix[joint * count + row], inverse);
            for &column in &before[place..] {
                let part = system.mul(factor, matrix[joint * count + column]);
                let at = row * count + column;
                matrix[at] = system.sub(matrix[at], part);
            }
            let part = system.mul(factor, forces[joint]);
            forces[row] = system.sub(forces[row], part);
        }
        for &row in &before {
            let at = joint * count + row;
            matrix[at] = system.mul(matrix[at], inverse);
        }
        forces[joint] = system.mul(forces[joint], inverse);
    }
    for joint in 0..count {
        system.enter(joint);
        for before in before(places, joint) {
            let part = system.mul(matrix[joint * count + before], forces[before]);
            forces[joint] = system.sub(forces[joint], part);
        }
    }
    forces
}

/// The joints before a joint, the nearest first.
fn before(places: &[JointPlacement], joint: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(places[joint].parent, |&joint| places[joint].parent)
}
