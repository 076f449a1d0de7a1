//! Literals of FPCore: decimals, hexadecimals, quotients and constants.

use robovec_num::decimal::is_lost;
use robovec_num::hexadecimal;
use std::f64::consts;

#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum CoreLiteral {
    /// The nearest number of binary64.
    Number(f64),
    /// The nearest number of binary64 to a decimal of too many digits.
    Long(f64),
    /// A number that binary64 does not hold.
    TooLarge,
    /// A number other than 0 that binary64 rounds to 0.
    TooSmall,
    /// Not a literal.
    None,
}

/// Significant digits that binary64 distinguishes.
const DIGITS: usize = 17;

pub(super) fn literal(atom: &str) -> CoreLiteral {
    if let Some(constant) = constant(atom) {
        return CoreLiteral::Number(constant);
    }
    let unsigned = atom.strip_prefix(['-', '+']).unwrap_or(atom);
    if !unsigned.starts_with(|first: char| first.is_ascii_digit() || first == '.') {
        return CoreLiteral::None;
    }
    let sign = if atom.starts_with('-') { -1.0 } else { 1.0 };
    if unsigned.starts_with("0x") {
        return match hexadecimal::parse(atom) {
            Some(number) => finite(number),
            None => CoreLiteral::None,
        };
    }
    if let Some((top, bottom)) = unsigned.split_once('/') {
        return match quotient(top, bottom) {
            Some(number) => CoreLiteral::Number(sign * number),
            None => CoreLiteral::None,
        };
    }
    let decimal = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E' | '+' | '-');
    if !unsigned.chars().all(decimal) {
        return CoreLiteral::None;
    }
    match unsigned.parse::<f64>() {
        Ok(number) if is_lost(unsigned, number) => CoreLiteral::TooSmall,
        Ok(number) if significant(unsigned) > DIGITS && number.is_finite() => {
            CoreLiteral::Long(sign * number)
        }
        Ok(number) => finite(sign * number),
        Err(_) => CoreLiteral::None,
    }
}

fn finite(number: f64) -> CoreLiteral {
    if number.is_finite() {
        CoreLiteral::Number(number)
    } else {
        CoreLiteral::TooLarge
    }
}

/// Digits of a decimal between its first and last that are not zero.
fn significant(decimal: &str) -> usize {
    let mantissa = decimal.split(['e', 'E']).next();
    let mantissa = mantissa.expect("a text has a first part");
    let digits = mantissa.replace('.', "");
    digits.trim_matches('0').len()
}

/// A quotient of whole numbers of binary64, so that one division rounds it.
fn quotient(top: &str, bottom: &str) -> Option<f64> {
    let whole = |text: &str| {
        let number: u64 = text.parse().ok()?;
        (number <= 1 << 53).then_some(number as f64)
    };
    let (top, bottom) = (whole(top)?, whole(bottom)?);
    (bottom != 0.0).then(|| top / bottom)
}

fn constant(atom: &str) -> Option<f64> {
    Some(match atom {
        "E" => consts::E,
        "LOG2E" => consts::LOG2_E,
        "LOG10E" => consts::LOG10_E,
        "LN2" => consts::LN_2,
        "LN10" => consts::LN_10,
        "PI" => consts::PI,
        "PI_2" => consts::FRAC_PI_2,
        "PI_4" => consts::FRAC_PI_4,
        "M_1_PI" => consts::FRAC_1_PI,
        "M_2_PI" => consts::FRAC_2_PI,
        "M_2_SQRTPI" => consts::FRAC_2_SQRT_PI,
        "SQRT2" => consts::SQRT_2,
        "SQRT1_2" => consts::FRAC_1_SQRT_2,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_are_the_nearest_numbers() {
        for (text, number) in [
            ("-1.5e-3", -1.5e-3),
            ("+.5", 0.5),
            ("0x1.8p3", 12.0),
            ("-0xAp-1", -5.0),
            ("1/3", 1.0 / 3.0),
            ("-7/2", -3.5),
            ("PI", consts::PI),
            ("0x1p-1074", 5e-324),
        ] {
            assert_eq!(literal(text), CoreLiteral::Number(number), "{text}");
        }
        assert_eq!(literal("1e999"), CoreLiteral::TooLarge);
        for text in ["1e-999", "-.5e-400"] {
            assert_eq!(literal(text), CoreLiteral::TooSmall, "{text}");
        }
        assert_eq!(
            literal("0.12345678901234567890"),
            CoreLiteral::Long(0.123_456_789_012_345_68)
        );
        for text in [
            "x",
            "1/0",
            "-",
            "1x",
            "0x",
            "e5",
            "infinity",
            "0xZ",
            "0x1p-1200",
        ] {
            assert_eq!(literal(text), CoreLiteral::None, "{text}");
        }
    }
}
