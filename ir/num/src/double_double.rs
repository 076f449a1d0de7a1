//! Double-double arithmetic: about 106 bits, the reference for rounding errors.
//!
//! A number is the unevaluated sum of two binary64 numbers, the second at
//! most half a unit in the last place of the first. Operations are built from
//! error-free transformations (Dekker 1971, Knuth 1969) and follow the
//! algorithms whose relative error Joldes, Muller and Popescu proved ("Tight
//! and rigorous error bounds for basic building blocks of double-word
//! arithmetic", 2017): a few times 2⁻¹⁰⁶, cancellation included. That leaves
//! some 50 bits to spare over the binary64 results it judges.
//!
//! Limits, all inherited from the exponent range of binary64: below about
//! 10⁻²⁹² the second half becomes subnormal and accuracy decreases to that of
//! binary64; an overflow is an infinity without a second half.

mod lanes;

pub use lanes::{DoubleDoubleLanes, DoubleLanes};

use crate::arithmetic::{Arithmetic, by_operators};
use std::sync::LazyLock;

/// Products and quotients below this may have lost bits of their second half
/// to the end of the range.
pub const SMALLEST_WHOLE: f64 = 1e-270;

/// The arithmetic of [`Double`] numbers.
#[derive(Clone, Copy, Default, Debug)]
pub struct DoubleDouble;

/// The sum of a binary64 number and a correction below its last place.
#[derive(Clone, Copy, PartialEq, PartialOrd, Default, Debug)]
pub struct Double {
    /// The number rounded to binary64.
    pub high: f64,
    /// The remainder of the rounding; 0 when `high` is not finite.
    pub low: f64,
}

impl Double {
    const NAN: Double = Double {
        high: f64::NAN,
        low: 0.0,
    };

    /// The difference to a binary64 number, rounded to binary64: the error of a
    /// computed `number` relative to this reference.
    pub fn distance(self, number: f64) -> f64 {
        (self - Double::from(number)).high.abs()
    }

    /// The number times a power of two; exact unless it leaves the range.
    fn scaled(self, power: f64) -> Double {
        Double {
            high: self.high * power,
            low: self.low * power,
        }
    }

    /// The sum of numbers whose error cannot overflow; otherwise its second
    /// half is not finite.
    #[inline]
    fn near_sum(self, other: Double) -> Double {
        let sum = two_sum(self.high, other.high);
        let rest = two_sum(self.low, other.low);
        let joined = fast_two_sum(sum.high, sum.low + rest.high);
        fast_two_sum(joined.high, joined.low + rest.low)
    }

    /// A sum with an intermediate result that is not finite: an infinity or NaN
    /// was added, or numbers near the largest ones, whose error can overflow
    /// although the sum does not.
    #[cold]
    fn far_sum(self, other: Double) -> Double {
        let sum = self.high + other.high;
        if !sum.is_finite() {
            return Double::from(sum);
        }
        // What sinks below the range by this is nothing beside such numbers.
        let number = self.scaled(0.0625).near_sum(other.scaled(0.0625));
        let number = number.scaled(16.0);
        if number.low.is_finite() {
            number
        } else {
            Double::from(number.high)
        }
    }

    fn sqrt(self) -> Double {
        if self.high < 0.0 || self.high.is_nan() {
            return Double::NAN;
        }
        if self.high == 0.0 || self.high == f64::INFINITY {
            return Double::from(self.high.sqrt());
        }
        // Moved by an even power of two, so that no square under- or
        // overflows and the root moves by half the power.
        if self.high < TINY {
            return self.scaled(2f64.powi(400)).sqrt().scaled(2f64.powi(-200));
        }
        if self.high > HUGE {
            return self.scaled(2f64.powi(-400)).sqrt().scaled(2f64.powi(200));
        }
        let root = self.high.sqrt();
        let (square, error) = two_product(root, root);
        let rest = self
            - Double {
                high: square,
                low: error,
            };
        fast_two_sum(root, rest.high / (2.0 * root))
    }
}

/// Bounds between which products and quotients can be formed without
/// spurious under- or overflow of the error terms.
const TINY: f64 = 1e-240;
const HUGE: f64 = 1e240;

impl From<f64> for Double {
    fn from(number: f64) -> Double {
        Double {
            high: number,
            low: 0.0,
        }
    }
}

impl std::ops::Neg for Double {
    type Output = Double;

