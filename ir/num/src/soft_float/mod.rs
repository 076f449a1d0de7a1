//! Arithmetic in any number format, bit for bit.
//!
//! The numbers of every format up to binary64 are stored as binary64 numbers:
//! formats need no conversion, and an operation of one format reads the results
//! of another unchanged. Formats differ only in how an exact result is rounded
//! ([`rounding`]).
//!
//! An operation is rounded once, in the fastest of these ways that is correct:
//!
//! - the hardware's own operation, for binary32 and binary64;
//! - the hardware's binary64 operation, rounded a second time: harmless for
//!   operands of at most 25 bits (Figueroa, "When is double rounding
//!   innocuous?", 1995), a product of such factors being exact at all;
//! - the binary64 result rounded *to odd* ([`odd`]), which keeps what a second
//!   rounding needs to know for formats with up to 51 bits (Boldo and
//!   Melquiond, "Emulation of a FMA and correctly rounded sums: proved
//!   algorithms using rounding to odd", 2008);
//! - integers of 128 bits ([`exact`]) for the formats just below binary64 and
//!   wherever binary64 itself would overflow or underflow.
//!
//! Sine and cosine are those of binary64 rounded once, as a host that
//! prepares inputs would compute them.
//!
//! **Flushing** (`subnormals = false`): a number below the smallest normal one
//! becomes a zero with its sign. Results are judged before they are rounded,
//! which is the cheaper test in hardware; conversions after it. Sums that small
//! are exact, so only products and quotients can show the difference.
//!
//! **Fixed point** has neither infinities nor NaN, and only one zero. Results
//! beyond the range saturate. An infinite result saturates too, so a quotient
//! by zero is the largest number with the dividend's sign (zero counts as
//! positive); a NaN becomes zero: `0/0`, the root of a negative number, and a
//! NaN from outside.

mod exact;
mod lanes;
mod odd;
mod rounding;
#[cfg(test)]
mod tests;
mod word;

use crate::NumberFormat;
use crate::arithmetic::Arithmetic;
use crate::format::Format;
pub use lanes::FormatLanes;
use rounding::Rounding;

/// The arithmetic of one format.
///
/// Operands are numbers of the format (of any format after
/// [`FormatArithmetic::mixed`]); so are results. NaN may have any payload.
#[derive(Clone, Copy, Debug)]
pub struct FormatArithmetic {
    format: Format,
    method: RoundingMethod,
    rounding: Rounding,
}

/// The method that reaches the result with one rounding.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum RoundingMethod {
    /// The hardware's binary32.
    Binary32,
    /// The hardware's binary64.
    Binary64,
    /// The hardware's binary64, and small results become zero.
    Binary64Flushed,
    /// The hardware's binary64 rounded once more.
    Twice,
    /// Rounding to odd, or integers.
    Once,
}

/// The maximum number of mantissa bits for which two roundings are as good as
/// one.
const TWICE_MANTISSA: u32 = 24;
/// The maximum number of exponent bits for which neither products nor quotients
/// leave the normal range of binary64.
const TWICE_EXPONENT: u32 = 9;

impl FormatArithmetic {
    /// The arithmetic of a format, for operands of that format.
    pub fn new(format: Format) -> FormatArithmetic {
        let method = match format {
            Format::BINARY32 => RoundingMethod::Binary32,
            Format::Float(NumberFormat {
                exponent, mantissa, ..
            }) if exponent <= TWICE_EXPONENT && mantissa <= TWICE_MANTISSA => RoundingMethod::Twice,
            _ => RoundingMethod::for_any_operands(format),
        };
        FormatArithmetic {
            format,
            method,
            rounding: Rounding::new(format),
        }
    }

    /// Arithmetic on operands of any formats, whose exact result is rounded
    /// into this one.
    pub fn mixed(format: Format) -> FormatArithmetic {
        FormatArithmetic {
            format,
            method: RoundingMethod::for_any_operands(format),
            rounding: Rounding::new(format),
        }
    }

    /// The format of the results.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The nearest number of the format, ties to even: the conversion of
    /// literals and inputs.
    #[inline]
    pub fn convert(&self, number: f64) -> f64 {
        match self.method {
            RoundingMethod::Binary64 => number,
            _ => self.rounding.round(number),
        }
    }

