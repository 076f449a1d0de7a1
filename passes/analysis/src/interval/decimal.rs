//! Literals as the decimals that they print as.

use super::GivenData;
use crate::adjoint::half_ulp;
use robovec_ir::Format;
use robovec_num::double_double::Double;
use robovec_num::interval::Interval;

/// Powers of ten at which the distance of a decimal is known.
const KNOWN_POWERS: std::ops::RangeInclusive<i32> = -60..=40;

/// Error of that distance relative to the number: some hundred products, each
/// within a few units of 2⁻¹⁰⁶.
const PRECISION: f64 = 1.0 / (1u128 << 95) as f64;

/// Range of a decimal that reads as a number, and the most that its rounding
/// to a format loses, when that of the number moves it this far.
pub(super) fn given(number: f64, rounding: Double) -> (Interval, f64) {
    let point = Interval::point(number);
    if is_decimal(number) {
        return (point, rounding.high.abs());
    }
    let Some(rest) = decimal_rest(number) else {
        let half = half_ulp(Format::BINARY64, number);
        return (point.widened(half), (rounding.high.abs() + half).next_up());
    };
    let slack = number.abs() * PRECISION;
    let exact = if rest.high > slack {
        Interval::new(number, number.next_up())
    } else if rest.high < -slack {
        Interval::new(number.next_down(), number)
    } else {
        point.widened(slack)
    };
    (exact, ((rounding - rest).high.abs() + slack).next_up())
}

/// The exact value of a literal: of real data the decimal that it prints as,
/// to 2⁻⁹⁵ of it, or the number where that is not known.
pub fn exact_literal(number: f64, data: GivenData) -> Double {
    match data {
        GivenData::Held => Double::from(number),
        GivenData::Real => Double::from(number) + decimal_rest(number).unwrap_or_default(),
    }
}

/// The shortest decimal that reads as a number less that number, where it is
/// known.
fn decimal_rest(number: f64) -> Option<Double> {
    if is_decimal(number) {
        return Some(Double::from(0.0));
    }
    let text = format!("{:e}", number.abs());
    let (digits, exponent) = text.split_once('e')?;
    let behind = digits.split_once('.').map_or(0, |(_, behind)| behind.len());
    let power = exponent.parse::<i32>().ok()? - behind as i32;
    if !KNOWN_POWERS.contains(&power) {
        return None;
    }
    let whole: u64 = digits.replace('.', "").parse().ok()?;
    let low = whole & 0xffff_ffff;
    let whole = Double::from((whole - low) as f64) + Double::from(low as f64);
    let ten = Double::from(10.0);
    let scale = (0..power.abs()).fold(Double::from(1.0), |scale, _| scale * ten);
    let size = if power < 0 {
        whole / scale
    } else {
        whole * scale
    };
    let rest = size - Double::from(number.abs());
    Some(if number < 0.0 { -rest } else { rest })
}

/// True when the shortest decimal that reads as a number is that number:
/// neither it nor any other number of as few digits was rounded.
fn is_decimal(number: f64) -> bool {
    if number == 0.0 {
        return true;
    }
    let bits = number.to_bits();
    let (exponent, fraction) = ((bits >> 52) as i32 & 0x7ff, bits & ((1 << 52) - 1));
    let (mantissa, exponent) = match exponent {
        0 => (fraction, -1074),
        biased => (fraction | 1 << 52, biased - 1075),
    };
    // The number is an odd one times this power of two: a decimal with as
    // many digits behind the point as the power is below one.
    let power = exponent + mantissa.trailing_zeros() as i32;
    let digits = number.abs().to_string();
    let behind = digits.split_once('.').map_or(0, |(_, behind)| behind.len());
    if power >= 0 {
        return number.abs() < (1u64 << 53) as f64;
    }
    usize::try_from(-power).is_ok_and(|power| power <= behind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_of_decimals_are_those_of_their_digits() {
        // 0.1 is 3602879701896397 / 2^55, 3602879701896396.8 for the decimal.
        let rest = decimal_rest(0.1).expect("it is known").high;
        assert!((rest + 0.2 * 2f64.powi(-55)).abs() < 1e-30);
        for number in [0.1, -0.3, 1.11, 331.4, 6.02e23, 1.3806503e-23, 42.7e-6] {
            let rest = decimal_rest(number).expect("it is known").high;
            let (exact, lost) = given(number, Double::from(0.0));
            assert!(rest != 0.0 && rest.abs() <= lost, "{number}");
            assert!(lost <= half_ulp(Format::BINARY64, number), "{number}");
            assert_eq!(exact.high > number, rest > 0.0, "{number}");
            assert_eq!(decimal_rest(-number).map(|rest| -rest.high), Some(rest));
        }
        for number in [0.0, 0.5, -3.0, 1e15, 0.1875] {
            assert_eq!(
                given(number, Double::from(0.0)),
                (Interval::point(number), 0.0)
            );
        }
        assert_eq!(decimal_rest(1e-200), None);
    }
}