    #[inline]
    fn neg(self) -> Double {
        Double {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl std::ops::Add for Double {
    type Output = Double;

    #[inline]
    fn add(self, other: Double) -> Double {
        let number = self.near_sum(other);
        if number.low.is_finite() {
            number
        } else {
            self.far_sum(other)
        }
    }
}

impl std::ops::Sub for Double {
    type Output = Double;

    #[inline]
    fn sub(self, other: Double) -> Double {
        self + -other
    }
}

impl std::ops::Mul for Double {
    type Output = Double;

    #[inline]
    fn mul(self, other: Double) -> Double {
        let (high, error) = two_product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        let number = fast_two_sum(high, error + cross);
        match number.low.is_finite() {
            true => number,
            // What rounds beyond the largest number has no second half.
            false if high.is_finite() => Double::from(f64::INFINITY.copysign(high)),
            false => Double::from(high),
        }
    }
}

impl std::ops::Div for Double {
    type Output = Double;

    fn div(self, other: Double) -> Double {
        let quotient = self.high / other.high;
        if quotient == 0.0 || !quotient.is_finite() || other.high.is_infinite() {
            return Double::from(quotient);
        }
        // As for the square root: the remainders below are as small as 2⁻¹⁰⁶
        // of the dividend and must not sink into the subnormals.
        let moved = |number: f64| match number.abs() {
            size if size < TINY => 2f64.powi(400),
            size if size > HUGE => 2f64.powi(-400),
            _ => 1.0,
        };
        let (above, below) = (moved(self.high), moved(other.high));
        if (above, below) != (1.0, 1.0) {
            let ratio = self.scaled(above) / other.scaled(below);
            return ratio.scaled(below).scaled(1.0 / above);
        }
        let rest = self - other * Double::from(quotient);
        let second = rest.high / other.high;
        let rest = rest - other * Double::from(second);
        let third = rest.high / other.high;
        let first = fast_two_sum(quotient, second);
        first + Double::from(third)
    }
}

/// The sum and its rounding error, exactly.
#[inline]
fn two_sum(a: f64, b: f64) -> Double {
    let sum = a + b;
    let part = sum - a;
    Double {
        high: sum,
        low: (a - (sum - part)) + (b - part),
    }
}

/// As [`two_sum`], when `a` is the larger or zero.
#[inline]
fn fast_two_sum(a: f64, b: f64) -> Double {
    let sum = a + b;
    Double {
        high: sum,
        low: b - (sum - a),
    }
}

/// The product and its rounding error, exactly unless the error is below the
/// smallest subnormal; the error is 0 when the product is not finite.
///
/// A fused multiply-add gives the error at once, but without the processor's
/// own instruction it is a library call several times slower than splitting
/// the factors; both give the same bits.
#[inline]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let error = if cfg!(target_feature = "fma") {
        a.mul_add(b, -product)
    } else {
        product_error(a, b, product)
    };
    if error.is_finite() {
        (product, error)
    } else {
        (product, large_product_error(a, b, product))
    }
}

/// The error of a product whose factors could not be split: splitting
/// multiplies by 2²⁷ + 1 and overflows for numbers near the largest.
#[cold]
fn large_product_error(a: f64, b: f64, product: f64) -> f64 {
    if !product.is_finite() {
        return 0.0;
    }
    let (down, up) = (2f64.powi(-200), 2f64.powi(200));
    let (small, large) = if a.abs() < b.abs() { (a, b) } else { (b, a) };
    product_error(small, large * down, product * down) * up
}

/// Dekker's product: the error of `product` from the halves of the factors.
#[inline]
pub(crate) fn product_error(a: f64, b: f64, product: f64) -> f64 {
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
}

/// The upper 26 bits of a mantissa and the rest (Veltkamp).
#[inline]
fn split(a: f64) -> (f64, f64) {
    let shifted = 134_217_729.0 * a;
    let high = shifted - (shifted - a);
    (high, a - high)
}

/// π/2 as a sum of four binary64 numbers, 212 bits.
const HALF_PI: [f64; 4] = [
    std::f64::consts::FRAC_PI_2,
    6.123233995736766e-17,
    -1.4973849048591698e-33,
    5.562271104316826e-50,
];

/// Beyond this an angle cannot be reduced with [`HALF_PI`] to full accuracy.
const LARGEST_ANGLE: f64 = 1e15;

/// The angle less the nearest multiple of π/2, and that multiple modulo 4;
/// `None` for angles that are not finite or beyond [`LARGEST_ANGLE`].
fn quadrant(angle: Double) -> Option<(Double, u64)> {
    if !angle.high.is_finite() || angle.high.abs() > LARGEST_ANGLE {
        return None;
    }
    let count = (angle.high / HALF_PI[0]).round();
    let mut rest = angle;
    for part in HALF_PI {
        let (high, low) = two_product(count, part);
        rest = rest - Double { high, low };
    }
    Some((rest, (count as i64).rem_euclid(4) as u64))
}

/// The terms of the series: the first one left out is below 2⁻¹⁰⁷ of the
/// result for angles up to π/4.
const TERMS: u32 = 14;

/// The coefficients of the Taylor series in the square of the angle, by falling
/// powers: of the cosine, and of the sine over the angle. Quotients are by far
/// the slowest operation, so that they are taken once.
static COEFFICIENTS: LazyLock<[Vec<Double>; 2]> = LazyLock::new(|| {
    [1, 2].map(|first| {
        let mut coefficients = vec![Double::from(1.0)];
        for term in 0..TERMS {
            let k = f64::from(first + 2 * term);
            let last = *coefficients.last().expect("the first is 1");
            coefficients.push(-last / Double::from(k * (k + 1.0)));
        }
        coefficients.reverse();
        coefficients
    })
});

/// The Taylor series of the cosine of `x` for `odd = 0`, and of its sine over
/// `x` for `odd = 1`, by Horner's rule.
fn series(square: Double, odd: usize) -> Double {
    let terms = COEFFICIENTS[odd].iter();
    terms.fold(Double::default(), |sum, &term| sum * square + term)
}

/// The sine of an angle plus a number of quarter turns.
fn sine(angle: Double, quarter_turns: u64) -> Double {
    let Some((rest, quadrant)) = quadrant(angle) else {
        return Double::NAN;
    };
    let square = rest * rest;
    let result = match (quadrant + quarter_turns) % 2 {
        0 if rest.high == 0.0 => rest,
        0 => rest * series(square, 1),
        _ => series(square, 0),
    };
    match (quadrant + quarter_turns) % 4 {
        0 | 1 => result,
        _ => -result,
    }
}

impl Arithmetic for DoubleDouble {
    type Number = Double;

