//! The gaps of a four-bar by the laws of Newton and Euler for each bar.

use super::super::loops::four_bar;
use crate::case::StressSubject;
use crate::drift::DriftSubject;
use crate::{LoopStabilisation, ProgramTreatment};
use robovec_dynamics::kinematics::linear::{DenseMatrix, column, solve_square};
use robovec_ir::Format;

/// Lengths (m), masses (kg) and central inertias (kg m^2) of crank, coupler and
/// rocker, the distance of the pivots and gravity: numbers of binary32.
const BARS: [[f32; 3]; 3] = [[0.3, 1.5, 0.0115], [0.8, 2.0, 0.107], [0.6, 1.8, 0.054]];
const PIVOT: f64 = 0.9f32 as f64;
const GRAVITY: f64 = 9.81f32 as f64;

/// Angles that turn a bar: the coupler's is relative to the crank.
const TURNS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Jacobian and velocity terms of a chain of bars up to fractions of
/// their lengths, in the plane of x and z.
fn place(y: &[f64; 6], parts: [f64; 3]) -> ([[f64; 3]; 2], [f64; 2], [f64; 2]) {
    let (mut jacobian, mut quadratic, mut at) = ([[0.0; 3]; 2], [0.0; 2], [0.0; 2]);
    for bar in 0..3 {
        let turn = |from: usize| (0..3).map(|k| TURNS[bar][k] * y[from + k]).sum::<f64>();
        let (angle, rate) = (turn(0), turn(3));
        let length = f64::from(BARS[bar][0]) * parts[bar];
        let along = [length * angle.cos(), -length * angle.sin()];
        for axis in 0..2 {
            at[axis] += along[axis];
            quadratic[axis] -= along[axis] * rate * rate;
        }
        for k in 0..3 {
            jacobian[0][k] += TURNS[bar][k] * along[1];
            jacobian[1][k] -= TURNS[bar][k] * along[0];
        }
    }
    (jacobian, quadratic, at)
}

/// The tip of the coupler less that of the rocker.
fn open(y: &[f64; 6]) -> ([[f64; 3]; 2], [f64; 2], [f64; 2]) {
    let (mut jacobian, mut quadratic, mut at) = place(y, [1.0, 1.0, 0.0]);
    let (other, terms, tip) = place(y, [0.0, 0.0, 1.0]);
    for axis in 0..2 {
        at[axis] -= tip[axis] + [PIVOT, 0.0][axis];
        quadratic[axis] -= terms[axis];
        for k in 0..3 {
            jacobian[axis][k] -= other[axis][k];
        }
    }
    (jacobian, quadratic, at)
}

/// Velocities and accelerations by the laws of Newton and Euler for each
/// bar, and multipliers for the loop.
fn slope(y: &[f64; 6]) -> [f64; 6] {
    let mut matrix = DenseMatrix::zeros(5, 5);
    let mut right = [0.0; 5];
    for (bar, parts) in [[0.5, 0.0, 0.0], [1.0, 0.5, 0.0], [0.0, 0.0, 0.5]]
        .into_iter()
        .enumerate()
    {
        let [_, mass, inertia] = BARS[bar].map(f64::from);
        let (jacobian, quadratic, _) = place(y, parts);
        for i in 0..3 {
            for k in 0..3 {
                let moved: f64 = (0..2)
                    .map(|axis| jacobian[axis][i] * jacobian[axis][k])
                    .sum();
                matrix[(i, k)] += mass * moved + inertia * TURNS[bar][i] * TURNS[bar][k];
            }
            right[i] -= mass * jacobian[0][i] * quadratic[0];
            right[i] -= mass * jacobian[1][i] * (quadratic[1] + GRAVITY);
        }
    }
    let (jacobian, quadratic, _) = open(y);
    for row in 0..2 {
        for k in 0..3 {
            matrix[(3 + row, k)] = jacobian[row][k];
            matrix[(k, 3 + row)] = jacobian[row][k];
        }
        right[3 + row] = -quadratic[row];
    }
    let found = solve_square(matrix, column(&right)).expect("the loop moves");
    [
        y[3],
        y[4],
        y[5],
        found[(0, 0)],
        found[(1, 0)],
        found[(2, 0)],
    ]
}

/// The largest gap over the longest coordinate of the model.
fn by_hand(start: [f64; 6], step: f64, steps: u64) -> f64 {
    let mut y = start;
    let mut most = 0.0f64;
    for _ in 0..steps {
        let moved = |k: [f64; 6], by: f64| std::array::from_fn(|i| y[i] + by * k[i]);
        let a = slope(&y);
        let b = slope(&moved(a, step / 2.0));
        let c = slope(&moved(b, step / 2.0));
        let d = slope(&moved(c, step));
        y = std::array::from_fn(|i| y[i] + step / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        let (_, _, gap) = open(&y);
        most = most.max(gap[0].abs()).max(gap[1].abs());
    }
    most / PIVOT
}

#[test]
fn gaps_are_those_of_bars_written_by_hand() {
    let model = four_bar(0.5);
    let joints = &model.joints;
    let initial = |place: usize, joint: usize| joints[joint].initial[place];
    let start = std::array::from_fn(|i| {
        let number = initial(i / 3, i % 3);
        f64::from(number as f32)
    });
    let (step, steps) = (2f64.powi(-6), 256);
    let gap = by_hand(start, step, steps);
    let subject = DriftSubject::new(model, (step, steps));
    let bench = subject.prepare().expect("it has equations");
    let told = |format, stabilisation| {
        let treatment = ProgramTreatment {
            format,
            stabilisation,
            ..subject.untreated()
        };
        bench.measure(&treatment).expect("it is computed").error
    };
    // What the method leaves out is far more than roundings, so that
    // both formats open alike.
    let free = |format| told(format, LoopStabilisation::None);
    let wide = free(Format::BINARY64);
    assert!((gap / wide - 1.0).abs() < 1e-5, "{gap:e} {wide:e}");
    let short = free(Format::BINARY32);
    assert!((gap / short - 1.0).abs() < 0.1, "{gap:e} {short:e}");
    // A loop that is led back or put back stays closed.
    let led = told(Format::BINARY64, LoopStabilisation::Baumgarte);
    assert!(led < 0.05 * gap, "{led:e}");
    let put = told(Format::BINARY64, LoopStabilisation::Projection);
    assert!(put < 1e-9, "{put:e}");
}
