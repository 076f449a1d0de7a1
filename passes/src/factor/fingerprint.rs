//! Values identified by what they are at random points.
//!
//! Two polynomials that differ agree at a random point of a field of `p`
//! elements with probability at most degree/p (Schwartz and Zippel). A
//! fingerprint is the value at one random point of each of two fields, of
//! 2⁶¹ − 1 and of 2⁶² − 57 elements: among a million values of degree a
//! thousand two different ones share a fingerprint with probability below
//! 10⁻²¹. Two fields and not two points of one, because powers of two repeat
//! in the first every 61 doublings and a program may well double a value 61
//! times.
//!
//! What is not a polynomial stands for itself: sines, cosines and roots are
//! drawn from their argument, so equal arguments give equal results. A
//! quotient is multiplied by the inverse; one whose divisor is zero, or a
//! literal that is not finite, has no fingerprint and is equal to nothing.

use robovec_ir::{Input, Operation};

/// The sizes of the two fields. Both are three modulo four, so that −1 is no
/// square and every angle has its point on the circle.
const MODULI: [u64; 2] = [(1 << 61) - 1, (1 << 62) - 57];

/// A value at the two points.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct Fingerprint([u64; 2]);

impl Fingerprint {
    pub(crate) const ZERO: Fingerprint = Fingerprint([0, 0]);
    pub(crate) const ONE: Fingerprint = Fingerprint([1, 1]);

    /// A random value, the same for the same number.
    pub(crate) fn random(number: u64) -> Fingerprint {
        Fingerprint([draw(0, number), draw(1, number)])
    }

    /// The value of an input element.
    pub(crate) fn input(input: Input) -> Fingerprint {
        Fingerprint::random(u64::from(input.0))
    }

    /// The value of a literal, exactly; `None` when it is not finite.
    pub(crate) fn literal(number: f64) -> Option<Fingerprint> {
        if !number.is_finite() {
            return None;
        }
        let bits = number.to_bits();
        let exponent = (bits >> 52 & 0x7ff) as i64;
        let fraction = bits & ((1 << 52) - 1);
        let (mantissa, power) = if exponent == 0 {
            (fraction, -1074)
        } else {
            (fraction | 1 << 52, exponent - 1075)
        };
        let magnitude = each(|k| {
            let two = if power < 0 { invert(k, 2) } else { 2 };
            multiply(k, mantissa, raise(k, two, power.unsigned_abs()))
        });
        Some(if number < 0.0 { -magnitude } else { magnitude })
    }

    /// The smaller of the value and its negation, and whether it is the
    /// negation: values that differ in sign only have this in common.
    pub(crate) fn without_sign(self) -> (Fingerprint, bool) {
        let negated = -self;
        if negated.0[0] < self.0[0] {
            (negated, true)
        } else {
            (self, false)
        }
    }

    /// Some of its bits, for tables.
    pub(crate) fn bits(self) -> u64 {
        mix(self.0[0])
    }

    /// The inverse; `None` for a value that is zero in a field.
    pub(crate) fn inverse(self) -> Option<Fingerprint> {
        (self.0[0] != 0 && self.0[1] != 0).then(|| each(|k| invert(k, self.0[k])))
    }

    /// The value of a sine, cosine or root; `circle` puts sine and cosine on
    /// the unit circle, else they know nothing of each other.
    pub(crate) fn of_function(
        operation: Operation,
        argument: Fingerprint,
        circle: bool,
    ) -> Fingerprint {
        let (size, negative) = argument.without_sign();
        let zero = argument == Fingerprint::ZERO;
        let salt = (operation as u64 + 1) << 56;
        let free = |salt: u64| each(|k| draw(k, mix(size.0[0] ^ salt) ^ size.0[1]));
        let signed = |value: Fingerprint, odd: bool| if odd && negative { -value } else { value };
        match operation {
            Operation::Sin if zero => Fingerprint::ZERO,
            Operation::Cos if zero => Fingerprint::ONE,
            Operation::Sin | Operation::Cos if circle => {
                let tangent = free(0xc1 << 56);
                let square = tangent * tangent;
                let scale = (Fingerprint::ONE + square)
                    .inverse()
                    .expect("-1 is no square in either field");
                match operation {
                    Operation::Sin => signed((tangent + tangent) * scale, true),
                    _ => (Fingerprint::ONE - square) * scale,
                }
            }
            Operation::Sin => signed(free(salt), true),
            Operation::Cos => free(salt),
            _ => each(|k| draw(k, mix(argument.0[0] ^ salt) ^ argument.0[1])),
        }
    }
}

impl std::ops::Neg for Fingerprint {
    type Output = Fingerprint;
    #[inline]
    fn neg(self) -> Fingerprint {
        each(|k| fold(k, MODULI[k] - self.0[k]))
    }
}

