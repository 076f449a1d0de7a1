//! A passenger car on four trailing arms.

use super::super::Model;
use super::super::build::{BASE, BodyRef, ModelBuilder};
use super::{FREE, MOTION, R2, R3, RIDE, principal};

/// From the centre of the body to the axles, m.
const HALF_WHEELBASE: f64 = 1.3;
/// From the middle plane to the wheels' centres, m.
const HALF_TRACK: f64 = 0.74;
/// The wheels' radius, the height of their centres above the road, m.
const RADIUS: f64 = 0.3;
/// Length of a trailing arm, m.
const ARM: f64 = 0.4;
/// Height of the body's centre above the wheels' centres, m.
const BODY_HEIGHT: f64 = 0.25;

/// A car with 18 degrees of freedom: a body free in space, four trailing arms,
/// at each a knuckle that steers and a wheel that spins. Springs and tie rods
/// are links, the contacts of tyres and road external forces.
pub fn car() -> Model {
    let mut builder = ModelBuilder::new("car");
    let body = builder.body("Body", BASE.origin(), &FREE);
    builder.mass(
        body,
        1250.0,
        [0.05, 0.0, 0.02],
        principal(520.0, 1900.0, 2100.0),
    );
    builder.joint(body, 2).initial[0] = RADIUS + BODY_HEIGHT;
    let seat = builder.point(body, "Seat", [-0.1, 0.35, 0.2]);
    builder.sensor("Driver", seat, RIDE);
    for (end, along) in [("Front", HALF_WHEELBASE), ("Rear", -HALF_WHEELBASE)] {
        for (side, across) in [("left", HALF_TRACK), ("right", -HALF_TRACK)] {
            add_corner(
                &mut builder,
                body,
                &format!("{end}_{side}"),
                [along, across],
            );
        }
    }
    builder.finish()
}

fn add_corner(builder: &mut ModelBuilder, body: BodyRef, name: &str, [along, across]: [f64; 2]) {
    // The arm points backwards from its hinge, so that the wheel trails.
    let hinge = [along + ARM, 0.8 * across, -BODY_HEIGHT];
    let hinge = builder.point(body, &format!("Hinge_{name}"), hinge);
    let arm = builder.body(&format!("Arm_{name}"), hinge, &[R2]);
    builder.mass(arm, 14.0, [-0.18, 0.0, 0.0], principal(0.1, 0.3, 0.35));
    let foot = builder.point(arm, "Spring", [-0.3, 0.0, 0.05]);
    let top = [along + ARM - 0.32, 0.8 * across, 0.2];
    let top = builder.point(body, &format!("Tower_{name}"), top);
    builder.link(&format!("Spring_{name}"), [foot, top]);
    let end = builder.point(arm, "End", [-ARM, 0.2 * across, 0.0]);
    let knuckle = builder.body(&format!("Knuckle_{name}"), end, &[R3]);
    builder.mass(knuckle, 11.0, [0.0, 0.02, 0.0], principal(0.12, 0.1, 0.09));
    let contact = builder.point(knuckle, "Contact", [0.0; 3]);
    builder.force(&format!("Tyre_{name}"), contact, MOTION);
    let lever = builder.point(knuckle, "Lever", [-0.12, 0.0, 0.0]);
    let bush = builder.point(arm, "Bush", [-ARM - 0.12, -0.3 * across, 0.0]);
    builder.link(&format!("Tie_rod_{name}"), [lever, bush]);
    let hub = builder.point(knuckle, "Hub", [0.0; 3]);
    let wheel = builder.body(&format!("Wheel_{name}"), hub, &[R2]);
    builder.mass(wheel, 17.0, [0.0; 3], principal(0.45, 0.85, 0.45));
}
