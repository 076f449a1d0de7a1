//! Chains: generic ones, and those whose mass matrix is nearly singular.

use super::super::case::{Case, Class};
use super::super::draw::Draw;
use super::super::dynamics::{Dynamics, Metric};
use super::super::verdict::Verdict;
use crate::model::build::{BASE, Builder};
use crate::model::{Axis, JointKind, Model, family};
use crate::motion::State;

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for joints in [7, 23, 50] {
        let model = family::serial(joints, 1);
        let states = (0..3).map(|seed| random(&model, seed, 1.0)).collect();
        cases.push(Case {
            name: format!("generic-{joints}"),
            class: Class::Base,
            construction: format!("the frozen serial model of {joints} joints, random states"),
            breaks: "nothing: the base line",
            expected: if joints < 50 {
                Verdict::Fine
            } else {
                Verdict::HardProblem
            },
            long: joints > 23,
            subject: Box::new(Dynamics::new(model, states, Metric::Accelerations)),
        });
    }
    for joints in [4, 8, 16, 32, 64, 128] {
        let model = planar(joints);
        let states = vec![straight(&model)];
        cases.push(Case {
            name: format!("straight-{joints}"),
            class: Class::Chain,
            construction: format!("{joints} equal bodies on parallel hinges, stretched out"),
            breaks: "the smallest eigenvalue of M: accelerations lose what M still has",
            expected: match joints {
                ..16 => Verdict::Fine,
                _ => Verdict::HardProblem,
            },
            long: joints > 16,
            subject: Box::new(Dynamics::new(model, states, Metric::Accelerations)),
        });
    }
    let model = planar(128);
    let states = vec![random(&model, 5, 1.0)];
    cases.push(Case {
        name: "crooked-128".to_owned(),
        class: Class::Chain,
        construction: "the same 128 bodies in a random pose".to_owned(),
        breaks: "less: the pose matters thirty times",
        expected: Verdict::HardProblem,
        long: true,
        subject: Box::new(Dynamics::new(model, states, Metric::Accelerations)),
    });
    let model = planar(1000);
    let states = vec![straight(&model)];
    let dynamics = Dynamics::new(model, states, Metric::Accelerations);
    cases.push(Case {
        name: "straight-1000".to_owned(),
        class: Class::Chain,
        construction: "1000 equal bodies on parallel hinges, by articulated bodies".to_owned(),
        breaks: "everything: no format of 32 bits holds such a mass matrix",
        expected: Verdict::HardProblem,
        long: true,
        subject: Box::new(Dynamics {
            articulated: true,
            ..dynamics
        }),
    });
    cases
}

/// Bodies of 1 kg and 1 m on hinges about the second axis, each at the end of
/// the one before.
fn planar(joints: usize) -> Model {
    let mut builder = Builder::new("planar");
    let mut place = BASE.origin();
    for number in 1..=joints {
        let hinge = [JointKind::Revolute(Axis::Y)];
        let body = builder.body(&format!("Body_{number}"), place, &hinge);
        let inertia = [1.0 / 12.0, 0.0, 0.0, 1.0 / 12.0, 0.0, 1.0 / 12.0];
        builder.mass(body, 1.0, [0.5, 0.0, 0.0], inertia);
        place = builder.point(body, "End", [1.0, 0.0, 0.0]);
    }
    builder.finish()
}

/// All angles zero, with velocities and accelerations of the order of one.
fn straight(model: &Model) -> State {
    let mut state = random(model, 3, 1.0);
    state.q.iter_mut().for_each(|q| *q = 0.0);
    state
}

/// A random state: angles up to half a turn, velocities and accelerations up
/// to the given size.
pub(super) fn random(model: &Model, seed: u64, rate: f64) -> State {
    let mut draw = Draw::new(seed);
    let mut state = State::initial(model);
    for joint in 0..model.joints.len() {
        state.q[joint] = draw.within(std::f64::consts::PI);
        state.qd[joint] = draw.within(rate);
        state.qdd[joint] = draw.within(rate);
    }
    state
}
