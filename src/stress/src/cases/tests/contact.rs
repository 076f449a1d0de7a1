//! The figures of contact by other means: whole numbers, closed forms of the
//! steps, and the laws written in plain binary32.

use super::super::equations::{bounce, rolling, slip, wheel};
use crate::case::StressSubject;
use crate::numbers::Draw;

/// A binary32 number in units of 2^-60.
fn whole(x: f64) -> i128 {
    let scaled = x * 2f64.powi(60);
    assert_eq!(scaled, scaled.trunc(), "{x} is no multiple of the unit");
    scaled as i128
}

/// The error that the case measures for the untreated program in binary32.
fn told(subject: &dyn StressSubject) -> f64 {
    let bench = subject.prepare().expect("it has equations");
    let measured = bench.measure(&subject.untreated());
    measured.expect("it is computed").error
}

fn agree(by_hand: f64, told: f64) {
    assert!((by_hand / told - 1.0).abs() < 1e-4, "{by_hand:e} {told:e}");
}

#[test]
fn errors_of_a_wheel_are_those_of_plain_binary32_against_whole_numbers() {
    for distance in [1e1, 1e3, 1e4] {
        let mut most = 0.0f64;
        for seed in 1..=4 {
            let mut draw = Draw::new(seed);
            let normal = [0.05f32, 0.998_749_2];
            let x = (distance * draw.between(0.75, 1.25)) as f32;
            let deep = draw.between(0.5, 1.5);
            let slope = [f64::from(normal[0]), f64::from(normal[1])];
            let depth = deep * 1e-4;
            let z = ((f64::from(0.3f32) - depth - slope[0] * f64::from(x)) / slope[1]) as f32;
            let velocity = [draw.between(1.0, 10.0) as f32, -0.5];
            let short = 2e5f32 * (0.3f32 - normal[0] * x - normal[1] * z)
                + 1e2 * (-(normal[0] * velocity[0]) - normal[1] * velocity[1]);
            // Products in units of 2^-60, of factors in units of 2^-30.
            let part = |n: f32, p: f32| {
                let product = whole(f64::from(n) * f64::from(p));
                assert!(product != 0);
                product
            };
            let exact_depth = whole(f64::from(0.3f32)) - part(normal[0], x) - part(normal[1], z);
            let rate = -part(normal[0], velocity[0]) - part(normal[1], velocity[1]);
            let exact = (200_000 * exact_depth + 100 * rate) as f64 * 2f64.powi(-60);
            most = most.max((f64::from(short) / exact - 1.0).abs());
        }
        agree(most, told(&wheel(distance)));
    }
}

#[test]
fn errors_of_a_slip_are_those_of_plain_binary32_against_whole_numbers() {
    for size in [1e-2, 1e-4, 1e-5] {
        let mut most = 0.0f64;
        for seed in 1..=8 {
            let mut draw = Draw::new(seed);
            let (w, r) = (draw.between(90.0, 110.0), f64::from(0.3f32));
            let v = f64::from((w * r - size * draw.between(0.5, 1.5)) as f32);
            let slip = w as f32 * r as f32 - v as f32;
            let edge = 0.01f32;
            let short = 2400.0 * slip / (slip * slip + edge * edge).sqrt();
            // The product of two binary32 numbers fits into binary64.
            let slip = (whole(w * r) - whole(v)) as f64 * 2f64.powi(-60);
            let exact = 2400.0 * slip / slip.hypot(f64::from(edge));
            most = most.max((f64::from(short) / exact - 1.0).abs());
        }
        agree(most, told(&slip(size)));
    }
}

/// Runge-Kutta of two numbers in a kind of number.
macro_rules! two_numbers {
    ($kind:ty, $start:expr, $step:expr, $slope:expr, $watch:expr) => {{
        let part = |x: f64| (x * $step) as $kind;
        let [half, whole] = [part(0.5), part(1.0)];
        let [sixth, third] = [part(1.0 / 6.0), part(1.0 / 3.0)];
        let slope = $slope;
        let watch = $watch;
        let moved = |y: [$kind; 2], k: [$kind; 2], by: $kind| [y[0] + by * k[0], y[1] + by * k[1]];
        let mut y: [$kind; 2] = $start;
        let mut seen: Vec<f64> = Vec::new();
        for done in 0..=2048u64 {
            // As many samples as the case looks at.
            if (0..=50).any(|sample| 2048 * sample / 50 == done) {
                seen.push(f64::from(watch(y)));
            }
            let a: [$kind; 2] = slope(y);
            let b: [$kind; 2] = slope(moved(y, a, half));
            let c: [$kind; 2] = slope(moved(y, b, half));
            let d: [$kind; 2] = slope(moved(y, c, whole));
            let change = |i: usize| sixth * (a[i] + d[i]) + third * (b[i] + c[i]);
            y = [y[0] + change(0), y[1] + change(1)];
        }
        (seen, y)
    }};
}

