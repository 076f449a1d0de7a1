//! Masses, inertias, lengths and velocities of very different sizes, and poses
//! near a singular one.

use super::super::case::{CaseClass, StressCase};
use super::super::verdict::StressVerdict;
use super::models::{HINGE, accelerations, planar, some, sphere, straight};
use robovec_model::build::{BASE, ModelBuilder};
use robovec_model::{Axis, JointKind, Model, family};

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = masses();
    cases.extend(lengths());
    cases.extend(swamped());
    cases.extend(poses());
    cases
}

fn masses() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, expected) in [
        (3, StressVerdict::HardProblem),
        (6, StressVerdict::HardProblem),
        (9, StressVerdict::Inconsistent),
    ] {
        let mut model = family::serial(6, 1);
        let tip = model.bodies.len() - 1;
        model.bodies[tip].mass *= 10f64.powi(power);
        let states = some(&model);
        cases.push(CaseClass::Ratio.case(
            format!("tip-mass-1e{power}"),
            format!("a chain of 6 whose last body has 1e{power} times the mass"),
            "the inertia of the bodies before it",
            expected,
            accelerations(model, states),
        ));
    }
    let mut model = family::serial(6, 1);
    model.bodies[0].mass *= 1e9;
    model.bodies[0].inertia = model.bodies[0].inertia.map(|x| x * 1e9);
    let states = some(&model);
    cases.push(CaseClass::Ratio.case(
        "base-mass-1e9",
        "a chain of 6 whose first body is 1e9 times as heavy",
        "nothing: a graded matrix, whose condition alone misleads",
        StressVerdict::Fine,
        accelerations(model, states),
    ));
    cases
}

fn lengths() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, expected) in [
        (2, StressVerdict::Fine),
        (4, StressVerdict::HardProblem),
        (6, StressVerdict::HardProblem),
    ] {
        let mut model = family::serial(6, 1);
        // The second joint sits on the first point.
        model.points[0].coordinates = [0.0, 0.0, 10f64.powi(power)];
        let states = some(&model);
        cases.push(CaseClass::Ratio.case(
            format!("offset-1e{power}"),
            format!("a chain of 6 whose second joint sits 1e{power} m from the first"),
            "small inertias absorbed by m d^2",
            expected,
            accelerations(model, states),
        ));
    }
    for (power, expected) in [
        (2, StressVerdict::HardProblem),
        (4, StressVerdict::Inconsistent),
    ] {
        let model = short_link(10f64.powi(-power));
        let states = some(&model);
        cases.push(CaseClass::Ratio.case(
            format!("short-link-1e-{power}"),
            format!("a chain of 5 whose third link is 1e-{power} m long and weighs accordingly"),
            "the two hinges at its ends are nearly one",
            expected,
            accelerations(model, states),
        ));
    }
    let model = massless();
    let states = some(&model);
    cases.push(CaseClass::Ratio.case(
        "massless",
        "a chain of 9 hinges, three at a place: two of three bodies have no mass",
        "nothing, while the three axes are apart",
        StressVerdict::Fine,
        accelerations(model, states),
    ));
    let model = millimetres();
    let states = some(&model)
        .into_iter()
        .map(|mut state| {
            // The rail's position is in hundreds of metres.
            state.q[0] *= 250.0;
            state
        })
        .collect();
    cases.push(
        CaseClass::Ratio.case(
            "rail-and-needle",
            "a carriage on a rail of a kilometre carries an arm with a needle of millimetres"
                .to_owned(),
            "inertias of 1e-12 kg m^2 beside masses of 1e3 kg",
            StressVerdict::HardProblem,
            accelerations(model, states),
        ),
    );
    cases
}

/// Rods on parallel hinges: 1 m and 1 kg each, but for the third, of the same
/// thickness.
fn short_link(length: f64) -> Model {
    let mut builder = ModelBuilder::new("short_link");
    let mut place = BASE.origin();
    for number in 1..=5 {
        let length = if number == 3 { length } else { 1.0 };
        let body = builder.body(&format!("Body_{number}"), place, &HINGE);
        let center = [0.5 * length, 0.0, 0.0];
        builder.mass(body, length, center, sphere(length.powi(3) / 12.0));
        place = builder.point(body, "End", [length, 0.0, 0.0]);
    }
    builder.finish()
}

