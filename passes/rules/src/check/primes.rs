//! The primes that rules are judged with.
//!
//! The primes are drawn, not chosen, so that no constant in a rule can be made
//! to vanish in them; and they have `p = 2042040 r - 1` with a prime `r`:
//!
//! - `p` leaves 3 modulo 4, so that of the two roots of a square exactly one
//!   is a square, which plays the part of the positive root;
//! - 2, 3, 5, 7, 11, 13 and 17 divide `p + 1`, so that they are squares
//!   themselves and play the part of positive numbers, as they should;
//! - the points of the unit circle form a group of `p + 1` elements, of which
//!   those of order `r` represent angles: multiplication by any rational
//!   number whose denominator `r` does not divide has an inverse there.

use robovec_num::field::is_prime;
use robovec_num::random::Random;

/// The cofactor of `r` in `p + 1`.
pub(super) const COFACTOR: u64 = 2_042_040;

/// Draws primes `p = 2042040 r - 1` and `r`, `p` between 2⁶⁰ and 2⁶¹.
pub(super) fn primes(random: &mut Random) -> (u64, u64) {
    let (lowest, highest) = ((1 << 60) / COFACTOR + 1, (1u64 << 61) / COFACTOR);
    loop {
        let factor = (lowest + random.bits() % (highest - lowest)) | 1;
        let prime = COFACTOR * factor - 1;
        if is_prime(factor) && is_prime(prime) {
            return (prime, factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_num::field::Modulus;

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
}