    fn literal(&self, number: f64) -> Double {
        Double::from(number)
    }
    by_operators!();
    /// NaN for angles beyond 10¹⁵.
    fn sin(&self, a: Double) -> Double {
        sine(a, 0)
    }
    /// NaN for angles beyond 10¹⁵.
    fn cos(&self, a: Double) -> Double {
        sine(a, 1)
    }
    fn sqrt(&self, a: Double) -> Double {
        a.sqrt()
    }
    /// Two roundings: as a reference the number has bits to spare for both.
    fn fma(&self, a: Double, b: Double, c: Double) -> Double {
        a * b + c
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{mix, unit};
    use astro_float::{BigFloat, Consts, RoundingMode};

    /// Enough for exact sums of numbers some 900 powers of two apart.
    const PRECISION: usize = 1152;
    const ROUNDING: RoundingMode = RoundingMode::ToEven;

    fn big(number: Double) -> BigFloat {
        let half = |number| BigFloat::from_f64(number, PRECISION);
        half(number.high).add(&half(number.low), PRECISION, ROUNDING)
    }

    /// Asserts that the relative error is at most 2 to the power `bits`.
    fn assert_close(computed: Double, exact: &BigFloat, bits: i32, what: &str) {
        let error = big(computed).sub(exact, PRECISION, ROUNDING);
        if error.is_zero() {
            return;
        }
        assert!(!exact.is_zero(), "{what}: {computed:?} is not 0");
        let ratio = error.div(exact, PRECISION, ROUNDING);
        let exponent = ratio.exponent().expect("it is finite");
        assert!(exponent <= bits, "{what}: error 2^{exponent}, {computed:?}");
    }

    /// Random numbers of random sizes with both halves filled.
    struct Numbers(u64);

    impl Numbers {
        fn unit(&mut self) -> f64 {
            self.0 += 1;
            unit(mix(self.0)) - 0.5
        }

        fn next(&mut self, exponents: i32) -> Double {
            let exponent = (self.unit() * 2.0 * f64::from(exponents)) as i32;
            let high = self.unit() * 2f64.powi(exponent);
            let low = self.unit() * high * 2f64.powi(-52);
            fast_two_sum(high, low)
        }
    }

    #[test]
    fn the_four_operations_and_the_root_keep_103_bits() {
        let mut numbers = Numbers(0);
        for exponents in [1, 40, 200] {
            for _ in 0..1500 {
                let (a, b) = (numbers.next(exponents), numbers.next(exponents));
                let (x, y) = (big(a), big(b));
                assert_close(a + b, &x.add(&y, PRECISION, ROUNDING), -103, "add");
                assert_close(a - b, &x.sub(&y, PRECISION, ROUNDING), -103, "sub");
                assert_close(a * b, &x.mul(&y, PRECISION, ROUNDING), -103, "mul");
                assert_close(a / b, &x.div(&y, PRECISION, ROUNDING), -103, "div");
                let positive = if a.high < 0.0 { -a } else { a };
                let root = big(positive).sqrt(PRECISION, ROUNDING);
                assert_close(positive.sqrt(), &root, -103, "sqrt");
            }
        }
    }

    #[test]
    fn cancellation_loses_nothing() {
        let mut numbers = Numbers(1 << 32);
        for _ in 0..3000 {
            let a = numbers.next(20);
            // A neighbour of `a` that shares up to all of its leading bits.
            let shared = (numbers.unit() * 100.0) as i32 - 53;
            let b = a * Double::from(1.0 + numbers.unit() * 2f64.powi(shared));
            let exact = big(a).sub(&big(b), PRECISION, ROUNDING);
            assert_close(a - b, &exact, -103, "cancelling sub");
        }
    }

    #[test]
    fn sine_and_cosine_keep_100_bits_up_to_100() {
        let mut constants = Consts::new().expect("the cache fits into memory");
        let mut numbers = Numbers(2 << 32);
        let precision = 448;
        let mut check = |angle: Double| {
            let exact = big(angle);
            let sine = exact.sin(precision, ROUNDING, &mut constants);
            let cosine = exact.cos(precision, ROUNDING, &mut constants);
            assert_close(DoubleDouble.sin(angle), &sine, -100, "sin");
            assert_close(DoubleDouble.cos(angle), &cosine, -100, "cos");
        };
        for _ in 0..150 {
            check(Double::from(numbers.unit() * 200.0));
            check(numbers.next(6));
            check(numbers.next(60) * Double::from(1e-10));
        }
        // Next to the zeros of sine and cosine nearly everything cancels.
        for multiple in 0..64 {
            check(Double::from(f64::from(multiple) * HALF_PI[0]));
            check(Double::from(
                f64::from(multiple) * std::f64::consts::FRAC_PI_4,
            ));
        }
        check(Double::from(-100.0));
    }

    #[test]
    fn extremes_stay_finite_and_accurate() {
        for (a, b) in [
            (1e300, 1e-300),
            (1.5e308, 0.75),
            (3e-200, 7e290),
            (1e-120, 1e-119),
            (1.7e308, 1.0),
        ] {
            let (x, y) = (Double::from(a), Double::from(b));
            let product = big(x).mul(&big(y), PRECISION, ROUNDING);
            assert_close(x * y, &product, -100, "mul");
            assert_close(y * x, &product, -100, "mul");
        }
        for (a, b) in [
            (1.7e308, 1.1e300),
            (3e-200, 7e-290),
            (1e-290, 3e-300),
            (1e300, 3e200),
        ] {
            let (x, y) = (Double::from(a), Double::from(b));
            let quotient = big(x).div(&big(y), PRECISION, ROUNDING);
            assert_close(x / y, &quotient, -100, "div");
        }
        for a in [1.7e308, 3e-290, 1e-270, 2e250, 1e-241] {
            let root = big(Double::from(a)).sqrt(PRECISION, ROUNDING);
            assert_close(Double::from(a).sqrt(), &root, -100, "sqrt");
        }
    }

    #[test]
    fn sums_near_the_largest_number_keep_their_second_halves() {
        // On the way to these sums numbers beyond the largest one are met.
        for (a, b) in [
            (f64::MAX, -8e307),
            (-8.123e307, f64::MAX),
            (-1.7976e308, 1.1e308),
            (8e307, 8e307),
        ] {
            let (x, y) = (
                Double {
                    high: a,
                    low: 1e290,
                },
                Double {
                    high: b,
                    low: -3e289,
                },
            );
            for sum in [x + y, y + x] {
                let exact = big(x).add(&big(y), PRECISION, ROUNDING);
                assert_close(sum, &exact, -104, "sum");
            }
        }
    }

    #[test]
    fn infinities_and_nan_follow_binary64() {
        let (zero, one) = (Double::from(0.0), Double::from(1.0));
        let infinity = one / zero;
        assert_eq!(infinity, Double::from(f64::INFINITY));
        assert_eq!(one / infinity, zero);
        assert_eq!(infinity + one, infinity);
        assert_eq!(Double::from(1e300) * Double::from(1e300), infinity);
        assert_eq!(Double::from(1.7e308) + Double::from(1.7e308), infinity);
        assert_eq!(zero.sqrt(), zero);
        assert_eq!(infinity.sqrt(), infinity);
        for undefined in [
            zero / zero,
            infinity - infinity,
            infinity * zero,
            (-one).sqrt(),
            DoubleDouble.sin(infinity),
            DoubleDouble.cos(Double::from(1e16)),
        ] {
            assert!(undefined.high.is_nan(), "{undefined:?}");
        }
        assert_eq!(DoubleDouble.sin(zero), zero);
        assert_eq!(DoubleDouble.cos(zero), one);
    }
}
