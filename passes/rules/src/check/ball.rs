//! Real numbers as balls: about 106 bits, a bound of the error, and no end of
//! the range.
//!
//! A ball is `(mantissa ± radius) * 2^exponent` with a double-double mantissa.
//! Results of balls are certain: two disjoint balls hold different numbers, and
//! a ball that does not contain zero excludes it. Sums and products of binary64
//! numbers that fit into a double-double are exact, so that small numbers keep
//! a radius of zero.

use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDouble};
use robovec_num::power::times_power_of_two;

/// A real number with a bound of its error.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct ScaledBall {
    mantissa: Double,
    /// In the unit of the mantissa; not negative.
    radius: f64,
    exponent: i64,
}

/// Factor that rounds radii up, above all roundings of one operation on them.
const UP: f64 = 1.0 + 1e-14;

/// Bounds of the relative errors of double-double operations, with room to
/// spare (2⁻¹⁰⁴ is proved for sums, products and quotients).
const SUM: f64 = 1.0 / (1u128 << 102) as f64;
const PRODUCT: f64 = 1.0 / (1u128 << 100) as f64;
const QUOTIENT: f64 = 1.0 / (1u128 << 98) as f64;
/// Of a sine or cosine of an angle up to [`LARGEST_ANGLE`], absolutely.
const SINE: f64 = 1.0 / (1u128 << 94) as f64;
const LARGEST_ANGLE: f64 = 1e6;

/// Beyond this number of powers of two the smaller term of a sum is only error.
const FAR: i64 = 400;

impl ScaledBall {
    /// A binary64 number, exactly.
    pub(super) fn exact(number: f64) -> ScaledBall {
        ScaledBall::between(number, 0.0)
    }

    /// A finite binary64 number with a bound of its distance from the intended
    /// number.
    pub(super) fn between(number: f64, radius: f64) -> ScaledBall {
        assert!(radius >= 0.0, "a radius is not negative");
        // Subnormals are lifted, so that what follows is exact.
        let (lift, exponent) = if number.abs().max(radius) < 1.0 {
            (2f64.powi(600), -600)
        } else {
            (1.0, 0)
        };
        ScaledBall {
            mantissa: Double::from(number * lift),
            radius: radius * lift,
            exponent,
        }
        .normal()
    }

    const ZERO: ScaledBall = ScaledBall {
        mantissa: Double {
            high: 0.0,
            low: 0.0,
        },
        radius: 0.0,
        exponent: 0,
    };

    /// Moves mantissa or radius, the larger, to between 1 and 2.
    fn normal(self) -> ScaledBall {
        let size = self.mantissa.high.abs().max(self.radius);
        if size == 0.0 {
            return ScaledBall::ZERO;
        }
        let power = i64::from((size.to_bits() >> 52 & 0x7ff) as u32) - 1023;
        self.shifted(-power)
    }

    /// The same with another exponent: the mantissa times a power of two.
    fn shifted(self, power: i64) -> ScaledBall {
        let scale = |number: f64| {
            let half = power / 2;
            number * 2f64.powi(half as i32) * 2f64.powi((power - half) as i32)
        };
        ScaledBall {
            mantissa: Double {
                high: scale(self.mantissa.high),
                low: scale(self.mantissa.low),
            },
            // A radius that is not zero does not become it.
            radius: if self.radius > 0.0 {
                scale(self.radius).max(f64::MIN_POSITIVE)
            } else {
                0.0
            },
            exponent: self.exponent - power,
        }
    }

    /// The ball in the unit of a larger exponent.
    fn in_unit(self, exponent: i64) -> ScaledBall {
        let distance = exponent - self.exponent;
        if distance <= FAR {
            return self.shifted(-distance);
        }
        let radius = if self.is_exact_zero() {
            0.0
        } else {
            // Mantissa and radius are below 2 each.
            2f64.powi(2 - FAR as i32)
        };
        ScaledBall {
            mantissa: Double::default(),
            radius,
            exponent,
        }
    }

    fn is_exact_zero(self) -> bool {
        self.mantissa.high == 0.0 && self.radius == 0.0
    }

    /// True when both are binary64 numbers times a power of two.
    fn both_short(self, other: ScaledBall) -> bool {
        self.mantissa.low == 0.0 && other.mantissa.low == 0.0
    }

    /// The sum.
    pub(super) fn plus(self, other: ScaledBall) -> ScaledBall {
        if self.is_exact_zero() {
            return other;
        }
        if other.is_exact_zero() {
            return self;
        }
        let exponent = self.exponent.max(other.exponent);
        let (a, b) = (self.in_unit(exponent), other.in_unit(exponent));
        let mantissa = a.mantissa + b.mantissa;
        let error = if self.both_short(other) && a.radius + b.radius == 0.0 {
            0.0
        } else {
            mantissa.high.abs() * SUM
        };
        ScaledBall {
            mantissa,
            radius: (a.radius + b.radius + error) * UP,
            exponent,
        }
        .normal()
    }

