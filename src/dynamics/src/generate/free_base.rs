//! A free base described by a quaternion instead of yaw, pitch and roll.
//!
//! Forces do not depend on the frame in which a motion is described. So the
//! base is described in its frame of the moment, where all six joints are at
//! zero: gravity is turned into that frame, and the rates of the joints are the
//! velocity `v` and the angular velocity `w` of the base along its own axes, as
//! in Pinocchio. These change by `vd` and `wd`; the joints then accelerate by
//!
//! ```text
//! translations  vd + w x v
//! yaw           wd_z + w_x w_y
//! pitch         wd_y - w_x w_z
//! roll          wd_x + w_y w_z
//! ```
//!
//! No pitch is singular, and six angles have neither sines nor cosines.
//!
//! Derivatives by the position of the base are those along its own axes: its
//! origin moves by `R d`, or it turns by `R exp(~d)`, while `v`, `w`, `vd` and
//! `wd` stay. Only gravity along its axes changes, by `g x d`. Of the velocities
//! `v` adds `w x d` to the acceleration of the origin; `w` adds `d x v`, and to
//! bodies at `r` that move as `u` the accelerations `2 d x u + (w x d) x r`.

use super::algebra::{Scalar, Sum};
use super::derivative::{MotionChange, across};
use super::equations::{Equations, QuantityLabel};
use super::parameters::ModelParameters;
use super::vector::{Vector, ZERO, cyclic, unit};
use super::{GenerateError, GenerationRequest};
use robovec_model::{Axis, JointKind, Model};
use robovec_robotran::FunctionKind;

/// The joints of a free base, in their order.
const KINDS: [JointKind; 6] = [
    JointKind::Prismatic(Axis::X),
    JointKind::Prismatic(Axis::Y),
    JointKind::Prismatic(Axis::Z),
    JointKind::Revolute(Axis::Z),
    JointKind::Revolute(Axis::Y),
    JointKind::Revolute(Axis::X),
];

/// The functions that do not depend on the place of the base.
const SUPPORTED: [FunctionKind; 8] = [
    FunctionKind::Dirdyna,
    FunctionKind::Invdyna,
    FunctionKind::Accelred,
    FunctionKind::InvdynaD,
    FunctionKind::DirdynaD,
    FunctionKind::AccelD,
    FunctionKind::Minv,
    FunctionKind::Regressor,
];

/// Refuses models without a free base, and functions that depend on its place.
pub(super) fn check(model: &Model, request: &GenerationRequest) -> Result<(), GenerateError> {
    let refused = |why: &str| {
        Err(GenerateError::Quaternion {
            model: model.name.clone(),
            why: why.to_owned(),
        })
    };
    let function = request.function;
    if !SUPPORTED.contains(&function) {
        let names = SUPPORTED.map(FunctionKind::name).join(", ");
        return refused(&format!(
            "{} is not among its functions, which are {names}",
            function.name()
        ));
    }
    let is_free = model.bodies.first().is_some_and(|body| {
        let joints = &model.joints[body.joints.clone()];
        body.point.is_none()
            && joints.iter().map(|joint| joint.kind).eq(KINDS)
            && joints.iter().all(|joint| joint.mounting.is_plain())
    });
    if !is_free {
        return refused("its first body has other joints than x, y, z, yaw, pitch and roll");
    }
    let base = model.bodies[0].joints.clone();
    if model.joints[base].iter().any(|joint| joint.armature != 0.0) {
        // It would resist the motion along the axes of the ground.
        return refused("its base has an armature");
    }
    if model.bodies[1..].iter().any(|body| body.parent.is_none()) {
        return refused("other bodies are attached to the ground as well");
    }
    if (model.cuts.iter().flat_map(|cut| &cut.ends)).any(|end| end.body.is_none()) {
        return refused("a loop is closed on the ground");
    }
    Ok(())
}

/// Gravity along the axes of the base; `quat` is `x y z w`, of length one.
pub(super) fn gravity(equations: &mut Equations, along: &Vector) -> Vector {
    let [x, y, z, w] = [1, 2, 3, 4].map(|number| equations.input("quat", &[number]));
    let vector = [x, y, z];
    let two = equations.number(2.0);
    [0, 1, 2].map(|a| {
        let (b, c) = cyclic(a);
        let mut sum = Sum::of(along[a]);
        for square in [vector[b], vector[c]] {
            sum.subtract(&[two, square, square, along[a]]);
        }
        // The rows of the rotation matrix are the axes of the ground.
        for (other, last, sign) in [(b, c, Scalar::ONE), (c, b, -Scalar::ONE)] {
            sum.add(&[two, vector[a], vector[other], along[other]]);
            sum.add(&[two, sign, w, vector[last], along[other]]);
        }
        equations.define(QuantityLabel::new("GB", a + 1, 1), sum)
    })
}

/// Accelerations of the base's joints, of their rates, at zero `vd` and `wd`.
pub(super) fn resting(equations: &mut Equations, qd: &[Scalar]) -> Vec<Scalar> {
    let (v, w) = ([qd[0], qd[1], qd[2]], [qd[5], qd[4], qd[3]]);
    let mut define =
        |joint: usize, sum: Sum| equations.define(QuantityLabel::new("QB", 0, joint + 1), sum);
    let mut all = Vec::with_capacity(6);
    for a in 0..3 {
        let (b, c) = cyclic(a);
        let mut sum = Sum::product(&[w[b], v[c]]);
        sum.subtract(&[w[c], v[b]]);
        all.push(define(a, sum));
    }
    for (joint, factors) in [(3, [w[0], w[1]]), (4, [-w[0], w[2]]), (5, [w[1], w[2]])] {
        all.push(define(joint, Sum::product(&factors)));
    }
    all
}

/// Changes of the base's motion along one axis, by position and velocity.
pub(super) fn changes(parameters: &ModelParameters<'_>, joint: usize) -> [MotionChange; 2] {
    let axis = parameters.axis(joint);
    let qd = &parameters.qd;
    let (v, w) = ([qd[0], qd[1], qd[2]], [qd[5], qd[4], qd[3]]);
    if !parameters.is_revolute(joint) {
        return [ZERO, across(axis, &w)].map(MotionChange::of_origin);
    }
    let turned = across(axis, &parameters.gravity);
    let by_velocity = MotionChange {
        angular: across(axis, &w),
        linear: across(axis, &v).map(|component| -component),
        velocity: unit(axis),
    };
    let by_position = turned.map(|component| -component);
    [MotionChange::of_origin(by_position), by_velocity]
}
