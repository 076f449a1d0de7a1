//! Numbers with the semantics of the languages.
//!
//! `1/2` is 0 in C and 0.5 in Matlab and Python, `010` is 8 in C, and `0.1f` is
//! not 0.1. So a literal keeps its type, and expressions of literals alone are
//! computed while the file is read, as the language computes them; a result
//! that no 64-bit float can represent is refused.

use robovec_ir::Operation;
use robovec_num::decimal::is_lost;

/// The number of a literal, or of an expression of literals alone.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Literal {
    /// A whole number: `int`, or C's `long` where that is too short.
    Whole {
        value: i64,
        /// True for C's `long`.
        long: bool,
    },
    /// A 32-bit float of C: `0.1f`.
    Single(f32),
    /// A 64-bit float.
    Double(f64),
}

/// Reason why a literal, or an operation on literals, cannot be kept.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Unkept {
    pub(super) message: &'static str,
    pub(super) note: &'static str,
}

/// The language whose integer arithmetic applies.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub(super) enum IntegerArithmetic {
    /// Every number is a 64-bit float: Matlab.
    #[default]
    Floats,
    /// Division cuts off, and a result has 32 or 64 bits.
    C,
    /// Sums and products are exact, quotients are floats.
    Python,
}

/// Whole numbers up to this one are exact 64-bit floats.
const LARGEST_EXACT: i64 = 1 << 53;

const TOO_LARGE: Unkept = Unkept {
    message: "this number is too large for a 64-bit float",
    note: "it would be read as infinity",
};
const TOO_SMALL: Unkept = Unkept {
    message: "this number is too small for a float of its type",
    note: "it would be read as 0",
};
const NOT_A_NUMBER: Unkept = Unkept {
    message: "this is not a number that is understood",
    note: "write it as a decimal number, such as 16.0 or 1e-3",
};
const OVERFLOW: Unkept = Unkept {
    message: "this whole number is too large for its type",
    note: "write it with a decimal point, so that it is computed as a floating-point number",
};
const DIVISION_BY_ZERO: Unkept = Unkept {
    message: "a whole number is divided by 0",
    note: "write the numbers with decimal points, if the quotient of floating-point numbers is meant",
};

impl Literal {
    /// The number converted to a 64-bit float, as for an operation with one.
    pub(super) fn number(self) -> f64 {
        match self {
            // Rounded to nearest, as C and Python convert.
            Literal::Whole { value, .. } => value as f64,
            Literal::Single(number) => f64::from(number),
            Literal::Double(number) => number,
        }
    }

    fn single(self) -> f32 {
        match self {
            Literal::Whole { value, .. } => value as f32,
            Literal::Single(number) => number,
            Literal::Double(number) => number as f32,
        }
    }

    /// The negative number; `None` for a 64-bit float: that is an operation.
    pub(super) fn negative(self) -> Result<Option<Literal>, Unkept> {
        match self {
            Literal::Whole { value, long } => whole(value.checked_neg(), long).map(Some),
            Literal::Single(number) => Ok(Some(Literal::Single(-number))),
            Literal::Double(_) => Ok(None),
        }
    }

    /// Result of an operation on two literals; `None` for one on 64-bit floats.
    pub(super) fn combined(
        self,
        operation: Operation,
        other: Literal,
        arithmetic: IntegerArithmetic,
    ) -> Result<Option<Literal>, Unkept> {
        match (self, other) {
            (Literal::Double(_), _) | (_, Literal::Double(_)) => Ok(None),
            (Literal::Whole { value: a, long }, Literal::Whole { value: b, long: l }) => {
                wholes(operation, (a, b), long || l, arithmetic)
            }
            (Literal::Single(_), _) | (_, Literal::Single(_)) => {
                let (a, b) = (self.single(), other.single());
                let number = match operation {
                    Operation::Add => a + b,
                    Operation::Sub => a - b,
                    Operation::Mul => a * b,
                    Operation::Div => a / b,
                    _ => return Ok(None),
                };
                if number.is_finite() {
                    Ok(Some(Literal::Single(number)))
                } else {
                    Err(TOO_LARGE)
                }
            }
        }
    }
}

/// A whole number within its type.
fn whole(value: Option<i64>, long: bool) -> Result<Literal, Unkept> {
    let value = value.ok_or(OVERFLOW)?;
    if long || i32::try_from(value).is_ok() {
        Ok(Literal::Whole { value, long })
    } else {
        Err(OVERFLOW)
    }
}

