//! Numbers of arbitrary precision seen from binary64.

use astro_float::{BigFloat, Sign, Word};

/// Number of the library's words in 64 bits.
const WORDS: usize = (64 / Word::BITS) as usize;

/// The top 64 bits of a number's mantissa, a flag for any bits below them, and
/// the exponent `e` with which the number is the mantissa as a fraction below
/// one times `2^e`; `None` for zero, infinities and NaN.
fn top(number: &BigFloat) -> Option<(u64, bool, i32)> {
    let (words, _, _, exponent, _) = number.as_raw_parts()?;
    // A word is as long as a pointer; precisions are multiples of 64 bits.
    let (below, top) = words.split_at(words.len().checked_sub(WORDS)?);
    let top = top.iter().rev();
    let top = top.fold(0, |top: u128, word| top << Word::BITS | u128::from(*word)) as u64;
    // The library's numbers are normalised but at the end of a range far
    // beyond that of binary64.
    if top >> 63 == 0 {
        return None;
    }
    let sticky = below.iter().any(|word| *word != 0);
    Some((top, sticky, exponent))
}

/// The number with a precision of this number of bits.
pub(crate) fn from_binary64(number: f64, bits: usize) -> BigFloat {
    if !number.is_subnormal() {
        return BigFloat::from_f64(number, bits);
    }
    // The library does not take the least subnormal numbers for what they
    // are; moved into the normal range and back they stay exact.
    let mut moved = BigFloat::from_f64(number * 2f64.powi(200), bits);
    if let Some(exponent) = moved.exponent() {
        moved.set_exponent(exponent - 200);
    }
    moved
}

/// The nearest binary64 number, ties to even, subnormal numbers included.
pub(crate) fn to_binary64(number: &BigFloat) -> f64 {
    if number.is_nan() {
        return f64::NAN;
    }
    let sign = match number.sign() {
        Some(Sign::Neg) => -1.0,
        _ => 1.0,
    };
    if number.is_inf_pos() || number.is_inf_neg() {
        return sign * f64::INFINITY;
    }
    let Some((mantissa, sticky, exponent)) = top(number) else {
        return sign * 0.0;
    };
    if exponent > 1024 {
        return sign * f64::INFINITY;
    }
    // Bits that binary64 keeps: 53, fewer below the normal numbers.
    let kept = (i64::from(exponent) + 1074).min(53);
    if kept < 0 {
        return sign * 0.0;
    }
    let dropped = 64 - kept as u32;
    let (integer, half) = match dropped {
        64 => (0, mantissa >> 63 == 1),
        _ => (mantissa >> dropped, mantissa >> (dropped - 1) & 1 == 1),
    };
    let rest = mantissa << (kept + 1) != 0 || sticky;
    let up = half && (rest || integer & 1 == 1);
    let integer = integer + u64::from(up);
    // Both factors are exact: at most 53 bits, and a power of two that is
    // applied in two steps where it alone would be out of range.
    let shift = exponent - kept as i32;
    let scaled = integer as f64 * 2f64.powi(shift / 2);
    sign * scaled * 2f64.powi(shift - shift / 2)
}

/// An upper bound of the absolute value, at most a few parts in 2⁶³ above it;
/// infinite beyond the range of binary64 and for NaN.
pub(super) fn magnitude(number: &BigFloat) -> f64 {
    if number.is_zero() {
        return 0.0;
    }
    match top(number) {
        None => f64::INFINITY,
        Some((_, _, exponent)) if exponent > 1023 => f64::INFINITY,
        Some((_, _, exponent)) if exponent < -1020 => f64::MIN_POSITIVE * 4.0,
        Some((mantissa, _, exponent)) => {
            let fraction = mantissa as f64 / 2f64.powi(64);
            (fraction * 2f64.powi(exponent)).next_up()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use astro_float::RoundingMode;

    fn big(number: f64) -> BigFloat {
        from_binary64(number, 256)
    }

    #[test]
    fn binary64_numbers_come_back() {
        for number in [
            0.0,
            1.0,
            -1.5,
            0.1,
            f64::MAX,
            f64::MIN_POSITIVE,
            5e-324,
            -3e-310,
            1e-300,
            f64::INFINITY,
        ] {
            assert_eq!(to_binary64(&big(number)), number);
            assert!(magnitude(&big(number)) >= number.abs());
        }
        assert!(to_binary64(&astro_float::NAN).is_nan());
        assert!(magnitude(&big(0.1)) < 0.1 * (1.0 + 1e-15));
    }

    #[test]
    fn ties_go_to_even_and_little_above_a_tie_goes_up() {
        let sum = |a: f64, b: f64| big(a).add(&big(b), 256, RoundingMode::ToEven);
        let half = f64::EPSILON / 2.0;
        assert_eq!(to_binary64(&sum(1.0, half)), 1.0);
        assert_eq!(
            to_binary64(&sum(1.0 + f64::EPSILON, half)),
            1.0 + 2.0 * f64::EPSILON
        );
        let above = sum(1.0, half).add(&big(1e-60), 256, RoundingMode::ToEven);
        assert_eq!(to_binary64(&above), 1.0 + f64::EPSILON);
        let below = sum(1.0 + f64::EPSILON, half).sub(&big(1e-60), 256, RoundingMode::ToEven);
        assert_eq!(to_binary64(&below), 1.0 + f64::EPSILON);
        assert_eq!(to_binary64(&sum(2.0, -half)), 2.0);
        assert_eq!(to_binary64(&sum(f64::MAX, 2f64.powi(970))), f64::INFINITY);
    }

    #[test]
    fn subnormal_numbers_are_rounded_once() {
        let least = 5e-324;
        let product = |a: f64, b: f64| big(a).mul(&big(b), 256, RoundingMode::ToEven);
        assert_eq!(to_binary64(&product(least, 0.5)), 0.0);
        assert_eq!(to_binary64(&product(least, 0.75)), least);
        assert_eq!(to_binary64(&product(least, 1.5)), 2.0 * least);
        assert_eq!(to_binary64(&product(least, 2.5)), 2.0 * least);
        assert_eq!(to_binary64(&product(least, 0.25)), 0.0);
        let number = 1.0 + f64::EPSILON;
        let expected = number * f64::MIN_POSITIVE / 4.0;
        assert_eq!(
            to_binary64(&product(number, f64::MIN_POSITIVE / 4.0)),
            expected
        );
    }
}
