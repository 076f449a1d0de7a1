//! Primes without structure, and arithmetic modulo them.
//!
//! A field of 2⁶¹ − 1 elements would be the fastest, but 2⁶¹ is 1 there, and
//! programs contain powers of two. The primes here are drawn at random, so
//! that no constant of a program is in any relation to them but by
//! accident.
//!
//! Numbers are kept in Montgomery's form: `x` as `x·2⁶⁴ mod p`, which makes a
//! product two multiplications and no division (P. L. Montgomery, "Modular
//! multiplication without trial division", Mathematics of Computation 44,
//! 1985).
//!
//! **Invariant.** Every prime is below 2⁶¹ and of the form `24r − 1` with `r`
//! prime: −1 is then no square, so that every angle has its point on the
//! circle, 2 and 3 are squares, and the points of the circle have a subgroup of the prime
//! order `r`, in which angles add up ([`super::CircleField`]).

use crate::random::mix;

/// An odd number below 2⁶¹ to compute modulo. Numbers are in Montgomery's
/// form and below the modulus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Modulus {
    /// The modulus itself.
    modulus: u64,
    /// `-1/modulus` modulo 2⁶⁴.
    inverse: u64,
    /// The number 1.
    one: u64,
    /// 2¹²⁸ modulo the modulus, the factor that brings a number into
    /// Montgomery's form.
    square: u64,
}

impl Modulus {
    /// The arithmetic of an odd modulus below 2⁶².
    pub fn new(modulus: u64) -> Modulus {
        // Newton's iteration doubles the correct bits, of which an odd number
        // as its own inverse has three.
        let inverse = (0..5).fold(modulus, |inverse, _| {
            inverse.wrapping_mul(2u64.wrapping_sub(modulus.wrapping_mul(inverse)))
        });
        let one = ((1u128 << 64) % u128::from(modulus)) as u64;
        Modulus {
            modulus,
            inverse: inverse.wrapping_neg(),
            one,
            square: (u128::from(one) * u128::from(one) % u128::from(modulus)) as u64,
        }
    }

    /// A number below twice the modulus, modulo it.
    #[inline]
    fn fold(&self, number: u64) -> u64 {
        number.min(number.wrapping_sub(self.modulus))
    }

    /// The modulus itself.
    #[inline]
    pub fn modulus(&self) -> u64 {
        self.modulus
    }

    /// The number 1.
    #[inline]
    pub fn one(&self) -> u64 {
        self.one
    }

    /// `a + b`.
    #[inline]
    pub fn add(&self, a: u64, b: u64) -> u64 {
        self.fold(a + b)
    }

    /// `-a`.
    #[inline]
    pub fn neg(&self, a: u64) -> u64 {
        self.fold(self.modulus - a)
    }

    /// `a - b`.
    #[inline]
    pub fn sub(&self, a: u64, b: u64) -> u64 {
        self.fold(a + (self.modulus - b))
    }

    /// `a * b`.
    #[inline]
    pub fn mul(&self, a: u64, b: u64) -> u64 {
        let product = u128::from(a) * u128::from(b);
        let factor = (product as u64).wrapping_mul(self.inverse);
        let sum = product + u128::from(factor) * u128::from(self.modulus);
        self.fold((sum >> 64) as u64)
    }

    /// `base` to a natural power.
    pub fn power(&self, base: u64, exponent: u64) -> u64 {
        let (mut result, mut square, mut rest) = (self.one, base, exponent);
        while rest > 0 {
            if rest & 1 == 1 {
                result = self.mul(result, square);
            }
            square = self.mul(square, square);
            rest >>= 1;
        }
        result
    }

    /// The inverse of a number that is not zero, for a modulus that is prime
    /// (Fermat).
    pub fn invert(&self, a: u64) -> u64 {
        self.power(a, self.modulus - 2)
    }

    /// A point of the unit circle, as cosine and sine, times a natural number:
    /// angles add up.
    pub fn turned(&self, point: [u64; 2], times: u64) -> [u64; 2] {
        let sum = |[c, s]: [u64; 2], [d, t]: [u64; 2]| {
            [
                self.sub(self.mul(c, d), self.mul(s, t)),
                self.add(self.mul(c, t), self.mul(s, d)),
            ]
        };
        let (mut result, mut double, mut rest) = ([self.one, 0], point, times);
        while rest > 0 {
            if rest & 1 == 1 {
                result = sum(result, double);
            }
            double = sum(double, double);
            rest >>= 1;
        }
        result
    }

    /// A natural number in Montgomery's form.
    pub fn number(&self, number: u64) -> u64 {
        self.mul(number % self.modulus, self.square)
    }

    /// The natural number below the modulus that a number represents.
    pub fn plain(&self, number: u64) -> u64 {
        self.mul(number, 1)
    }

