//! The one rounding that makes a result a number of its format.

use super::exact::ExactNumber;
use crate::NumberFormat;
use crate::format::{FixedFormat, Format};

/// The maximum number of bits after the leading one for which binary64 rounded
/// to odd carries enough.
const NARROW: u32 = 50;

/// The rounding of numbers into a format.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rounding {
    Float(FloatRounding),
    Fixed(FixedRounding),
}

impl Rounding {
    pub(super) fn new(format: Format) -> Rounding {
        match format {
            Format::Float(format) => Rounding::Float(FloatRounding::new(format)),
            Format::Fixed(format) => Rounding::Fixed(FixedRounding::new(format)),
        }
    }

    /// True when binary64 numbers rounded to odd may be rounded again.
    #[inline]
    pub(super) fn is_narrow(&self) -> bool {
        match self {
            Rounding::Float(float) => float.mantissa <= NARROW as i32,
            Rounding::Fixed(fixed) => fixed.bits <= NARROW,
        }
    }

    /// The nearest number of the format.
    #[inline]
    pub(super) fn round(&self, number: f64) -> f64 {
        match self {
            Rounding::Float(float) => float.round(number),
            Rounding::Fixed(fixed) => fixed.round(number),
        }
    }

    /// As [`Rounding::round`], for the result of an operation: without
    /// subnormal numbers it is judged before it is rounded. The number is the
    /// exact result, or rounded to odd, which never crosses the smallest normal
    /// number.
    #[inline]
    pub(super) fn round_result(&self, number: f64) -> f64 {
        match self {
            Rounding::Float(float) if float.flush && number.abs() < float.least => {
                0f64.copysign(number)
            }
            _ => self.round(number),
        }
    }

    /// The nearest number of the format to the exact result of an operation.
    pub(super) fn round_exact(&self, number: ExactNumber) -> f64 {
        match self {
            Rounding::Float(float) => float.round_exact(number),
            Rounding::Fixed(fixed) => fixed.round_exact(number),
        }
    }
}

/// Rounding into a floating-point format.
#[derive(Clone, Copy, Debug)]
pub(super) struct FloatRounding {
    /// Bits of a binary64 mantissa that the format lacks.
    dropped: u32,
    mantissa: i32,
    /// The exponents of the smallest normal number and of the largest.
    smallest: i32,
    largest_exponent: i32,
    /// The smallest normal number.
    pub(super) least: f64,
    /// The largest finite number.
    pub(super) largest: f64,
    /// 2^52 times the smallest subnormal number: adding it rounds to multiples
    /// of that number.
    pub(super) shift: f64,
    flush: bool,
}

impl FloatRounding {
    fn new(format: NumberFormat) -> FloatRounding {
        let dropped = 52 - format.mantissa;
        let mantissa = format.mantissa as i32;
        let smallest = format.smallest_exponent();
        let ones = (1u64 << 52) - (1u64 << dropped);
        let top = power(format.largest_exponent()).to_bits();
        FloatRounding {
            dropped,
            mantissa,
            smallest,
            largest_exponent: format.largest_exponent(),
            least: power(smallest),
            largest: f64::from_bits(top | ones),
            shift: power(smallest - mantissa + 52),
            flush: !format.subnormals,
        }
    }

    #[inline]
    fn round(&self, number: f64) -> f64 {
        let size = number.abs();
        if size >= self.least {
            let rounded = f64::from_bits(self.drop_bits(size.to_bits()));
            let rounded = if rounded > self.largest {
                f64::INFINITY
            } else {
                rounded
            };
            return rounded.copysign(number);
        }
        if number.is_nan() {
            return f64::NAN;
        }
        let rounded = (size + self.shift) - self.shift;
        self.flushed(rounded).copysign(number)
    }