    /// The hardware's result where it is correct; `general` elsewhere.
    #[inline(always)]
    fn choose<const COUNT: usize>(
        &self,
        operands: [f64; COUNT],
        binary32: impl Fn([f32; COUNT]) -> f32,
        binary64: impl Fn([f64; COUNT]) -> f64,
        general: impl Fn([f64; COUNT], &Rounding) -> f64,
    ) -> f64 {
        match self.method {
            RoundingMethod::Binary32 => f64::from(binary32(operands.map(|number| number as f32))),
            RoundingMethod::Binary64 => binary64(operands),
            RoundingMethod::Binary64Flushed | RoundingMethod::Twice => {
                self.rounding.round_result(binary64(operands))
            }
            RoundingMethod::Once => general(operands, &self.rounding),
        }
    }
}

impl RoundingMethod {
    fn for_any_operands(format: Format) -> RoundingMethod {
        match format {
            Format::BINARY64 => RoundingMethod::Binary64,
            Format::Float(NumberFormat {
                exponent: 11,
                mantissa: 52,
                ..
            }) => RoundingMethod::Binary64Flushed,
            _ => RoundingMethod::Once,
        }
    }
}

impl Arithmetic for FormatArithmetic {
    type Number = f64;

    fn literal(&self, number: f64) -> f64 {
        self.convert(number)
    }
    #[inline]
    fn neg(&self, a: f64) -> f64 {
        // Exact but for the least number of a fixed-point format, and for
        // operands of other formats.
        self.convert(-a)
    }
    #[inline]
    fn add(&self, a: f64, b: f64) -> f64 {
        self.choose([a, b], |[a, b]| a + b, |[a, b]| a + b, odd::sum)
    }
    #[inline]
    fn sub(&self, a: f64, b: f64) -> f64 {
        let difference = |[a, b]: [f64; 2], rounding: &Rounding| odd::sum([a, -b], rounding);
        self.choose([a, b], |[a, b]| a - b, |[a, b]| a - b, difference)
    }
    #[inline]
    fn mul(&self, a: f64, b: f64) -> f64 {
        match self.method {
            RoundingMethod::Twice => self.rounding.round_result(a * b),
            RoundingMethod::Binary64Flushed => odd::flushed_product(a, b, &self.rounding),
            _ => self.choose([a, b], |[a, b]| a * b, |[a, b]| a * b, odd::product),
        }
    }
    #[inline]
    fn div(&self, a: f64, b: f64) -> f64 {
        match self.method {
            // Binary64's own result may have been rounded up to the least
            // normal number.
            RoundingMethod::Binary64Flushed => odd::quotient([a, b], &self.rounding),
            _ => self.choose([a, b], |[a, b]| a / b, |[a, b]| a / b, odd::quotient),
        }
    }
    fn sin(&self, a: f64) -> f64 {
        self.convert(a.sin())
    }
    fn cos(&self, a: f64) -> f64 {
        self.convert(a.cos())
    }
    #[inline]
    fn sqrt(&self, a: f64) -> f64 {
        self.choose([a], |[a]| a.sqrt(), |[a]| a.sqrt(), odd::root)
    }
    #[inline]
    fn fma(&self, a: f64, b: f64, c: f64) -> f64 {
        match self.method {
            // The product is exact, so this is a sum of two numbers.
            RoundingMethod::Twice => odd::sum([a * b, c], &self.rounding),
            // Binary64's own result may have been rounded up to the least
            // normal number.
            RoundingMethod::Binary64Flushed => odd::fused([a, b, c], &self.rounding),
            _ => self.choose(
                [a, b, c],
                |[a, b, c]| a.mul_add(b, c),
                |[a, b, c]| a.mul_add(b, c),
                odd::fused,
            ),
        }
    }

    // A negative operand need not be a number of the format, so it must not
    // go through `neg`, which rounds.
    #[inline]
    fn fms(&self, a: f64, b: f64, c: f64) -> f64 {
        self.fma(a, b, -c)
    }
    #[inline]
    fn fnma(&self, a: f64, b: f64, c: f64) -> f64 {
        self.fma(-a, b, c)
    }
}
