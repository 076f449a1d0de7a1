//! Arithmetic modulo an odd number below 2⁶², in Montgomery's form, and the
//! primes that rules are judged with.
//!
//! The primes are drawn, not chosen, so that no constant in a rule can be made
//! to vanish in them; and they have `p = 2042040 r - 1` with a prime `r`:
//!
//! - `p` leaves 3 modulo 4, so that of the two roots of a square exactly one
//!   is a square, which plays the part of the positive root;
//! - 2, 3, 5, 7, 11, 13 and 17 divide `p + 1`, so that they are squares
//!   themselves and play the part of positive numbers, as they should;
//! - the points of the unit circle form a group of `p + 1` elements, of which
//!   those of order `r` stand for angles: multiplication by any rational
//!   number whose denominator `r` does not divide has an inverse there.

use super::super::random::Random;

/// What divides `p + 1` beside `r`.
pub(super) const COFACTOR: u64 = 2_042_040;

/// A modulus; the numbers it works on are in Montgomery's form and below it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::rules) struct Modulus {
    modulus: u64,
    /// `-1/modulus` modulo 2⁶⁴.
    inverse: u64,
    /// 2¹²⁸ modulo the modulus: takes a number into the form.
    square: u64,
}

impl Modulus {
    /// The arithmetic of an odd modulus below 2⁶².
    pub(super) fn new(modulus: u64) -> Modulus {
        let mut inverse = modulus;
        // Newton's iteration doubles the bits that are right, three at first.
        for _ in 0..5 {
            inverse = inverse.wrapping_mul(2u64.wrapping_sub(modulus.wrapping_mul(inverse)));
        }
        let wide = u128::from(modulus);
        let word = (1u128 << 64) % wide;
        Modulus {
            modulus,
            inverse: inverse.wrapping_neg(),
            square: (word * word % wide) as u64,
        }
    }

    /// The modulus itself.
    pub(in crate::rules) fn modulus(self) -> u64 {
        self.modulus
    }

    /// A number in Montgomery's form.
    pub(super) fn number(self, plain: u64) -> u64 {
        self.mul(plain % self.modulus, self.square)
    }

    /// A number out of Montgomery's form.
    pub(super) fn plain(self, number: u64) -> u64 {
        self.mul(number, 1)
    }

    #[inline]
    pub(super) fn mul(self, a: u64, b: u64) -> u64 {
        let product = u128::from(a) * u128::from(b);
        let factor = (product as u64).wrapping_mul(self.inverse);
        let sum = product + u128::from(factor) * u128::from(self.modulus);
        self.fold((sum >> 64) as u64)
    }

    #[inline]
    pub(super) fn add(self, a: u64, b: u64) -> u64 {
        self.fold(a + b)
    }

    #[inline]
    pub(super) fn neg(self, a: u64) -> u64 {
        self.fold(self.modulus - a)
    }

    #[inline]
    pub(super) fn sub(self, a: u64, b: u64) -> u64 {
        self.fold(a + self.modulus - b)
    }

    /// A number below twice the modulus.
    #[inline]
    fn fold(self, number: u64) -> u64 {
        number.min(number.wrapping_sub(self.modulus))
    }

    /// `base` to a power.
    pub(super) fn power(self, base: u64, mut exponent: u64) -> u64 {
        let (mut result, mut square) = (self.number(1), base);
        while exponent > 0 {
            if exponent & 1 == 1 {
                result = self.mul(result, square);
            }
            square = self.mul(square, square);
            exponent >>= 1;
        }
        result
    }

    /// The inverse of a number that is not zero, modulo a prime.
    pub(super) fn invert(self, a: u64) -> u64 {
        self.power(a, self.modulus - 2)
    }

    /// The dyadic rational that a finite binary64 number is, modulo a prime.
    pub(super) fn literal(self, number: f64) -> u64 {
        let bits = number.to_bits();
        let exponent = (bits >> 52 & 0x7ff) as i64;
        let fraction = bits & ((1 << 52) - 1);
        let (mantissa, power) = match exponent {
            0 => (fraction, -1074),
            _ => (fraction | 1 << 52, exponent - 1075),
        };
        let two = match power < 0 {
            true => self.number(self.modulus / 2 + 1),
            false => self.number(2),
        };
        let scale = self.power(two, power.unsigned_abs());
        let magnitude = self.mul(self.number(mantissa), scale);
        match number < 0.0 {
            true => self.neg(magnitude),
            false => magnitude,
        }
    }
}