    /// A positive number without the bits that the format lacks; a carry runs
    /// into the exponent, as it should.
    #[inline]
    pub(super) fn drop_bits(&self, bits: u64) -> u64 {
        if self.dropped == 0 {
            return bits;
        }
        let last = bits >> self.dropped & 1;
        let half = 1u64 << (self.dropped - 1);
        (bits + (half - 1) + last) >> self.dropped << self.dropped
    }

    #[inline]
    fn flushed(&self, size: f64) -> f64 {
        if self.flush && size < self.least {
            0.0
        } else {
            size
        }
    }

    fn round_exact(&self, number: ExactNumber) -> f64 {
        let leading = number.leading();
        let size = if leading > self.largest_exponent {
            f64::INFINITY
        } else if self.flush && leading < self.smallest {
            0.0
        } else {
            let unit = (leading - self.mantissa).max(self.smallest - self.mantissa);
            let size = multiples(number.significand, number.exponent, unit) as f64 * power(unit);
            if size > self.largest {
                f64::INFINITY
            } else {
                size
            }
        };
        signed(size, number.negative)
    }
}

/// Rounding into a fixed-point format.
#[derive(Clone, Copy, Debug)]
pub(super) struct FixedRounding {
    /// Bits without the sign.
    bits: u32,
    /// Bits before the point.
    integer: i32,
    /// The exponent of the unit.
    unit: i32,
    lowest: f64,
    pub(super) highest: f64,
    /// 2^52 units.
    pub(super) shift: f64,
}

impl FixedRounding {
    fn new(format: FixedFormat) -> FixedRounding {
        let unit = -(format.fraction as i32);
        let integer = format.integer as i32;
        FixedRounding {
            bits: format.integer + format.fraction,
            integer,
            unit,
            lowest: -power(integer),
            highest: power(integer) - power(unit),
            shift: power(52 + unit),
        }
    }

    #[inline]
    fn round(&self, number: f64) -> f64 {
        if number.is_nan() {
            return 0.0;
        }
        let size = number.abs();
        let rounded = if size < self.shift {
            (size + self.shift) - self.shift
        } else {
            size
        };
        self.saturated(rounded.copysign(number))
    }

    fn saturated(&self, number: f64) -> f64 {
        // The sum turns a negative zero into the only zero there is.
        number.clamp(self.lowest, self.highest) + 0.0
    }

    fn round_exact(&self, number: ExactNumber) -> f64 {
        let size = if number.leading() > self.integer {
            f64::INFINITY
        } else {
            multiples(number.significand, number.exponent, self.unit) as f64 * power(self.unit)
        };
        self.saturated(signed(size, number.negative))
    }
}

/// `significand * 2^exponent` in multiples of `2^unit`, to nearest, ties to
/// even; the result must fit into 64 bits.
fn multiples(significand: u128, exponent: i32, unit: i32) -> u64 {
    let shift = unit - exponent;
    assert!(
        (u128::BITS - significand.leading_zeros()) as i32 - shift <= 64,
        "the multiples fit into 64 bits"
    );
    if shift <= 0 {
        return (significand << -shift) as u64;
    }
    let shift = shift.unsigned_abs();
    if shift > 128 {
        return 0;
    }
    // In two steps, because a shift by all 128 bits is none in Rust.
    let kept = significand >> (shift - 1) >> 1;
    let half = 1u128 << (shift - 1);
    let rest = significand & (half | (half - 1));
    let up = rest > half || (rest == half && kept & 1 == 1);
    kept as u64 + u64::from(up)
}

fn signed(size: f64, negative: bool) -> f64 {
    if negative { -size } else { size }
}

/// `2^exponent`, from -1074 to 1023.
fn power(exponent: i32) -> f64 {
    assert!(
        (-1074..=1023).contains(&exponent),
        "binary64 has the power of two"
    );
    if exponent >= -1022 {
        f64::from_bits(((exponent + 1023) as u64) << 52)
    } else {
        f64::from_bits(1 << (exponent + 1074))
    }
}
