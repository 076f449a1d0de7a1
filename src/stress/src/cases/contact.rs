//! Contact and friction: a penetration far from the origin, and a slip beside
//! the velocity of rolling.

use super::super::case::{CaseClass, StressCase};
use super::super::draw::Draw;
use super::super::equations::EquationsSubject;
use super::super::forms::TextForm;
use super::super::steps::{MotionStart, StepsSubject};
use super::super::verdict::StressVerdict;

pub(super) fn cases() -> Vec<StressCase> {
    let mut cases = Vec::new();
    for (power, expected) in [
        (1, StressVerdict::Fine),
        (3, StressVerdict::BadCode),
        (4, StressVerdict::BadCode),
    ] {
        cases.push(CaseClass::Contact.case(
            format!("wheel-1e{power}"),
            format!("a wheel on a slope, 1e{power} m from the origin, 1e-4 m in the ground"),
            "the penetration: what is left of positions and the radius",
            expected,
            wheel(10f64.powi(power)),
        ));
    }
    for (power, expected) in [
        (2, StressVerdict::Fine),
        (4, StressVerdict::BadCode),
        (5, StressVerdict::BadCode),
    ] {
        cases.push(CaseClass::Contact.case(
            format!("slip-1e-{power}"),
            format!("regularised friction of a wheel at 30 m/s that slips by 1e-{power} m/s"),
            "the slip w r - v: the product is rounded before the difference",
            expected,
            slip(10f64.powi(-power)),
        ));
    }
    for (power, expected) in [
        (0, StressVerdict::HardProblem),
        (3, StressVerdict::HardProblem),
    ] {
        cases.push(CaseClass::Contact.case(
            format!("bounce-1e{power}"),
            format!("a train's wheel in time on a rail 1e{power} m above the origin"),
            "the penetration of 1e-4 m, and the state that holds a height",
            expected,
            bounce(10f64.powi(power)),
        ));
    }
    for (power, expected) in [
        (1, StressVerdict::HardProblem),
        (2, StressVerdict::HardProblem),
    ] {
        cases.push(CaseClass::Contact.case(
            format!("rolling-1e{power}"),
            format!("a driven wheel in time that rolls at 1e{power} m/s with a slip of 4e-4 m/s"),
            "the slip, and the velocities that hardly change in a step",
            expected,
            rolling(10f64.powi(power)),
        ));
    }
    cases
}

const WHEEL: &str = "function wheel equations {
  in p[1..2]
  in v[1..2]
  in n[1..2]
  in level
  in r
  in k
  in d
  out force
  %depth = r + level - n[1]*p[1] - n[2]*p[2]
  %rate = 0 - n[1]*v[1] - n[2]*v[2]
  force = k*%depth + d*%rate
}
";

/// A wheel of 0.3 m on a plane through the origin that rises by a twentieth;
/// the host can move the origin to a place on the plane near the wheel.
fn wheel(distance: f64) -> EquationsSubject {
    let (mut far, mut near) = (Vec::new(), Vec::new());
    for seed in 1..=4 {
        let mut draw = Draw::new(seed);
        let normal = [0.05, 0.998_749_2].map(|x| f64::from(x as f32));
        let x = f64::from((distance * draw.between(0.75, 1.25)) as f32);
        let depth = draw.between(0.5, 1.5) * 1e-4;
        let radius = f64::from(0.3f32);
        let z = f64::from(((radius - depth - normal[0] * x) / normal[1]) as f32);
        let velocity = [draw.between(1.0, 10.0), -0.5].map(|x| f64::from(x as f32));
        let rest = [radius, 2e5, 1e2];
        let inputs = |place: [f64; 2], level: f64| {
            let mut inputs = place.to_vec();
            inputs.extend(velocity);
            inputs.extend(normal);
            inputs.push(level);
            inputs.extend(rest);
            inputs
        };
        far.push(inputs([x, z], 0.0));
        let origin = [x.round(), -(x.round() * normal[0] / normal[1])];
        let level = -(normal[0] * origin[0] + normal[1] * origin[1]);
        near.push(inputs([x - origin[0], z - origin[1]], level));
    }
    EquationsSubject::new(WHEEL.to_owned(), far)
        .of("force")
        .or_prepared("origin moved", WHEEL.to_owned(), near)
}