impl std::ops::Add for Fingerprint {
    type Output = Fingerprint;
    #[inline]
    fn add(self, other: Fingerprint) -> Fingerprint {
        each(|k| fold(k, self.0[k] + other.0[k]))
    }
}

impl std::ops::Sub for Fingerprint {
    type Output = Fingerprint;
    #[inline]
    fn sub(self, other: Fingerprint) -> Fingerprint {
        self + -other
    }
}

impl std::ops::Mul for Fingerprint {
    type Output = Fingerprint;
    #[inline]
    fn mul(self, other: Fingerprint) -> Fingerprint {
        each(|k| multiply(k, self.0[k], other.0[k]))
    }
}

#[inline]
fn each(value: impl Fn(usize) -> u64) -> Fingerprint {
    Fingerprint([value(0), value(1)])
}

/// A number below twice the modulus, modulo it.
#[inline]
fn fold(field: usize, number: u64) -> u64 {
    number.min(number.wrapping_sub(MODULI[field]))
}

#[inline]
fn multiply(field: usize, a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    if field == 0 {
        return fold(0, (product as u64 & MODULI[0]) + (product >> 61) as u64);
    }
    // 2⁶² is 57 here: twice folding the upper part leaves less than 2⁶³.
    let mask = (1u128 << 62) - 1;
    let once = (product & mask) + 57 * (product >> 62);
    let twice = (once & mask) + 57 * (once >> 62);
    fold(1, fold(1, twice as u64))
}

fn raise(field: usize, base: u64, exponent: u64) -> u64 {
    let (mut result, mut square, mut rest) = (1, base, exponent);
    while rest > 0 {
        if rest & 1 == 1 {
            result = multiply(field, result, square);
        }
        square = multiply(field, square, square);
        rest >>= 1;
    }
    result
}

/// The inverse of an element that is not zero, by Fermat's little theorem.
fn invert(field: usize, a: u64) -> u64 {
    raise(field, a, MODULI[field] - 2)
}

/// A random element for a number, the same every time; never zero.
fn draw(field: usize, number: u64) -> u64 {
    let bits = mix(mix(number ^ (field as u64 + 0x51) << 32) ^ number);
    1 + bits % (MODULI[field] - 1)
}

/// A permutation of the 64-bit numbers in which every bit of the argument
/// reaches every bit of the result (the finaliser of SplitMix64).
fn mix(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples() -> Vec<Fingerprint> {
        let mut samples: Vec<Fingerprint> = (0..30).map(Fingerprint::random).collect();
        samples.extend([Fingerprint::ZERO, Fingerprint::ONE, -Fingerprint::ONE]);
        samples
    }

    #[test]
    fn both_are_fields() {
        for a in samples() {
            assert_eq!(a + -a, Fingerprint::ZERO);
            match a.inverse() {
                Some(inverse) => assert_eq!(a * inverse, Fingerprint::ONE),
                None => assert_eq!(a, Fingerprint::ZERO),
            }
            for b in samples() {
                for (k, modulus) in MODULI.into_iter().enumerate() {
                    let exact = u128::from(a.0[k]) * u128::from(b.0[k]) % u128::from(modulus);
                    assert_eq!(u128::from((a * b).0[k]), exact);
                }
                assert_eq!((a - b).without_sign().0, (b - a).without_sign().0);
                for c in samples() {
                    assert_eq!(a * (b + c), a * b + a * c);
                }
            }
        }
    }

    #[test]
    fn literals_are_exact_and_far_powers_of_two_differ() {
        let literal = |number| Fingerprint::literal(number).expect("finite");
        for (a, b) in [(0.1, 1024.0), (-3e-300, 0.125), (5e-324, 2f64.powi(900))] {
            assert_eq!(literal(a) * literal(b), literal(a * b));
        }
        assert_ne!(literal(0.1) + literal(0.2), literal(0.3));
        assert_ne!(literal(2f64.powi(61)), literal(1.0));
        assert_eq!(Fingerprint::literal(f64::NAN), None);
    }

    #[test]
    fn functions_are_odd_and_even_and_on_the_circle_when_asked() {
        for a in samples() {
            for circle in [false, true] {
                let of = |operation, a| Fingerprint::of_function(operation, a, circle);
                let (sine, cosine) = (of(Operation::Sin, a), of(Operation::Cos, a));
                assert_eq!(of(Operation::Sin, -a), -sine);
                assert_eq!(of(Operation::Cos, -a), cosine);
                let norm = sine * sine + cosine * cosine;
                assert_eq!(norm == Fingerprint::ONE, circle || a == Fingerprint::ZERO);
            }
        }
    }
}
