//! Numbers of a format as the bits of a word.
//!
//! A float's word is sign, exponent and mantissa from the top down, laid out
//! as IEEE's interchange formats; a fixed-point number's is the two's
//! complement of its multiple of the unit.

use super::FormatArithmetic;
use crate::NumberFormat;
use crate::format::{FixedFormat, Format};

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
            Format::BINARY64 => f64::from_bits(word),
            Format::Float(format) => self.convert(float_number(format, word)),
            Format::Fixed(format) => fixed_number(format, word),
        }
    }
}

fn float_word(format: NumberFormat, number: f64) -> u64 {
    let ones = (1u64 << format.exponent) - 1;
    let bits = number.to_bits();
    let sign = bits >> 63;
    let (exponent, mantissa) = if number.is_nan() {
        return ones << format.mantissa | 1 << (format.mantissa - 1);
    } else if number.is_infinite() {
        (ones, 0)
    } else if number.abs() < 2f64.powi(format.smallest_exponent()) {
        // Zero or subnormal: a multiple of the least subnormal number.
        let unit = format.smallest_exponent() - format.mantissa as i32;
        (0, multiple(number.abs(), unit))
    } else {
        let exponent = (bits >> 52 & 0x7FF) as i32 - 1023;
        let fraction = bits & ((1 << 52) - 1);
        (
            (exponent + format.largest_exponent()) as u64,
            fraction >> (52 - format.mantissa),
        )
    };
    (sign << format.exponent | exponent) << format.mantissa | mantissa
}

fn float_number(format: NumberFormat, word: u64) -> f64 {
    let ones = (1u64 << format.exponent) - 1;
    let mantissa = word & ((1 << format.mantissa) - 1);
    let exponent = word >> format.mantissa & ones;
    let negative = word >> (format.mantissa + format.exponent) & 1 == 1;
    let size = if exponent == ones {
        if mantissa == 0 {
            f64::INFINITY
        } else {
            f64::NAN
        }
    } else if exponent == 0 {
        let unit = format.smallest_exponent() - format.mantissa as i32;
        scaled(mantissa as f64, unit)
    } else {
        let field = (exponent as i32 - format.largest_exponent() + 1023) as u64;
        f64::from_bits(field << 52 | mantissa << (52 - format.mantissa))
    };
    if negative { -size } else { size }
}

fn fixed_word(format: FixedFormat, number: f64) -> u64 {
    let width = Format::Fixed(format).width();
    let multiple = scaled(number, format.fraction as i32) as i64;
    multiple as u64 & (u64::MAX >> (64 - width))
}

fn fixed_number(format: FixedFormat, word: u64) -> f64 {
    let unused = 64 - Format::Fixed(format).width();
    let multiple = (word << unused) as i64 >> unused;
    scaled(multiple as f64, -(format.fraction as i32))
}

/// A number in multiples of `2^unit`, which it is one of.
fn multiple(number: f64, unit: i32) -> u64 {
    scaled(number, -unit) as u64
}

/// `number * 2^exponent`, in two steps: the power alone may be out of range.
fn scaled(number: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    number * 2f64.powi(half) * 2f64.powi(exponent - half)
}
