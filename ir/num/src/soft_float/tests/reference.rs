//! Results of another library, on words.

use rustc_apfloat::ieee::{Double, IeeeFloat, Quad, Semantics};
use rustc_apfloat::{Float, FloatConvert, Round, Status, StatusAnd};
use std::cmp::Ordering;

/// A format with these numbers of exponent and mantissa bits.
pub(super) struct Custom<const EXPONENT: usize, const MANTISSA: usize>;

impl<const EXPONENT: usize, const MANTISSA: usize> Semantics for Custom<EXPONENT, MANTISSA> {
    const BITS: usize = 1 + EXPONENT + MANTISSA;
    const EXP_BITS: usize = EXPONENT;
}

/// The other library's numbers of a format.
pub(super) type Other<const E: usize, const M: usize> = IeeeFloat<Custom<E, M>>;

pub(super) fn read<const E: usize, const M: usize>(word: u64) -> Other<E, M> {
    Other::from_bits(u128::from(word))
}

/// The word of a number; of all that are NaN the same.
pub(super) fn written<const E: usize, const M: usize>(number: Other<E, M>) -> u64 {
    if number.is_nan() {
        let ones = (1u64 << E) - 1;
        return ones << M | 1 << (M - 1);
    }
    number.to_bits() as u64
}

/// True for zeros and for numbers below the smallest normal one.
pub(super) fn is_small<const E: usize, const M: usize>(word: u64) -> bool {
    word >> M & ((1 << E) - 1) == 0
}

/// The word, or the zero that represents it where there are no subnormal
/// numbers.
pub(super) fn flushed<const E: usize, const M: usize>(word: u64) -> u64 {
    if is_small::<E, M>(word) {
        word >> (E + M) << (E + M)
    } else {
        word
    }
}

/// A result where there are no subnormal numbers: judged before rounding, for
/// which rounding towards zero serves.
pub(super) fn flushed_result<const E: usize, const M: usize>(
    truncated: Other<E, M>,
    rounded: u64,
) -> u64 {
    let truncated = truncated.to_bits() as u64;
    if is_small::<E, M>(truncated) {
        flushed::<E, M>(truncated)
    } else {
        rounded
    }
}

/// A binary64 number in the format.
pub(super) fn converted<const E: usize, const M: usize>(number: f64) -> u64 {
    let number = Double::from_bits(u128::from(number.to_bits()));
    let converted: StatusAnd<Other<E, M>> = number.convert(&mut false);
    written(converted.value)
}

/// A number of the format in binary64, exactly.
pub(super) fn widened<const E: usize, const M: usize>(word: u64) -> f64 {
    let mut loses = false;
    let wide: StatusAnd<Double> = read::<E, M>(word).convert(&mut loses);
    assert!(!loses, "every format fits into binary64");
    f64::from_bits(wide.value.to_bits() as u64)
}

/// A number of the format in binary128, exactly.
pub(super) fn quad<const E: usize, const M: usize>(word: u64) -> Quad {
    let wide: StatusAnd<Quad> = read::<E, M>(word).convert(&mut false);
    wide.value
}

/// True when `root` is the number nearest to the root of `square`, both
/// positive and finite: the square lies between those of the middles to both
/// neighbours. Middles have a bit more than numbers, so their squares are
/// exact in binary128.
pub(super) fn is_root<const E: usize, const M: usize>(square: u64, root: u64) -> bool {
    let middle = |a: u64, b: u64| {
        let sum = (quad::<E, M>(a) + quad::<E, M>(b)).value;
        sum.scalbn(-1)
    };
    let (below, above) = (middle(root - 1, root), middle(root, root + 1));
    let square = quad::<E, M>(square);
    let order = |middle: Quad| (middle * middle).value.partial_cmp(&square);
    order(below) == Some(Ordering::Less) && order(above) == Some(Ordering::Greater)
}

/// A binary128 result, computed towards zero, as a number of the format: with
/// its last bit set where it was not exact, nothing is lost.
pub(super) fn rounded<const E: usize, const M: usize>(result: StatusAnd<Quad>) -> u64 {
    let inexact = u128::from(result.status.contains(Status::INEXACT));
    let odd = Quad::from_bits(result.value.to_bits() | inexact);
    let narrow: StatusAnd<Other<E, M>> = odd.convert_r(Round::NearestTiesToEven, &mut false);
    written(narrow.value)
}

/// A binary64 number in binary128.
pub(super) fn quad_of(number: f64) -> Quad {
    let number = Double::from_bits(u128::from(number.to_bits()));
    let wide: StatusAnd<Quad> = number.convert(&mut false);
    wide.value
}
