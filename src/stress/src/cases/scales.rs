//! Sizes at the ends of what a format holds.

use super::super::case::{CaseClass, StressCase};
use super::super::dynamics::{DynamicsSubject, Metric};
use super::super::verdict::StressVerdict;
use super::models::{random, resized, sphere};
use robovec_model::build::{BASE, ModelBuilder};
use robovec_model::{Axis, JointKind, Model, family};

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, metric, expected) in [
        (-3, Metric::Accelerations, StressVerdict::HardProblem),
        (-6, Metric::Accelerations, StressVerdict::HardProblem),
        (-9, Metric::Accelerations, StressVerdict::OutOfRange),
        (-9, Metric::Masses, StressVerdict::OutOfRange),
    ] {
        let model = resized(family::serial(7, 1), 10f64.powi(power), 1.0);
        let suffix = if metric == Metric::Masses {
            "-masses"
        } else {
            ""
        };
        cases.push(CaseClass::Scale.case(
            format!("tiny-1e{power}{suffix}"),
            format!("a chain of 7 whose lengths are 1e{power} times as large"),
            "gravity swamps inertia; below 1e-38 nothing is left of M",
            expected,
            subject(model, metric),
        ));
    }
    let model = resized(family::serial(7, 1), 1e6, 1e3);
    cases.push(CaseClass::Scale.case(
        "huge-1e6",
        "a chain of 7 whose lengths are 1e6 times as large, its density 1e3 times",
        "nothing: the exponent of binary32 is wide enough",
        StressVerdict::Fine,
        subject(model, Metric::Accelerations),
    ));
    cases.push(CaseClass::Scale.case(
        "spindle-1e-30",
        "a spindle of 1e-30 kg m^2 on a light arm that hardly moves",
        "products of small inertias and velocities, which become subnormal",
        StressVerdict::OutOfRange,
        subject(spindle(), Metric::Forces),
    ));
    cases
}

/// Random states of a model, which hardly moves where its forces are asked for.
fn subject(model: Model, metric: Metric) -> DynamicsSubject {
    let rate = if metric == Metric::Forces { 1e-12 } else { 1.0 };
    let states = (0..3).map(|seed| random(&model, seed, rate)).collect();
    DynamicsSubject::new(model, states, metric)
}

/// An arm that carries a spindle of almost no inertia, balanced, without
/// gravity.
fn spindle() -> Model {
    let mut builder = ModelBuilder::new("spindle");
    builder.gravity([0.0; 3]);
    let turn = |axis| JointKind::Revolute(axis);
    let arm = builder.body("Arm", BASE.origin(), &[turn(Axis::Z), turn(Axis::Y)]);
    builder.mass(arm, 1e-6, [0.1, 0.0, 0.0], sphere(2e-8));
    let end = builder.point(arm, "End", [0.3, 0.0, 0.0]);
    let spindle = builder.body("Spindle", end, &[turn(Axis::X)]);
    builder.mass(
        spindle,
        1e-6,
        [0.0; 3],
        [1e-30, 0.0, 0.0, 2e-30, 3e-31, 4e-30],
    );
    builder.finish()
}
