//! Closed loops.

use super::super::case::{CaseClass, StressCase};
use super::super::loops::LoopsSubject;
use super::super::verdict::StressVerdict;
use super::models::{HINGE, sphere};
use robovec_dynamics::kinematics::MotionState;
use robovec_model::build::{BASE, BodyPlace, ModelBuilder};
use robovec_model::{CutKind, Model, Nature};

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, expected) in [
        (1, StressVerdict::Fine),
        (2, StressVerdict::Fine),
        (3, StressVerdict::Fine),
        (4, StressVerdict::BadCode),
    ] {
        cases.push(CaseClass::Loop.case(
            format!("parallelogram-1e-{power}"),
            format!("four bars of lengths 1, 2, 1, 2 m with the crank at 1e-{power} rad"),
            "the Jacobian of the loop: all bars on one line",
            expected,
            LoopsSubject::new(SLOPES.map(|slope| parallelogram(10f64.powi(-power), slope, false))),
        ));
    }
    // Rounded pivots of an overconstrained loop would never meet: this one
    // lies along an axis, where they are exact.
    cases.push(CaseClass::Loop.case(
        "redundant",
        "a parallelogram with a third rocker, at 1 rad",
        "the rank of the Jacobian: two rows say the same",
        StressVerdict::Fine,
        LoopsSubject::new([parallelogram(1.0, 0.0, true)]),
    ));
    cases.push(CaseClass::Loop.case(
        "redundant-1e-3",
        "the same with the crank at 1e-3 rad",
        "the rank, beside rows that nearly say the same",
        StressVerdict::Fine,
        LoopsSubject::new([parallelogram(1e-3, 0.0, true)]),
    ));
    for (bend, expected) in [
        (5e-1, StressVerdict::Fine),
        (1e-1, StressVerdict::Fine),
        (1e-2, StressVerdict::Fine),
        (1e-3, StressVerdict::BadCode),
    ] {
        let state = MotionState::initial(&four_bar(bend));
        let subject = LoopsSubject::in_states([(four_bar(0.5), state)]);
        cases.push(CaseClass::Loop.case(
            format!("whole-step-{bend:e}"),
            format!(
                "positions, velocities and accelerations of a four-bar from its rocker, \
                 {bend:e} rad from its dead point"
            ),
            "the partition of the coordinates: a rounded rocker leaves the crank uncertain",
            expected,
            subject.whole_step(),
        ));
    }
    for (power, expected) in [
        (2, StressVerdict::Fine),
        (5, StressVerdict::BadCode),
        (6, StressVerdict::BadCode),
    ] {
        // Made where the rocker moves, run where it turns round.
        let state = MotionState::initial(&four_bar(10f64.powi(-power)));
        cases.push(CaseClass::Loop.case(
            format!("dead-point-1e-{power}"),
            format!("a four-bar with the rocker independent, 1e-{power} rad from its dead point"),
            "the partition of the coordinates: the rocker hardly tells where the crank is",
            expected,
            LoopsSubject::in_states([(four_bar(0.5), state)]),
        ));
    }
    cases
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

/// A crank of 0.3 m, a coupler of 0.8 m and a rocker of 0.6 m on pivots 0.9 m
/// apart; crank and coupler are so far from one line, rad, where the rocker
/// turns round.
pub(in super::super) fn four_bar(bend: f64) -> Model {
    let mut builder = ModelBuilder::new("four_bar");
    let pivot = builder.point(BASE, "Pivot", [0.9, 0.0, 0.0]);
    let rod = |length: f64| [length / 2.0, 0.0, 0.0];
    let (crank_length, coupler_length, rocker_length) = (0.3f64, 0.8f64, 0.6f64);
    let crank = builder.body("Crank", BASE.origin(), &HINGE);
    builder.mass(crank, 1.5, rod(crank_length), sphere(0.0115));
    let pin = builder.point(crank, "Pin", [crank_length, 0.0, 0.0]);
    let coupler = builder.body("Coupler", pin, &HINGE);
    builder.mass(coupler, 2.0, rod(coupler_length), sphere(0.107));
    let end = builder.point(coupler, "End", [coupler_length, 0.0, 0.0]);
    let rocker = builder.body("Rocker", pivot, &HINGE);
    builder.mass(rocker, 1.8, rod(rocker_length), sphere(0.054));
    let tip = builder.point(rocker, "Tip", [rocker_length, 0.0, 0.0]);
    builder.cut("Loop", CutKind::Ball, [end, tip]);
    // The triangle of crank with coupler, rocker, and the line of the pivots.
    let (x, y) = (
        crank_length + coupler_length * bend.cos(),
        coupler_length * bend.sin(),
    );
    let reach = x.hypot(y);
    let at_crank = (reach * reach + 0.81 - rocker_length * rocker_length) / (2.0 * reach * 0.9);
    let angle = at_crank.acos() - y.atan2(x);
    let (tip_x, tip_y) = (
        crank_length * angle.cos() + coupler_length * (angle + bend).cos(),
        crank_length * angle.sin() + coupler_length * (angle + bend).sin(),
    );
    // Hinges turn from x towards -z: angles change sign.
    let rate = 1.0;
    let [coupler_rate, rocker_rate] = rates(
        [tip_x, tip_y],
        [
            tip_x - crank_length * angle.cos(),
            tip_y - crank_length * angle.sin(),
        ],
        rate,
    );
    set(&mut builder, crank, [-angle, rate], true);
    set(&mut builder, coupler, [-bend, coupler_rate], true);
    let swing = tip_y.atan2(tip_x - 0.9);
    set(&mut builder, rocker, [-swing, rocker_rate], false);
    builder.finish()
}

/// The rates of the coupler, relative to the crank, and of the rocker, rad/s, that close the four-bar when the
/// crank turns at `rate`: from where the tip is, seen from the crank's pivot
/// and from the pin.
fn rates([x, y]: [f64; 2], [from_pin_x, from_pin_y]: [f64; 2], rate: f64) -> [f64; 2] {
    // The tip moves by the crank about its pivot and the coupler about the pin:
    // across the rocker, along which it cannot move.
    let [along_x, along_y] = [x - 0.9, y];
    let along = |x: f64, y: f64| -y * along_x + x * along_y;
    let coupler = -rate * along(x, y) / along(from_pin_x, from_pin_y);
    let velocity = [
        -y * rate - from_pin_y * coupler,
        x * rate + from_pin_x * coupler,
    ];
    let length = along_x * along_x + along_y * along_y;
    let rocker = (along_x * velocity[1] - along_y * velocity[0]) / length;
    [coupler, rocker]
}

fn set(
    builder: &mut ModelBuilder,
    body: robovec_model::build::BodyRef,
    [angle, rate]: [f64; 2],
    dependent: bool,
) {
    let joint = builder.joint(body, 0);
    (joint.initial[0], joint.initial[1]) = (angle, rate);
    if dependent {
        joint.nature = Nature::Dependent;
    }
}
