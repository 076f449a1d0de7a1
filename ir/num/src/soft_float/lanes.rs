//! Arithmetic in any number format for several states at once.
//!
//! What is done is decided once for all lanes, and no operation branches on a
//! single lane, so that a compiler can keep several lanes in one register of
//! the processor. One test over all lanes finds the special cases (overflow,
//! subnormal numbers, NaN, formats near binary64); the operation is then
//! repeated lane by lane with [`FormatArithmetic`]. Both ways give the same
//! bits.

use super::odd::{self, is_tame, odd};
use super::rounding::{FixedRounding, FloatRounding, Rounding};
use super::{FormatArithmetic, RoundingMethod};
use crate::arithmetic::Arithmetic;
use crate::double_double::product_error;
use std::array;

/// The arithmetic of one format on `LANES` numbers at a time.
#[derive(Clone, Copy, Debug)]
pub struct FormatLanes<const LANES: usize>(pub FormatArithmetic);

impl<const LANES: usize> FormatLanes<LANES> {
    /// Results rounded into the format, all of them or, where one is special,
    /// by `single` from the number of the lane.
    #[inline]
    fn rounded(&self, results: [f64; LANES], single: impl Fn(usize) -> f64) -> [f64; LANES] {
        let rounded = match &self.0.rounding {
            Rounding::Float(float) => float.round_lanes(results),
            Rounding::Fixed(fixed) => fixed.round_lanes(results),
        };
        rounded.unwrap_or_else(|| array::from_fn(single))
    }

    /// `a + b` rounded to odd where the format needs it.
    #[inline]
    fn sum(&self, a: [f64; LANES], b: [f64; LANES], single: impl Fn(usize) -> f64) -> [f64; LANES] {
        let plain = || array::from_fn(|lane| a[lane] + b[lane]);
        match self.0.method {
            RoundingMethod::Binary64 => plain(),
            RoundingMethod::Binary32 => plain().map(|sum: f64| f64::from(sum as f32)),
            RoundingMethod::Twice | RoundingMethod::Binary64Flushed => {
                self.rounded(plain(), single)
            }
            RoundingMethod::Once if self.0.rounding.is_narrow() => {
                let sums = array::from_fn(|lane| odd::odd_sum(a[lane], b[lane]));
                self.rounded(sums, single)
            }
            RoundingMethod::Once => array::from_fn(single),
        }
    }
}

impl<const LANES: usize> Arithmetic for FormatLanes<LANES> {
    type Number = [f64; LANES];

    fn literal(&self, number: f64) -> Self::Number {
        [self.0.literal(number); LANES]
    }
    #[inline]
    fn neg(&self, a: Self::Number) -> Self::Number {
        array::from_fn(|lane| self.0.neg(a[lane]))
    }
    #[inline]
    fn add(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        self.sum(a, b, |lane| self.0.add(a[lane], b[lane]))
    }
    #[inline]
    fn sub(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        self.sum(a, b.map(|number| -number), |lane| {
            self.0.sub(a[lane], b[lane])
        })
    }
    #[inline]
    fn mul(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        let single = |lane: usize| self.0.mul(a[lane], b[lane]);
        let plain: [f64; LANES] = array::from_fn(|lane| a[lane] * b[lane]);
        match self.0.method {
            RoundingMethod::Binary64 => plain,
            RoundingMethod::Binary32 => plain.map(|product| f64::from(product as f32)),
            RoundingMethod::Twice => self.rounded(plain, single),
            RoundingMethod::Once if self.0.rounding.is_narrow() => {
                let errors: [f64; LANES] =
                    array::from_fn(|lane| product_error(a[lane], b[lane], plain[lane]));
                // Factors that are too large to be split have an error of NaN.
                let are_exact = plain
                    .iter()
                    .fold(true, |all, &number| all & is_tame(number));
                if !are_exact || !total(errors).is_finite() {
                    return array::from_fn(single);
                }
                let products = array::from_fn(|lane| odd(plain[lane], errors[lane]));
                self.rounded(products, single)
            }
            RoundingMethod::Binary64Flushed | RoundingMethod::Once => array::from_fn(single),
        }
    }
    fn div(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        array::from_fn(|lane| self.0.div(a[lane], b[lane]))
    }
    fn sin(&self, a: Self::Number) -> Self::Number {
        a.map(|number| self.0.sin(number))
    }
    fn cos(&self, a: Self::Number) -> Self::Number {
        a.map(|number| self.0.cos(number))
    }
    fn sqrt(&self, a: Self::Number) -> Self::Number {
        a.map(|number| self.0.sqrt(number))
    }
    #[inline]
    fn fma(&self, a: Self::Number, b: Self::Number, c: Self::Number) -> Self::Number {
        let single = |lane: usize| self.0.fma(a[lane], b[lane], c[lane]);
        match self.0.method {
            // The product is exact.
            RoundingMethod::Twice => {
                let sums = array::from_fn(|lane| odd::odd_sum(a[lane] * b[lane], c[lane]));
                self.rounded(sums, single)
            }
            _ => array::from_fn(single),
        }
    }

    // As for [`FormatArithmetic`], a negative operand must not be rounded.
    #[inline]
    fn fms(&self, a: Self::Number, b: Self::Number, c: Self::Number) -> Self::Number {
        self.fma(a, b, c.map(|number| -number))
    }
    #[inline]
    fn fnma(&self, a: Self::Number, b: Self::Number, c: Self::Number) -> Self::Number {
        self.fma(a.map(|number| -number), b, c)
    }
}

impl FloatRounding {
    /// The nearest numbers of the format to normal numbers that do not
    /// overflow, and to zeros; `None` with any other.
    #[inline]
    fn round_lanes<const LANES: usize>(&self, numbers: [f64; LANES]) -> Option<[f64; LANES]> {
        let rounded = numbers.map(|number| f64::from_bits(self.drop_bits(number.to_bits())));
        let mut least = self.least;
        for number in numbers {
            let size = number.abs();
            let size = if size == 0.0 { self.least } else { size };
            least = if size < least { size } else { least };
        }
        let are_plain = least >= self.least && total(numbers) <= self.largest;
        are_plain.then_some(rounded)
    }
}

impl FixedRounding {
    /// The nearest numbers of the format to numbers within its range; `None`
    /// with any other.
    #[inline]
    fn round_lanes<const LANES: usize>(&self, numbers: [f64; LANES]) -> Option<[f64; LANES]> {
        let rounded = numbers.map(|number| {
            let size = (number.abs() + self.shift) - self.shift;
            // The sum turns a negative zero into the only zero there is.
            size.copysign(number) + 0.0
        });
        let size = total(numbers);
        let are_plain = size <= self.highest && size < self.shift;
        are_plain.then_some(rounded)
    }
}

/// The sum of all sizes: at least the largest of them, and NaN if one is.
#[inline]
fn total<const LANES: usize>(numbers: [f64; LANES]) -> f64 {
    numbers.iter().fold(0.0, |sum, number| sum + number.abs())
}
