//! A passenger car on double wishbones, with all its joints: many small loops.

use super::super::build::{BASE, BodyPlace, BodyRef, ModelBuilder};
use super::super::{CutKind, Model, Nature};
use super::{FREE, MOTION, R1, R2, R3, RIDE, T2, principal};

/// From the centre of the body to the axles, m.
const HALF_WHEELBASE: f64 = 1.3;
/// The height of the body's centre above the road, m.
const BODY_HEIGHT: f64 = 0.55;
/// Where the wheels' centres are behind the tie rods, m.
const STEERING_ARM: f64 = 0.12;

/// A car of 45 joints with 10 ball loops, closed where all angles are zero. At
/// every corner two wishbones hold a knuckle, whose ball on the lower wishbone
/// is three joints; a tie rod steers it, from a rack that moves as prescribed
/// in front and from the body behind. At each axle an anti-roll bar hangs on
/// the left lower wishbone by a drop link. 14 degrees of freedom: the body, the
/// springs, the wheels.
pub fn wishbone_car() -> Model {
    let mut builder = ModelBuilder::new("wishbone_car");
    let body = builder.body("Body", BASE.origin(), &FREE);
    builder.mass(
        body,
        1150.0,
        [0.05, 0.0, 0.02],
        principal(480.0, 1800.0, 2000.0),
    );
    builder.joint(body, 2).initial[0] = BODY_HEIGHT;
    let seat = builder.point(body, "Seat", [-0.1, 0.35, 0.2]);
    builder.sensor("Driver", seat, RIDE);
    let rack = builder.point(body, "Rack", [HALF_WHEELBASE - STEERING_ARM, 0.0, -0.1]);
    let rack = builder.body("Rack", rack, &[T2]);
    builder.mass(rack, 4.0, [0.0; 3], principal(0.1, 0.002, 0.1));
    builder.joint(rack, 0).nature = Nature::Driven;
    for (end, along) in [("Front", HALF_WHEELBASE), ("Rear", -HALF_WHEELBASE)] {
        for (side, hand) in [("left", 1.0), ("right", -1.0)] {
            let name = format!("{end}_{side}");
            let inner = match end {
                "Front" => builder.point(rack, &format!("Inner_{name}"), [0.0, 0.36 * hand, 0.0]),
                _ => {
                    let place = [along - STEERING_ARM, 0.36 * hand, -0.1];
                    builder.point(body, &format!("Inner_{name}"), place)
                }
            };
            let wishbone = add_corner(&mut builder, body, inner, &name, [along, hand]);
            if side == "left" {
                add_bar(&mut builder, body, wishbone, end, along);
            }
        }
    }
    builder.finish()
}

/// Adds wishbones, knuckle, wheel and tie rod; gives the lower wishbone.
fn add_corner(
    builder: &mut ModelBuilder,
    body: BodyRef,
    inner: BodyPlace,
    name: &str,
    [along, hand]: [f64; 2],
) -> BodyRef {
    let across = |y: f64| y * hand;
    let pivot = builder.point(body, &format!("Lower_{name}"), [along, across(0.35), -0.15]);
    let lower = builder.body(&format!("Lower_{name}"), pivot, &[R1]);
    builder.mass(
        lower,
        6.0,
        [0.0, across(0.22), 0.0],
        principal(0.09, 0.03, 0.11),
    );
    let foot = builder.point(lower, "Spring", [0.0, across(0.28), 0.03]);
    let tower = [along, across(0.5), 0.3];
    let tower = builder.point(body, &format!("Tower_{name}"), tower);
    builder.link(&format!("Spring_{name}"), [foot, tower]);
    let ball = builder.point(lower, "Ball", [0.0, across(0.4), 0.0]);
    let knuckle = builder.body(&format!("Knuckle_{name}"), ball, &[R1, R2, R3]);
    builder.mass(
        knuckle,
        9.0,
        [0.0, across(0.03), 0.12],
        principal(0.1, 0.09, 0.05),
    );
    let hub = builder.point(knuckle, "Hub", [0.0, across(0.07), 0.11]);
    builder.force(&format!("Tyre_{name}"), hub, MOTION);
    let wheel = builder.body(&format!("Wheel_{name}"), hub, &[R2]);
    builder.mass(wheel, 18.0, [0.0; 3], principal(0.5, 0.9, 0.5));
    let pivot = builder.point(body, &format!("Upper_{name}"), [along, across(0.4), 0.1]);
    let upper = builder.body(&format!("Upper_{name}"), pivot, &[R1]);
    builder.mass(
        upper,
        4.0,
        [0.0, across(0.17), 0.0],
        principal(0.05, 0.02, 0.06),
    );
    let upper_ball = builder.point(upper, "Ball", [0.0, across(0.32), 0.0]);
    let knuckle_ball = builder.point(knuckle, "Ball", [0.0, across(-0.03), 0.25]);
    let rod = builder.body(&format!("Tie_rod_{name}"), inner, &[R1, R3]);
    builder.mass(
        rod,
        1.2,
        [0.0, across(0.185), 0.0],
        principal(0.014, 0.0002, 0.014),
    );
    let rod_end = builder.point(rod, "End", [0.0, across(0.37), 0.0]);
    let arm = [-STEERING_ARM, across(-0.02), 0.05];
    let arm = builder.point(knuckle, "Arm", arm);
    for (part, joints) in [(knuckle, 3), (upper, 1), (rod, 2)] {
        follow_loops(builder, part, joints);
    }
    builder.cut(
        &format!("Upper_{name}"),
        CutKind::Ball,
        [knuckle_ball, upper_ball],
    );
    builder.cut(&format!("Steering_{name}"), CutKind::Ball, [arm, rod_end]);
    lower
}

/// Adds an anti-roll bar, which a drop link moves with the left wishbone.
fn add_bar(builder: &mut ModelBuilder, body: BodyRef, wishbone: BodyRef, end: &str, along: f64) {
    let pivot = builder.point(body, &format!("Bar_{end}"), [along + 0.25, 0.0, -0.05]);
    let bar = builder.body(&format!("Bar_{end}"), pivot, &[R2]);
    builder.mass(bar, 3.0, [-0.08, 0.1, 0.0], principal(0.25, 0.03, 0.27));
    let hook = builder.point(bar, "End", [-0.25, 0.6, 0.0]);
    let link = builder.body(&format!("Drop_link_{end}"), hook, &[R1, R2]);
    builder.mass(
        link,
        0.4,
        [0.0, 0.0, -0.05],
        principal(0.0004, 0.0004, 0.0001),
    );
    let foot = builder.point(link, "End", [0.0, 0.0, -0.1]);
    let eye = builder.point(wishbone, "Bar", [0.0, 0.25, 0.0]);
    follow_loops(builder, bar, 1);
    follow_loops(builder, link, 2);
    builder.cut(&format!("Bar_{end}"), CutKind::Ball, [foot, eye]);
}

/// Makes all joints of a body, so many, follow from the loops.
fn follow_loops(builder: &mut ModelBuilder, body: BodyRef, joints: usize) {
    for number in 0..joints {
        builder.joint(body, number).nature = Nature::Dependent;
    }
}
