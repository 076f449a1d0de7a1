//! An error bound that is known before anything is measured.
//!
//! For every value two numbers are kept: its *magnitude*, the value if every
//! term of every sum counted with its absolute value, and its *roundings*, the
//! maximum number of roundings that a term can have met. The rounded value is
//! then within `k u / (1 - k u)` times the magnitude of the exact one (the
//! classical forward bound: Higham, *Accuracy and Stability of Numerical
//! Algorithms*, 2002, sections 3.1 and 4.2, with a product counting the
//! roundings of both factors).
//!
//! The magnitude makes the bound useful for rewriting: exchanging, regrouping,
//! distributing and factoring do not change it, and only a rewrite that removes
//! or adds cancelling terms does. A pass that promises to be *real* therefore
//! changes the bound by the roundings alone, unless it invents cancellations.

use robovec_num::arithmetic::Arithmetic;

/// Evaluates with magnitudes and roundings; the bounds are those of binary32
/// and hold without overflow and underflow. Values are kept in binary64, whose
/// own errors are a billion times smaller.
#[derive(Clone, Copy, Default, Debug)]
pub struct Binary32Bound;

/// A value with a bound of its error.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Bounded {
    /// The value, to binary64.
    pub value: f64,
    /// The value with all terms taken as positive; infinite where no bound
    /// can be given, as when a divisor may be zero.
    pub magnitude: f64,
    /// The largest number of roundings that a term has met.
    pub roundings: f64,
}

/// Unit roundoff of binary32.
const UNIT: f64 = 1.0 / (1u64 << 24) as f64;

/// Largest relative error of a divisor or radicand; beyond it no bound is
/// given.
const LARGEST_RELATIVE: f64 = 1.0 / 16.0;

impl Bounded {
    /// An input that is a number of binary32.
    pub fn exact(value: f64) -> Bounded {
        Bounded {
            value,
            magnitude: value.abs(),
            roundings: 0.0,
        }
    }

    /// The largest error of the number computed in binary32, for a given
    /// magnitude.
    pub fn bound_for(self, magnitude: f64) -> f64 {
        let sum = self.roundings * UNIT;
        match sum < 0.5 {
            true if sum == 0.0 => 0.0,
            true => sum / (1.0 - sum) * magnitude,
            false => f64::INFINITY,
        }
    }

    /// The largest error of the number computed in binary32.
    pub fn bound(self) -> f64 {
        self.bound_for(self.magnitude)
    }

    /// The bound relative to the value.
    fn relative(self) -> f64 {
        self.bound() / self.value.abs()
    }

    fn is_zero(self) -> bool {
        self.magnitude == 0.0
    }
}

fn sum(value: f64, a: Bounded, b: Bounded) -> Bounded {
    // Adding zero is exact.
    let rounding = f64::from(!a.is_zero() && !b.is_zero());
    Bounded {
        value,
        magnitude: a.magnitude + b.magnitude,
        roundings: a.roundings.max(b.roundings) + rounding,
    }
}

/// Sine and cosine have slopes of at most one.
fn wave(value: f64, a: Bounded) -> Bounded {
    let carried = if a.roundings == 0.0 { 0.0 } else { a.magnitude };
    Bounded {
        value,
        magnitude: value.abs() + carried,
        roundings: a.roundings + 1.0,
    }
}

impl Arithmetic for Binary32Bound {
    type Number = Bounded;

    fn literal(&self, number: f64) -> Bounded {
        Bounded {
            roundings: f64::from(f64::from(number as f32) != number),
            ..Bounded::exact(number)
        }
    }

    fn neg(&self, a: Bounded) -> Bounded {
        Bounded {
            value: -a.value,
            ..a
        }
    }

    fn add(&self, a: Bounded, b: Bounded) -> Bounded {
        sum(a.value + b.value, a, b)
    }

    fn sub(&self, a: Bounded, b: Bounded) -> Bounded {
        sum(a.value - b.value, a, b)
    }

    fn mul(&self, a: Bounded, b: Bounded) -> Bounded {
        Bounded {
            value: a.value * b.value,
            magnitude: a.magnitude * b.magnitude,
            roundings: a.roundings + b.roundings + 1.0,
        }
    }

