//! Small mechanisms, open and closed.

use super::super::build::{BASE, ModelBuilder};
use super::super::{Asks, CutKind, Model, Nature};
use super::{MOTION, R1, R2, T1, T3, principal};

/// Two rods that swing in the plane of the second and third axis.
pub fn double_pendulum() -> Model {
    let mut builder = ModelBuilder::new("double_pendulum");
    let upper = builder.body("Upper", BASE.origin(), &[R1]);
    // A slender rod of 2 kg and 1 m: m l^2 / 12.
    builder.mass(upper, 2.0, [0.0, 0.0, -0.5], principal(0.167, 0.167, 0.001));
    builder.joint(upper, 0).initial[0] = 0.5;
    let elbow = builder.point(upper, "Elbow", [0.0, 0.0, -1.0]);
    let lower = builder.body("Lower", elbow, &[R1]);
    builder.mass(
        lower,
        1.0,
        [0.0, 0.0, -0.4],
        principal(0.053, 0.053, 0.0005),
    );
    builder.joint(lower, 0).initial[0] = -0.3;
    let tip = builder.point(lower, "Tip", [0.0, 0.0, -0.8]);
    let asks = Asks {
        jacobian: true,
        ..MOTION
    };
    builder.sensor("Tip", tip, asks);
    builder.finish()
}

/// A crank, a coupler and a rocker in the plane of the first and third axis,
/// closed by a ball. The crank turns freely: the shortest and the longest side
/// are together shorter than the other two.
pub fn four_bar() -> Model {
    let mut builder = ModelBuilder::new("four_bar");
    let pivot = builder.point(BASE, "Rocker_pivot", [0.9, 0.0, 0.0]);
    let crank = builder.body("Crank", BASE.origin(), &[R2]);
    builder.mass(
        crank,
        1.5,
        [0.15, 0.0, 0.0],
        principal(0.001, 0.0115, 0.0115),
    );
    // Upwards, where the loop closes with the angles below to 1e-6 m.
    builder.joint(crank, 0).initial[0] = -1.0;
    let pin = builder.point(crank, "Pin", [0.3, 0.0, 0.0]);
    let coupler = builder.body("Coupler", pin, &[R2]);
    builder.mass(
        coupler,
        2.0,
        [0.4, 0.0, 0.0],
        principal(0.002, 0.107, 0.107),
    );
    let coupler_end = builder.point(coupler, "End", [0.8, 0.0, 0.0]);
    let rocker = builder.body("Rocker", pivot, &[R2]);
    builder.mass(
        rocker,
        1.8,
        [0.3, 0.0, 0.0],
        principal(0.0015, 0.054, 0.054),
    );
    let rocker_end = builder.point(rocker, "End", [0.6, 0.0, 0.0]);
    let [coupler_angle, rocker_angle] = FOUR_BAR_ANGLES;
    for (body, angle) in [(coupler, coupler_angle), (rocker, rocker_angle)] {
        let joint = builder.joint(body, 0);
        joint.nature = Nature::Dependent;
        joint.initial[0] = angle;
    }
    builder.cut("Loop", CutKind::Ball, [coupler_end, rocker_end]);
    builder.finish()
}

/// Joint angles of coupler and rocker that close the loop when the crank is at
/// -1 rad.
const FOUR_BAR_ANGLES: [f64; 2] = [0.550_918, -1.599_521];

/// A crank and a slider, with the connecting rod as a constraint of length
/// instead of a body.
pub fn slider_crank() -> Model {
    let mut builder = ModelBuilder::new("slider_crank");
    let crank = builder.body("Crank", BASE.origin(), &[R2]);
    builder.mass(crank, 3.0, [0.05, 0.0, 0.0], principal(0.004, 0.012, 0.012));
    builder.joint(crank, 0).initial[0] = 0.5;
    let pin = builder.point(crank, "Pin", [0.1, 0.0, 0.0]);
    let slider = builder.body("Slider", BASE.origin(), &[T1]);
    builder.mass(slider, 0.8, [0.0; 3], principal(0.0008, 0.0009, 0.0009));
    let joint = builder.joint(slider, 0);
    joint.nature = Nature::Dependent;
    // 0.1 cos 0.5 + sqrt(0.35^2 - (0.1 sin 0.5)^2).
    joint.initial[0] = 0.434_459_15;
    let wrist = builder.point(slider, "Wrist", [0.0; 3]);
    let gas = Asks {
        position: true,
        velocity: true,
        ..Asks::default()
    };
    builder.force("Gas", wrist, gas);
    builder.cut("Rod", CutKind::Rod(0.35), [pin, wrist]);
    builder.finish()
}

/// A quarter of a car on double wishbones, the model of
/// `examples/suspension`: its equations are the files there. The loop is closed
/// where all angles are zero.
pub fn quarter_car() -> Model {
    let mut builder = ModelBuilder::new("suspension");
    let chassis = builder.body("Chassis", BASE.origin(), &[T3]);
    builder.mass(chassis, 320.0, [0.0; 3], [0.0; 6]);
    builder.joint(chassis, 0).initial[0] = 0.45;
    let lower_pivot = builder.point(chassis, "Lower_pivot", [0.0, 0.3, -0.15]);
    let upper_pivot = builder.point(chassis, "Upper_pivot", [0.0, 0.35, 0.1]);
    let spring_top = builder.point(chassis, "Spring_top", [0.0, 0.45, 0.35]);
    let lower = builder.body("Lower_wishbone", lower_pivot, &[R1]);
    builder.mass(lower, 6.0, [0.0, 0.22, 0.0], principal(0.09, 0.03, 0.11));
    let lower_ball = builder.point(lower, "Ball", [0.0, 0.4, 0.0]);
    let spring_foot = builder.point(lower, "Spring_foot", [0.0, 0.25, 0.03]);
    let knuckle = builder.body("Knuckle", lower_ball, &[R1]);
    builder.mass(knuckle, 9.0, [0.0, 0.03, 0.12], principal(0.1, 0.09, 0.05));
    let knuckle_ball = builder.point(knuckle, "Ball", [0.0, -0.03, 0.25]);
    let hub = builder.point(knuckle, "Hub", [0.0, 0.07, 0.11]);
    let upper = builder.body("Upper_wishbone", upper_pivot, &[R1]);
    builder.mass(upper, 4.0, [0.0, 0.17, 0.0], principal(0.05, 0.02, 0.06));
    let upper_ball = builder.point(upper, "Ball", [0.0, 0.32, 0.0]);
    let wheel = builder.body("Wheel", hub, &[R2]);
    builder.mass(wheel, 18.0, [0.0; 3], principal(0.5, 0.9, 0.5));
    let middle = builder.point(wheel, "Middle", [0.0; 3]);
    for body in [knuckle, upper] {
        builder.joint(body, 0).nature = Nature::Dependent;
    }
    builder.cut("Loop", CutKind::Ball, [knuckle_ball, upper_ball]);
    builder.link("Spring", [spring_top, spring_foot]);
    let all = Asks {
        acceleration: true,
        angular_acceleration: true,
        jacobian: true,
        ..MOTION
    };
    builder.force("Tyre", middle, MOTION);
    builder.sensor("Wheel", middle, all);
    builder.sensor("Chassis", spring_top, all);
    builder.finish()
}
