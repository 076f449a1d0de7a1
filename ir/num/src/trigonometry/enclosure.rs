//! An enclosure of the error of a polynomial on a part of its range.
//!
//! With `t = x^2`, the polynomial less the function's own series is a power
//! series in `t` whose first coefficients are known to some 100 bits; cut off
//! far beyond the polynomial's degree it is a polynomial `D(t)` and a remainder
//! below Lagrange's bound. On an interval of `t` the values of a polynomial are
//! between the smallest and the largest of its Bernstein coefficients, which
//! are computed from the expansion about the interval's lower end. The width of
//! the enclosure beyond the true range decreases with the square of the
//! interval's width, and there is no harmful cancellation: small differences
//! are formed before anything is rounded to binary64.
//!
//! Rounding inside the computation: every double-double operation has a
//! relative error below 2^-103; none of the fewer than 2^15 operations of an
//! enclosure meets a number above the sum of all `|D_k| t^k` at the end of
//! the range, whose 2^-88 part is therefore added as a margin.

use super::bound::worst;
use super::polynomial::{Circular, LARGEST_RANGE, Polynomial};
use crate::double_double::Double;
use crate::interval::Interval;

/// The error of a polynomial as a function of the angle.
#[derive(Clone, Debug)]
pub struct ErrorEnclosure {
    of: Circular,
    /// `D(t)`, without the factor `x` of a sine.
    difference: Vec<Double>,
    /// Bounds of the contributions of truncation and computation to `D`.
    margin: f64,
}

/// The series continues until its remainder is this part of the first term the
/// polynomial leaves out.
const NEGLIGIBLE: f64 = 1.0 / (1u64 << 60) as f64;

/// And no further than this many terms: enough for [`LARGEST_RANGE`].
const MAX_TERMS: usize = 100;

impl Polynomial {
    /// The largest absolute distance from the true function for angles of at
    /// most `range` radians: never below it, and at most a few per cent above.
    ///
    /// Infinite beyond [`LARGEST_RANGE`] and for ranges that are no number.
    pub fn proved_error(&self, range: f64) -> f64 {
        match ErrorEnclosure::new(self, range) {
            Some(enclosure) => worst(range, |low, high| enclosure.error(low, high)),
            None => f64::INFINITY,
        }
    }
}

impl ErrorEnclosure {
    /// The error for angles up to `range` radians of either sign; `None` for
    /// ranges beyond [`LARGEST_RANGE`] or that are no size.
    pub fn new(polynomial: &Polynomial, range: f64) -> Option<ErrorEnclosure> {
        if !(0.0..=LARGEST_RANGE).contains(&range) {
            return None;
        }
        let square = (range * range).next_up();
        let used = polynomial.coefficients.len();
        assert!(used > 0, "a polynomial has a coefficient");
        let series = polynomial.of.series(MAX_TERMS);
        // Terms `|c_k| t^k` of the series at the end of the range.
        let mut power = 1.0;
        let mut sizes = Vec::with_capacity(MAX_TERMS);
        for coefficient in &series {
            sizes.push(coefficient.high.abs() * power);
            power *= square;
        }
        let left_out = sizes[used.min(MAX_TERMS - 2)];
        let last = (used + 1..MAX_TERMS - 1)
            .find(|&term| sizes[term] <= left_out * NEGLIGIBLE)
            .unwrap_or(MAX_TERMS - 1);
        // Lagrange: the remainder is at most the size of the first term that
        // is left out, whatever the angle.
        let remainder = sizes[last] * (1.0 + 1e-12) + f64::MIN_POSITIVE;
        let difference: Vec<Double> = (0..last)
            .map(|k| match polynomial.coefficients.get(k) {
                Some(&used) => Double::from(used) - series[k],
                None => -series[k],
            })
            .collect();
        let mut majorant = 0.0;
        for coefficient in difference.iter().rev() {
            majorant = majorant * square + coefficient.high.abs();
        }
        Some(ErrorEnclosure {
            of: polynomial.of,
            difference,
            margin: remainder + majorant * 2f64.powi(-88),
        })
    }

