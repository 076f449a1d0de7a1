//! The prime field of 2⁶¹ − 1: exact comparison of whole functions.
//!
//! Over the reals a Robotran function is a rational function of its inputs
//! and of the sines and cosines in it. Two such functions that differ take
//! different values at a random point of a finite field with probability at
//! least `1 - degree / p` (Schwartz and Zippel), so evaluating both at a few
//! random points of this field decides whether a rewrite is an identity: no
//! tolerance, no growth of numbers, about three nanoseconds per operation.
//!
//! What stands for what:
//!
//! - A literal is the dyadic rational its binary64 value is, exactly: the
//!   mantissa times a power of two, which modulo 2⁶¹ − 1 is a rotation.
//!   `0.1` is therefore not one tenth, and powers of two that differ by a
//!   factor of 2⁶¹ coincide.
//! - Division multiplies by the inverse. Dividing by zero, or a literal that
//!   is not finite, gives [`PrimeField::UNDEFINED`], and so does every
//!   operation on it: such a point says nothing and must be drawn anew.
//! - `sin` and `cos` are drawn from the seed and the argument's value, so
//!   equal arguments give equal results. They keep what a pass may always
//!   use, `sin(0) = 0`, `cos(0) = 1`, `sin(-x) = -sin(x)`, `cos(-x) = cos(x)`,
//!   and on the circle also `sin² + cos² = 1`. The theorems for sums of
//!   angles do not hold.
//! - `sqrt` is drawn likewise and has no law but that the roots of squares of
//!   short literals are right (`sqrt(2.25) = 1.5`): `sqrt(x)*sqrt(x)` is not
//!   `x` here, so the field may reject a true identity of square roots.

use crate::arithmetic::Arithmetic;

/// The field of 2⁶¹ − 1 elements, with sines and cosines drawn from a seed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PrimeField {
    /// Selects the random elements that stand for inputs, sines, cosines and
    /// square roots.
    pub seed: u64,
    /// True to draw sine and cosine as a point of the unit circle, false to
    /// draw them independently, for rewrites that must not rely on
    /// `sin² + cos² = 1`.
    pub circle: bool,
}

const P: u64 = PrimeField::MODULUS;

/// What a random element stands for; it keeps the draws apart.
#[derive(Clone, Copy)]
enum Role {
    Input = 1,
    Sine = 2,
    Cosine = 3,
    Root = 4,
}

impl PrimeField {
    /// The number of elements, 2⁶¹ − 1. Numbers are kept below it.
    pub const MODULUS: u64 = (1 << 61) - 1;

    /// The result of a division by zero, and of every operation on it.
    pub const UNDEFINED: u64 = u64::MAX;

    /// True for a number that an undefined operation has reached.
    pub fn is_undefined(number: u64) -> bool {
        number >= P
    }

    /// Random inputs: a point at which to evaluate a function of `len` input
    /// elements. Element `i` depends on the seed and on `i` alone.
    pub fn point(&self, len: usize) -> Vec<u64> {
        (0..len as u64)
            .map(|index| self.draw(index, Role::Input))
            .collect()
    }

    /// A random element, the same for the same seed, number and role.
    fn draw(&self, number: u64, role: Role) -> u64 {
        // Two rounds of a full-avalanche permutation: inputs are often small
        // consecutive numbers, and the seeds of successive points are too.
        let salt = mix(self.seed ^ (role as u64).rotate_left(56));
        reduce(mix(number.wrapping_add(salt)))
    }

    /// The parameter `t` of the circle's point for an angle, odd in the angle
    /// so that the sine is odd and the cosine even.
    fn half_tangent(&self, angle: u64, role: Role) -> u64 {
        if angle == 0 {
            return 0;
        }
        if angle <= P / 2 {
            self.draw(angle, role)
        } else {
            negate(self.draw(P - angle, role))
        }
    }

    /// Sine and cosine on the circle; `1 + t²` has an inverse for every `t`,
    /// since −1 is not a square modulo 2⁶¹ − 1.
    fn circle_point(&self, angle: u64) -> (u64, u64) {
        let t = self.half_tangent(angle, Role::Sine);
        let square = multiply(t, t);
        let scale = invert(sum(1, square));
        (
            multiply(sum(t, t), scale),
            multiply(sum(1, negate(square)), scale),
        )
    }
}

impl Arithmetic for PrimeField {
    type Number = u64;

    fn literal(&self, number: f64) -> u64 {
        if !number.is_finite() {
            return PrimeField::UNDEFINED;
        }
        let bits = number.to_bits();
        let exponent = (bits >> 52 & 0x7ff) as i64;
        let fraction = bits & ((1 << 52) - 1);
        let (mantissa, power) = if exponent == 0 {
            (fraction, -1074)
        } else {
            (fraction | 1 << 52, exponent - 1075)
        };
        let magnitude = multiply(mantissa, 1 << power.rem_euclid(61));
        if number < 0.0 {
            negate(magnitude)
        } else {
            magnitude
        }
    }

