//! Binary64 results rounded to odd, then once into the format.
//!
//! Rounding to odd takes, of the two neighbours of a result that is not exact,
//! the one whose last bit is set. That bit then means "and a little more or
//! less", so the second rounding knows the side of a tie on which the exact
//! result is, if the format has at least two bits less than binary64. The
//! error-free transformations that show the error of the first rounding hold
//! only far from the ends of binary64's range; near them, and for formats with
//! more bits, [`exact`] computes with integers instead.

use super::exact;
use super::rounding::Rounding;

/// Products and quotients at least this large have an exact error term:
/// its last bit is 2 * 53 places further down.
const LEAST: f64 = f64::from_bits((1023 - 850) << 52);
/// Results up to here leave room for the intermediate results of their errors.
const MOST: f64 = f64::from_bits((1023 + 1000) << 52);

/// True where error terms are exact.
#[inline]
pub(super) fn is_tame(number: f64) -> bool {
    let size = number.abs();
    (LEAST..=MOST).contains(&size)
}

/// The neighbour with an odd last bit, from the nearest binary64 number of a
/// value and a number with the sign of the difference.
#[inline]
pub(super) fn odd(nearest: f64, error: f64) -> f64 {
    let bits = nearest.to_bits();
    let inexact = u64::from(error != 0.0);
    let beyond = (bits ^ error.to_bits()) >> 63 & inexact;
    f64::from_bits((bits - beyond) | inexact)
}

/// `a + b` rounded to odd; both far below the largest number.
#[inline]
pub(super) fn odd_sum(a: f64, b: f64) -> f64 {
    let (sum, error) = two_sum(a, b);
    odd(sum, error)
}

/// `a + b` to nearest and its rounding error (Knuth).
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// `a + b`, rounded once.
#[inline]
pub(super) fn sum([a, b]: [f64; 2], rounding: &Rounding) -> f64 {
    let (nearest, error) = two_sum(a, b);
    // Sums do not underflow, and far below the largest number nothing
    // overflows on the way; a sum that is no number fails the comparison.
    if rounding.is_narrow() && nearest.abs() <= MOST {
        return rounding.round_result(odd(nearest, error));
    }
    match exact::sum(a, b) {
        Some(sum) => rounding.round_exact(sum),
        None => rounding.round_result(nearest),
    }
}

/// `a * b`, rounded once.
#[inline]
pub(super) fn product([a, b]: [f64; 2], rounding: &Rounding) -> f64 {
    let nearest = a * b;
    if rounding.is_narrow() && is_tame(nearest) {
        return rounding.round_result(odd(nearest, a.mul_add(b, -nearest)));
    }
    exact_product(a, b, nearest, rounding)
}

/// `a * b` in binary64 without subnormal numbers.
#[inline]
pub(super) fn flushed_product(a: f64, b: f64, rounding: &Rounding) -> f64 {
    let nearest = a * b;
    if is_tame(nearest) {
        return nearest;
    }
    exact_product(a, b, nearest, rounding)
}

fn exact_product(a: f64, b: f64, nearest: f64, rounding: &Rounding) -> f64 {
    match exact::product(a, b) {
        Some(product) => rounding.round_exact(product),
        None => rounding.round_result(nearest),
    }
}

/// `a / b`, rounded once.
#[inline]
pub(super) fn quotient([a, b]: [f64; 2], rounding: &Rounding) -> f64 {
    let nearest = a / b;
    if rounding.is_narrow() && is_tame(nearest) && is_tame(a) && is_tame(b) {
        let rest = (-nearest).mul_add(b, a);
        // What is missing is rest / b.
        let error = if rest == 0.0 {
            0.0
        } else {
            rest.copysign(f64::from_bits(rest.to_bits() ^ b.to_bits()))
        };
        return rounding.round_result(odd(nearest, error));
    }
    match exact::quotient(a, b) {
        Some(quotient) => rounding.round_exact(quotient),
        None => rounding.round_result(nearest),
    }
}

/// `sqrt(a)`, rounded once.
#[inline]
pub(super) fn root([a]: [f64; 1], rounding: &Rounding) -> f64 {
    let nearest = a.sqrt();
    if rounding.is_narrow() && is_tame(a) && nearest > 0.0 {
        return rounding.round_result(odd(nearest, (-nearest).mul_add(nearest, a)));
    }
    match exact::root(a) {
        Some(root) => rounding.round_exact(root),
        None => rounding.round_result(nearest),
    }
}

/// `a * b + c`, rounded once (Boldo and Melquiond, figure 5, with the last
/// sum rounded to odd as well, because a rounding follows).
#[inline]
pub(super) fn fused([a, b, c]: [f64; 3], rounding: &Rounding) -> f64 {
    let product = a * b;
    if rounding.is_narrow() && is_tame(product) && c.abs() <= MOST {
        let rest = a.mul_add(b, -product);
        let (low, lowest) = two_sum(c, rest);
        let (high, middle) = two_sum(product, low);
        return rounding.round_result(odd_sum(high, odd_sum(middle, lowest)));
    }
    match exact::fused(a, b, c) {
        Some(sum) => rounding.round_exact(sum),
        None => rounding.round_result(a.mul_add(b, c)),
    }
}