    /// Holds polynomial minus function for all angles from `low` to `high`,
    /// both within the range and not negative.
    pub fn error(&self, low: f64, high: f64) -> Interval {
        assert!(
            0.0 <= low && low <= high,
            "angles are in order and not negative"
        );
        let start = Double::from(low) * Double::from(low);
        let end = Double::from(high) * Double::from(high);
        let bernstein = bernstein(&self.difference, start, end - start);
        let mut lowest = f64::INFINITY;
        let mut highest = f64::NEG_INFINITY;
        for coefficient in bernstein {
            lowest = lowest.min(coefficient.high);
            highest = highest.max(coefficient.high);
        }
        let difference = Interval {
            low: lowest.next_down(),
            high: highest.next_up(),
        };
        let difference = difference.widened(self.margin);
        match self.of {
            Circular::Sine => difference * Interval { low, high },
            Circular::Cosine => difference,
        }
    }
}

/// The Bernstein coefficients of a polynomial on `[start, start + width]`.
fn bernstein(coefficients: &[Double], start: Double, width: Double) -> Vec<Double> {
    let mut shifted = coefficients.to_vec();
    let degree = shifted.len().saturating_sub(1);
    // Horner's scheme, repeated: the expansion about `start`.
    for first in 0..degree {
        for k in (first..degree).rev() {
            shifted[k] = shifted[k] + shifted[k + 1] * start;
        }
    }
    // In the variable that runs from 0 to 1, divided by the binomials of the
    // degree; then the sums `b_i = Σ_j C(i,j) a_j` by Pascal's triangle.
    let mut power = Double::from(1.0);
    let mut binomial = Double::from(1.0);
    for (k, coefficient) in shifted.iter_mut().enumerate() {
        *coefficient = *coefficient * power / binomial;
        power = power * width;
        let (k, degree) = (k as f64, degree as f64);
        binomial = binomial * Double::from(degree - k) / Double::from(k + 1.0);
        if binomial.high == 0.0 {
            binomial = Double::from(1.0);
        }
    }
    for row in 1..=degree {
        for i in (row..=degree).rev() {
            shifted[i] = shifted[i] + shifted[i - 1];
        }
    }
    shifted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bernstein_coefficients_enclose_and_meet_the_ends() {
        // (t - 1)(t - 2)(t - 3) on [0.5, 3.5].
        let coefficients = [-6.0, 11.0, -6.0, 1.0].map(Double::from);
        let found = bernstein(&coefficients, Double::from(0.5), Double::from(3.0));
        let found: Vec<f64> = found.iter().map(|number| number.high).collect();
        assert_eq!(found.len(), 4);
        assert!((found[0] + 1.875).abs() < 1e-12 && (found[3] - 1.875).abs() < 1e-12);
        // The derivative at the start is 3 (b_1 - b_0) / width = 5.75.
        assert!((found[1] - found[0] - 5.75).abs() < 1e-12);
    }

    #[test]
    fn the_error_lies_in_the_enclosure() {
        use crate::arithmetic::Arithmetic;
        use crate::double_double::DoubleDouble;
        for of in Circular::BOTH {
            for (order, range) in [(1, 0.1), (3, 1.0), (7, 3.0), (11, 6.0)] {
                let polynomial = Polynomial::taylor(of, order);
                let enclosure = ErrorEnclosure::new(&polynomial, range).expect("a fair range");
                for piece in 0..16 {
                    let low = range * f64::from(piece) / 16.0;
                    let high = range * f64::from(piece + 1) / 16.0;
                    let enclosed = enclosure.error(low, high);
                    for sample in 0..=8 {
                        let angle = low + (high - low) * f64::from(sample) / 8.0;
                        let angle = Double::from(angle.min(high));
                        let exact = match of {
                            Circular::Sine => DoubleDouble.sin(angle),
                            Circular::Cosine => DoubleDouble.cos(angle),
                        };
                        let error = (polynomial.at(angle) - exact).high;
                        assert!(enclosed.low <= error && error <= enclosed.high);
                    }
                }
            }
        }
    }
}
