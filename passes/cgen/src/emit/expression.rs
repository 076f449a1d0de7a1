//! Literals, operations, and the parentheses they need.

use super::Real;
use robovec_ir::Operation;

/// The binding strength of a text; a text of lower strength than its place
/// requires is in parentheses.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Tightness {
    /// The weakest: it needs parentheses in every expression.
    Open,
    /// A sum or difference.
    Sum,
    /// A product or quotient.
    Product,
    /// A sign or cast before something.
    Unary,
    /// A name, an element, a call, a number without sign.
    Primary,
}

impl Tightness {
    /// The tightness that the right operand of an operator needs, since
    /// operators of one tightness associate to the left.
    pub(crate) fn next(self) -> Tightness {
        match self {
            Tightness::Open => Tightness::Sum,
            Tightness::Sum => Tightness::Product,
            Tightness::Product => Tightness::Unary,
            Tightness::Unary | Tightness::Primary => Tightness::Primary,
        }
    }
}

#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct BoundText {
    pub(crate) text: String,
    pub(crate) tightness: Tightness,
}

impl BoundText {
    /// A text and how tightly it binds.
    pub(crate) fn new(text: impl Into<String>, tightness: Tightness) -> BoundText {
        BoundText {
            text: text.into(),
            tightness,
        }
    }

    /// A name, an element or a call.
    pub(crate) fn primary(text: impl Into<String>) -> BoundText {
        BoundText::new(text, Tightness::Primary)
    }

    /// The text, in parentheses where it binds less tightly than it must.
    pub(crate) fn within(&self, least: Tightness) -> String {
        if self.tightness < least {
            format!("({})", self.text)
        } else {
            self.text.clone()
        }
    }
}

/// The type that is computed with.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Operands {
    /// Numbers: the library has `fma`, and a root for each type.
    Numbers,
    /// Vectors, or numbers that agree with them: there is no `fma`, compilers
    /// contract; roots, like sines, are those of binary64 rounded once.
    Lanes,
}

/// An operation on operands, one for each that the operation takes.
pub(crate) fn apply(
    operation: Operation,
    operands: &[BoundText],
    real: Real,
    kind: Operands,
) -> BoundText {
    use Tightness::{Open, Primary, Product, Sum, Unary};
    let operand = |number: usize, least: Tightness| operands[number].within(least);
    let binary = |sign: &str, own: Tightness| {
        let (left, right) = (operand(0, own), operand(1, own.next()));
        BoundText::new(format!("{left} {sign} {right}"), own)
    };
    match operation {
        Operation::Copy => BoundText::primary(operand(0, Primary)),
        Operation::Neg => BoundText::new(format!("-{}", operand(0, Primary)), Unary),
        Operation::Add => binary("+", Sum),
        Operation::Sub => binary("-", Sum),
        Operation::Mul => binary("*", Product),
        Operation::Div => binary("/", Product),
        Operation::Sqrt if kind == Operands::Numbers && real == Real::Float => {
            BoundText::primary(format!("sqrtf({})", operand(0, Open)))
        }
        Operation::Sin | Operation::Cos | Operation::Sqrt => {
            library(operation.name(), &operands[0], real, kind)
        }
        Operation::Fma | Operation::Fms | Operation::Fnma => match kind {
            Operands::Numbers => fused(operation, operands, real),
            Operands::Lanes => contracted(operation, operands),
        },
    }
}

/// A call of the library's function for binary64.
fn library(name: &str, operand: &BoundText, real: Real, kind: Operands) -> BoundText {
    let least = match kind {
        Operands::Numbers => Tightness::Open,
        Operands::Lanes => Tightness::Unary,
    };
    match real {
        Real::Double => BoundText::primary(format!("{name}({})", operand.within(least))),
        Real::Float => {
            let operand = operand.within(Tightness::Unary);
            BoundText::new(
                format!("(float){name}((double){operand})"),
                Tightness::Unary,
            )
        }
    }
}