    /// The exact value of a finite literal, a dyadic rational.
    pub fn literal(&self, number: f64) -> u64 {
        let bits = number.to_bits();
        let exponent = (bits >> 52 & 0x7ff) as i64;
        let fraction = bits & ((1 << 52) - 1);
        let (mantissa, power) = if exponent == 0 {
            (fraction, -1074)
        } else {
            (fraction | 1 << 52, exponent - 1075)
        };
        // The natural number that is half of 1.
        let two = if power < 0 {
            self.modulus.div_ceil(2)
        } else {
            2
        };
        let scale = self.power(self.number(two), power.unsigned_abs());
        let magnitude = self.mul(self.number(mantissa), scale);
        if number < 0.0 {
            self.neg(magnitude)
        } else {
            magnitude
        }
    }

    /// A number from 64 random bits; no number is more than an eighth likelier
    /// than another.
    pub fn spread(&self, bits: u64) -> u64 {
        ((u128::from(bits) * u128::from(self.modulus)) >> 64) as u64
    }
}

/// Number of values that can be made squares: each halves the number of usable
/// primes.
pub const MAX_RADICANDS: usize = 6;

/// A prime of the form `24r − 1` with `r` prime, between 2⁶⁰ and 2⁶¹.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Prime {
    pub(super) field: Modulus,
    /// The order `r` of the subgroup of the circle.
    pub(super) order: Modulus,
    /// Squares that the prime was drawn for, and their roots, which are
    /// squares too; pairs of zeros after the last.
    pub(super) roots: [(u64, u64); MAX_RADICANDS],
}

impl Prime {
    /// Two different primes, the same for the same seed. Costs 70 µs.
    pub fn pair(seed: u64) -> [Prime; 2] {
        Prime::pair_for(seed, &[])
    }

    /// As [`Prime::pair`], but the first [`MAX_RADICANDS`] of these positive
    /// numbers are squares modulo both primes, and the fields know their roots.
    /// The root of a product is then the product of the roots, as for real
    /// numbers. It takes a millisecond on average for six of them.
    pub fn pair_for(seed: u64, radicands: &[f64]) -> [Prime; 2] {
        let radicands = &radicands[..radicands.len().min(MAX_RADICANDS)];
        let first = Prime::draw(mix(seed), radicands);
        let mut salt = mix(seed ^ 0x5eed_0002);
        loop {
            let second = Prime::draw(salt, radicands);
            if second.field != first.field {
                return [first, second];
            }
            salt = mix(salt);
        }
    }

    /// The prime itself.
    pub fn modulus(&self) -> u64 {
        self.field.modulus
    }

    /// The first prime of the form at or after a random place modulo which
    /// the numbers are squares.
    fn draw(bits: u64, mut radicands: &[f64]) -> Prime {
        // 24 times either is between 2⁶⁰ and 2⁶¹.
        const LOWEST: u64 = 3 << 54;
        const HIGHEST: u64 = 4 << 54;
        // One in 2⁶ primes has six squares, so that this many candidates are
        // enough; numbers of which never all are squares lose the last.
        const PATIENCE: u32 = 1 << 21;
        let mut order = (LOWEST + (bits >> 10)) | 1;
        for candidate in 1u32.. {
            if candidate.is_multiple_of(PATIENCE) {
                radicands = radicands.split_last().map_or(&[], |(_, rest)| rest);
            }
            let modulus = 24 * order - 1;
            let is_wanted = !has_small_divisor(modulus)
                && !has_small_divisor(order)
                && radicands
                    .iter()
                    .all(|&number| may_be_square(number, modulus));
            if is_wanted && is_prime(order) && is_prime(modulus) {
                assert!(
                    (1 << 60..1 << 61).contains(&modulus),
                    "a prime lies between 2^60 and 2^61"
                );
                let field = Modulus::new(modulus);
                let mut roots = [(0, 0); MAX_RADICANDS];
                for (place, &number) in roots.iter_mut().zip(radicands) {
                    let square = field.literal(number);
                    // Of the two roots the one that is a square itself.
                    let root = field.power(square, 6 * order);
                    assert_eq!(field.mul(root, root), square, "the number is a square");
                    *place = (square, root);
                }
                return Prime {
                    field,
                    order: Modulus::new(order),
                    roots,
                };
            }
            order += 2;
            if order >= HIGHEST {
                order = LOWEST | 1;
            }
        }
        unreachable!("there are primes of every form")
    }
}

/// Tests whether a positive number is a square modulo a number that is prime:
/// its Jacobi symbol is 1.
fn may_be_square(number: f64, modulus: u64) -> bool {
    let bits = number.to_bits();
    let fraction = bits & ((1 << 52) - 1);
    let mantissa = match bits >> 52 {
        0 => fraction,
        _ => fraction | 1 << 52,
    };
    let odd = mantissa >> mantissa.trailing_zeros();
    // The number 2 is a square, and so are its powers.
    jacobi(odd, modulus) == 1
}

