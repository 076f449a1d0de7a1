//! Polynomials in fixed-point arithmetic.

use crate::double_double::Double;
use crate::format::{FixedFormat, Format};
use crate::trigonometry::{Circular, Polynomial};

/// A number in units of `2^-bits`, rounded to nearest.
pub(super) fn fixed(number: Double, bits: u32) -> i64 {
    let scale = 2f64.powi(bits as i32);
    // Both halves scale exactly; the lower one decides the rounding.
    let whole = (number.high * scale).floor();
    let rest = number.high * scale - whole + number.low * scale;
    whole as i64 + (rest + 0.5).floor() as i64
}

/// A product of two numbers in units of `2^-bits`, rounded to nearest.
pub(super) fn product(a: i64, b: i64, bits: u32) -> i64 {
    let exact = i128::from(a) * i128::from(b);
    ((exact + (1i128 << (bits - 1))) >> bits) as i64
}

/// Half a unit in the last place: the largest rounding error of one result.
pub(super) fn half_unit(bits: u32) -> f64 {
    2f64.powi(-(bits as i32) - 1)
}

/// Polynomials for sine and cosine of small angles.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct HostKernel {
    polynomials: [Polynomial; 2],
    coefficients: [Vec<i64>; 2],
    bits: u32,
    /// Angles up to this size, in radians.
    range: f64,
}

impl HostKernel {
    /// The best polynomials of an order for angles of at most `range`.
    pub(super) fn new(order: u32, range: f64, bits: u32) -> HostKernel {
        let format = Format::Fixed(FixedFormat {
            integer: 1,
            fraction: bits,
        });
        let polynomials =
            Circular::BOTH.map(|of| Polynomial::minimax(of, order, range, Some(format)));
        let coefficients = [0, 1].map(|which: usize| {
            let numbers = polynomials[which].coefficients.iter();
            let fixed = numbers.map(|&number| fixed(Double::from(number), bits));
            fixed.collect()
        });
        HostKernel {
            polynomials,
            coefficients,
            bits,
            range,
        }
    }

    /// Sine and cosine of an angle, everything in units of `2^-bits`.
    pub(super) fn at(&self, angle: i64) -> [i64; 2] {
        let square = product(angle, angle, self.bits);
        let [sine, cosine] = [0, 1].map(|which: usize| {
            let mut sum = 0;
            for &coefficient in self.coefficients[which].iter().rev() {
                sum = product(sum, square, self.bits) + coefficient;
            }
            sum
        });
        [product(sine, angle, self.bits), cosine]
    }

    /// The largest distance from the true values at the angle as given: the
    /// error of the polynomials and that of every rounding.
    pub(super) fn errors(&self) -> [f64; 2] {
        let half = half_unit(self.bits);
        let square = self.range * self.range;
        let rounding = [0, 1].map(|which: usize| {
            let (mut error, mut size) = (0.0, 0.0);
            let terms = self.polynomials[which].coefficients.len();
            for (k, coefficient) in self.polynomials[which]
                .coefficients
                .iter()
                .enumerate()
                .rev()
            {
                // The first product is that of zero.
                if k + 1 < terms {
                    error = error * (square + half) + size * half + half;
                }
                size = size * square + coefficient.abs();
            }
            error
        });
        let proved = [0, 1].map(|which: usize| self.polynomials[which].proved_error(self.range));
        [
            proved[0] + rounding[0] * self.range + half,
            proved[1] + rounding[1],
        ]
    }

    /// Multiplications one after the other.
    pub(super) fn depth(&self) -> u32 {
        // The square, Horner's scheme, and the factor of the sine.
        self.coefficients[0].len().max(self.coefficients[1].len()) as u32 + 1
    }
}
