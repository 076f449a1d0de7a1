//! The text of one operation.

use super::Real;
use robovec_ir::Operation;

/// An operation on operands that are names, elements or literals. Sines,
/// cosines and roots only of numbers; those of lanes are no expressions.
pub(super) fn expression(operation: Operation, operands: &[String], real: Real) -> String {
    let operand = |index: usize| match operands.get(index) {
        Some(text) if text.starts_with('-') => format!("({text})"),
        Some(text) => text.clone(),
        None => String::new(),
    };
    let (a, b, c) = (operand(0), operand(1), operand(2));
    match operation {
        Operation::Copy => a,
        Operation::Neg => format!("-{a}"),
        Operation::Add => format!("{a} + {b}"),
        Operation::Sub => format!("{a} - {b}"),
        Operation::Mul => format!("{a} * {b}"),
        Operation::Div => format!("{a} / {b}"),
        Operation::Fma => format!("{a} * {b} + {c}"),
        Operation::Fms => format!("{a} * {b} - {c}"),
        Operation::Fnma => format!("{c} - {a} * {b}"),
        Operation::Sin | Operation::Cos | Operation::Sqrt => match real {
            Real::Double => format!("{}({a})", operation.name()),
            Real::Float => format!("(float){}((double){a})", operation.name()),
        },
    }
}

/// A number as a literal that reads back as itself.
pub(super) fn literal(number: f64, real: Real) -> String {
    let single = number as f32;
    let (finite, text) = match real {
        Real::Double => (number.is_finite(), format!("{:?}", number.abs())),
        Real::Float => (single.is_finite(), format!("{:?}f", single.abs())),
    };
    let sign = if number.is_sign_negative() { "-" } else { "" };
    match (finite, number.is_nan()) {
        (true, _) => format!("{sign}{text}"),
        (false, true) => format!("({})NAN", real.name()),
        (false, false) => format!("{sign}({})INFINITY", real.name()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_do_not_run_together() {
        let text = |operation, operands: [&str; 3]| {
            expression(operation, &operands.map(str::to_owned), Real::Double)
        };
        assert_eq!(text(Operation::Sub, ["a", "-2.0", ""]), "a - (-2.0)");
        assert_eq!(text(Operation::Neg, ["-2.0", "", ""]), "-(-2.0)");
        assert_eq!(text(Operation::Fnma, ["a", "b", "c"]), "c - a * b");
    }

    #[test]
    fn literals_keep_every_bit() {
        assert_eq!(literal(0.1, Real::Double), "0.1");
        assert_eq!(literal(-0.0, Real::Float), "-0.0f");
        assert_eq!(literal(f64::NEG_INFINITY, Real::Float), "-(float)INFINITY");
        assert_eq!(literal(f64::NAN, Real::Double), "(double)NAN");
    }
}