/// The friction of a wheel of 0.3 m, `mu N s / sqrt(s^2 + e^2)` for the slip
/// `s`; a fused product rounds the slip once.
fn slip(slip: f64) -> EquationsSubject {
    let text = |slip: &str| {
        format!(
            "function slip equations {{\n  in w\n  in r\n  in v\n  in limit\n  in e\n  \
             out force\n  %s = {slip}\n  force = limit*%s/sqrt(%s*%s + e*e)\n}}\n"
        )
    };
    let inputs = (1..=8).map(|seed| {
        let mut draw = Draw::new(seed);
        let (w, r) = (draw.between(90.0, 110.0), f64::from(0.3f32));
        let v = f64::from((w * r - slip * draw.between(0.5, 1.5)) as f32);
        vec![w, r, v, 2400.0, 0.01]
    });
    EquationsSubject::new(text("w*r - v"), inputs.collect())
        .of("friction")
        .or("fused slip", text("fms(w, r, v)"))
}

/// A wheel of 5 t on a rail of 5e8 N/m: it swings about a penetration of
/// 1e-4 m. The state holds its height and velocity, or the penetration.
fn bounce(ground: f64) -> StepsSubject {
    let text = |depth: &str, rate: &str| {
        format!(
            "function bounce equations {{\n  in x[1..2]\n  in p[1..5]\n  out dx[1..2]\n  \
             out force\n  %f = p[1]*({depth})\n  dx[1] = {rate}\n  dx[2] = %f*p[2] - p[3]\n  \
             force = %f\n}}\n"
        )
    };
    // 2^-13 m, so that every height holds it.
    let depth = 2f64.powi(-13);
    let radius = 0.5;
    let start = |state: [f64; 2]| MotionStart {
        state: state.to_vec(),
        parameters: vec![5e8, 2e-4, 9.81, ground, radius],
    };
    StepsSubject::new(
        text("p[4] + p[5] - x[1]", "x[2]"),
        start([ground + radius - depth, 0.0]),
        (2f64.powi(-11), 2048),
    )
    .or(TextForm::prepared(
        "penetration as coordinate",
        text("x[1]", "0 - x[2]"),
        start([depth, 0.0]),
    ))
}

/// A wheel of 300 kg, 1.2 kg m^2 and 0.3 m under a torque of 30 N m. The state
/// holds the speeds of turning and of travel, or the slip and the speed.
fn rolling(speed: f64) -> StepsSubject {
    let text = |slip: &str, first: &str| {
        format!(
            "function rolling equations {{\n  in x[1..2]\n  in p[1..6]\n  out dx[1..2]\n  \
             out force\n  out speed\n  %s = {slip}\n  %f = p[5]*%s/sqrt(%s*%s + p[6]*p[6])\n  \
             %w = (p[4] - p[1]*%f)*p[3]\n  %v = %f*p[2]\n  dx[1] = {first}\n  dx[2] = %v\n  \
             force = %f\n  speed = x[2]\n}}\n"
        )
    };
    let radius = f64::from(0.3f32);
    // Radius, reciprocal mass and inertia, torque, mu N, regularisation.
    let parameters = vec![radius, 1.0 / 300.0, 1.0 / 1.2, 30.0, 2400.0, 0.01];
    let turning = f64::from((speed / radius) as f32);
    let start = |first: f64| MotionStart {
        state: vec![first, speed],
        parameters: parameters.clone(),
    };
    let plain = text("x[1]*p[1] - x[2]", "%w");
    let fused = text("fms(x[1], p[1], x[2])", "%w");
    let relative = text("x[1]", "p[1]*%w - %v");
    let slip = turning * radius - speed;
    StepsSubject::new(plain, start(turning), (2f64.powi(-14), 2048))
        .or(TextForm::given("fused slip", fused, start(turning)))
        .or(TextForm::prepared(
            "slip as coordinate",
            relative,
            start(slip),
        ))
}

#[cfg(test)]
mod tests;