    #[inline]
    fn neg(&self, a: u64) -> u64 {
        if PrimeField::is_undefined(a) {
            return PrimeField::UNDEFINED;
        }
        negate(a)
    }

    #[inline]
    fn add(&self, a: u64, b: u64) -> u64 {
        if either_undefined(a, b) {
            return PrimeField::UNDEFINED;
        }
        sum(a, b)
    }

    #[inline]
    fn sub(&self, a: u64, b: u64) -> u64 {
        if either_undefined(a, b) {
            return PrimeField::UNDEFINED;
        }
        sum(a, negate(b))
    }

    #[inline]
    fn mul(&self, a: u64, b: u64) -> u64 {
        if either_undefined(a, b) {
            return PrimeField::UNDEFINED;
        }
        multiply(a, b)
    }

    fn div(&self, a: u64, b: u64) -> u64 {
        if either_undefined(a, b) || b == 0 {
            return PrimeField::UNDEFINED;
        }
        multiply(a, invert(b))
    }

    fn sin(&self, a: u64) -> u64 {
        if PrimeField::is_undefined(a) {
            return PrimeField::UNDEFINED;
        }
        if self.circle {
            return self.circle_point(a).0;
        }
        self.half_tangent(a, Role::Sine)
    }

    fn cos(&self, a: u64) -> u64 {
        if PrimeField::is_undefined(a) {
            return PrimeField::UNDEFINED;
        }
        if self.circle {
            return self.circle_point(a).1;
        }
        match a {
            0 => 1,
            angle => self.draw(angle.min(P - angle), Role::Cosine),
        }
    }

    fn sqrt(&self, a: u64) -> u64 {
        if PrimeField::is_undefined(a) {
            return PrimeField::UNDEFINED;
        }
        exact_root(a).unwrap_or_else(|| self.draw(a, Role::Root))
    }

    #[inline]
    fn fma(&self, a: u64, b: u64, c: u64) -> u64 {
        self.add(self.mul(a, b), c)
    }
}

/// Elements are below 2⁶¹, the undefined mark has its top bit set.
#[inline]
fn either_undefined(a: u64, b: u64) -> bool {
    (a | b) >> 63 != 0
}

/// Any 64-bit number modulo p.
#[inline]
fn reduce(number: u64) -> u64 {
    fold((number & P) + (number >> 61))
}

/// A number below 2p, modulo p.
#[inline]
fn fold(number: u64) -> u64 {
    number.min(number.wrapping_sub(P))
}

#[inline]
fn sum(a: u64, b: u64) -> u64 {
    fold(a + b)
}

#[inline]
fn negate(a: u64) -> u64 {
    fold(P - a)
}

#[inline]
fn multiply(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    // 2⁶¹ is 1 here, so the upper and lower 61 bits are simply added.
    fold((product as u64 & P) + (product >> 61) as u64)
}

/// `a` to the power 2^`count`.
fn squared(mut a: u64, count: u32) -> u64 {
    for _ in 0..count {
        a = multiply(a, a);
    }
    a
}

/// The inverse of an element that is not zero: its power p − 2 (Fermat).
/// `ones(k)` below is `a` to the power 2ᵏ − 1, a row of k one bits, and
/// p − 2 is 59 one bits, a zero and a one.
fn invert(a: u64) -> u64 {
    let join = |high: u64, count: u32, low: u64| multiply(squared(high, count), low);
    let ones2 = join(a, 1, a);
    let ones3 = join(ones2, 1, a);
    let ones6 = join(ones3, 3, ones3);
    let ones12 = join(ones6, 6, ones6);
    let ones24 = join(ones12, 12, ones12);
    let ones48 = join(ones24, 24, ones24);
    let ones54 = join(ones48, 6, ones6);
    let ones57 = join(ones54, 3, ones3);
    let ones59 = join(ones57, 2, ones2);
    join(ones59, 2, a)
}

/// The root of an element that is the square of a short literal: of
/// `m * 2ᵉ` with `m` below 2¹² and `e` from −15 to 15. One element in 2³²
/// looks like one by accident.
fn exact_root(a: u64) -> Option<u64> {
    let power = |exponent: i32| 1u64 << exponent.rem_euclid(61);
    (-15..=15).find_map(|exponent| {
        let square = multiply(a, power(-2 * exponent));
        let root = square.isqrt();
        (root < 1 << 12 && root * root == square).then(|| multiply(root, power(exponent)))
    })
}

