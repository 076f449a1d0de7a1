//! Numbers of a format as the bits of a word.
//!
//! A float's word is sign, exponent and mantissa from the top down, laid out as
//! IEEE's interchange formats; a fixed-point number's is the two's complement
//! of its multiple of the unit, `2^-fraction`. The number itself is passed as
//! binary64, so both directions move bits between two layouts without rounding:
//! every number of a format is a binary64 number.

use super::FormatArithmetic;
use crate::NumberFormat;
use crate::format::{FixedFormat, Format};
use crate::power::times_power_of_two;

/// Bits of the mantissa of binary64.
const BINARY64_MANTISSA: u32 = 52;
/// The bias of the exponent of binary64.
const BINARY64_BIAS: i32 = 1023;

impl FormatArithmetic {
    /// The word of a number of the format, in its lowest [`Format::width`]
    /// bits. NaN becomes the quiet one without sign or payload.
    pub fn word(&self, number: f64) -> u64 {
        match self.format() {
            Format::Float(format) => float_word(format, number),
            Format::Fixed(format) => fixed_word(format, number),
        }
    }

    /// The number of a word; bits above the width are ignored. A subnormal
    /// number of a format that has none becomes zero.
    pub fn from_word(&self, word: u64) -> f64 {
        match self.format() {
            // The word is the number as it travels, the payload of NaN included.
            Format::BINARY64 => f64::from_bits(word),
            // `float_number` knows no flushing; the conversion does.
            Format::Float(format) => self.convert(float_number(format, word)),
            Format::Fixed(format) => fixed_number(format, word),
        }
    }
}

fn float_word(format: NumberFormat, number: f64) -> u64 {
    // The exponent field of infinities and NaN; NaN is quiet by the highest
    // bit of its mantissa.
    let all_ones = (1u64 << format.exponent) - 1;
    if number.is_nan() {
        return all_ones << format.mantissa | 1 << (format.mantissa - 1);
    }
    let bits = number.to_bits();
    let sign = bits >> 63;
    let (exponent_field, mantissa) = if number.is_infinite() {
        (all_ones, 0)
    } else if number.abs() < 2f64.powi(format.smallest_exponent()) {
        // Zero or subnormal: a multiple of the least subnormal number.
        let multiple = times_power_of_two(number.abs(), -least_exponent(format));
        (0, multiple as u64)
    } else {
        let exponent = (bits >> BINARY64_MANTISSA & 0x7FF) as i32 - BINARY64_BIAS;
        let mantissa = bits & ((1 << BINARY64_MANTISSA) - 1);
        (
            (exponent + bias(format)) as u64,
            // What is cut off is zero in a number of the format.
            mantissa >> (BINARY64_MANTISSA - format.mantissa),
        )
    };
    (sign << format.exponent | exponent_field) << format.mantissa | mantissa
}

/// The number of a float format's word, subnormal ones kept in any case.
fn float_number(format: NumberFormat, word: u64) -> f64 {
    let all_ones = (1u64 << format.exponent) - 1;
    let mantissa = word & ((1 << format.mantissa) - 1);
    let exponent_field = word >> format.mantissa & all_ones;
    let negative = word >> (format.mantissa + format.exponent) & 1 == 1;
    let size = if exponent_field == all_ones {
        if mantissa == 0 {
            f64::INFINITY
        } else {
            f64::NAN
        }
    } else if exponent_field == 0 {
        // Zero or subnormal, as in `float_word`.
        times_power_of_two(mantissa as f64, least_exponent(format))
    } else {
        let field = (exponent_field as i32 - bias(format) + BINARY64_BIAS) as u64;
        f64::from_bits(
            field << BINARY64_MANTISSA | mantissa << (BINARY64_MANTISSA - format.mantissa),
        )
    };
    if negative { -size } else { size }
}

/// The bias of the exponent field, which is the largest exponent of a finite
/// number in IEEE's formats.
fn bias(format: NumberFormat) -> i32 {
    format.largest_exponent()
}

/// The exponent of the smallest subnormal number, of which all subnormal
/// numbers are multiples.
fn least_exponent(format: NumberFormat) -> i32 {
    format.smallest_exponent() - format.mantissa as i32
}

/// The word of a number of a fixed-point format.
fn fixed_word(format: FixedFormat, number: f64) -> u64 {
    let width = Format::Fixed(format).width();
    let multiple = times_power_of_two(number, format.fraction as i32) as i64;
    // The two's complement, cut to the width.
    multiple as u64 & (u64::MAX >> (64 - width))
}

/// The number of a fixed-point format's word.
fn fixed_number(format: FixedFormat, word: u64) -> f64 {
    let unused = 64 - Format::Fixed(format).width();
    // Shifting back extends the sign, the highest bit of the word.
    let multiple = (word << unused) as i64 >> unused;
    times_power_of_two(multiple as f64, -(format.fraction as i32))
}
