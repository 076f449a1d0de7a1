//! A railway bogie with 23 degrees of freedom.

use super::super::Model;
use super::super::build::{BASE, BodyPlace, BodyRef, ModelBuilder};
use super::{FREE, MOTION, R2, RIDE, principal};

/// Half the distance between the axles, m.
const HALF_WHEELBASE: f64 = 1.25;
/// Half the distance between the axle boxes of a wheelset, m.
const HALF_SPAN: f64 = 1.0;
/// Half the distance between the contact points of a wheelset, m.
const HALF_GAUGE: f64 = 0.75;
/// Height of the axles above the rails, the radius of the wheels, m.
const RADIUS: f64 = 0.45;
/// Height of the frame's centre above the axles, m.
const FRAME_HEIGHT: f64 = 0.15;

/// A motor bogie: a frame, two wheelsets, their four axle boxes and a motor
/// that is hinged to the frame. Frame and wheelsets are free in space (6
/// degrees of freedom each); the boxes turn about the axles and the motor
/// about a cross beam. Ten springs of the primary suspension and the motor's
/// bracket are links, the four contacts of wheel and rail external forces;
/// sensors measure the ride.
pub fn bogie() -> Model {
    let mut builder = ModelBuilder::new("bogie");
    let bogie = add_bogie(&mut builder, "", BASE.origin(), RADIUS + FRAME_HEIGHT);
    builder.sensor("Ride", bogie.center, RIDE);
    builder.finish()
}

/// A bogie in a model.
pub(super) struct Bogie {
    /// The centre of the frame, where the car body sits.
    pub(super) center: BodyPlace,
    /// Where the secondary springs stand, left and right.
    pub(super) seats: [BodyPlace; 2],
}

/// Adds a bogie whose frame stands at a height above a place, or hangs on it.
/// Names end in `suffix`.
pub(super) fn add_bogie(
    builder: &mut ModelBuilder,
    suffix: &str,
    on: BodyPlace,
    height: f64,
) -> Bogie {
    let frame = builder.body(&format!("Frame{suffix}"), on, &FREE);
    builder.mass(
        frame,
        2600.0,
        [0.0, 0.0, 0.02],
        principal(1700.0, 1500.0, 3100.0),
    );
    builder.joint(frame, 2).initial[0] = height;
    let center = builder.point(frame, "Center", [0.0, 0.0, 0.1]);
    let seats = [("Seat_left", HALF_SPAN), ("Seat_right", -HALF_SPAN)]
        .map(|(name, side)| builder.point(frame, name, [0.0, side, 0.25]));
    for (end, along) in [("Front", HALF_WHEELBASE), ("Rear", -HALF_WHEELBASE)] {
        add_wheelset(builder, suffix, frame, end, along);
    }
    let hinge = builder.point(frame, "Motor_hinge", [0.3, 0.1, -0.05]);
    let motor = builder.body(&format!("Motor{suffix}"), hinge, &[R2]);
    // The rotor is heavier on the side of the coupling, hence the offset.
    builder.mass(motor, 650.0, [0.35, 0.05, 0.0], principal(45.0, 60.0, 50.0));
    let bracket = builder.point(motor, "Bracket", [0.6, 0.05, 0.1]);
    let beam = builder.point(frame, "Motor_beam", [0.9, 0.15, 0.4]);
    builder.link(&format!("Motor_bracket{suffix}"), [bracket, beam]);
    Bogie { center, seats }
}

fn add_wheelset(builder: &mut ModelBuilder, suffix: &str, frame: BodyRef, end: &str, along: f64) {
    let place = builder.point(frame, &format!("Axle_{end}"), [along, 0.0, -FRAME_HEIGHT]);
    let wheelset = builder.body(&format!("Wheelset_{end}{suffix}"), place, &FREE);
    builder.mass(wheelset, 1500.0, [0.0; 3], principal(900.0, 100.0, 900.0));
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let contact = builder.point(
            wheelset,
            &format!("Wheel_{side}"),
            [0.0, sign * HALF_GAUGE, 0.0],
        );
        builder.force(&format!("Rail_{end}_{side}{suffix}"), contact, MOTION);
        let journal = builder.point(
            wheelset,
            &format!("Journal_{side}"),
            [0.0, sign * HALF_SPAN, 0.0],
        );
        let axle_box = builder.body(&format!("Box_{end}_{side}{suffix}"), journal, &[R2]);
        builder.mass(
            axle_box,
            120.0,
            [0.02, 0.01, 0.03],
            principal(4.0, 6.0, 5.0),
        );
        let direction = along.signum();
        let post = builder.point(
            frame,
            &format!("Post_{end}_{side}"),
            [along, sign * HALF_SPAN, 0.3],
        );
        let top = builder.point(axle_box, "Spring", [0.0, 0.0, 0.12]);
        builder.link(&format!("Spring_{end}_{side}{suffix}"), [top, post]);
        let arm = builder.point(axle_box, "Rod", [-0.15 * direction, 0.0, 0.0]);
        let bush = builder.point(
            frame,
            &format!("Bush_{end}_{side}"),
            [along - 0.65 * direction, sign * HALF_SPAN, -FRAME_HEIGHT],
        );
        builder.link(&format!("Guide_{end}_{side}{suffix}"), [arm, bush]);
    }
}
