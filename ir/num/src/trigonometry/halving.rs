//! Angles halved before a polynomial, and doubled again after it.
//!
//! `sin 2y = 2 sin y cos y` and `cos 2y = 1 - 2 sin² y` hold without any
//! comparison, so straight-line code can reduce its range with them: with `K`
//! halvings the polynomials see angles 2^K times smaller. Errors grow on the
//! way back; [`Halved::proved_errors`] follows them, with their signs, on
//! every part of the range.

use super::bound::worst;
use super::enclosure::ErrorEnclosure;
use super::polynomial::{Circular, Polynomial};
use crate::arithmetic::Arithmetic;
use crate::double_double::{Double, DoubleDouble};
use crate::interval::Interval;

/// A sine and a cosine of an angle divided by a power of two, doubled back.
#[derive(Clone, PartialEq, Debug)]
pub struct Halved {
    /// Represents the sine of the small angle.
    pub sine: Polynomial,
    /// Represents the cosine of the small angle.
    pub cosine: Polynomial,
    /// The number of times the angle is halved.
    pub halvings: u32,
}

/// Angles are halved at most this often: the rest of the largest range is then
/// below 1/2000 radian.
pub const MAX_HALVINGS: u32 = 16;

impl Halved {
    /// The largest absolute errors of the sine and of the cosine that come
    /// out, for angles of at most `range` radians; proved, as
    /// [`Polynomial::proved_error`].
    pub fn proved_errors(&self, range: f64) -> [f64; 2] {
        let small = self.reduced(range);
        let sine = ErrorEnclosure::new(&self.sine, small);
        let cosine = ErrorEnclosure::new(&self.cosine, small);
        let (Some(sine), Some(cosine)) = (sine, cosine) else {
            return [f64::INFINITY; 2];
        };
        [0, 1].map(|which| {
            worst(small, |low, high| {
                let errors = [sine.error(low, high), cosine.error(low, high)];
                self.doubled(errors, low, high)[which]
            })
        })
    }

    /// The range the polynomials see.
    pub fn reduced(&self, range: f64) -> f64 {
        range * 2f64.powi(-(self.halvings.min(MAX_HALVINGS) as i32))
    }

    /// The errors of sine and cosine after the angles between `low` and `high`
    /// are doubled back.
    fn doubled(&self, errors: [Interval; 2], low: f64, high: f64) -> [Interval; 2] {
        let [mut sine, mut cosine] = errors;
        let two = Interval::point(2.0);
        let mut scale = 1.0;
        for _ in 0..self.halvings {
            let (s, c) = (
                true_values(Circular::Sine, low * scale, high * scale),
                true_values(Circular::Cosine, low * scale, high * scale),
            );
            // 2 (s + e)(c + f) - 2 s c and -2 (s + e)² + 2 s².
            let next = two * (s * cosine + c * sine + sine * cosine);
            cosine = -(two * sine * (two * s + sine));
            sine = next;
            scale *= 2.0;
        }
        [sine, cosine]
    }

    /// The values of sine and cosine to some 100 bits.
    pub fn at(&self, angle: Double) -> [Double; 2] {
        let scale = Double::from(2f64.powi(-(self.halvings as i32)));
        let small = angle * scale;
        let mut sine = self.sine.at(small);
        let mut cosine = self.cosine.at(small);
        let two = Double::from(2.0);
        for _ in 0..self.halvings {
            let next = two * sine * cosine;
            cosine = Double::from(1.0) - two * sine * sine;
            sine = next;
        }
        [sine, cosine]
    }
}

/// Holds the true values for all angles between two: the value in the middle
/// and half the width, since no slope is steeper than 1.
fn true_values(of: Circular, low: f64, high: f64) -> Interval {
    let middle = Double::from(0.5 * (low + high));
    let value = match of {
        Circular::Sine => DoubleDouble.sin(middle),
        Circular::Cosine => DoubleDouble.cos(middle),
    };
    let half = 0.5 * (high - low) + high.abs() * f64::EPSILON;
    let enclosed = Interval::point(value.high).widened(half + f64::EPSILON);
    enclosed.clamped(Interval::within(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors of sine and cosine found on a grid.
    fn sampled(halved: &Halved, range: f64) -> [f64; 2] {
        let mut worst = [0.0f64; 2];
        for sample in 0..=400 {
            let angle = Double::from(range * f64::from(sample) / 400.0);
            let [sine, cosine] = halved.at(angle);
            let errors = [
                sine - DoubleDouble.sin(angle),
                cosine - DoubleDouble.cos(angle),
            ];
            for (worst, error) in worst.iter_mut().zip(errors) {
                *worst = worst.max(error.high.abs());
            }
        }
        worst
    }

    #[test]
    fn doubled_errors_are_bounded_closely() {
        for (order, halvings, range) in [(3, 1, 0.5), (5, 2, 3.0), (7, 3, 6.0), (1, 6, 1.0)] {
            let halved = Halved {
                sine: Polynomial::taylor(Circular::Sine, order),
                cosine: Polynomial::taylor(Circular::Cosine, order),
                halvings,
            };
            let (proved, sampled) = (halved.proved_errors(range), sampled(&halved, range));
            for (proved, sampled) in proved.into_iter().zip(sampled) {
                assert!(proved >= sampled, "{proved} below {sampled}");
                assert!(proved <= 1.3 * sampled, "{proved} far above {sampled}");
            }
        }
    }

    #[test]
    fn without_halvings_the_errors_are_those_of_the_polynomials() {
        let halved = Halved {
            sine: Polynomial::taylor(Circular::Sine, 5),
            cosine: Polynomial::taylor(Circular::Cosine, 5),
            halvings: 0,
        };
        let expected = [
            halved.sine.proved_error(1.0),
            halved.cosine.proved_error(1.0),
        ];
        assert_eq!(halved.proved_errors(1.0), expected);
    }
}
