//! Rotations by shifts and additions.
//!
//! The vector `(K, 0)` is turned by `± atan 2^-i` for `i = 0, 1, 2 …`, always
//! towards the angle (Volder 1959). `K` makes up for the factor `sqrt(1 +
//! 4^-i)` by which every such turn lengthens the vector. After `n` turns the
//! rest of the angle is at most `atan 2^-(n-1)`; the rest of the error is that
//! of the shifts, which cut.

use super::kernel::{fixed, half_unit};
use crate::arithmetic::Arithmetic;
use crate::double_double::{Double, DoubleDouble};

/// The constants of a number of rotations.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Cordic {
    /// `atan 2^-i` in units of `2^-bits`.
    angles: Vec<i64>,
    /// `K` in units of `2^-bits`.
    start: i64,
    bits: u32,
}

impl Cordic {
    pub(super) fn new(iterations: u32, bits: u32) -> Cordic {
        let angles = (0..iterations).map(|i| fixed(arc_tangent(i), bits));
        let mut gain = Double::from(1.0);
        for i in 0..iterations {
            gain = gain * lengthening(i);
        }
        Cordic {
            angles: angles.collect(),
            start: fixed(Double::from(1.0) / gain, bits),
            bits,
        }
    }

    /// Sine and cosine of an angle from 0 to an eighth of a turn, everything
    /// in units of `2^-bits`.
    pub(super) fn at(&self, angle: i64) -> [i64; 2] {
        let (mut x, mut y, mut rest) = (self.start, 0i64, angle);
        for (i, &turn) in self.angles.iter().enumerate() {
            let (across, along) = (y >> i, x >> i);
            if rest >= 0 {
                (x, y, rest) = (x - across, y + along, rest - turn);
            } else {
                (x, y, rest) = (x + across, y - along, rest + turn);
            }
        }
        [y, x]
    }

    /// The largest distance from the true values at the angle as given.
    pub(super) fn error(&self) -> f64 {
        let iterations = self.angles.len() as u32;
        let unit = 2.0 * half_unit(self.bits);
        let half = half_unit(self.bits);
        // What is left of the angle, and the rounding of the table.
        let left = 2f64.powi(1 - iterations as i32) + f64::from(iterations) * half;
        // The error of the vector: that of `K`, and one unit in both
        // components for every turn, lengthened by the turns that follow.
        let mut error = half;
        for i in 0..iterations {
            error = error * lengthening(i).high * (1.0 + 1e-15) + std::f64::consts::SQRT_2 * unit;
        }
        left + error
    }
}

/// `sqrt(1 + 4^-i)`.
fn lengthening(i: u32) -> Double {
    DoubleDouble.sqrt(Double::from(1.0) + Double::from(4f64.powi(-(i as i32))))
}

/// `atan 2^-i`, from its series; that of 1 is `π/4`.
fn arc_tangent(i: u32) -> Double {
    if i == 0 {
        return Double {
            high: std::f64::consts::FRAC_PI_4,
            low: 3.061616997868383e-17,
        };
    }
    let tangent = Double::from(2f64.powi(-(i as i32)));
    let mut sum = Double::from(0.0);
    for k in (0..60u32).rev() {
        let term = Double::from(1.0) / Double::from(f64::from(2 * k + 1));
        sum = term - sum * tangent * tangent;
    }
    sum * tangent
}