/// The Jacobi symbol of two odd numbers (H. Cohen, *A Course in Computational
/// Algebraic Number Theory*, 1993, algorithm 1.4.10).
fn jacobi(mut above: u64, mut below: u64) -> i32 {
    let mut sign = 1;
    above %= below;
    while above != 0 {
        let twos = above.trailing_zeros();
        above >>= twos;
        if twos % 2 == 1 && matches!(below % 8, 3 | 5) {
            sign = -sign;
        }
        if above % 4 == 3 && below % 4 == 3 {
            sign = -sign;
        }
        (above, below) = (below % above, above);
    }
    if below == 1 { sign } else { 0 }
}

/// Rules out nearly all composite numbers cheaply.
fn has_small_divisor(number: u64) -> bool {
    [3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53]
        .into_iter()
        .any(|divisor| number.is_multiple_of(divisor))
}

/// True for a prime, for odd numbers between 59 and 2⁶²: the test of Miller
/// and Rabin; these bases decide every such number (J. Sorenson and J. Webster, "Strong pseudoprimes to twelve
/// prime bases", Mathematics of Computation 86, 2017).
pub fn is_prime(number: u64) -> bool {
    if has_small_divisor(number) {
        return false;
    }
    let modulus = Modulus::new(number);
    let minus_one = modulus.neg(modulus.one());
    let twos = (number - 1).trailing_zeros();
    [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37]
        .into_iter()
        .all(|base| {
            let mut power = modulus.power(modulus.number(base), (number - 1) >> twos);
            if power == modulus.one {
                return true;
            }
            for _ in 1..twos {
                if power == minus_one {
                    return true;
                }
                power = modulus.mul(power, power);
            }
            power == minus_one
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primes_are_prime_and_follow_the_seed() {
        let slowly = |number: u64| {
            // Fermat's test by division, which shares nothing with the above.
            [2u64, 3, 10, 123_456_789].into_iter().all(|base| {
                let (mut power, mut square, mut rest) = (1u128, u128::from(base), number - 1);
                while rest > 0 {
                    if rest & 1 == 1 {
                        power = power * square % u128::from(number);
                    }
                    square = square * square % u128::from(number);
                    rest >>= 1;
                }
                power == 1
            })
        };
        for seed in 0..20 {
            let [first, second] = Prime::pair(seed);
            assert_eq!([first, second], Prime::pair(seed));
            assert_ne!(first.modulus(), second.modulus());
            for prime in [first, second] {
                assert!((1 << 60..1 << 61).contains(&prime.modulus()));
                assert_eq!(prime.modulus(), 24 * prime.order.modulus() - 1);
                assert!(slowly(prime.modulus()) && slowly(prime.order.modulus()));
            }
        }
        assert_ne!(Prime::pair(1), Prime::pair(2));
    }

    #[test]
    fn small_numbers_are_told_apart_by_the_test() {
        for number in (59..20_000u64).step_by(2) {
            let divisible = (3..200).any(|divisor| number > divisor && number % divisor == 0);
            assert_eq!(is_prime(number), !divisible, "{number}");
        }
        // Products of two primes that pass many bases.
        for number in [3_215_031_751, 3_825_123_056_546_413_051, 2_047, 1_373_653] {
            assert!(!is_prime(number), "{number}");
        }
        assert!(is_prime((1 << 61) - 1));
    }

    #[test]
    fn radicands_are_squares_and_their_roots_multiply() {
        let numbers = [0.1, 2.0, 3.0, 0.2, 1e300, 5e-324];
        for prime in Prime::pair_for(5, &numbers) {
            let field = prime.field;
            for (&number, (square, root)) in numbers.iter().zip(prime.roots) {
                assert_eq!(square, field.literal(number));
                assert_eq!(field.mul(root, root), square);
            }
            // 0.2 is twice 0.1 in binary64.
            let [tenth, two, _, fifth, ..] = prime.roots.map(|(_, root)| root);
            assert_eq!(field.mul(tenth, two), fifth);
        }
    }

    #[test]
    fn powers_of_two_do_not_repeat() {
        // The doublings that binary64 numbers can differ by.
        for seed in 0..4 {
            for prime in Prime::pair(seed) {
                let (field, mut power) = (prime.field, prime.field.one());
                for doubling in 1..=4400 {
                    power = field.add(power, power);
                    assert!(power != field.one() && power != field.neg(field.one()));
                    assert_ne!(power, 0, "after {doubling} doublings");
                }
            }
        }
    }
}
