//! 64-bit floats as text that loses no bit, as C's `%a` writes them:
//! `0x1.8p+1` is 3.

use crate::decimal::is_lost;

/// Writes a number in the format of C's `%a`.
pub fn format(number: f64) -> String {
    let bits = number.to_bits();
    let sign = if number.is_sign_negative() { "-" } else { "" };
    if number.is_nan() {
        return format!("{sign}nan");
    }
    if number.is_infinite() {
        return format!("{sign}inf");
    }
    let exponent = ((bits >> 52) & 0x7ff) as i32;
    let mantissa = bits & ((1 << 52) - 1);
    if exponent == 0 && mantissa == 0 {
        return format!("{sign}0x0p+0");
    }
    // Numbers below the normal range have no leading one.
    let (leading, exponent) = match exponent {
        0 => (0, -1022),
        _ => (1, exponent - 1023),
    };
    let digits = format!("{mantissa:013x}");
    let digits = digits.trim_end_matches('0');
    let point = if digits.is_empty() { "" } else { "." };
    format!("{sign}0x{leading}{point}{digits}p{exponent:+}")
}

/// Reads a number as C's `%a` writes it, or a decimal one. `None` for any other
/// text, for a hexadecimal number with more digits than a 64-bit float has, and
/// for a number other than 0 that would become 0.
pub fn parse(text: &str) -> Option<f64> {
    let (sign, rest) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let Some(rest) = rest.strip_prefix("0x").or_else(|| rest.strip_prefix("0X")) else {
        let number = text.parse().ok();
        return number.filter(|&number| !is_lost(text, number));
    };
    let (digits, exponent) = rest.split_once(['p', 'P']).unwrap_or((rest, "0"));
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let mut mantissa = 0u64;
    for digit in whole.chars().chain(fraction.chars()) {
        mantissa = mantissa.checked_mul(16)? + u64::from(digit.to_digit(16)?);
        if mantissa >> 53 != 0 {
            return None;
        }
    }
    if whole.is_empty() && fraction.is_empty() {
        return None;
    }
    let exponent: i32 = exponent.parse().ok()?;
    let exponent = exponent.checked_sub(i32::try_from(fraction.len()).ok()?.checked_mul(4)?)?;
    let number = scale(mantissa as f64, exponent);
    (number != 0.0 || mantissa == 0).then_some(sign * number)
}

/// `number * 2^exponent`, exact where the result can be.
fn scale(mut number: f64, exponent: i32) -> f64 {
    let mut left = exponent.clamp(-2200, 2200);
    while left != 0 {
        let step = left.clamp(-1000, 1000);
        number *= 2f64.powi(step);
        left -= step;
    }
    number
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_c_writes_them() {
        assert_eq!(format(3.0), "0x1.8p+1");
        assert_eq!(format(-0.0), "-0x0p+0");
        assert_eq!(format(0.1), "0x1.999999999999ap-4");
        assert_eq!(format(f64::from_bits(1)), "0x0.0000000000001p-1022");
        assert_eq!(format(f64::NEG_INFINITY), "-inf");
    }

    #[test]
    fn every_bit_survives() {
        let samples = [
            1.0,
            -1.5,
            0.1,
            1e300,
            1e-300,
            5e-324,
            f64::MAX,
            f64::MIN_POSITIVE,
            -0.0,
        ];
        for number in samples {
            let again = parse(&format(number)).expect("just written");
            assert_eq!(again.to_bits(), number.to_bits(), "{number}");
        }
        assert_eq!(parse("2.5"), Some(2.5));
        assert_eq!(parse("0x1.123456789abcdefp+0"), None);
        assert_eq!(parse("0x1p-1200"), None);
        assert_eq!(parse("1e-400"), None);
        assert_eq!(parse("0x"), None);
        assert_eq!(parse("q"), None);
    }
}
