//! Cases of equations: sums whose terms cancel; stiff springs,
//! `k (length - free length)`, whose lengths agree in all but their last
//! digits; contact and friction, a penetration far from the origin and a slip
//! beside the velocity of rolling; a sensor beside a target, both far away.

use super::super::case::StressSubject;
use super::super::equations::EquationsSubject;
use super::super::forms::TextForm;
use super::super::numbers::Draw;
use super::super::program::shared;
use super::super::steps::{MotionStart, StepsSubject};
use super::CaseMember;
use robovec_num::double_double::Double;

pub(super) fn subject(name: &str, case: &CaseMember) -> Option<Box<dyn StressSubject>> {
    let number = |name: &str| case.number(name);
    let in_time = match name {
        "spring-chain" => chain(number("ratio")),
        "bounce" => bounce(number("ground")),
        "rolling" => rolling(number("speed")),
        _ => {
            return Some(Box::new(match name {
                "dot" => products(number("condition")),
                "alternating" => alternating(),
                "ties" => ties(),
                "springs" => row(number("stiffness")),
                "wheel" => wheel(number("distance")),
                "slip" => slip(number("slip")),
                "sensor" => sensor(number("distance"), false),
                "sensor-held" => sensor(number("distance"), true),
                _ => return None,
            }));
        }
    };
    Some(Box::new(in_time))
}

/// Pairs of a scalar product.
const PAIRS: usize = 32;

/// Scalar products with a condition (Ogita, Rump and Oishi, "Accurate sum and
/// dot product", 2005, Algorithm 6.1): products up to the root of the
/// condition, then those that bring the sum down to one.
fn products(condition: f64) -> EquationsSubject {
    let terms: Vec<String> = (1..=PAIRS).map(|i| format!("x[{i}]*y[{i}]")).collect();
    let sum = terms.join(" + ");
    let text = format!(
        "function dot equations {{\n  in x[1..{PAIRS}]\n  in y[1..{PAIRS}]\n  out s\n  s = {sum}\n}}\n"
    );
    let inputs = (1..=5).map(|seed| pairs(condition, seed)).collect();
    EquationsSubject::new(text, inputs)
}

fn pairs(condition: f64, seed: u64) -> Vec<f64> {
    let mut draw = Draw::new(seed);
    // Half of the bits of the condition, spread over x and y.
    let half = 0.5 * condition.log2();
    let (mut x, mut y) = (Vec::new(), Vec::new());
    let mut sum = Double::from(0.0);
    for index in 0..PAIRS {
        let exponent = if index == 0 {
            half.round()
        } else if index < PAIRS / 2 {
            (draw.between(0.0, 1.0) * half).round()
        } else {
            // From the largest size down to one.
            let done = (index - PAIRS / 2) as f64 / (PAIRS / 2 - 1) as f64;
            (half * (1.0 - done)).round()
        };
        let size = 2f64.powi(exponent as i32);
        let left = draw.between(0.5, 1.0) * size;
        let right = if index < PAIRS / 2 {
            draw.within(1.0) * size
        } else {
            let wanted = draw.within(1.0) * size;
            f64::from(((wanted - sum.high) / left) as f32)
        };
        sum = sum + Double::from(left) * Double::from(right);
        x.push(left);
        y.push(right);
    }
    x.extend(y);
    x
}

/// `a1 + M - M + a2 + M - M + …`: here every small term meets a large one.
fn alternating() -> EquationsSubject {
    const TERMS: usize = 16;
    let terms: Vec<String> = (1..=TERMS).map(|i| format!("a[{i}] + m - n")).collect();
    let text = format!(
        "function alternating equations {{\n  in a[1..{TERMS}]\n  in m\n  in n\n  out s\n  s = {}\n}}\n",
        terms.join(" + ")
    );
    let mut draw = Draw::new(4);
    let mut inputs: Vec<f64> = (0..TERMS).map(|_| draw.between(0.01, 1.0)).collect();
    inputs.extend([1e7, 1e7]);
    EquationsSubject::new(text, vec![inputs])
}