/// A call of `fma`.
fn fused(operation: Operation, operands: &[BoundText], real: Real) -> BoundText {
    let signed = |number: usize, minus: bool| {
        if minus {
            format!("-{}", operands[number].within(Tightness::Primary))
        } else {
            operands[number].text.clone()
        }
    };
    let function = match real {
        Real::Double => "fma",
        Real::Float => "fmaf",
    };
    let first = signed(0, operation == Operation::Fnma);
    let (middle, last) = (signed(1, false), signed(2, operation == Operation::Fms));
    BoundText::primary(format!("{function}({first}, {middle}, {last})"))
}

/// The same as a product and a sum.
fn contracted(operation: Operation, operands: &[BoundText]) -> BoundText {
    let [a, b] = [0, 1].map(|number| operands[number].within(Tightness::Unary));
    let c = operands[2].within(Tightness::Unary);
    let text = match operation {
        Operation::Fms => format!("{a} * {b} - {c}"),
        Operation::Fnma => format!("{c} - {a} * {b}"),
        _ => format!("{a} * {b} + {c}"),
    };
    BoundText::new(text, Tightness::Sum)
}

/// A number as a literal that reads back as the same number.
pub(crate) fn literal(number: f64, real: Real) -> BoundText {
    let size = size(number, real).unwrap_or_else(|| not_finite(number).to_owned());
    signed(number, size, Tightness::Unary)
}

/// The same for [`Operands::Lanes`]: a number that is not finite has the type
/// of a lane, and a sign always has parentheses.
pub(crate) fn lane_literal(number: f64, real: Real) -> BoundText {
    let cast = || format!("({}){}", real.name(), not_finite(number));
    let size = size(number, real).unwrap_or_else(cast);
    signed(number, size, Tightness::Open)
}

/// The digits of a number without its sign, if it is finite in its type.
fn size(number: f64, real: Real) -> Option<String> {
    let single = number as f32;
    match real {
        Real::Double => number.is_finite().then(|| format!("{:?}", number.abs())),
        Real::Float => single.is_finite().then(|| format!("{:?}f", single.abs())),
    }
}

/// The macro for an infinity or NaN.
fn not_finite(number: f64) -> &'static str {
    if number.is_nan() { "NAN" } else { "INFINITY" }
}

fn signed(number: f64, size: String, negative: Tightness) -> BoundText {
    if number.is_sign_negative() && !number.is_nan() {
        BoundText::new(format!("-{size}"), negative)
    } else {
        BoundText::primary(size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_keep_every_bit_and_their_sign() {
        let double = |number| literal(number, Real::Double).text;
        assert_eq!(double(0.1), "0.1");
        assert_eq!(double(-0.0), "-0.0");
        assert_eq!(double(1e300), "1e300");
        assert_eq!(double(f64::NEG_INFINITY), "-INFINITY");
        assert_eq!(literal(1e300, Real::Float).text, "INFINITY");
        assert_eq!(literal(0.1, Real::Float).text, "0.1f");
        assert_eq!(literal(3.0, Real::Float).text, "3.0f");
    }

    #[test]
    fn literals_of_lanes_have_their_type() {
        let text = |number, real| lane_literal(number, real).text;
        assert_eq!(text(0.1, Real::Double), "0.1");
        assert_eq!(text(-0.0, Real::Float), "-0.0f");
        assert_eq!(text(f64::NEG_INFINITY, Real::Float), "-(float)INFINITY");
        assert_eq!(text(f64::NAN, Real::Double), "(double)NAN");
    }

    #[test]
    fn signs_do_not_run_together() {
        let of = |operation, operands: [BoundText; 3]| {
            apply(operation, &operands, Real::Double, Operands::Lanes).text
        };
        let [a, b, c] = ["a", "b", "c"].map(BoundText::primary);
        let two = || lane_literal(-2.0, Real::Double);
        let sub = [a.clone(), two(), c.clone()];
        assert_eq!(of(Operation::Sub, sub), "a - (-2.0)");
        let neg = [two(), b.clone(), c.clone()];
        assert_eq!(of(Operation::Neg, neg), "-(-2.0)");
        assert_eq!(of(Operation::Fnma, [a, b, c]), "c - a * b");
    }
}
