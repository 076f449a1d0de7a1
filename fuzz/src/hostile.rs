//! Constants chosen to be taken for other ones.
//!
//! A check modulo a number confuses numbers that differ by it, a check in
//! floating point those that differ by less than a rounding, and a pass that
//! folds constants may round, overflow or lose a sign. So: powers of two around
//! 61 and 122, the primes around them as sums of two literals, neighbours of
//! one, numbers that decimals and powers of two cannot both hold, the ends of
//! the range, and both zeros.

use arbitrary::{Result, Unstructured};

/// Powers of two that are one, or near it, modulo a number of 61 bits, or
/// that end the precision of a format.
const EXPONENTS: [i32; 14] = [61, 62, 60, 63, 64, 122, 123, 121, 183, 53, 52, 24, 31, 127];

/// Numbers that are tested unchanged.
const PLAIN: [f64; 16] = [
    1.0,
    -1.0,
    2.0,
    3.0,
    0.5,
    0.1,
    -0.1,
    0.3,
    -0.0,
    0.0,
    1.0 + f64::EPSILON,
    1.0 - f64::EPSILON / 2.0,
    -1.0 - f64::EPSILON,
    9.81,
    1e15 + 1.0,
    0.333_333_333_333_333_3,
];

/// Numbers near the ends of the range.
const EXTREME: [f64; 10] = [
    f64::MAX,
    f64::MIN_POSITIVE,
    5e-324,
    -3e-310,
    1e300,
    -1e-300,
    1e155,
    1e-160,
    3.402_823_466_385_288_6e38,
    1.2e-38,
];

/// Primes as the nearest literal of binary64 and the rest.
const PRIMES: [[f64; 2]; 10] = [
    // 2^61 - 1, 2^61 - 31, 2^61 - 45, 2^61 - 229, 2^61 - 259.
    [2_305_843_009_213_693_952.0, -1.0],
    [2_305_843_009_213_693_952.0, -31.0],
    [2_305_843_009_213_693_952.0, -45.0],
    [2_305_843_009_213_693_952.0, -229.0],
    [2_305_843_009_213_693_952.0, -259.0],
    // 2^62 - 57, 2^62 - 87.
    [4_611_686_018_427_387_904.0, -57.0],
    [4_611_686_018_427_387_904.0, -87.0],
    // 2^60 - 93, 2^63 - 25, 2^31 - 1.
    [1_152_921_504_606_846_976.0, -93.0],
    [9_223_372_036_854_775_808.0, -25.0],
    [2_147_483_648.0, -1.0],
];

/// A literal.
pub(crate) fn number(bytes: &mut Unstructured<'_>) -> Result<f64> {
    Ok(match bytes.int_in_range(0..=15)? {
        0..=6 => power(bytes)?,
        7..=8 => {
            let factor = f64::from(bytes.int_in_range(-9..=9)?);
            factor * power(bytes)?
        }
        9 => *bytes.choose(&EXTREME)?,
        10 => {
            let number = f64::from_bits(bytes.arbitrary()?);
            // Of all exponents most would overflow in the next product.
            let usual = (1e-60..1e60).contains(&number.abs());
            if usual { number } else { 2.5 }
        }
        _ => *bytes.choose(&PLAIN)?,
    })
}

/// A power of two or of its negative, or a number next to it.
fn power(bytes: &mut Unstructured<'_>) -> Result<f64> {
    let exponent = *bytes.choose(&EXPONENTS)?;
    let exponent = if bytes.arbitrary()? {
        exponent
    } else {
        -exponent
    };
    let power = 2f64.powi(exponent);
    let power = match bytes.int_in_range(0..=9)? {
        0 => power.next_up(),
        1 => power.next_down(),
        _ => power,
    };
    Ok(if bytes.ratio(1, 4)? { -power } else { power })
}

/// Two literals whose sum is a prime, and no literal itself.
pub(crate) fn prime(bytes: &mut Unstructured<'_>) -> Result<[f64; 2]> {
    bytes.choose(&PRIMES).copied()
}

/// An input: near and far, whole and not, of either sign.
pub(crate) fn input(random: u64) -> f64 {
    let (choice, bits) = (random & 15, random >> 4);
    let unit = bits as f64 / (1u64 << 60) as f64;
    let signed = 2.0 * unit - 1.0;
    let sign = if bits & 1 == 0 { 1.0 } else { -1.0 };
    match choice {
        0..=4 => signed * 3.0,
        5..=7 => (bits % 9) as f64 - 4.0,
        8 => sign * 1e3 * unit,
        9 => sign * (1.0 + unit) * 1e-8,
        10 => sign * (bits % 4096) as f64 / 64.0,
        11 => sign * 2f64.powi((bits % 130) as i32 - 65),
        12 => sign * (1.0 + unit) * 1e9,
        13 => sign * (bits % 1_000_000_007) as f64,
        14 => sign * 0.1 * (1 + bits % 50) as f64,
        _ => signed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sums_are_primes_that_no_literal_is() {
        for [high, low] in PRIMES {
            let prime = high as u128 - (-low) as u128;
            // Fermat's test with several bases is beyond doubt for numbers
            // that were looked up.
            for base in [2u128, 3, 5, 7, 11, 13] {
                let (mut power, mut square, mut exponent) = (1u128, base, prime - 1);
                while exponent > 0 {
                    if exponent & 1 == 1 {
                        power = power * square % prime;
                    }
                    square = square * square % prime;
                    exponent >>= 1;
                }
                assert_eq!(power, 1, "{prime} by {base}");
            }
            assert!(prime as f64 as u128 != prime || prime < 1 << 53, "{prime}");
        }
    }
}