    /// The opposite.
    pub(super) fn negative(self) -> ScaledBall {
        ScaledBall {
            mantissa: -self.mantissa,
            ..self
        }
    }

    /// The product.
    pub(super) fn times(self, other: ScaledBall) -> ScaledBall {
        let mantissa = self.mantissa * other.mantissa;
        let (a, b) = (
            self.mantissa.high.abs() * UP,
            other.mantissa.high.abs() * UP,
        );
        let spread = a * other.radius + b * self.radius + self.radius * other.radius;
        let error = match self.both_short(other) && self.radius + other.radius == 0.0 {
            true => 0.0,
            // A mantissa is tiny only beside a radius.
            false => mantissa.high.abs() * PRODUCT + f64::MIN_POSITIVE,
        };
        ScaledBall {
            mantissa,
            radius: (spread + error) * UP,
            exponent: self.exponent + other.exponent,
        }
        .normal()
    }

    /// The quotient; `None` when the divisor can be zero.
    pub(super) fn over(self, other: ScaledBall) -> Option<ScaledBall> {
        if other.has_zero() {
            return None;
        }
        // Without zero its mantissa is the larger, between 1 and 2.
        let mantissa = self.mantissa / other.mantissa;
        let quotient = mantissa.high.abs() * UP;
        let least = (other.mantissa.high.abs() - other.radius) / UP;
        if least <= 0.0 {
            return None;
        }
        let spread = (self.radius + quotient * other.radius) / least;
        let error = if self.is_exact_zero() {
            0.0
        } else {
            quotient * QUOTIENT + f64::MIN_POSITIVE
        };
        Some(
            ScaledBall {
                mantissa,
                radius: (spread + error) * UP,
                exponent: self.exponent - other.exponent,
            }
            .normal(),
        )
    }

    /// The square root of a ball that holds positive numbers only.
    pub(super) fn root(self) -> ScaledBall {
        let even = match self.exponent.rem_euclid(2) {
            0 => self,
            _ => self.shifted(1),
        };
        let mantissa = DoubleDouble.sqrt(even.mantissa);
        let radius = even.radius / mantissa.high + mantissa.high * QUOTIENT;
        ScaledBall {
            mantissa,
            radius: radius * UP,
            exponent: even.exponent / 2,
        }
        .normal()
    }

    /// The sine, or the cosine.
    fn wave(self, cosine: bool) -> ScaledBall {
        let unknown = ScaledBall::between(0.0, 1.0);
        let half = |number: f64| number * 2f64.powi(self.exponent.clamp(-900, 100) as i32);
        if self.exponent > 20 || half(self.mantissa.high).abs() > LARGEST_ANGLE {
            return unknown;
        }
        if self.is_exact_zero() {
            return ScaledBall::exact(if cosine { 1.0 } else { 0.0 });
        }
        if self.exponent < -FAR {
            // Beside 1 the square of the angle is nothing, and the sine is
            // the angle.
            return if cosine {
                ScaledBall::between(1.0, 2f64.powi(-FAR as i32))
            } else {
                ScaledBall {
                    radius: self.radius + 2f64.powi(-FAR as i32),
                    ..self
                }
            };
        }
        let angle = Double {
            high: half(self.mantissa.high),
            low: half(self.mantissa.low),
        };
        let mantissa = if cosine {
            DoubleDouble.cos(angle)
        } else {
            DoubleDouble.sin(angle)
        };
        ScaledBall {
            mantissa,
            // Neither function is steeper than 1.
            radius: (half(self.radius) + SINE) * UP,
            exponent: 0,
        }
        .normal()
    }

    pub(super) fn sine(self) -> ScaledBall {
        self.wave(false)
    }

    pub(super) fn cosine(self) -> ScaledBall {
        self.wave(true)
    }

    /// True when the number can be zero.
    pub(super) fn has_zero(self) -> bool {
        self.mantissa.high.abs() <= self.radius * UP
    }

    /// 1 or −1 when the number has that sign for certain, else 0.
    pub(super) fn sign(self) -> i32 {
        match self.has_zero() {
            true => 0,
            false if self.mantissa.high > 0.0 => 1,
            false => -1,
        }
    }

    /// True when the balls have no number in common.
    pub(super) fn is_apart_from(self, other: ScaledBall) -> bool {
        !self.plus(other.negative()).has_zero()
    }

