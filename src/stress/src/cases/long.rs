//! Long simulations.

use super::super::case::{CaseClass, StressCase};
use super::super::long::{Kept, Long};
use super::super::verdict::StressVerdict;
use super::models::{random, sphere};
use robovec_dynamics::kinematics::MotionState;
use robovec_model::build::{BASE, ModelBuilder};
use robovec_model::family::built_in;
use robovec_model::{Axis, JointKind, Model};

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, duration, expected) in [
        (2, 100.0, StressVerdict::Fine),
        (3, 100.0, StressVerdict::Fine),
        (4, 100.0, StressVerdict::Fine),
        (5, 60.0, StressVerdict::BadCode),
    ] {
        let model = built_in("double-pendulum").expect("a family");
        let initial = MotionState::initial(&model);
        let step = 10f64.powi(-power);
        let subject = Long::new(model, initial, Kept::Energy, [duration, step]);
        cases.push(StressCase {
            long: power > 2,
            ..CaseClass::Motion.case(
                format!("pendulum-1e-{power}"),
                format!("a double pendulum for {duration} s in steps of 1e-{power} s"),
                "the energy: every step adds a small change to the state",
                expected,
                subject,
            )
        });
    }
    for (power, duration, expected) in [
        (3, 10.0, StressVerdict::Fine),
        (4, 20.0, StressVerdict::BadCode),
    ] {
        let model = satellite();
        let mut initial = random(&model, 2, 1.0);
        initial.q[3..6].copy_from_slice(&[0.3, 0.2, -0.4]);
        let step = 10f64.powi(-power);
        let subject = Long::new(model, initial, Kept::Momentum, [duration, step]);
        cases.push(StressCase {
            long: true,
            ..CaseClass::Motion.case(
                format!("satellite-1e-{power}"),
                format!("a free body with two arms for {duration} s in steps of 1e-{power} s"),
                "linear and angular momentum, which nothing changes",
                expected,
                subject,
            )
        });
    }
    cases
}

/// A body that floats, with two arms that turn.
fn satellite() -> Model {
    let mut builder = ModelBuilder::new("satellite");
    builder.gravity([0.0; 3]);
    let hub = builder.body("Hub", BASE.origin(), &JointKind::ALL);
    builder.mass(hub, 10.0, [0.01, 0.02, -0.01], sphere(1.0));
    for (name, place, axis) in [
        ("Left", [-0.5, 0.0, 0.1], Axis::Y),
        ("Right", [0.5, 0.1, 0.0], Axis::X),
    ] {
        let mount = builder.point(hub, name, place);
        let arm = builder.body(name, mount, &[JointKind::Revolute(axis)]);
        builder.mass(arm, 1.0, [0.1, 0.05, 0.3], sphere(0.04));
    }
    builder.finish()
}
