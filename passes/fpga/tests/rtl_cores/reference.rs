//! Expected results: `rustc_apfloat`, a port of LLVM's arithmetic, on the words
//! of any format listed here.
//!
//! The simulator's arithmetic must agree with it, words of NaN included, so
//! that the simulator predicts the hardware; with the feature `softfloat`
//! Berkeley SoftFloat must agree as well. Formats without subnormal numbers
//! have their rule put on top here: small operands count as zero, and a result
//! is too small when it is so rounded towards zero.

use robovec_fpga::rtl::cores::OperatorCore;
use robovec_ir::{Format, Operation};
use robovec_num::NumberFormat;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::soft_float::FormatArithmetic;
use rustc_apfloat::ieee::{IeeeFloat, Quad, Semantics};
use rustc_apfloat::{Float, FloatConvert, Round, StatusAnd};
use std::cmp::Ordering;

/// The arithmetic of a format on words.
pub(crate) struct Reference {
    format: NumberFormat,
    simulator: FormatArithmetic,
}

/// An operation on words, rounded in one of two ways.
type Applied = fn(Operation, [u64; 3], Direction) -> u64;

/// Direction in which a result is rounded.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Direction {
    Nearest,
    TowardZero,
}

impl Reference {
    pub(crate) fn new(format: NumberFormat) -> Reference {
        Reference {
            format,
            simulator: FormatArithmetic::new(Format::Float(format)),
        }
    }

    pub(crate) fn simulator(&self) -> &FormatArithmetic {
        &self.simulator
    }

    /// The word of a result, on which all references agree.
    pub(crate) fn result(&self, core: OperatorCore, operation: u64, words: [u64; 3]) -> u64 {
        let operation = operation_of(core, operation);
        let numbers = words.map(|word| self.simulator.from_word(word));
        let simulated = self
            .simulator
            .word(self.simulator.apply(operation, numbers));
        for other in self.others() {
            let expected = self.ruled(other, operation, words, simulated);
            assert_eq!(
                simulated, expected,
                "{operation:?} of {words:x?} in {:?}: the simulator gives {simulated:#x}, not {expected:#x}",
                self.format
            );
        }
        simulated
    }

    fn others(&self) -> impl Iterator<Item = Applied> {
        let format = (self.format.exponent, self.format.mantissa);
        [apfloat(format), softfloat(format)].into_iter().flatten()
    }

    /// Result of another implementation under the rules of the format.
    fn ruled(&self, other: Applied, operation: Operation, words: [u64; 3], ours: u64) -> u64 {
        if operation == Operation::Sqrt {
            return self.root(words[0], ours);
        }
        let apply = |words, direction| self.canonical(other(operation, words, direction));
        if self.format.subnormals {
            return apply(words, Direction::Nearest);
        }
        let words = words.map(|word| self.flushed(word));
        // An exact zero is one in either direction, with the same sign.
        let truncated = apply(words, Direction::TowardZero);
        if self.is_small(truncated) {
            self.flushed(truncated)
        } else {
            apply(words, Direction::Nearest)
        }
    }

    /// The root of a word, given the expected result: correct when the word
    /// lies between the squares of the midpoints to both neighbours, which
    /// binary128 represents exactly.
    fn root(&self, word: u64, ours: u64) -> u64 {
        let number = self.simulator.from_word(word);
        if number.is_nan() || number < 0.0 {
            return self.canonical(u64::MAX >> (64 - Format::Float(self.format).width()));
        }
        if number == 0.0 || number.is_infinite() {
            return self.simulator.word(number);
        }
        let quad = |number: f64| -> Quad {
            let number = rustc_apfloat::ieee::Double::from_bits(u128::from(number.to_bits()));
            let wide: StatusAnd<Quad> = number.convert(&mut false);
            wide.value
        };
        let at = |word: u64| quad(self.simulator.from_word(word));
        let middle = |a: Quad, b: Quad| (a + b).value.scalbn(-1);
        let below = middle(at(ours.wrapping_sub(1)), at(ours));
        let above = middle(at(ours), at(ours + 1));
        let order = |middle: Quad| (middle * middle).value.partial_cmp(&quad(number));
        // A root is never a middle: that would have a bit more than half of
        // the bits of its square, but for subnormal roots.
        let right = order(below) != Some(Ordering::Greater) && order(above) != Some(Ordering::Less);
        if right { ours } else { !ours }
    }

    /// The word, with the one NaN for any.
    fn canonical(&self, word: u64) -> u64 {
        let ones = (1u64 << self.format.exponent) - 1;
        let mantissa = self.format.mantissa;
        let is_nan = word >> mantissa & ones == ones && word & ((1 << mantissa) - 1) != 0;
        if is_nan {
            ones << mantissa | 1 << (mantissa - 1)
        } else {
            word
        }
    }

    fn is_small(&self, word: u64) -> bool {
        word >> self.format.mantissa & ((1 << self.format.exponent) - 1) == 0
    }

