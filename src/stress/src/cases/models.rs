//! Models and states that several cases start from.

use super::super::draw::Draw;
use super::super::dynamics::{DynamicsSubject, Metric};
use robovec_dynamics::kinematics::MotionState;
use robovec_model::build::{BASE, ModelBuilder};
use robovec_model::{Axis, JointKind, Model};

/// A hinge about the second axis.
pub(super) const HINGE: [JointKind; 1] = [JointKind::Revolute(Axis::Y)];

/// Bodies of 1 kg and 1 m on hinges about the second axis, each at the end of
/// the one before.
pub(super) fn planar(joints: usize) -> Model {
    let mut builder = ModelBuilder::new("planar");
    let mut place = BASE.origin();
    for number in 1..=joints {
        let body = builder.body(&format!("Body_{number}"), place, &HINGE);
        builder.mass(body, 1.0, [0.5, 0.0, 0.0], sphere(1.0 / 12.0));
        place = builder.point(body, "End", [1.0, 0.0, 0.0]);
    }
    builder.finish()
}

/// The inertia of a body that is the same about all axes.
pub(super) fn sphere(inertia: f64) -> [f64; 6] {
    [inertia, 0.0, 0.0, inertia, 0.0, inertia]
}

/// A random state: angles up to half a turn, velocities and accelerations up
/// to the given size.
pub(super) fn random(model: &Model, seed: u64, rate: f64) -> MotionState {
    let mut draw = Draw::new(seed);
    let mut state = MotionState::initial(model);
    for joint in 0..model.joints.len() {
        state.q[joint] = draw.within(std::f64::consts::PI);
        state.qd[joint] = draw.within(rate);
        state.qdd[joint] = draw.within(rate);
    }
    state
}

/// The accelerations of a model in states.
pub(super) fn accelerations(model: Model, states: Vec<MotionState>) -> DynamicsSubject {
    DynamicsSubject::new(model, states, Metric::Accelerations)
}

/// Three random states, with velocities and accelerations of the order of one.
pub(super) fn some(model: &Model) -> Vec<MotionState> {
    (0..3).map(|seed| random(model, seed, 1.0)).collect()
}

/// All positions zero, with velocities and accelerations of the order of one.
pub(super) fn straight(model: &Model) -> MotionState {
    let mut state = random(model, 3, 1.0);
    state.q.iter_mut().for_each(|q| *q = 0.0);
    state
}

/// The model with all lengths multiplied by a factor, of the same density
/// times another.
pub(super) fn resized(mut model: Model, length: f64, density: f64) -> Model {
    let mass = density * length.powi(3);
    for body in &mut model.bodies {
        body.mass *= mass;
        body.center = body.center.map(|x| x * length);
        body.inertia = body.inertia.map(|x| x * mass * length * length);
    }
    for point in &mut model.points {
        point.coordinates = point.coordinates.map(|x| x * length);
    }
    model
}