fn wholes(
    operation: Operation,
    (a, b): (i64, i64),
    long: bool,
    arithmetic: IntegerArithmetic,
) -> Result<Option<Literal>, Unkept> {
    let quotient = operation == Operation::Div;
    if quotient && b == 0 && arithmetic != IntegerArithmetic::Floats {
        return Err(DIVISION_BY_ZERO);
    }
    let value = match operation {
        Operation::Add => a.checked_add(b),
        Operation::Sub => a.checked_sub(b),
        Operation::Mul => a.checked_mul(b),
        Operation::Div if arithmetic == IntegerArithmetic::C => a.checked_div(b),
        _ => return Ok(None),
    };
    let result = whole(value, long)?;
    match result {
        Literal::Whole { value, .. }
            if arithmetic == IntegerArithmetic::Python && value.abs() > LARGEST_EXACT =>
        {
            Err(OVERFLOW)
        }
        result => Ok(Some(result)),
    }
}

pub(super) fn matlab(text: &str) -> Result<Literal, Unkept> {
    float(text).map(Literal::Double)
}

/// A number of C: a number token of the preprocessor.
pub(super) fn c(text: &str) -> Result<Literal, Unkept> {
    let lower = text.to_ascii_lowercase();
    if let Some(digits) = lower.strip_prefix("0x") {
        if digits.contains(['.', 'p']) {
            return hexadecimal_float(digits);
        }
        return whole_of_c(digits, 16);
    }
    let mut characters = lower.chars();
    if characters.all(|c| c.is_ascii_digit() || matches!(c, 'u' | 'l')) {
        let octal =
            lower.len() > 1 && lower.starts_with('0') && lower.as_bytes()[1].is_ascii_digit();
        return whole_of_c(&lower, if octal { 8 } else { 10 });
    }
    if let Some(digits) = lower.strip_suffix('f') {
        return match digits.parse::<f32>() {
            Ok(number) if is_lost(digits, number.into()) => Err(TOO_SMALL),
            Ok(number) if number.is_finite() && is_decimal_float(digits) => {
                Ok(Literal::Single(number))
            }
            Ok(number) if number.is_infinite() => Err(TOO_LARGE),
            Ok(_) | Err(_) => Err(NOT_A_NUMBER),
        };
    }
    if lower.ends_with('l') && is_decimal_float(lower.trim_end_matches('l')) {
        return Err(Unkept {
            message: "a number of type `long double`",
            note: "it has more digits than a 64-bit float; leave out the suffix `L`",
        });
    }
    if !is_decimal_float(&lower) {
        return Err(NOT_A_NUMBER);
    }
    float(&lower).map(Literal::Double)
}

pub(super) fn python(text: &str) -> Result<Literal, Unkept> {
    if text.bytes().all(|byte| byte.is_ascii_digit()) {
        if text.len() > 1 && text.starts_with('0') && text.bytes().any(|byte| byte != b'0') {
            return Err(Unkept {
                message: "a whole number that begins with 0",
                note: "Python does not accept it; leave out the zeros, or write 0o10 as 8",
            });
        }
        let value = text.parse::<i64>().map_err(|_| OVERFLOW)?;
        if value > LARGEST_EXACT {
            return Err(OVERFLOW);
        }
        return Ok(Literal::Whole { value, long: true });
    }
    if !is_decimal_float(text) {
        return Err(NOT_A_NUMBER);
    }
    float(text).map(Literal::Double)
}

fn float(text: &str) -> Result<f64, Unkept> {
    match text.parse::<f64>() {
        Ok(number) if is_lost(text, number) => Err(TOO_SMALL),
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(TOO_LARGE),
        Err(_) => Err(NOT_A_NUMBER),
    }
}

/// True for digits with a point or an exponent; Rust takes `inf` and `nan` too.
fn is_decimal_float(text: &str) -> bool {
    text.bytes()
        .all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b'e' | b'E' | b'+' | b'-'))
        && text.bytes().any(|byte| !byte.is_ascii_digit())
}

/// A whole constant of C with its suffix, which states the smallest type.
fn whole_of_c(text: &str, radix: u32) -> Result<Literal, Unkept> {
    let digits = text.trim_end_matches(['u', 'l']);
    let suffix = &text[digits.len()..];
    if suffix.contains('u') {
        return Err(Unkept {
            message: "a number without a sign (`u`)",
            note: "its arithmetic wraps around; write it as a floating-point number",
        });
    }
    if !matches!(suffix, "" | "l" | "ll") || digits.is_empty() {
        return Err(NOT_A_NUMBER);
    }
    let value = i64::from_str_radix(digits, radix).map_err(|error| match error.kind() {
        std::num::IntErrorKind::PosOverflow => OVERFLOW,
        _ => NOT_A_NUMBER,
    })?;
    let long = !suffix.is_empty() || i32::try_from(value).is_err();
    if long && radix != 10 && u32::try_from(value).is_ok() && suffix.is_empty() {
        return Err(Unkept {
            message: "a number that C takes for one without a sign",
            note: "write it in decimal digits",
        });
    }
    Ok(Literal::Whole { value, long })
}