/// `1 + t + t + … - 1` with the tie `t = 2^-24`.
fn ties() -> EquationsSubject {
    const TERMS: usize = 1024;
    let terms: Vec<String> = (1..=TERMS).map(|i| format!("t[{i}]")).collect();
    let text = format!(
        "function ties equations {{\n  in t[1..{TERMS}]\n  in one\n  out s\n  s = one + {} - one\n}}\n",
        terms.join(" + ")
    );
    let mut inputs = vec![2f64.powi(-24); TERMS];
    inputs.push(1.0);
    EquationsSubject::new(text, vec![inputs])
}

/// Forces on the inner two of four points with springs, soft ones of 1 N/m.
pub(super) fn row(stiffness: f64) -> EquationsSubject {
    let inputs = (1..=4).map(|seed| points(stiffness, seed)).collect();
    EquationsSubject::new(include_str!("data/springs.rvir"), inputs)
        .of("force")
        .or(
            "stretch from squares",
            include_str!("data/springs-squares.rvir"),
        )
}

/// Places of the points, stiffnesses and free lengths: the soft springs have
/// 1.5 times their free length, the stiff one has 1e3 N.
pub(super) fn points(stiffness: f64, seed: u64) -> Vec<f64> {
    let mut draw = Draw::new(seed);
    let mut place = [0.0; 3].map(|_: f64| draw.within(0.5));
    let mut numbers = place.to_vec();
    for length in [1.5, 1.0 + 1e3 / stiffness, 1.5] {
        let way = [0.0; 3].map(|_: f64| draw.between(0.2, 1.0));
        let size = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        for (place, way) in place.iter_mut().zip(way) {
            *place = f64::from((*place + way / size * length) as f32);
        }
        numbers.extend(place);
    }
    numbers.extend([1.0, stiffness, 1.0]);
    numbers.extend([1.0; 3]);
    numbers
}

/// Four masses of 1 kg on a line, a metre apart, without forces; the state
/// holds positions and velocities, or the first position and the stretches.
pub(super) fn chain(ratio: f64) -> StepsSubject {
    // 0.14 of the reciprocal of the highest frequency.
    let step = f64::from((0.1 / ratio.sqrt()) as f32);
    let stretches = [0.1, 1e3 / ratio, -0.05];
    let mut positions = vec![0.25];
    for stretch in stretches {
        let last = positions[positions.len() - 1];
        positions.push(f64::from((last + 1.0 + stretch) as f32));
    }
    let velocities = [0.5, -0.25, 0.125, 0.25];
    let start = |places: Vec<f64>, parameters: &[f64]| MotionStart {
        state: [places, velocities.to_vec()].concat(),
        parameters: parameters.to_vec(),
    };
    let mut relative = vec![positions[0]];
    relative.extend(positions.windows(2).map(|pair| pair[1] - pair[0] - 1.0));
    StepsSubject::new(
        include_str!("data/chain.rvir"),
        start(positions, &[1.0, ratio, 1.0, 1.0]),
        (step, 2000),
    )
    .or(TextForm::prepared(
        "stretches as coordinates",
        include_str!("data/chain-stretches.rvir"),
        start(relative, &[1.0, ratio, 1.0]),
    ))
}

/// A wheel of 0.3 m on a plane through the origin that rises by a twentieth;
/// the host can move the origin to a place on the plane near the wheel.
pub(super) fn wheel(distance: f64) -> EquationsSubject {
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
    let equations = include_str!("data/wheel.rvir");
    EquationsSubject::new(equations, far)
        .of("force")
        .or_prepared("origin moved", equations, near)
}

/// The friction of a wheel of 0.3 m, `mu N s / sqrt(s^2 + e^2)` for the slip
/// `s`; a fused product rounds the slip once.
pub(super) fn slip(slip: f64) -> EquationsSubject {
    let inputs = (1..=8).map(|seed| {
        let mut draw = Draw::new(seed);
        let (w, r) = (draw.between(90.0, 110.0), f64::from(0.3f32));
        let v = f64::from((w * r - slip * draw.between(0.5, 1.5)) as f32);
        vec![w, r, v, 2400.0, 0.01]
    });
    EquationsSubject::new(include_str!("data/slip.rvir"), inputs.collect())
        .of("friction")
        .or("fused slip", include_str!("data/slip-fused.rvir"))
}