/// A permutation of the 64-bit numbers in which every bit of the argument
/// reaches every bit of the result (the finaliser of SplitMix64).
pub(crate) fn mix(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIELD: PrimeField = PrimeField {
        seed: 7,
        circle: true,
    };

    /// Random elements and the ones at the edges.
    fn samples() -> Vec<u64> {
        let mut samples = FIELD.point(40);
        samples.extend([0, 1, 2, P / 2, P / 2 + 1, P - 2, P - 1]);
        samples
    }

    #[test]
    fn the_axioms_of_a_field_hold() {
        let samples = samples();
        for &a in &samples {
            assert!(a < P);
            assert_eq!(FIELD.add(a, FIELD.neg(a)), 0);
            assert_eq!(FIELD.add(a, 0), a);
            assert_eq!(FIELD.mul(a, 1), a);
            if a != 0 {
                assert_eq!(FIELD.mul(a, FIELD.div(1, a)), 1);
            }
            for &b in &samples {
                assert_eq!(FIELD.add(a, b), FIELD.add(b, a));
                assert_eq!(FIELD.mul(a, b), FIELD.mul(b, a));
                assert_eq!(FIELD.sub(a, b), FIELD.neg(FIELD.sub(b, a)));
                assert_eq!(
                    u128::from(FIELD.mul(a, b)),
                    u128::from(a) * u128::from(b) % u128::from(P)
                );
                assert_eq!(FIELD.add(a, b), (a + b) % P);
                for &c in &samples {
                    let (left, right) = (FIELD.add(a, FIELD.add(b, c)), FIELD.add(a, b));
                    assert_eq!(left, FIELD.add(right, c));
                    let (left, right) = (FIELD.mul(a, FIELD.add(b, c)), FIELD.mul(a, b));
                    assert_eq!(left, FIELD.add(right, FIELD.mul(a, c)));
                }
            }
        }
    }

    #[test]
    fn literals_are_dyadic_rationals() {
        for (number, numerator, halvings) in [
            (0.5, 1, 1),
            (0.75, 3, 2),
            (-2.5, P - 5, 1),
            (3.0, 3, 0),
            (0.0, 0, 0),
            (-0.0, 0, 0),
        ] {
            let mut value = FIELD.literal(number);
            for _ in 0..halvings {
                value = FIELD.add(value, value);
            }
            assert_eq!(value, numerator, "{number}");
        }
        // Products of literals that are exact in binary64 are exact here.
        for (a, b) in [(0.1, 1024.0), (3e-300, 0.125), (5e-324, 2f64.powi(900))] {
            let product = FIELD.mul(FIELD.literal(a), FIELD.literal(b));
            assert_eq!(product, FIELD.literal(a * b));
        }
        assert_ne!(
            FIELD.add(FIELD.literal(0.1), FIELD.literal(0.2)),
            FIELD.literal(0.3)
        );
    }

    #[test]
    fn sine_and_cosine_are_on_the_circle_only_when_asked() {
        let plane = PrimeField {
            circle: false,
            ..FIELD
        };
        for a in samples() {
            let norm = |field: PrimeField| {
                let (s, c) = (field.sin(a), field.cos(a));
                field.add(field.mul(s, s), field.mul(c, c))
            };
            assert_eq!(norm(FIELD), 1);
            assert_eq!(norm(plane) == 1, a == 0);
            for field in [FIELD, plane] {
                assert_eq!(field.sin(field.neg(a)), field.neg(field.sin(a)));
                assert_eq!(field.cos(field.neg(a)), field.cos(a));
                assert!(field.sin(a) < P && field.cos(a) < P && field.sqrt(a) < P);
            }
            let other = PrimeField { seed: 8, ..FIELD };
            assert_eq!(FIELD.sin(a) == other.sin(a), a == 0);
        }
        assert_eq!((FIELD.cos(0), plane.cos(0), plane.sin(0)), (1, 1, 0));
    }

    #[test]
    fn roots_of_short_literals_are_right() {
        for root in [0.0, 1.0, 2.0, 3.0, 0.5, 1.5, 0.25, 4095.0, 40.0] {
            let square = FIELD.literal(root * root);
            assert_eq!(FIELD.sqrt(square), FIELD.literal(root), "{root}");
        }
        for number in [2.0, 3.0, 0.1, -1.0, -4.0] {
            let root = FIELD.sqrt(FIELD.literal(number));
            let other = PrimeField { seed: 8, ..FIELD };
            assert_ne!(root, other.sqrt(FIELD.literal(number)), "{number}");
        }
    }

    #[test]
    fn what_is_undefined_stays_undefined() {
        let undefined = FIELD.div(5, 0);
        for result in [
            undefined,
            FIELD.add(undefined, 1),
            FIELD.sub(1, undefined),
            FIELD.mul(0, undefined),
            FIELD.div(undefined, 3),
            FIELD.div(0, 0),
            FIELD.neg(undefined),
            FIELD.sin(undefined),
            FIELD.cos(undefined),
            FIELD.sqrt(undefined),
            FIELD.literal(f64::NAN),
            FIELD.literal(f64::INFINITY),
        ] {
            assert!(PrimeField::is_undefined(result));
        }
    }
}