/// The digits of `0x1.8p1` after its `0x`, in lower case.
fn hexadecimal_float(text: &str) -> Result<Literal, Unkept> {
    let (digits, exponent) = text.split_once('p').ok_or(NOT_A_NUMBER)?;
    let exponent: i32 = exponent.parse().map_err(|_| NOT_A_NUMBER)?;
    let (before, behind) = digits.split_once('.').unwrap_or((digits, ""));
    let all = format!("{before}{behind}");
    let significant = all.trim_start_matches('0');
    // Thirteen digits fit a 64-bit float whatever they are, and these
    // exponents keep it a normal number: no rounding.
    if all.is_empty() || significant.len() > 13 || exponent.abs() > 900 {
        return Err(NOT_A_NUMBER);
    }
    if significant.is_empty() {
        return Ok(Literal::Double(0.0));
    }
    let whole = u64::from_str_radix(significant, 16).map_err(|_| NOT_A_NUMBER)?;
    let scale = exponent - 4 * behind.len() as i32;
    if scale.abs() > 960 {
        return Err(NOT_A_NUMBER);
    }
    Ok(Literal::Double(whole as f64 * 2f64.powi(scale)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn int(value: i64) -> Literal {
        Literal::Whole { value, long: false }
    }

    #[test]
    fn whole_and_single_numbers_keep_their_minus() {
        assert_eq!(int(3).negative(), Ok(Some(int(-3))));
        assert_eq!(int(-3).negative(), Ok(Some(int(3))));
        let single = Literal::Single(0.5).negative();
        assert_eq!(single, Ok(Some(Literal::Single(-0.5))));
        assert_eq!(Literal::Double(0.5).negative(), Ok(None));
        assert!(int(i64::MIN).negative().is_err());
    }

    #[test]
    fn literals_of_c_have_the_types_of_c() {
        assert_eq!(c("017"), Ok(int(15)));
        assert_eq!(c("0"), Ok(int(0)));
        assert_eq!(c("0x1F"), Ok(int(31)));
        assert_eq!(
            c("7l"),
            Ok(Literal::Whole {
                value: 7,
                long: true
            })
        );
        let beyond = Literal::Whole {
            value: 3_000_000_000,
            long: true,
        };
        assert_eq!(c("3000000000"), Ok(beyond));
        assert_eq!(c("0.1f"), Ok(Literal::Single(0.1)));
        assert_eq!(c("010."), Ok(Literal::Double(10.0)));
        assert_eq!(c("0x1.8p1"), Ok(Literal::Double(3.0)));
        assert_eq!(c("0xap-1"), Ok(Literal::Double(5.0)));
        assert_eq!(c("1e-400"), Err(TOO_SMALL));
        for text in [
            "08",
            "0x",
            "1u",
            "0xffffffff",
            "0.1L",
            "1.0.0",
            "1e",
            "1f",
            "0b1",
            "2e400",
        ] {
            assert!(c(text).is_err(), "{text}");
        }
        assert!(c("99999999999999999999").is_err());
    }

    #[test]
    fn literals_of_python_are_exact_or_refused() {
        assert_eq!(
            python("00"),
            Ok(Literal::Whole {
                value: 0,
                long: true
            })
        );
        assert_eq!(python("007.5"), Ok(Literal::Double(7.5)));
        for text in ["010", "1_000", "1j", "0x10", "9007199254740993", "1e"] {
            assert!(python(text).is_err(), "{text}");
        }
    }

    #[test]
    fn whole_numbers_divide_as_their_language_does() {
        let half = |arithmetic| int(1).combined(Operation::Div, int(2), arithmetic);
        assert_eq!(half(IntegerArithmetic::C), Ok(Some(int(0))));
        assert_eq!(half(IntegerArithmetic::Python), Ok(None));
        let cut = int(-7).combined(Operation::Div, int(2), IntegerArithmetic::C);
        assert_eq!(cut, Ok(Some(int(-3))));
        let none = int(1).combined(Operation::Div, int(0), IntegerArithmetic::C);
        assert_eq!(none, Err(DIVISION_BY_ZERO));
        let large = int(65536).combined(Operation::Mul, int(32768), IntegerArithmetic::C);
        assert_eq!(large, Err(OVERFLOW));
        let third = int(1).combined(Operation::Div, Literal::Single(3.0), IntegerArithmetic::C);
        assert_eq!(third, Ok(Some(Literal::Single(1.0 / 3.0))));
    }
}
