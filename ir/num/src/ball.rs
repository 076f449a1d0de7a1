//! Double-double with a bound of its error.
//!
//! Beside every number a radius is kept in binary64: the exact value lies
//! within it (running error analysis: Wilkinson 1963; Higham, *Accuracy and
//! Stability of Numerical Algorithms*, 2002, section 3.3). Radii treat errors
//! as if they always added up, and along a chain of joints they grow by about
//! half a bit per joint more than errors do; double-double has some fifty bits
//! to spare for that. A caller that needs a decision computes an uncertain
//! result again with more bits.
//!
//! The radii are themselves rounded; [`SLACK`] covers that for any function
//! that fits into memory.

use crate::arithmetic::Arithmetic;
use crate::double_double::{DoubleDoubleLanes, DoubleLanes, SMALLEST_WHOLE};

/// Relative errors of the operations of double-double (Joldes, Muller and
/// Popescu 2017, in units of 2⁻¹⁰⁶: 3 for a sum, 7 for a product, 15 for a
/// quotient).
const SUM_UNIT: f64 = 1.0 / (1u128 << 104) as f64;
const PRODUCT_UNIT: f64 = 1.0 / (1u128 << 103) as f64;
const UNIT: f64 = 1.0 / (1u128 << 102) as f64;

/// Relative error of sine and cosine in double-double, for angles that need
/// little reduction.
const WAVE_UNIT: f64 = 1.0 / (1u128 << 98) as f64;

/// The error of reducing an angle: π/2 is known to 212 bits and the remainder
/// is formed in double-double.
const REDUCTION: f64 = WAVE_UNIT * (f64::EPSILON / 16.0);

/// No bound is claimed for the sine of a larger angle.
const LARGEST_ANGLE: f64 = (1u64 << 40) as f64;

/// The largest error of products and quotients below [`SMALLEST_WHOLE`].
const SUNK: f64 = f64::MIN_POSITIVE;

/// Covers the rounding of the radii: each operation rounds a handful of times
/// by 2⁻⁵³, and a chain has less than 2³⁰ operations.
pub const SLACK: f64 = 1.0 + 1.0 / (1u32 << 18) as f64;

/// Double-double numbers of several states with radii.
#[derive(Clone, Copy, Debug)]
pub struct Ball<const LANES: usize> {
    /// The numbers.
    pub value: DoubleLanes<LANES>,
    /// The largest distance of the exact ones; infinite where nothing is known.
    pub radius: [f64; LANES],
}

/// The arithmetic of [`Ball`].
#[derive(Clone, Copy, Debug)]
pub struct Balls<const LANES: usize>;

impl<const LANES: usize> Ball<LANES> {
    /// Numbers that are known.
    pub fn exact(numbers: [f64; LANES]) -> Ball<LANES> {
        Ball {
            value: DoubleLanes::new(numbers),
            radius: [0.0; LANES],
        }
    }

    /// True for a lane of whose number something is known.
    #[inline]
    pub fn is_known(&self, lane: usize) -> bool {
        let numbers = [self.value.high[lane], self.value.low[lane]];
        numbers.iter().all(|number| number.is_finite()) && self.radius[lane].is_finite()
    }

    /// The largest possible absolute value of the exact number of a lane.
    #[inline]
    pub fn reach(&self, lane: usize) -> f64 {
        self.value.high[lane].abs() + self.radius[lane]
    }

    /// Tests whether the exact numbers of a lane, of which bounds are known,
    /// can be equal.
    #[inline]
    pub fn touches(&self, other: &Ball<LANES>, lane: usize) -> bool {
        let [low, other_low] = [self, other].map(|ball| ball.value.low[lane]);
        // The difference of the lower halves is rounded once.
        let rounding = (low.abs() + other_low.abs()) * f64::EPSILON;
        self.distance(other, lane) <= (self.radius[lane] + other.radius[lane]) * SLACK + rounding
    }

    /// The distance between the middles of the balls of a lane.
    #[inline]
    pub fn distance(&self, other: &Ball<LANES>, lane: usize) -> f64 {
        let low = self.value.low[lane] - other.value.low[lane];
        (self.value.high[lane] - other.value.high[lane] + low).abs()
    }

    /// The operation's result with radii by lane.
    #[inline]
    fn with(value: DoubleLanes<LANES>, radius: impl Fn(usize) -> f64) -> Ball<LANES> {
        let mut ball = Ball {
            value,
            radius: [0.0; LANES],
        };
        for lane in 0..LANES {
            ball.radius[lane] = radius(lane);
            assert!(
                ball.radius[lane].is_nan() || ball.radius[lane] >= 0.0,
                "a radius is not negative"
            );
        }
        ball
    }
}

/// Cost of the end of the range for a product or quotient that may be other
/// than zero, and for its radius, which sinks to zero as well.
#[inline]
fn sunk(result: f64, may_be_other: bool) -> f64 {
    let lost = result.abs() < SMALLEST_WHOLE && may_be_other;
    if lost { SUNK } else { 0.0 }
}

/// Tests whether a number with a radius may be other than zero.
#[inline]
fn may_be_other((number, radius): (f64, f64)) -> bool {
    (number != 0.0) | (radius != 0.0)
}

/// Tests whether it is one or minus one: products with it do not underflow.
#[inline]
fn is_unit((number, radius): (f64, f64)) -> bool {
    (number.abs() == 1.0) & (radius == 0.0)
}