/// Draws primes `p = 2042040 r - 1` and `r`, `p` between 2⁶⁰ and 2⁶¹.
pub(super) fn primes(random: &mut Random) -> (u64, u64) {
    let (lowest, highest) = ((1 << 60) / COFACTOR + 1, (1u64 << 61) / COFACTOR);
    loop {
        let factor = (lowest + random.next() % (highest - lowest)) | 1;
        let prime = COFACTOR * factor - 1;
        if is_prime(factor) && is_prime(prime) {
            return (prime, factor);
        }
    }
}

/// Divisors to try before anything dearer.
const SMALL: [u64; 14] = [3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47];

/// Bases with which the test of Miller and Rabin errs on no number of 64 bits
/// (found by Sinclair).
const BASES: [u64; 7] = [2, 325, 9375, 28178, 450_775, 9_780_504, 1_795_265_022];

/// True for a prime; for odd numbers from 49 to 2⁶².
fn is_prime(number: u64) -> bool {
    if SMALL.iter().any(|small| number.is_multiple_of(*small)) {
        return false;
    }
    let modulus = Modulus::new(number);
    let (one, minus) = (modulus.number(1), modulus.number(number - 1));
    let halvings = (number - 1).trailing_zeros();
    BASES.iter().all(|&base| {
        let mut power = modulus.power(modulus.number(base), (number - 1) >> halvings);
        if power == one || power == minus || base % number == 0 {
            return true;
        }
        (1..halvings).any(|_| {
            power = modulus.mul(power, power);
            power == minus
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primes_have_the_form_that_rules_need() {
        let mut random = Random::new(1);
        for _ in 0..20 {
            let (prime, factor) = primes(&mut random);
            assert_eq!(prime + 1, COFACTOR * factor);
            assert!((1 << 60..1 << 61).contains(&prime), "{prime}");
            let modulus = Modulus::new(prime);
            for positive in [2, 3, 5, 7, 11, 13, 17] {
                let power = modulus.power(modulus.number(positive), (prime - 1) / 2);
                assert_eq!(modulus.plain(power), 1, "{positive} is a square");
            }
        }
    }

    #[test]
    fn primes_are_told_from_products() {
        let found: Vec<u64> = (49..200).step_by(2).filter(|&n| is_prime(n)).collect();
        let slow = |n: &u64| (2..*n).all(|divisor| n % divisor != 0);
        let expected: Vec<u64> = (49..200).filter(slow).collect();
        assert_eq!(found, expected);
        assert!(is_prime((1 << 61) - 1) && !is_prime((1 << 59) - 1));
        // A product of two primes that passes the test with base 2.
        assert!(!is_prime(4_335_207) && !is_prime(3_215_031_751));
    }

    #[test]
    fn numbers_are_those_of_plain_arithmetic() {
        let mut random = Random::new(2);
        let (prime, _) = primes(&mut random);
        let modulus = Modulus::new(prime);
        let wide = u128::from(prime);
        for _ in 0..200 {
            let (a, b) = (random.next() % prime, random.next() % prime);
            let (x, y) = (modulus.number(a), modulus.number(b));
            let plain = |number| u128::from(modulus.plain(number));
            assert_eq!(plain(x), u128::from(a));
            assert_eq!(
                plain(modulus.mul(x, y)),
                u128::from(a) * u128::from(b) % wide
            );
            assert_eq!(
                plain(modulus.add(x, y)),
                (u128::from(a) + u128::from(b)) % wide
            );
            assert_eq!(modulus.add(modulus.sub(x, y), y), x);
            assert_eq!(plain(modulus.mul(x, modulus.invert(x))), 1);
        }
        for (number, times, product) in [(0.75, 4, 3), (-2.5, 2, prime - 5), (1e3, 1, 1000)] {
            let found = modulus.mul(modulus.literal(number), modulus.number(times));
            assert_eq!(modulus.plain(found), product, "{number}");
        }
        let tiny = modulus.mul(modulus.literal(5e-324), modulus.literal(2f64.powi(1000)));
        assert_eq!(tiny, modulus.literal(2f64.powi(-74)));
        // The powers of two that are one modulo 2⁶¹ - 1.
        assert_ne!(modulus.literal(2f64.powi(61)), modulus.number(1));
    }
}
