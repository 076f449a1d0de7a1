//! Numbers as words of a memory image, and the host's arithmetic.
//!
//! Numbers travel as binary64, which holds every binary32 number exactly.

use super::ImageError;
use robovec_ir::Operation;
use robovec_ir::arithmetic::{Arithmetic, Binary32, Binary64};
use robovec_ir::machine::NumberFormat;

/// The machine's words, of a format that data images can be written in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoding {
    double: bool,
    flush: bool,
}

impl Encoding {
    /// The encoding of a format.
    ///
    /// # Errors
    ///
    /// For formats other than binary32 and binary64: their arithmetic on the
    /// host is not there yet.
    pub(super) fn new(format: NumberFormat) -> Result<Encoding, ImageError> {
        let double = match (format.exponent, format.mantissa) {
            (8, 23) => false,
            (11, 52) => true,
            (exponent, mantissa) => {
                return Err(ImageError::Number(format!(
                    "data images are written for binary32 (8+23 bits) and binary64 (11+52 bits), \
                     not for {exponent}+{mantissa} bits"
                )));
            }
        };
        Ok(Encoding {
            double,
            flush: !format.subnormals,
        })
    }

    /// Bits of a word.
    pub(super) fn width(self) -> u32 {
        if self.double { 64 } else { 32 }
    }

    /// The nearest number of the format; zero for a subnormal one where the
    /// machine has none.
    pub(super) fn rounded(self, number: f64) -> f64 {
        let (number, least) = if self.double {
            (number, f64::MIN_POSITIVE)
        } else {
            let single = Binary32.literal(number);
            (f64::from(single), f64::from(f32::MIN_POSITIVE))
        };
        if self.flush && number.abs() < least {
            0.0f64.copysign(number)
        } else {
            number
        }
    }

    /// The word of a number of the format.
    pub(super) fn word(self, number: f64) -> u64 {
        if self.double {
            number.to_bits()
        } else {
            u64::from((number as f32).to_bits())
        }
    }

    /// What the host computes from numbers of the format.
    pub(super) fn apply(self, operation: Operation, operands: [f64; 3]) -> f64 {
        let raw = if self.double {
            apply(&Binary64, operation, operands)
        } else {
            f64::from(apply(
                &Binary32,
                operation,
                operands.map(|number| number as f32),
            ))
        };
        self.rounded(raw)
    }
}

fn apply<A: Arithmetic>(
    arithmetic: &A,
    operation: Operation,
    [a, b, c]: [A::Number; 3],
) -> A::Number {
    match operation {
        Operation::Copy => a,
        Operation::Neg => arithmetic.neg(a),
        Operation::Add => arithmetic.add(a, b),
        Operation::Sub => arithmetic.sub(a, b),
        Operation::Mul => arithmetic.mul(a, b),
        Operation::Div => arithmetic.div(a, b),
        Operation::Sin => arithmetic.sin(a),
        Operation::Cos => arithmetic.cos(a),
        Operation::Sqrt => arithmetic.sqrt(a),
        Operation::Fma => arithmetic.fma(a, b, c),
        Operation::Fms => arithmetic.fms(a, b, c),
        Operation::Fnma => arithmetic.fnma(a, b, c),
    }
}