/// The radius of a product of numbers with radii.
#[inline]
fn product((a, a_radius): (f64, f64), (b, b_radius): (f64, f64)) -> f64 {
    let (a, b) = (a.abs(), b.abs());
    // Twice the product of the radii lets the radii belong to any number in
    // the balls and not only to their middles.
    a * b_radius + b * a_radius + 2.0 * a_radius * b_radius
}

#[inline]
fn quotient(value: f64, a_radius: f64, (b, b_radius): (f64, f64)) -> f64 {
    let nearest = b.abs() - b_radius;
    if a_radius == 0.0 && b_radius == 0.0 {
        0.0
    } else if nearest > 0.0 {
        (a_radius + value.abs() * b_radius) / nearest
    } else {
        f64::INFINITY
    }
}

#[inline]
fn root(value: f64, a: f64, radius: f64) -> f64 {
    if radius == 0.0 {
        0.0
    } else if radius < a {
        // The derivative at the near end of the ball, or steeper.
        radius / (a - radius).sqrt().min(value)
    } else {
        f64::INFINITY
    }
}

/// The radius of a sine or cosine.
#[inline]
fn wave(value: f64, angle: f64, radius: f64) -> f64 {
    if angle == 0.0 && radius == 0.0 {
        return 0.0;
    }
    if angle.abs() > LARGEST_ANGLE {
        return 2.0;
    }
    radius.min(2.0) + value.abs() * WAVE_UNIT + angle.abs() * REDUCTION
}

impl<const LANES: usize> Arithmetic for Balls<LANES> {
    type Number = Ball<LANES>;

    fn literal(&self, number: f64) -> Ball<LANES> {
        Ball::exact([number; LANES])
    }

    #[inline]
    fn neg(&self, a: Ball<LANES>) -> Ball<LANES> {
        Ball {
            value: DoubleDoubleLanes.neg(a.value),
            radius: a.radius,
        }
    }

    #[inline]
    fn add(&self, a: Ball<LANES>, b: Ball<LANES>) -> Ball<LANES> {
        let value = DoubleDoubleLanes.add(a.value, b.value);
        Ball::with(value, |lane| {
            a.radius[lane] + b.radius[lane] + value.high[lane].abs() * SUM_UNIT
        })
    }

    #[inline]
    fn sub(&self, a: Ball<LANES>, b: Ball<LANES>) -> Ball<LANES> {
        self.add(a, self.neg(b))
    }

    #[inline]
    fn mul(&self, a: Ball<LANES>, b: Ball<LANES>) -> Ball<LANES> {
        let value = DoubleDoubleLanes.mul(a.value, b.value);
        Ball::with(value, |lane| {
            let x = (a.value.high[lane], a.radius[lane]);
            let y = (b.value.high[lane], b.radius[lane]);
            let can_sink = may_be_other(x) & may_be_other(y) & !is_unit(x) & !is_unit(y);
            product(x, y) + value.high[lane].abs() * PRODUCT_UNIT + sunk(value.high[lane], can_sink)
        })
    }

    fn div(&self, a: Ball<LANES>, b: Ball<LANES>) -> Ball<LANES> {
        let value = DoubleDoubleLanes.div(a.value, b.value);
        Ball::with(value, |lane| {
            let x = (a.value.high[lane], a.radius[lane]);
            let y = (b.value.high[lane], b.radius[lane]);
            quotient(value.high[lane], x.1, y)
                + value.high[lane].abs() * UNIT
                + sunk(value.high[lane], may_be_other(x) & !is_unit(y))
        })
    }

    fn sin(&self, a: Ball<LANES>) -> Ball<LANES> {
        let value = DoubleDoubleLanes.sin(a.value);
        Ball::with(value, |lane| {
            wave(value.high[lane], a.value.high[lane], a.radius[lane])
        })
    }

    fn cos(&self, a: Ball<LANES>) -> Ball<LANES> {
        let value = DoubleDoubleLanes.cos(a.value);
        Ball::with(value, |lane| {
            wave(value.high[lane], a.value.high[lane], a.radius[lane])
        })
    }

    fn sqrt(&self, a: Ball<LANES>) -> Ball<LANES> {
        let value = DoubleDoubleLanes.sqrt(a.value);
        Ball::with(value, |lane| {
            root(value.high[lane], a.value.high[lane], a.radius[lane])
                + value.high[lane].abs() * UNIT
        })
    }

    #[inline]
    fn fma(&self, a: Ball<LANES>, b: Ball<LANES>, c: Ball<LANES>) -> Ball<LANES> {
        self.add(self.mul(a, b), c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_sinks_below_the_range_is_in_the_radius() {
        let [one, large, tiny] = [1.0, 1e300, 1e-300].map(|number| Balls.literal(number));
        let radius = |ball: Ball<1>| ball.radius[0];
        // The second half of 1/1e300 is below the range, and of a product.
        assert!(radius(Balls.div(one, large)) >= f64::MIN_POSITIVE);
        let tenth = Balls.literal(0.1);
        assert!(radius(Balls.mul(tiny, tenth)) >= f64::MIN_POSITIVE);
        assert!(radius(Balls.mul(tiny, one)) < 1e-320);
        assert!(radius(Balls.div(tiny, one)) < 1e-320);
        let zero = Balls.literal(0.0);
        assert_eq!(radius(Balls.mul(tiny, zero)), 0.0);
        assert_eq!(radius(Balls.div(zero, large)), 0.0);
    }
}
