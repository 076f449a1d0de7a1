//! The figures of a far sensor by matrices.

use super::super::equations::sensor;
use crate::ProgramTreatment;
use crate::case::StressSubject;
use crate::numbers::Draw;

type TurnMatrix = [[f64; 3]; 3];

fn turn(axis: usize, angle: f64) -> TurnMatrix {
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut matrix = [[0.0; 3]; 3];
    matrix[axis][axis] = 1.0;
    (matrix[next][next], matrix[last][last]) = (angle.cos(), angle.cos());
    (matrix[last][next], matrix[next][last]) = (angle.sin(), -angle.sin());
    matrix
}

fn times(matrix: &TurnMatrix, vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| (0..3).map(|k| row[k] * vector[k]).sum())
}

/// Place of the tip, seen from the origin of the body, along the base's axes:
/// by matrices, from the last joint to the first.
fn lever(angles: &[f64]) -> [f64; 3] {
    let mut place = [0.125, 0.0, 0.75];
    for (axis, angle) in [(0, angles[4]), (1, angles[3])] {
        place = times(&turn(axis, angle), place);
    }
    place = [place[0] + 0.5, place[1] + 0.25, place[2] + 0.125];
    for axis in [2, 1, 0] {
        place = times(&turn(axis, angles[axis]), place);
    }
    place
}

#[test]
fn errors_are_those_of_rounding_far_positions() {
    for (size, held) in [(1e4, false), (1e6, false), (1e6, true)] {
        let mut most = 0.0f64;
        for seed in 1..=4 {
            let mut draw = Draw::new(seed);
            let (mut body, mut target) = ([0.0; 3], [0.0; 3]);
            for axis in 0..3 {
                let place = size * (1.0 + 0.1 * axis as f64) + draw.within(1.0) / 3.0;
                let nearest = |x: f64| if held { f64::from(x as f32) } else { x };
                body[axis] = nearest(place);
                target[axis] = nearest(body[axis] + draw.between(1.0, 2.0));
                draw.within(20.0);
            }
            let angles: Vec<f64> = (0..5)
                .map(|_| {
                    let angle = draw.within(1.0);
                    draw.within(1.0);
                    angle
                })
                .collect();
            let lever = lever(&angles);
            for axis in 0..3 {
                let exact = body[axis] - target[axis] + lever[axis];
                // The body's place and the target are rounded, then the
                // sum of place and lever; the difference is exact.
                let sum = (f64::from(body[axis] as f32) + lever[axis]) as f32;
                let short = f64::from(sum - target[axis] as f32);
                most = most.max((short / exact - 1.0).abs());
            }
        }
        let subject = sensor(size, held);
        let bench = subject.prepare().expect("it has equations");
        let measured = bench.measure(&ProgramTreatment::default());
        let error = measured.expect("it is computed").error;
        assert!((most / error - 1.0).abs() < 1e-2, "{most:e} {error:e}");
    }
}
