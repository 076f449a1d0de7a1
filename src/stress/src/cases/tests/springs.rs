//! The figures of springs in plain binary32 against whole numbers.

use super::super::equations::{chain, points, row};
use crate::ProgramTreatment;
use crate::case::StressSubject;

/// The forces on the inner points in plain binary32.
fn short_forces(numbers: &[f32]) -> Vec<f64> {
    let mut pulls = Vec::new();
    for spring in 0..3 {
        let (from, to) = (&numbers[3 * spring..], &numbers[3 * spring + 3..]);
        let way = [0, 1, 2].map(|axis| to[axis] - from[axis]);
        let length = (way[0] * way[0] + way[1] * way[1] + way[2] * way[2]).sqrt();
        let pull = numbers[12 + spring] * (length - numbers[15 + spring]) / length;
        pulls.push(way.map(|x| pull * x));
    }
    let pairs = pulls.windows(2);
    let forces = pairs.flat_map(|pair| [0, 1, 2].map(|axis| pair[1][axis] - pair[0][axis]));
    forces.map(f64::from).collect()
}

/// The same with lengths from square roots of whole numbers: coordinates
/// in units of 2^-40 m, lengths in units of 2^-60 m.
fn whole_forces(numbers: &[f64]) -> Vec<f64> {
    let whole = |x: f64| {
        let scaled = x * 2f64.powi(40);
        assert_eq!(scaled, scaled.trunc(), "{x} is no multiple of the unit");
        scaled as i128
    };
    let mut pulls = Vec::new();
    for spring in 0..3 {
        let (from, to) = (&numbers[3 * spring..], &numbers[3 * spring + 3..]);
        let way = [0, 1, 2].map(|axis| whole(to[axis]) - whole(from[axis]));
        let square: i128 = way.iter().map(|x| x * x).sum();
        let length = ((square as u128) << 40).isqrt() as i128;
        let stretch = length - (whole(numbers[15 + spring]) << 20);
        let pull = numbers[12 + spring] * stretch as f64 / length as f64;
        pulls.push(way.map(|x| pull * (x as f64 * 2f64.powi(-40))));
    }
    let pairs = pulls.windows(2);
    let forces = pairs.flat_map(|pair| [0, 1, 2].map(|axis| pair[1][axis] - pair[0][axis]));
    forces.collect()
}

#[test]
fn errors_of_a_row_are_those_of_plain_binary32_against_whole_numbers() {
    for stiffness in [1e6, 1e8, 1e9] {
        let mut most = 0.0f64;
        for seed in 1..=4 {
            let numbers = points(stiffness, seed);
            let short: Vec<f32> = numbers.iter().map(|&x| x as f32).collect();
            let exact = whole_forces(&numbers);
            let pairs = short_forces(&short).into_iter().zip(exact);
            most = pairs.fold(most, |most, (x, y)| most.max((x / y - 1.0).abs()));
        }
        let subject = row(stiffness);
        let bench = subject.prepare().expect("it has equations");
        let measured = bench.measure(&ProgramTreatment::default());
        let error = measured.expect("it is computed").error;
        assert!((most / error - 1.0).abs() < 1e-4, "{most:e} {error:e}");
    }
}

/// Positions and velocities at the start, and the step.
fn chain_start(ratio: f64) -> ([f64; 8], f64) {
    let mut start = [0.25, 0.0, 0.0, 0.0, 0.5, -0.25, 0.125, 0.25];
    for (i, stretch) in [0.1, 1e3 / ratio, -0.05].into_iter().enumerate() {
        start[i + 1] = f64::from((start[i] + 1.0 + stretch) as f32);
    }
    (start, f64::from((0.1 / ratio.sqrt()) as f32))
}

/// Every this number of steps the case looks at the forces.
const LOOKS: u32 = 40;

/// The forces of the springs by positions in plain binary32.
fn short_chain(ratio: f64) -> Vec<[f64; 3]> {
    let (start, step) = chain_start(ratio);
    let k = [1.0, ratio as f32, 1.0];
    let [half, whole, sixth, third] =
        [0.5, 1.0, 1.0 / 6.0, 1.0 / 3.0].map(|part| (part * step) as f32);
    let pulls = |y: &[f32; 8]| [0, 1, 2].map(|i| k[i] * (y[i + 1] - y[i] - 1.0));
    let slope = |y: &[f32; 8]| {
        let [f, g, h] = pulls(y);
        [y[4], y[5], y[6], y[7], f, g - f, h - g, -h]
    };
    let moved = |y: &[f32; 8], k: &[f32; 8], by: f32| std::array::from_fn(|i| y[i] + by * k[i]);
    let mut y: [f32; 8] = start.map(|x| x as f32);
    let mut seen = Vec::new();
    for done in 0..=2000 {
        if done % LOOKS == 0 {
            seen.push(pulls(&y).map(f64::from));
        }
        let a = slope(&y);
        let b = slope(&moved(&y, &a, half));
        let c = slope(&moved(&y, &b, half));
        let d = slope(&moved(&y, &c, whole));
        y = std::array::from_fn(|i| y[i] + (sixth * (a[i] + d[i]) + third * (b[i] + c[i])));
    }
    seen
}

/// The same in elongations, which binary64 represents to all digits, and the
/// momentum at the end. The equations are linear: a step is the series of the
/// exponential function up to the fourth power.
fn wide_chain(ratio: f64) -> (Vec<[f64; 3]>, f64) {
    let (start, step) = chain_start(ratio);
    let k = [1.0, ratio, 1.0];
    let slope = |y: &[f64; 7]| {
        let [f, g, h] = [0, 1, 2].map(|i| k[i] * y[i]);
        [y[4] - y[3], y[5] - y[4], y[6] - y[5], f, g - f, h - g, -h]
    };
    let mut y: [f64; 7] = std::array::from_fn(|i| match i {
        0..3 => start[i + 1] - start[i] - 1.0,
        _ => start[i + 1],
    });
    let mut seen = Vec::new();
    for done in 0..=2000 {
        if done % LOOKS == 0 {
            seen.push([0, 1, 2].map(|i| k[i] * y[i]));
        }
        let mut term = y;
        for power in 1..=4 {
            let next = slope(&term);
            term = std::array::from_fn(|i| step / f64::from(power) * next[i]);
            y = std::array::from_fn(|i| y[i] + term[i]);
        }
    }
    (seen, y[3] + y[4] + y[5] + y[6])
}

#[test]
fn errors_of_a_chain_are_those_of_plain_binary32_and_momentum_stays() {
    for ratio in [1e6, 1e9] {
        let (exact, momentum) = wide_chain(ratio);
        // Springs push both ends alike.
        assert!((momentum - 0.625).abs() < 1e-9, "{momentum}");
        let short = short_chain(ratio);
        let most = (0..3).map(|i| {
            let size = exact.iter().fold(0.0f64, |most, f| most.max(f[i].abs()));
            let pairs = short.iter().zip(&exact);
            pairs.fold(0.0f64, |most, (x, y)| most.max((x[i] - y[i]).abs())) / size
        });
        let most = most.fold(0.0, f64::max);
        let subject = chain(ratio);
        let bench = subject.prepare().expect("it has equations");
        let measured = bench.measure(&subject.untreated()).expect("it is computed");
        let error = measured.error;
        assert!((most / error - 1.0).abs() < 1e-4, "{most:e} {error:e}");
    }
}
