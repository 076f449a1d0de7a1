//! Cases of models without loops.

use super::super::case::StressSubject;
use super::super::dynamics::{DynamicsSubject, Metric};
use super::super::long::{Kept, Long};
use super::super::numbers::Draw;
use super::super::program::shared;
use super::super::series::AnglesSubject;
use super::CaseMember;
use robovec_dynamics::kinematics::MotionState;
use robovec_model::Model;
use robovec_model::build::{BASE, ModelBuilder};
use robovec_model::family::{built_in, serial};
use robovec_model::mbs::read_mbs;
use robovec_model::{Axis, JointKind};

pub(super) fn subject(name: &str, case: &CaseMember) -> Option<Box<dyn StressSubject>> {
    let number = |name: &str| case.number(name);
    let joints = || number("joints") as usize;
    if let "pendulum" | "satellite" = name {
        return Some(Box::new(left_alone(name, case)));
    }
    Some(Box::new(match name {
        "generic" => in_some(serial(joints(), 1)),
        "straight" => in_pose(planar(joints()), &[]),
        "articulated" => DynamicsSubject {
            articulated: true,
            ..in_pose(planar(joints()), &[])
        },
        "crooked" => {
            let model = planar(joints());
            let states = vec![random(&model, 5, 1.0)];
            DynamicsSubject::new(model, states, Metric::Accelerations)
        }
        "tip-mass" => {
            let mut model = serial(6, 1);
            model.bodies[5].mass *= number("ratio");
            in_some(model)
        }
        "base-mass" => {
            let mut model = serial(6, 1);
            let body = &mut model.bodies[0];
            body.mass *= number("ratio");
            body.inertia = body.inertia.map(|x| x * number("ratio"));
            in_some(model)
        }
        "offset" => {
            let mut model = serial(6, 1);
            // The second joint sits on the first point.
            model.points[0].coordinates = [0.0, 0.0, number("length")];
            in_some(model)
        }
        "short-link" => in_some(short_link(number("length"))),
        "massless" => in_some(file(include_str!("data/massless.mbs"))),
        "rail-and-needle" => {
            let mut subject = in_some(file(include_str!("data/rail-and-needle.mbs")));
            // The rail's position is in hundreds of metres.
            let states = subject.states.iter_mut();
            states.for_each(|state| state.q[0] = shared(state.q[0] * 250.0));
            subject
        }
        "counter-rotation" => {
            let mut subject = in_some(planar(6));
            for rates in subject.states.iter_mut().map(|state| &mut state.qd) {
                let signs = [1.0, -1.0].into_iter().cycle();
                let pairs = rates.iter_mut().zip(signs);
                pairs.for_each(|(rate, sign)| *rate = sign * number("rate"));
            }
            subject
        }
        "resized" => in_some(resized(number("length"), number("density"))),
        "resized-masses" => DynamicsSubject {
            metric: Metric::Masses,
            ..in_some(resized(number("length"), number("density")))
        },
        "spindle" => {
            let model = file(include_str!("data/spindle.mbs"));
            let states = (0..3).map(|seed| random(&model, seed, 1e-12)).collect();
            DynamicsSubject::new(model, states, Metric::Forces)
        }
        "gimbal" => {
            let model = file(include_str!("data/gimbal.mbs"));
            in_pose(model, &[0.4, 0.7, -0.3, number("angle"), 0.9])
        }
        "counterweight" => {
            let mut model = file(include_str!("data/counterweight.mbs"));
            // The arm of the right weight, a metre but for what leaves a torque.
            model.points[1].coordinates[0] = 1.0 + number("residual") / (100.0 * 9.81);
            let mut state = MotionState::initial(&model);
            state.q[0] = 0.3;
            DynamicsSubject::new(model, vec![state], Metric::Forces)
        }
        "order-1" => return Some(Box::new(angles_within(number("range")))),
        _ => return None,
    }))
}

pub(super) fn file(text: &str) -> Model {
    let read = read_mbs("case", text.as_bytes());
    read.expect("a model of the cases is sound").model
}

/// A chain of 7 with angles up to a size.
fn angles_within(range: f64) -> AnglesSubject {
    let model = serial(7, 1);
    let states = (0..24).map(|seed| {
        let mut state = random(&model, seed, 1.0);
        let mut draw = Draw::new(seed);
        state.q.iter_mut().for_each(|q| *q = draw.within(range));
        state
    });
    let states = states.collect();
    AnglesSubject::new(model, states)
}

/// A model that nothing drives, in time.
fn left_alone(name: &str, case: &CaseMember) -> Long {
    let (model, initial, kept) = if name == "pendulum" {
        let model = built_in("double-pendulum").expect("a family");
        let initial = MotionState::initial(&model);
        (model, initial, Kept::Energy)
    } else {
        let model = file(include_str!("data/satellite.mbs"));
        let mut initial = random(&model, 2, 1.0);
        initial.q[3..6].copy_from_slice(&[0.3, 0.2, -0.4]);
        (model, initial, Kept::Momentum)
    };
    let times = [case.number("duration"), case.number("step")];
    Long::new(model, initial, kept, times)
}

/// Bodies of 1 kg and 1 m in a row, on hinges about the second axis.
fn planar(joints: usize) -> Model {
    let mut builder = ModelBuilder::new("planar");
    let mut place = BASE.origin();
    for number in 1..=joints {
        let hinge = [JointKind::Revolute(Axis::Y)];
        let body = builder.body(&format!("Body_{number}"), place, &hinge);
        builder.mass(body, 1.0, [0.5, 0.0, 0.0], sphere(1.0 / 12.0));
        place = builder.point(body, "End", [1.0, 0.0, 0.0]);
    }
    builder.finish()
}

/// Five such bodies, the third of another length and the same thickness.
fn short_link(length: f64) -> Model {
    let mut model = planar(5);
    let body = &mut model.bodies[2];
    (body.mass, body.center[0]) = (length, 0.5 * length);
    body.inertia = sphere(length.powi(3) / 12.0);
    model.points[2].coordinates[0] = length;
    model
}

/// The inertia of a body that is the same about all axes.
fn sphere(inertia: f64) -> [f64; 6] {
    [inertia, 0.0, 0.0, inertia, 0.0, inertia]
}

/// A random state: angles up to half a turn, rates up to the given size.
fn random(model: &Model, seed: u64, rate: f64) -> MotionState {
    let mut draw = Draw::new(seed);
    let mut state = MotionState::initial(model);
    for joint in 0..model.joints.len() {
        state.q[joint] = draw.within(std::f64::consts::PI);
        state.qd[joint] = draw.within(rate);
        state.qdd[joint] = draw.within(rate);
    }
    state
}

/// Accelerations in three random states, with rates of the order of one.
fn in_some(model: Model) -> DynamicsSubject {
    let states = (0..3).map(|seed| random(&model, seed, 1.0)).collect();
    DynamicsSubject::new(model, states, Metric::Accelerations)
}

/// Accelerations in a pose, other positions zero, rates of the order of one.
fn in_pose(model: Model, pose: &[f64]) -> DynamicsSubject {
    let mut state = random(&model, 3, 1.0);
    state.q.fill(0.0);
    state.q[..pose.len()].copy_from_slice(pose);
    DynamicsSubject::new(model, vec![state], Metric::Accelerations)
}

/// A chain of 7 with its lengths and its density multiplied by factors.
fn resized(length: f64, density: f64) -> Model {
    let mut model = serial(7, 1);
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