    /// The middle as a binary64 number; infinite beyond its range.
    pub(super) fn middle(self) -> f64 {
        // Far beyond the range of binary64, and small enough for `i32`.
        let exponent = self.exponent.clamp(-4000, 4000) as i32;
        // Adding zero turns -0 into 0: people are shown one zero only.
        times_power_of_two(self.mantissa.high, exponent) + 0.0
    }

    /// The binary logarithm of the largest absolute value, rounded up.
    pub(super) fn log_size(self) -> i64 {
        if self.is_exact_zero() {
            i64::MIN / 4
        } else {
            self.exponent + 2
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use astro_float::{BigFloat, Consts, RoundingMode};
    use robovec_num::random::Random;

    const BITS: usize = 1024;
    const NEAREST: RoundingMode = RoundingMode::ToEven;

    fn big(number: f64) -> BigFloat {
        BigFloat::from_f64(number, BITS)
    }

    /// Ends of a ball; of numbers in the range of binary64.
    fn holds(ball: ScaledBall, exact: &BigFloat, what: &str) {
        let scale = big(2.0).powi(ball.exponent.unsigned_abs() as usize, BITS, NEAREST);
        let scaled = |number: &BigFloat| {
            if ball.exponent < 0 {
                number.div(&scale, BITS, NEAREST)
            } else {
                number.mul(&scale, BITS, NEAREST)
            }
        };
        let middle = big(ball.mantissa.high).add(&big(ball.mantissa.low), BITS, NEAREST);
        let distance = scaled(&middle).sub(exact, BITS, NEAREST).abs();
        let radius = scaled(&big(ball.radius));
        assert!(distance <= radius, "{what}: {ball:?}");
        assert!(ball.radius < 1e-24, "{what}: {ball:?} is tight");
    }

    #[test]
    fn balls_hold_what_they_are_balls_of() {
        let mut random = Random::new(1);
        let mut constants = Consts::new().expect("memory");
        for _ in 0..400 {
            let [a, b] = [0; 2].map(|_| random.log_uniform(-12, 12));
            let (x, y) = (ScaledBall::exact(a), ScaledBall::exact(b));
            let (u, v) = (big(a), big(b));
            holds(x.plus(y), &u.add(&v, BITS, NEAREST), "sum");
            holds(x.times(y), &u.mul(&v, BITS, NEAREST), "product");
            let ratio = x.over(y).expect("not zero");
            let quotient = u.div(&v, BITS, NEAREST);
            holds(ratio, &quotient, "quotient");
            let both = ratio.times(ratio).plus(x);
            let exact = quotient
                .mul(&quotient, BITS, NEAREST)
                .add(&u, BITS, NEAREST);
            if both.mantissa.high.abs() > 0.01 {
                holds(both, &exact, "a sum of a product");
            }
            let size = u.abs();
            holds(
                ScaledBall::exact(a.abs()).root(),
                &size.sqrt(BITS, NEAREST),
                "root",
            );
            let sine = u.sin(BITS, NEAREST, &mut constants);
            let cosine = u.cos(BITS, NEAREST, &mut constants);
            holds(x.sine(), &sine, "sine");
            holds(x.cosine(), &cosine, "cosine");
        }
    }

    #[test]
    fn small_numbers_are_exact_and_nothing_overflows() {
        let [two, three] = [2.0, 3.0].map(ScaledBall::exact);
        let six = two.times(three);
        assert_eq!(six, ScaledBall::exact(6.0));
        assert_eq!(six.plus(ScaledBall::exact(-6.0)), ScaledBall::ZERO);
        assert_eq!(two.over(ScaledBall::ZERO), None);
        let huge = ScaledBall::exact(1e300);
        let square = huge.times(huge);
        assert_eq!(square.middle(), f64::INFINITY);
        assert_eq!(square.root().middle(), 1e300);
        assert!(!square.root().is_apart_from(huge));
        assert!(square.root().is_apart_from(huge.negative()));
        let tiny = ScaledBall::exact(5e-324);
        assert_eq!(tiny.times(tiny).root().middle(), 5e-324);
        assert_eq!(tiny.times(tiny).sign(), 1);
        let sum = huge.plus(tiny);
        assert!(
            !sum.is_apart_from(huge),
            "only error is left of the small term"
        );
        assert!(sum.plus(huge.negative()).has_zero());
    }

    #[test]
    fn what_is_not_known_is_in_the_radius() {
        let wide = ScaledBall::between(1.0, 0.5);
        assert_eq!(wide.sign(), 1);
        assert_eq!(wide.plus(wide.negative()).sign(), 0);
        assert!(wide.over(ScaledBall::between(0.25, 0.5)).is_none());
        assert!(ScaledBall::exact(1e9).sine().has_zero());
        assert!(!wide.is_apart_from(ScaledBall::exact(1.4)));
        assert!(wide.is_apart_from(ScaledBall::exact(1.6)));
    }
}
