//! A rail car with 70 degrees of freedom.

use super::super::Model;
use super::super::build::{BASE, BodyRef, ModelBuilder};
use super::bogie::add_bogie;
use super::{Asks, FREE, R1, R2, RIDE, T3, principal};

/// Height of the car body's centre above the rails, m.
const HEIGHT: f64 = 1.9;
/// Half the distance between the pivots of the bogies, m.
const HALF_PIVOTS: f64 = 8.0;

/// A rail car: the car body, two bogies as [`super::bogie`] with a second motor
/// each, a pantograph, a driver and two passengers. The bogies are described
/// relative to the car body, so that the equations have long paths as well as
/// many branches.
pub fn train() -> Model {
    let mut builder = ModelBuilder::new("train");
    let car = builder.body("Car", BASE.origin(), &FREE);
    builder.mass(
        car,
        31_000.0,
        [0.1, 0.0, 0.05],
        // The machinery sits low at the front.
        [56_000.0, 0.0, 1200.0, 1_900_000.0, 0.0, 1_900_000.0],
    );
    builder.joint(car, 2).initial[0] = HEIGHT;
    for (suffix, along) in [("_A", HALF_PIVOTS), ("_B", -HALF_PIVOTS)] {
        add_running_gear(&mut builder, car, suffix, along);
    }
    add_pantograph(&mut builder, car);
    add_person(&mut builder, car, "Driver", [9.0, 0.4, -0.6], true);
    add_person(&mut builder, car, "Passenger_1", [1.5, 1.0, -0.6], false);
    add_person(&mut builder, car, "Passenger_2", [-6.0, -0.9, -0.6], false);
    builder.finish()
}

/// A bogie below the car body, the secondary springs, and the second motor (24
/// joints).
fn add_running_gear(builder: &mut ModelBuilder, car: BodyRef, suffix: &str, along: f64) {
    let pivot = builder.point(car, &format!("Pivot{suffix}"), [along, 0.0, -1.1]);
    let bogie = add_bogie(builder, suffix, pivot, 0.0);
    for (seat, (side, across)) in bogie
        .seats
        .into_iter()
        .zip([("left", 1.0), ("right", -1.0)])
    {
        let top = builder.point(
            car,
            &format!("Secondary_{side}{suffix}"),
            [along, across, -0.45],
        );
        builder.link(&format!("Secondary_{side}{suffix}"), [seat, top]);
    }
    let motor = builder.body(&format!("Motor_2{suffix}"), bogie.center, &[R2]);
    builder.mass(
        motor,
        640.0,
        [-0.35, -0.05, 0.0],
        principal(45.0, 60.0, 50.0),
    );
    builder.sensor(&format!("Ride{suffix}"), pivot, RIDE);
}

/// Lower arm, upper arm and head (3 joints), raised by a link.
fn add_pantograph(builder: &mut ModelBuilder, car: BodyRef) {
    let foot = builder.point(car, "Pantograph", [7.0, 0.0, 1.9]);
    let lower = builder.body("Lower_arm", foot, &[R2]);
    builder.mass(lower, 32.0, [-0.8, 0.0, 0.0], principal(0.6, 8.5, 8.7));
    builder.joint(lower, 0).initial[0] = 0.5;
    let knee = builder.point(lower, "Knee", [-1.6, 0.0, 0.0]);
    let upper = builder.body("Upper_arm", knee, &[R2]);
    builder.mass(upper, 18.0, [0.9, 0.0, 0.0], principal(0.4, 5.8, 5.9));
    builder.joint(upper, 0).initial[0] = -1.1;
    let top = builder.point(upper, "Top", [1.8, 0.0, 0.0]);
    let head = builder.body("Head", top, &[R2]);
    builder.mass(head, 9.0, [0.0, 0.0, 0.05], principal(1.6, 0.2, 1.7));
    let strip = builder.point(head, "Strip", [0.0, 0.0, 0.1]);
    let contact = Asks {
        position: true,
        velocity: true,
        ..Asks::default()
    };
    builder.force("Wire", strip, contact);
    let piston = builder.point(lower, "Piston", [-0.3, 0.0, -0.1]);
    let cylinder = builder.point(car, "Cylinder", [6.2, 0.0, 1.85]);
    builder.link("Raise", [piston, cylinder]);
}

/// A person on a sprung seat: seat up and down, trunk to the sides and fore and
/// aft, head to and fro and, for the driver, to the sides (4 or 5 joints).
fn add_person(builder: &mut ModelBuilder, car: BodyRef, name: &str, at: [f64; 3], driver: bool) {
    let floor = builder.point(car, &format!("Seat_{name}"), at);
    let seat = builder.body(&format!("Seat_{name}"), floor, &[T3]);
    builder.mass(seat, 24.0, [0.0, 0.0, 0.35], principal(0.9, 0.8, 0.7));
    let hip = builder.point(seat, "Hip", [0.05, 0.0, 0.5]);
    let trunk = builder.body(&format!("Trunk_{name}"), hip, &[R1, R2]);
    builder.mass(trunk, 44.0, [0.01, 0.0, 0.28], principal(1.6, 1.5, 0.5));
    let neck = builder.point(trunk, "Neck", [0.02, 0.0, 0.56]);
    let joints = if driver { &[R1, R2][..] } else { &[R2] };
    let head = builder.body(&format!("Head_{name}"), neck, joints);
    builder.mass(head, 5.2, [0.02, 0.0, 0.12], principal(0.03, 0.03, 0.02));
    let eyes = builder.point(head, "Eyes", [0.09, 0.0, 0.13]);
    builder.sensor(&format!("Comfort_{name}"), eyes, RIDE);
    let spring = builder.point(seat, "Spring", [0.0, 0.0, 0.2]);
    let base = builder.point(car, &format!("Floor_{name}"), [at[0], at[1], at[2] - 0.2]);
    builder.link(&format!("Seat_spring_{name}"), [spring, base]);
}