/// Bodies on three hinges each: between them nothing has mass or inertia.
fn massless() -> Model {
    let mut builder = ModelBuilder::new("massless");
    let axes = [Axis::Z, Axis::Y, Axis::X].map(JointKind::Revolute);
    let mut place = BASE.origin();
    for number in 1..=3 {
        for (part, axis) in axes.into_iter().enumerate() {
            let body = builder.body(&format!("Body_{number}_{part}"), place, &[axis]);
            match part {
                2 => {
                    builder.mass(body, 2.0, [0.2, 0.1, 0.5], sphere(0.3));
                    place = builder.point(body, "End", [0.0, 0.1, 1.0]);
                }
                _ => place = body.origin(),
            }
        }
    }
    builder.finish()
}

/// Prismatic and revolute joints, kilometres and millimetres.
fn millimetres() -> Model {
    let mut builder = ModelBuilder::new("rail_and_needle");
    let slide = |axis| JointKind::Prismatic(axis);
    let turn = |axis| JointKind::Revolute(axis);
    let carriage = builder.body("Carriage", BASE.origin(), &[slide(Axis::X), turn(Axis::Z)]);
    builder.mass(carriage, 1e3, [0.1, 0.0, 0.5], sphere(200.0));
    let mast = builder.point(carriage, "Mast", [500.0, 0.0, 100.0]);
    let arm = builder.body("Arm", mast, &[turn(Axis::Y), slide(Axis::X)]);
    builder.mass(arm, 1.0, [0.2, 0.0, 0.01], sphere(0.02));
    let tip = builder.point(arm, "Tip", [0.4, 0.0, 0.0]);
    let stage = builder.body("Stage", tip, &[turn(Axis::X), slide(Axis::Z)]);
    builder.mass(stage, 1e-3, [0.001, 0.0, 0.002], sphere(1e-9));
    let mount = builder.point(stage, "Mount", [0.002, 0.0, 0.003]);
    let needle = builder.body("Needle", mount, &[turn(Axis::Y)]);
    builder.mass(needle, 1e-6, [0.001, 0.0, 0.0], sphere(1e-12));
    builder.finish()
}

fn swamped() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, expected) in [
        (2, StressVerdict::HardProblem),
        (4, StressVerdict::HardProblem),
    ] {
        let model = planar(6);
        let mut states = some(&model);
        for state in &mut states {
            for (joint, rate) in state.qd.iter_mut().enumerate() {
                let speed = 10f64.powi(power);
                *rate = if joint % 2 == 0 { speed } else { -speed };
            }
        }
        cases.push(CaseClass::Swamped.case(
            format!("counter-rotation-1e{power}"),
            format!("six bodies on parallel hinges that turn at +-1e{power} rad/s in turn"),
            "what inertia does beside terms of the squared velocities",
            expected,
            accelerations(model, states),
        ));
    }
    cases
}

fn poses() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, expected) in [
        (1, StressVerdict::HardProblem),
        (2, StressVerdict::HardProblem),
        (3, StressVerdict::HardProblem),
        (4, StressVerdict::HardProblem),
    ] {
        let model = gimbal();
        let mut state = straight(&model);
        (state.q[0], state.q[1], state.q[2]) = (0.4, 0.7, -0.3);
        (state.q[3], state.q[4]) = (10f64.powi(-power), 0.9);
        cases.push(CaseClass::Pose.case(
            format!("gimbal-1e-{power}"),
            format!("an arm with a wrist of 1e-4 kg on axes z, y, z, the middle at 1e-{power}"),
            "the wrist's first and last axis become one",
            expected,
            accelerations(model, vec![state]),
        ));
    }
    cases
}

/// An arm of two joints and a light wrist on the axes z, y, z.
fn gimbal() -> Model {
    let mut builder = ModelBuilder::new("gimbal");
    let turn = |axis| JointKind::Revolute(axis);
    let upper = builder.body("Upper", BASE.origin(), &[turn(Axis::Z)]);
    builder.mass(upper, 2.0, [0.1, 0.0, 0.0], sphere(0.02));
    let elbow = builder.point(upper, "Elbow", [0.3, 0.0, 0.0]);
    let lower = builder.body("Lower", elbow, &HINGE);
    builder.mass(lower, 1.0, [0.1, 0.0, 0.0], sphere(0.01));
    let end = builder.point(lower, "End", [0.3, 0.0, 0.0]);
    let axes = [turn(Axis::Z), turn(Axis::Y), turn(Axis::Z)];
    let wrist = builder.body("Wrist", end, &axes);
    let inertia = [2e-8, 1e-9, 0.0, 3e-8, 0.0, 1e-8];
    builder.mass(wrist, 1e-4, [0.01, 0.0, 0.02], inertia);
    builder.finish()
}
