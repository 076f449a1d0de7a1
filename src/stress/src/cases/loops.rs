//! Cases of closed loops: near dead points, redundant constraints, in time.

use super::super::case::StressSubject;
use super::super::drift::DriftSubject;
use super::super::loops::LoopsSubject;
use super::CaseMember;
use super::models::file;
use robovec_dynamics::kinematics::MotionState;
use robovec_model::Model;

pub(super) fn subject(name: &str, case: &CaseMember) -> Option<Box<dyn StressSubject>> {
    let number = |name: &str| case.number(name);
    // Made where the rocker moves, run where it turns round.
    let bent = || {
        let state = MotionState::initial(&four_bar(number("bend")));
        LoopsSubject::in_states([(four_bar(0.5), state)])
    };
    Some(Box::new(match name {
        "parallelogram" => {
            let text = include_str!("data/parallelogram.mbs");
            LoopsSubject::new(SLOPES.map(|slope| parallelogram(text, number("angle"), slope)))
        }
        // Rounded pivots of an overconstrained loop would never meet: this one
        // lies along an axis, where they are exact.
        "redundant" => {
            let text = include_str!("data/parallelogram-redundant.mbs");
            LoopsSubject::new([parallelogram(text, number("angle"), 0.0)])
        }
        "whole-step" => bent().whole_step(),
        "dead-point" => bent(),
        "swinging" => {
            let step = 2f64.powi(-number("power") as i32);
            let steps = (number("duration") / step) as u64;
            return Some(Box::new(DriftSubject::new(four_bar(0.5), (step, steps))));
        }
        _ => return None,
    }))
}

/// Directions of the line of the pivots, rad: along an axis sums are exact.
const SLOPES: [f64; 4] = [0.3, 0.7, 1.1, 2.3];

/// A crank, a coupler and rockers that make a parallelogram of 1 m by 2 m.
fn parallelogram(text: &str, angle: f64, slope: f64) -> Model {
    let mut model = file(text);
    // Rounded to binary32 here, so that rounding hardly opens the loop.
    let slope = f64::from(slope as f32);
    let lifted = f64::from((slope + angle) as f32);
    // The pivots of the rockers.
    for (point, length) in model.points.iter_mut().zip([2.0, 1.0]) {
        point.coordinates = [length * slope.cos(), 0.0, -length * slope.sin()];
    }
    for joint in &mut model.joints {
        joint.initial[0] = lifted;
    }
    model.joints[1].initial[0] = slope - lifted;
    model
}

/// Crank, coupler and rocker of 0.3, 0.8 and 0.6 m on pivots 0.9 m apart, the
/// given angle, rad, between crank and coupler where the rocker turns round.
pub(in super::super) fn four_bar(bend: f64) -> Model {
    let mut model = file(include_str!("data/four-bar.mbs"));
    let (crank_length, coupler_length, rocker_length) = (0.3f64, 0.8f64, 0.6f64);
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
    let swing = tip_y.atan2(tip_x - 0.9);
    let initial = [[-angle, rate], [-bend, coupler_rate], [-swing, rocker_rate]];
    for (joint, initial) in model.joints.iter_mut().zip(initial) {
        joint.initial[..2].copy_from_slice(&initial);
    }
    model
}

/// The rates of the coupler, relative to the crank, and of the rocker, rad/s,
/// that close the four-bar when the crank turns at `rate`: from where the tip
/// is, seen from the crank's pivot and from the pin.
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