    fn div(&self, a: Bounded, b: Bounded) -> Bounded {
        let value = a.value / b.value;
        let relative = b.relative();
        let known = relative <= LARGEST_RELATIVE;
        // The error of a quotient is that of the product with the inverse;
        // the factor covers what is of second order in the divisor's error.
        let second_order = 1.0 / (1.0 - relative);
        let magnitude = a.magnitude * b.magnitude / (b.value * b.value) * second_order;
        Bounded {
            value,
            magnitude: if known { magnitude } else { f64::INFINITY },
            roundings: a.roundings + b.roundings + 1.0,
        }
    }

    fn sin(&self, a: Bounded) -> Bounded {
        wave(a.value.sin(), a)
    }

    fn cos(&self, a: Bounded) -> Bounded {
        wave(a.value.cos(), a)
    }

    fn sqrt(&self, a: Bounded) -> Bounded {
        let value = a.value.sqrt();
        let known = a.value > 0.0 && a.relative() <= LARGEST_RELATIVE;
        Bounded {
            value,
            // The relative error halves, but for what is of second order.
            magnitude: if known {
                value * (a.magnitude / a.value)
            } else {
                f64::INFINITY
            },
            roundings: a.roundings + 1.0,
        }
    }

    fn fma(&self, a: Bounded, b: Bounded, c: Bounded) -> Bounded {
        Bounded {
            value: a.value * b.value + c.value,
            magnitude: a.magnitude * b.magnitude + c.magnitude,
            roundings: (a.roundings + b.roundings).max(c.roundings) + 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_num::arithmetic::Binary32;
    use robovec_num::random::Random;

    #[test]
    fn cancellation_is_in_the_magnitude() {
        let bound = Binary32Bound;
        let (a, b) = (Bounded::exact(1.0), Bounded::exact(1.25));
        let product = bound.mul(a, b);
        let difference = bound.sub(product, b);
        assert_eq!((difference.value, difference.magnitude), (0.0, 2.5));
        assert_eq!(difference.roundings, 2.0);
        let zero = bound.literal(0.0);
        assert_eq!(bound.sub(zero, product).roundings, 1.0);
        assert_eq!(bound.literal(0.1).roundings, 1.0);
        assert!(bound.div(a, difference).bound().is_infinite());
    }

    #[test]
    fn regrouping_and_distributing_keep_the_magnitude() {
        let bound = Binary32Bound;
        let [a, b, c] = [3.0, -0.75, 0.8125].map(Bounded::exact);
        let left = bound.mul(a, bound.sub(b, c));
        let right = bound.sub(bound.mul(a, b), bound.mul(a, c));
        assert_eq!(left.magnitude, right.magnitude);
        let left = bound.add(bound.sub(a, b), c);
        let right = bound.sub(a, bound.sub(b, c));
        assert_eq!(left.magnitude, right.magnitude);
    }

    #[test]
    fn rounded_values_are_within_the_bound() {
        let (bound, float) = (Binary32Bound, Binary32);
        let mut random = Random::new(1);
        for _ in 0..2000 {
            let mut draw = || (random.unit() as f32 - 0.3) * 4.0;
            let [a, b, c] = [draw(), draw(), draw()];
            let [x, y, z] = [a, b, c].map(|number| Bounded::exact(f64::from(number)));
            let root = |x| bound.sqrt(bound.add(bound.mul(x, x), bound.literal(0.1)));
            let exact = bound.sub(
                bound.div(bound.sin(bound.add(x, y)), root(z)),
                bound.mul(x, y),
            );
            let root = |x| float.sqrt(float.add(float.mul(x, x), float.literal(0.1)));
            let rounded = float.sub(
                float.div(float.sin(float.add(a, b)), root(c)),
                float.mul(a, b),
            );
            let error = (f64::from(rounded) - exact.value).abs();
            assert!(
                error <= exact.bound(),
                "{a} {b} {c}: {error} over {}",
                exact.bound()
            );
        }
    }
}