/// A wheel of 5 t on a rail of 5e8 N/m: it swings about a penetration of
/// 1e-4 m. The state holds its height and velocity, or the penetration.
pub(super) fn bounce(ground: f64) -> StepsSubject {
    // 2^-13 m, so that every height holds it.
    let depth = 2f64.powi(-13);
    let radius = 0.5;
    let start = |state: [f64; 2]| MotionStart {
        state: state.to_vec(),
        parameters: vec![5e8, 2e-4, 9.81, ground, radius],
    };
    StepsSubject::new(
        include_str!("data/bounce.rvir"),
        start([ground + radius - depth, 0.0]),
        (2f64.powi(-11), 2048),
    )
    .or(TextForm::prepared(
        "penetration as coordinate",
        include_str!("data/bounce-penetration.rvir"),
        start([depth, 0.0]),
    ))
}

/// A wheel of 300 kg, 1.2 kg m^2 and 0.3 m under a torque of 30 N m. The state
/// holds the speeds of turning and of travel, or the slip and the speed.
pub(super) fn rolling(speed: f64) -> StepsSubject {
    let radius = f64::from(0.3f32);
    // Radius, reciprocal mass and inertia, torque, mu N, regularisation.
    let parameters = vec![radius, 1.0 / 300.0, 1.0 / 1.2, 30.0, 2400.0, 0.01];
    let turning = f64::from((speed / radius) as f32);
    let start = |first: f64| MotionStart {
        state: vec![first, speed],
        parameters: parameters.clone(),
    };
    let plain = include_str!("data/rolling.rvir");
    let fused = include_str!("data/rolling-fused.rvir");
    let relative = include_str!("data/rolling-slip.rvir");
    let slip = turning * radius - speed;
    StepsSubject::new(plain, start(turning), (2f64.powi(-14), 2048))
        .or(TextForm::given("fused slip", fused, start(turning)))
        .or(TextForm::prepared(
            "slip as coordinate",
            relative,
            start(slip),
        ))
}

/// Position and velocity of a sensor relative to a target a metre or two away:
/// a body floats, and has an arm of two joints with the sensor at its end.
pub(super) fn sensor(distance: f64, held: bool) -> EquationsSubject {
    /// Places of the arm on the body and of the sensor on the arm.
    const POINTS: [f64; 6] = [0.5, 0.125, 0.25, 0.0, 0.125, 0.75];
    let (mut far, mut near) = (Vec::new(), Vec::new());
    for seed in 1..=4 {
        let mut draw = Draw::new(seed);
        let (mut q, mut qd) = ([0.0; 8], [0.0; 8]);
        let mut target = Vec::new();
        for axis in 0..3 {
            // Away from the numbers of binary32, but for those to be held.
            let place = distance * (1.0 + 0.1 * f64::from(axis as u32)) + draw.within(1.0) / 3.0;
            q[axis] = if held { shared(place) } else { place };
            let beside = q[axis] + draw.between(1.0, 2.0);
            target.push(if held { shared(beside) } else { beside });
            qd[axis] = draw.within(20.0);
        }
        for joint in 3..q.len() {
            (q[joint], qd[joint]) = (draw.within(1.0), draw.within(1.0));
        }
        let rates = qd[..3].iter();
        target.extend(rates.map(|rate| f64::from((rate + draw.between(2.0, 3.0)) as f32)));
        far.push([&q[..], &qd, &POINTS, &target].concat());
        // Whole metres away: the differences are exact.
        for (place, target) in q.iter_mut().zip(&mut target[..3]) {
            let origin = place.round();
            *place -= origin;
            *target -= origin;
        }
        near.push([&q[..], &qd, &POINTS, &target].concat());
    }
    let equations = include_str!("data/sensor.rvir");
    EquationsSubject::of_host(equations, far)
        .of("distance")
        .or_prepared("origin moved", equations, near)
}
