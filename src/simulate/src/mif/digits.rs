//! Numbers of any base and width.

use super::Radix;

/// A decimal number of 32 bits.
pub(super) fn decimal(digits: &[u8]) -> Option<u32> {
    let mut limb = [0];
    number(digits, Radix::Decimal, 32, &mut limb).then_some(limb[0] as u32)
}

pub(super) fn radix(name: &[u8]) -> Option<Radix> {
    let known = [
        ("bin", Radix::Binary),
        ("oct", Radix::Octal),
        ("dec", Radix::Decimal),
        ("uns", Radix::Decimal),
        ("hex", Radix::Hexadecimal),
    ];
    let found = known
        .iter()
        .find(|(known, _)| name.eq_ignore_ascii_case(known.as_bytes()));
    found.map(|&(_, radix)| radix)
}

/// Reads digits into limbs that are zero; false when there are none, one is
/// foreign, or the number has more than `width` bits.
pub(super) fn number(digits: &[u8], radix: Radix, width: u32, limbs: &mut [u64]) -> bool {
    let zeros = digits.iter().take_while(|&&digit| digit == b'0').count();
    let significant = &digits[zeros..];
    // Every digit behind the leading zeros stands for a bit or more.
    if digits.is_empty() || significant.len() > width as usize {
        return false;
    }
    let fits = match radix {
        Radix::Hexadecimal => shifted(significant, 4, limbs),
        Radix::Octal => shifted(significant, 3, limbs),
        Radix::Binary => shifted(significant, 1, limbs),
        Radix::Decimal => multiplied(significant, limbs),
    };
    let used = width % 64;
    let top = (width / 64) as usize;
    fits && (used == 0 || limbs.get(top).is_none_or(|limb| limb >> used == 0))
}

/// Digits of a base that is a power of two, from the last to the first.
fn shifted(digits: &[u8], bits: u32, limbs: &mut [u64]) -> bool {
    let (mut limb, mut shift) = (0, 0);
    for &digit in digits.iter().rev() {
        let Some(digit) = (digit as char).to_digit(1 << bits) else {
            return false;
        };
        let wide = u128::from(digit) << shift;
        for (limb, part) in [(limb, wide as u64), (limb + 1, (wide >> 64) as u64)] {
            match limbs.get_mut(limb) {
                Some(limb) => *limb |= part,
                None if part != 0 => return false,
                None => {}
            }
        }
        shift += bits;
        if shift >= 64 {
            (limb, shift) = (limb + 1, shift - 64);
        }
    }
    true
}

/// Decimal digits, from the first to the last.
fn multiplied(digits: &[u8], limbs: &mut [u64]) -> bool {
    for &digit in digits {
        let Some(digit) = (digit as char).to_digit(10) else {
            return false;
        };
        let mut carry = u128::from(digit);
        for limb in limbs.iter_mut() {
            let product = u128::from(*limb) * 10 + carry;
            *limb = product as u64;
            carry = product >> 64;
        }
        if carry != 0 {
            return false;
        }
    }
    true
}
