//! Closed loops.

use super::super::case::{CaseClass, StressCase};
use super::super::loops::LoopsSubject;
use super::super::verdict::StressVerdict;
use super::models::{HINGE, sphere};
use crate::model::build::{BASE, BodyPlace, ModelBuilder};
use crate::model::{CutKind, Model, Nature};

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, expected) in [
        (1, StressVerdict::Fine),
        (2, StressVerdict::Fine),
        (3, StressVerdict::Fine),
        (4, StressVerdict::HardProblem),
    ] {
        cases.push(case(
            format!("parallelogram-1e-{power}"),
            format!("four bars of lengths 1, 2, 1, 2 m with the crank at 1e-{power} rad"),
            "the Jacobian of the loop: all bars on one line",
            expected,
            SLOPES.map(|slope| parallelogram(10f64.powi(-power), slope, false)),
        ));
    }
    // Rounded pivots of an overconstrained loop would never meet: this one
    // lies along an axis, where they are exact.
    cases.push(case(
        "redundant".to_owned(),
        "a parallelogram with a third rocker, at 1 rad".to_owned(),
        "the rank of the Jacobian: two rows say the same",
        StressVerdict::Fine,
        [parallelogram(1.0, 0.0, true)],
    ));
    cases.push(case(
        "redundant-1e-3".to_owned(),
        "the same with the crank at 1e-3 rad".to_owned(),
        "the rank, beside rows that nearly say the same",
        StressVerdict::Fine,
        [parallelogram(1e-3, 0.0, true)],
    ));
    cases
}

fn case(
    name: String,
    construction: String,
    breaks: &'static str,
    expected: StressVerdict,
    models: impl IntoIterator<Item = Model>,
) -> StressCase {
    StressCase {
        name,
        class: CaseClass::Loop,
        construction,
        breaks,
        expected,
        long: false,
        subject: Box::new(LoopsSubject::new(models)),
    }
}

/// Directions of the line between the pivots, rad: along an axis sums would be
/// exact that are not elsewhere.
const SLOPES: [f64; 4] = [0.3, 0.7, 1.1, 2.3];

/// A crank, a coupler and a rocker that make a parallelogram of 1 m by 2 m;
/// with a third rocker under the middle of the coupler that changes nothing.
fn parallelogram(angle: f64, slope: f64, third: bool) -> Model {
    let mut builder = ModelBuilder::new("parallelogram");
    // Rounded to binary32 here, so that rounding hardly opens the loop.
    let slope = f64::from(slope as f32);
    let along = |length: f64| [length * slope.cos(), 0.0, -length * slope.sin()];
    let far = builder.point(BASE, "Far", along(2.0));
    let middle = builder.point(BASE, "Middle", along(1.0));
    let crank = builder.body("Crank", BASE.origin(), &HINGE);
    builder.mass(crank, 1.0, [0.5, 0.0, 0.0], sphere(1.0 / 12.0));
    let pin = builder.point(crank, "Pin", [1.0, 0.0, 0.0]);
    let coupler = builder.body("Coupler", pin, &HINGE);
    builder.mass(coupler, 2.0, [1.0, 0.0, 0.0], sphere(2.0 / 3.0));
    let end = builder.point(coupler, "End", [2.0, 0.0, 0.0]);
    let half = builder.point(coupler, "Half", [1.0, 0.0, 0.0]);
    let lifted = f64::from((slope + angle) as f32);
    let rate = 0.5;
    set(&mut builder, crank, [lifted, rate], false);
    set(&mut builder, coupler, [slope - lifted, -rate], true);
    let mut rocker = |name: &str, on: BodyPlace, to: BodyPlace| {
        let rocker = builder.body(name, on, &HINGE);
        builder.mass(rocker, 1.0, [0.5, 0.0, 0.0], sphere(1.0 / 12.0));
        set(&mut builder, rocker, [lifted, rate], true);
        let tip = builder.point(rocker, "Tip", [1.0, 0.0, 0.0]);
        builder.cut(name, CutKind::Ball, [to, tip]);
    };
    rocker("Rocker", far, end);
    if third {
        rocker("Third", middle, half);
    }
    builder.finish()
}

fn set(
    builder: &mut ModelBuilder,
    body: crate::model::build::BodyRef,
    [angle, rate]: [f64; 2],
    dependent: bool,
) {
    let joint = builder.joint(body, 0);
    (joint.initial[0], joint.initial[1]) = (angle, rate);
    if dependent {
        joint.nature = Nature::Dependent;
    }
}
