//! Operands that find mistakes: every kind of number beside random ones.

use crate::NumberFormat;
use crate::random::Random;

/// A word of a float format from its fields.
fn word(format: NumberFormat, negative: bool, exponent: u64, mantissa: u64) -> u64 {
    (u64::from(negative) << format.exponent | exponent) << format.mantissa | mantissa
}

/// Zeros, ends of the subnormal and normal ranges, ones and their
/// neighbours, ties, infinities, NaN; of both signs. The `few` most useful
/// ones or all.
pub(super) fn special(format: NumberFormat, few: bool) -> Vec<u64> {
    let mantissa = format.mantissa;
    let ones = (1u64 << mantissa) - 1;
    let top = (1u64 << format.exponent) - 1;
    let one = top >> 1;
    let half = 1u64 << (mantissa - 1);
    let telling = [
        (0, 0),
        (0, 1),
        (0, ones),
        (1, 0),
        (1, 1),
        (one, 0),
        (one, 1),
        (one - 1, ones),
        (top - 1, ones),
        (top, 0),
        (top, half),
    ];
    // The exponents at which a sum with one is a tie, a bit further, and
    // those whose products and quotients meet the ends of the range.
    let behind = u64::from(mantissa);
    let more = [
        (0, half),
        (0, ones >> 1),
        (1, ones),
        (2, 0),
        (one, half),
        (one, ones),
        (one + 1, 0),
        (one + 1, half),
        (one.saturating_sub(behind), 0),
        (one.saturating_sub(behind + 1), 0),
        (one.saturating_sub(behind + 1), 1),
        (one.saturating_sub(behind + 2), ones),
        ((one + behind).min(top - 1), 1),
        ((one + behind + 1).min(top - 1), 0),
        (one / 2, ones),
        (one / 2 + 1, 1),
        (one + one / 2, ones),
        (top - 1, 0),
    ];
    let more = if few { &more[..0] } else { &more[..] };
    let words = telling.iter().chain(more).flat_map(|&(exponent, bits)| {
        [false, true].map(|negative| word(format, negative, exponent, bits & ones))
    });
    let mut words: Vec<u64> = words.collect();
    words.sort_unstable();
    words.dedup();
    words
}

/// Any word of the format: evenly distributed bits, or few bits set at one
/// end of the mantissa, which makes ties.
pub(super) fn any(random: &mut Random, format: NumberFormat) -> u64 {
    let width = 1 + format.exponent + format.mantissa;
    let bits = random.bits() >> (64 - width);
    let shift = random.below(format.mantissa as usize + 1) as u32;
    let mantissa = (1u64 << format.mantissa) - 1;
    match random.below(4) {
        0 => bits & !(mantissa >> shift),
        1 => bits & !mantissa | bits & (mantissa >> shift),
        _ => bits,
    }
}

/// A word whose exponent is near that of another, as often as not.
pub(super) fn near(random: &mut Random, format: NumberFormat, other: u64) -> u64 {
    let word = any(random, format);
    if random.below(2) == 0 {
        return word;
    }
    let ones = (1i64 << format.exponent) - 1;
    let spread = 2 * format.mantissa as usize + 9;
    let offset = random.below(spread) as i64 - spread as i64 / 2;
    let exponent = ((other >> format.mantissa) as i64 & ones) + offset;
    let exponent = exponent.clamp(0, ones - 1) as u64;
    word & !((ones as u64) << format.mantissa) | exponent << format.mantissa
}