/// The largest difference over the largest size.
fn distance(found: &[f64], exact: &[f64]) -> f64 {
    let size = exact.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let pairs = found.iter().zip(exact);
    pairs.fold(0.0f64, |most, (x, y)| most.max((x - y).abs())) / size
}

#[test]
fn errors_of_a_bounce_are_those_against_the_closed_form_of_its_steps() {
    let step = 2f64.powi(-11);
    // Force over mass, and the penetration that bears the weight.
    let (k, reciprocal) = (5e8, f64::from(2e-4f32));
    let gravity = f64::from(9.81f32);
    let rest = gravity / (k * reciprocal);
    let z = (k * reciprocal).sqrt() * step;
    let factor = (1.0 - z * z / 2.0 + z.powi(4) / 24.0).hypot(z - z.powi(3) / 6.0);
    let angle = (z - z.powi(3) / 6.0).atan2(1.0 - z * z / 2.0 + z.powi(4) / 24.0);
    let closed = |n: u64| {
        let swing = factor.powi(n as i32) * (angle * n as f64).cos();
        k * (rest + (2f64.powi(-13) - rest) * swing)
    };
    let exact: Vec<f64> = (0..=50).map(|sample| closed(2048 * sample / 50)).collect();
    for ground in [1.0f32, 1e3] {
        let (k, reciprocal, gravity) = (5e8f32, 2e-4f32, 9.81f32);
        let force = move |y: [f32; 2]| k * (ground + 0.5 - y[0]);
        let slope = move |y: [f32; 2]| [y[1], force(y) * reciprocal - gravity];
        let start = [ground + 0.5 - 2f32.powi(-13), 0.0];
        let (short, _) = two_numbers!(f32, start, step, slope, force);
        agree(distance(&short, &exact), told(&bounce(f64::from(ground))));
    }
}

#[test]
fn errors_of_rolling_are_those_of_plain_binary32_and_angular_momentum_grows_by_the_torque() {
    let step = 2f64.powi(-14);
    let [r, m, i] = [0.3f32, (1.0 / 300.0) as f32, (1.0 / 1.2) as f32];
    for speed in [1e1f32, 1e2] {
        let turning = (f64::from(speed) / f64::from(r)) as f32;
        let edge = 0.01f32;
        let force = move |y: [f32; 2]| {
            let slip = y[0] * r - y[1];
            2400.0 * slip / (slip * slip + edge * edge).sqrt()
        };
        let slope = move |y: [f32; 2]| [(30.0 - r * force(y)) * i, force(y) * m];
        let (short, _) = two_numbers!(f32, [turning, speed], step, slope, force);
        // In the slip and the speed gained, in binary64.
        let [r, m, i, edge] = [r, m, i, edge].map(f64::from);
        let force = move |y: [f64; 2]| 2400.0 * y[0] / y[0].hypot(edge);
        let slope = move |y: [f64; 2]| {
            let f = force(y);
            [r * ((30.0 - r * f) * i) - f * m, f * m]
        };
        let start = [f64::from(turning) * r - f64::from(speed), 0.0];
        let (exact, end) = two_numbers!(f64, start, step, slope, force);
        // About a point of the road: m v r + I w grows by the torque's time.
        let gained = |slip: f64, v: f64| v / m * r + (slip + v) / r / i;
        let growth = gained(end[0], end[1]) - gained(start[0], 0.0);
        let torque = 30.0 * step * 2049.0;
        assert!((growth / torque - 1.0).abs() < 1e-9, "{growth} {torque}");
        agree(distance(&short, &exact), told(&rolling(f64::from(speed))));
    }
}