    fn flushed(&self, word: u64) -> u64 {
        if self.is_small(word) {
            word & 1 << (self.format.exponent + self.format.mantissa)
        } else {
            word
        }
    }
}

fn operation_of(core: OperatorCore, code: u64) -> Operation {
    match (core, code) {
        (OperatorCore::Add, 0) => Operation::Add,
        (OperatorCore::Add, _) => Operation::Sub,
        (OperatorCore::Multiply, _) => Operation::Mul,
        (OperatorCore::Divide, _) => Operation::Div,
        (OperatorCore::Root, _) => Operation::Sqrt,
        (OperatorCore::Fused, 0) => Operation::Fma,
        (OperatorCore::Fused, 1) => Operation::Fms,
        (OperatorCore::Fused, _) => Operation::Fnma,
    }
}

/// A format with these numbers of exponent and mantissa bits.
struct Custom<const EXPONENT: usize, const MANTISSA: usize>;

impl<const EXPONENT: usize, const MANTISSA: usize> Semantics for Custom<EXPONENT, MANTISSA> {
    const BITS: usize = 1 + EXPONENT + MANTISSA;
    const EXP_BITS: usize = EXPONENT;
}

/// The operations of `rustc_apfloat` in a format.
fn apfloat(format: (u32, u32)) -> Option<Applied> {
    let applied: Applied = match format {
        (2, 1) => apfloat_applied::<2, 1>,
        (2, 9) => apfloat_applied::<2, 9>,
        (3, 14) => apfloat_applied::<3, 14>,
        (5, 10) => apfloat_applied::<5, 10>,
        (8, 7) => apfloat_applied::<8, 7>,
        (8, 17) => apfloat_applied::<8, 17>,
        (8, 23) => apfloat_applied::<8, 23>,
        (11, 3) => apfloat_applied::<11, 3>,
        (11, 52) => apfloat_applied::<11, 52>,
        _ => panic!("a format without a reference: {format:?}"),
    };
    Some(applied)
}

fn apfloat_applied<const E: usize, const M: usize>(
    operation: Operation,
    words: [u64; 3],
    direction: Direction,
) -> u64 {
    let rounding = match direction {
        Direction::Nearest => Round::NearestTiesToEven,
        Direction::TowardZero => Round::TowardZero,
    };
    let [a, b, c] = words.map(|word| IeeeFloat::<Custom<E, M>>::from_bits(u128::from(word)));
    let result = match operation {
        Operation::Add => a.add_r(b, rounding),
        Operation::Sub => a.sub_r(b, rounding),
        Operation::Mul => a.mul_r(b, rounding),
        Operation::Div => a.div_r(b, rounding),
        Operation::Fma => a.mul_add_r(b, c, rounding),
        Operation::Fms => a.mul_add_r(b, -c, rounding),
        Operation::Fnma => (-a).mul_add_r(b, c, rounding),
        _ => unreachable!("the core has no such operation"),
    };
    result.value.to_bits() as u64
}

#[cfg(not(feature = "softfloat"))]
fn softfloat(_format: (u32, u32)) -> Option<Applied> {
    None
}

/// The operations of Berkeley SoftFloat in a format that it supports.
#[cfg(feature = "softfloat")]
fn softfloat(format: (u32, u32)) -> Option<Applied> {
    use softfloat_wrapper::{F16, F32, F64, Float as _};
    match format {
        (5, 10) => Some(|operation, words, direction| {
            let numbers = words.map(|word| F16::from_bits(word as u16));
            u64::from(softfloat_applied(operation, numbers, direction).to_bits())
        }),
        (8, 23) => Some(|operation, words, direction| {
            let numbers = words.map(|word| F32::from_bits(word as u32));
            u64::from(softfloat_applied(operation, numbers, direction).to_bits())
        }),
        (11, 52) => Some(|operation, words, direction| {
            let numbers = words.map(F64::from_bits);
            softfloat_applied(operation, numbers, direction).to_bits()
        }),
        _ => None,
    }
}

#[cfg(feature = "softfloat")]
fn softfloat_applied<F: softfloat_wrapper::Float>(
    operation: Operation,
    [a, b, c]: [F; 3],
    direction: Direction,
) -> F {
    use softfloat_wrapper::RoundingMode;
    let rounding = match direction {
        Direction::Nearest => RoundingMode::TiesToEven,
        Direction::TowardZero => RoundingMode::TowardZero,
    };
    match operation {
        Operation::Add => a.add(b, rounding),
        Operation::Sub => a.sub(b, rounding),
        Operation::Mul => a.mul(b, rounding),
        Operation::Div => a.div(b, rounding),
        Operation::Fma => a.fused_mul_add(b, c, rounding),
        Operation::Fms => a.fused_mul_add(b, c.neg(), rounding),
        Operation::Fnma => a.neg().fused_mul_add(b, c, rounding),
        _ => unreachable!("the core has no such operation"),
    }
}
