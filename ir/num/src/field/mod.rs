//! Prime fields: exact comparison of whole functions.
//!
//! Over the reals a Robotran function is a rational function of its inputs and
//! of its sines and cosines. Two such functions that differ take different
//! values at a random point of a finite field with probability at least `1 -
//! degree / p` (Schwartz and Zippel), provided that their difference does not
//! vanish modulo `p`. Primes are therefore drawn at random and come in pairs
//! ([`Prime::pair`]): modulo 2⁶¹ − 1 the constant 2⁶¹ is 1, and a pass that
//! trusts that field alone drops it.
//!
//! Representations:
//!
//! - A literal is the dyadic rational its binary64 value is, exactly: the
//!   mantissa times a power of two. `0.1` is therefore not one tenth.
//! - Division multiplies by the inverse. Dividing by zero, or a literal that is
//!   not finite, gives [`PrimeField::UNDEFINED`], and so does every operation
//!   on it: such a point means nothing and must be drawn again.
//! - `sin` and `cos` are drawn from the seed and the argument's value, so equal
//!   arguments give equal results. They keep the identities that every pass may
//!   use: `sin(0) = 0`, `cos(0) = 1`, `sin(-x) = -sin(x)`, `cos(-x) = cos(x)`,
//!   and on the circle also `sin² + cos² = 1`. The theorems for sums of angles
//!   hold in [`CircleField`] alone.
//! - `sqrt` is drawn likewise and has no law but that the roots of squares of
//!   short literals are right (`sqrt(2.25) = 1.5`), and those of the numbers
//!   the prime was drawn for and of their squares: `sqrt(x)*sqrt(x)` is not `x`
//!   here. In [`RootField`] they are equal.
//!
//! A field has no positive numbers and no domains of functions; questions that
//! depend on them are decided with numbers.

mod circle;
mod prime;
mod root;

pub use circle::{Angular, CircleField};
pub use prime::{MAX_RADICANDS, Modulus, Prime, is_prime};
pub use root::{Gaussian, RootField};

use crate::arithmetic::Arithmetic;
use crate::random::mix;

/// The point at which functions are evaluated: the seed of the random elements.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct FieldPoint {
    /// Selects the random elements that represent inputs, sines, cosines and
    /// square roots.
    pub seed: u64,
}

/// Arithmetic modulo a prime at a random point.
pub trait Field: Arithmetic<Number: PartialEq> + Sized {
    /// The field of a prime, at a point.
    fn at(prime: Prime, point: FieldPoint) -> Self;

    /// Its prime.
    fn prime(&self) -> Prime;

    /// The random element that represents an input element; it depends on
    /// the point and the index alone.
    fn input(&self, index: u64) -> Self::Number;

    /// The value modulo the prime, in an internal form: equal for equal
    /// numbers.
    fn value(number: Self::Number) -> u64;

    /// The natural number below the prime of a value; `None` when it is
    /// undefined.
    fn residue(&self, value: u64) -> Option<u64>;

    /// Random inputs for a function of `len` input elements.
    fn point(&self, len: usize) -> Vec<Self::Number> {
        (0..len as u64).map(|index| self.input(index)).collect()
    }

    /// True for a number that an undefined operation has reached.
    fn is_undefined(number: Self::Number) -> bool {
        PrimeField::is_undefined(Self::value(number))
    }
}

/// The field of a prime number of elements, with sines and cosines drawn from
/// a seed. Numbers are kept in Montgomery's form ([`Field::residue`]).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PrimeField {
    /// The number of elements.
    pub prime: Prime,
    /// Selects the random elements that represent inputs, sines, cosines and
    /// square roots.
    pub seed: u64,
    /// True to draw sine and cosine as a point of the unit circle, false to
    /// draw them independently, for rewrites that must not rely on
    /// `sin² + cos² = 1`.
    pub circle: bool,
}

/// The role of a random element; draws for different roles are independent.
#[derive(Clone, Copy)]
enum DrawRole {
    Input = 1,
    Sine = 2,
    Cosine = 3,
    Root = 4,
    /// The place of an input on the circle.
    Turn = 5,
    /// The point on the circle for the result of a sine, cosine or root.
    Angle = 6,
    /// The point of the circle that generates its subgroup.
    Generator = 7,
    /// The inverse of a number that may be zero elsewhere.
    Inverse = 8,
}

impl PrimeField {
    /// The result of a division by zero, and of every operation on it.
    pub const UNDEFINED: u64 = u64::MAX;

    /// The same point in two fields, whose primes are drawn from the seed as
    /// well.
    pub fn pair(seed: u64, circle: bool) -> [PrimeField; 2] {
        Prime::pair(seed).map(|prime| PrimeField {
            prime,
            seed,
            circle,
        })
    }

    /// True for a number that an undefined operation has reached.
    #[inline]
    pub fn is_undefined(number: u64) -> bool {
        number >> 63 != 0
    }

    /// The number or its negation, and a flag: true for the negation. Numbers
    /// that differ in sign only have the same result. One is not the negation
    /// of anything.
    #[inline]
    pub fn without_sign(&self, number: u64) -> (u64, bool) {
        if PrimeField::is_undefined(number) {
            return (PrimeField::UNDEFINED, false);
        }
        let half = self.prime.modulus() / 2;
        // Montgomery's form of 1 can lie in either half.
        let negative = number != 0 && (number > half) != (self.prime.field.one() > half);
        if negative {
            (self.prime.field.neg(number), true)
        } else {
            (number, false)
        }
    }

    /// A random element that represents the inverse of a number, odd in the
    /// number, and for nothing else: With it, `x*(1/y)*y` differs from `x`,
    /// since only the latter has a value where `y` is zero.
    pub fn guarded_inverse(&self, number: u64) -> u64 {
        if PrimeField::is_undefined(number) || number == 0 {
            return PrimeField::UNDEFINED;
        }
        self.odd(number, DrawRole::Inverse)
    }

    /// Random bits, the same for the same seed, prime, number and role.
    fn bits(&self, number: u64, role: DrawRole) -> u64 {
        // Two rounds of a full-avalanche permutation: inputs are often small
        // consecutive numbers, and the seeds of successive points are too.
        let salt = mix(self.seed ^ self.prime.modulus() ^ (role as u64).rotate_left(56));
        mix(number.wrapping_add(salt))
    }

    /// A random element, the same for the same seed, number and role.
    fn draw(&self, number: u64, role: DrawRole) -> u64 {
        self.prime.field.spread(self.bits(number, role))
    }

    /// A random element that is odd in a number.
    fn odd(&self, number: u64, role: DrawRole) -> u64 {
        match self.without_sign(number) {
            (0, _) => 0,
            (size, false) => self.draw(size, role),
            (size, true) => self.prime.field.neg(self.draw(size, role)),
        }
    }

    /// Cosine and sine of the circle's point of a parameter; `1 + t²` has an
    /// inverse for every `t`, since −1 is not a square.
    fn circle_point(&self, t: u64) -> (u64, u64) {
        let field = &self.prime.field;
        let square = field.mul(t, t);
        let scale = field.invert(field.add(field.one(), square));
        (
            field.mul(field.sub(field.one(), square), scale),
            field.mul(field.add(t, t), scale),
        )
    }

    /// The root of an element that is the square of a short literal: of
    /// `m * 2ᵉ` with `m` below 2¹² and `e` from −15 to 15. One element in 2³²
    /// looks like one by accident.
    fn exact_root(&self, a: u64) -> Option<u64> {
        let field = &self.prime.field;
        for &(square, root) in &self.prime.roots {
            if square == a {
                return Some(root);
            }
            // The square of such a number, of which it is the root.
            if field.mul(square, square) == a {
                return Some(square);
            }
        }
        (-15..=15).find_map(|exponent: i32| {
            let scale = field.literal(f64::from(exponent).exp2());
            let shrink = field.literal(f64::from(-2 * exponent).exp2());
            let square = field.plain(field.mul(a, shrink));
            let root = square.isqrt();
            (root < 1 << 12 && root * root == square).then(|| field.mul(field.number(root), scale))
        })
    }
}

impl Field for PrimeField {
    fn at(prime: Prime, point: FieldPoint) -> PrimeField {
        PrimeField {
            prime,
            seed: point.seed,
            circle: false,
        }
    }

    fn prime(&self) -> Prime {
        self.prime
    }

    fn input(&self, index: u64) -> u64 {
        self.draw(index, DrawRole::Input)
    }

    fn value(number: u64) -> u64 {
        number
    }

    fn residue(&self, value: u64) -> Option<u64> {
        (!PrimeField::is_undefined(value)).then(|| self.prime.field.plain(value))
    }
}

impl Arithmetic for PrimeField {
    type Number = u64;

    fn literal(&self, number: f64) -> u64 {
        if !number.is_finite() {
            return PrimeField::UNDEFINED;
        }
        self.prime.field.literal(number)
    }

    #[inline]
    fn neg(&self, a: u64) -> u64 {
        if PrimeField::is_undefined(a) {
            return PrimeField::UNDEFINED;
        }
        self.prime.field.neg(a)
    }

    #[inline]
    fn add(&self, a: u64, b: u64) -> u64 {
        if either_undefined(a, b) {
            return PrimeField::UNDEFINED;
        }
        self.prime.field.add(a, b)
    }

    #[inline]
    fn sub(&self, a: u64, b: u64) -> u64 {
        if either_undefined(a, b) {
            return PrimeField::UNDEFINED;
        }
        self.prime.field.sub(a, b)
    }

    #[inline]
    fn mul(&self, a: u64, b: u64) -> u64 {
        if either_undefined(a, b) {
            return PrimeField::UNDEFINED;
        }
        self.prime.field.mul(a, b)
    }

    fn div(&self, a: u64, b: u64) -> u64 {
        if either_undefined(a, b) || b == 0 {
            return PrimeField::UNDEFINED;
        }
        self.prime.field.mul(a, self.prime.field.invert(b))
    }

    fn sin(&self, a: u64) -> u64 {
        if PrimeField::is_undefined(a) {
            return PrimeField::UNDEFINED;
        }
        let drawn = self.odd(a, DrawRole::Sine);
        if self.circle {
            return self.circle_point(drawn).1;
        }
        drawn
    }

    fn cos(&self, a: u64) -> u64 {
        if PrimeField::is_undefined(a) {
            return PrimeField::UNDEFINED;
        }
        if self.circle {
            return self.circle_point(self.odd(a, DrawRole::Sine)).0;
        }
        match self.without_sign(a).0 {
            0 => self.prime.field.one(),
            size => self.draw(size, DrawRole::Cosine),
        }
    }

    fn sqrt(&self, a: u64) -> u64 {
        if PrimeField::is_undefined(a) {
            return PrimeField::UNDEFINED;
        }
        self.exact_root(a)
            .unwrap_or_else(|| self.draw(a, DrawRole::Root))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn fields() -> [PrimeField; 2] {
        PrimeField::pair(7, true)
    }

    /// Random elements and the ones at the edges.
    fn samples(field: &PrimeField) -> Vec<u64> {
        let p = field.prime.modulus();
        let mut samples = field.point(40);
        samples.extend([0, 1, 2, p / 2, p / 2 + 1, p - 2, p - 1]);
        samples
    }

    /// The number as a natural number below the prime.
    fn natural(field: &PrimeField, number: u64) -> u128 {
        u128::from(field.residue(number).expect("it is defined"))
    }

    #[test]
    fn the_axioms_of_a_field_hold() {
        for field in fields() {
            let p = u128::from(field.prime.modulus());
            let samples = samples(&field);
            let one = field.literal(1.0);
            assert_eq!(field.without_sign(one), (one, false));
            assert_eq!(field.without_sign(0), (0, false));
            for &a in &samples {
                assert!(a < field.prime.modulus());
                assert_eq!(field.add(a, field.neg(a)), 0);
                assert_eq!(field.add(a, 0), a);
                assert_eq!(field.mul(a, one), a);
                if a != 0 {
                    assert_eq!(field.mul(a, field.div(one, a)), one);
                }
                for &b in &samples {
                    assert_eq!(field.sub(a, b), field.neg(field.sub(b, a)));
                    let [x, y] = [a, b].map(|number| natural(&field, number));
                    assert_eq!(natural(&field, field.add(a, b)), (x + y) % p);
                    assert_eq!(natural(&field, field.sub(a, b)), (p + x - y) % p);
                    assert_eq!(natural(&field, field.mul(a, b)), x * y % p);
                    let [n, m] = [a, b].map(|number| field.without_sign(number).0);
                    assert_eq!(n == m, a == b || a == field.neg(b));
                }
            }
        }
    }

    #[test]
    fn literals_are_dyadic_rationals() {
        for field in fields() {
            let p = u128::from(field.prime.modulus());
            for (number, numerator, halvings) in [
                (0.5, 1, 1),
                (0.75, 3, 2),
                (-2.5, p - 5, 1),
                (3.0, 3, 0),
                (0.0, 0, 0),
                (-0.0, 0, 0),
                (2f64.powi(60) - 256.0, (1 << 60) - 256, 0),
            ] {
                let mut value = field.literal(number);
                for _ in 0..halvings {
                    value = field.add(value, value);
                }
                assert_eq!(natural(&field, value), numerator % p, "{number}");
            }
            // Products of literals that are exact in binary64 are exact here.
            for (a, b) in [(0.1, 1024.0), (3e-300, 0.125), (5e-324, 2f64.powi(900))] {
                let product = field.mul(field.literal(a), field.literal(b));
                assert_eq!(product, field.literal(a * b));
            }
            assert_ne!(
                field.add(field.literal(0.1), field.literal(0.2)),
                field.literal(0.3)
            );
            // In no field but that of 2^61-1 these are one.
            for power in [61, -61, 122, -122, 1023, -1074] {
                assert_ne!(field.literal(2f64.powi(power)), field.literal(1.0));
            }
        }
    }

    #[test]
    fn sine_and_cosine_are_on_the_circle_only_when_asked() {
        for circle in fields() {
            let plane = PrimeField {
                circle: false,
                ..circle
            };
            let one = plane.literal(1.0);
            for a in samples(&circle) {
                let norm = |field: PrimeField| {
                    let (s, c) = (field.sin(a), field.cos(a));
                    field.add(field.mul(s, s), field.mul(c, c))
                };
                assert_eq!(norm(circle), one);
                assert_eq!(norm(plane) == one, a == 0);
                for field in [circle, plane] {
                    assert_eq!(field.sin(field.neg(a)), field.neg(field.sin(a)));
                    assert_eq!(field.cos(field.neg(a)), field.cos(a));
                    let defined = |number| !PrimeField::is_undefined(number);
                    assert!([field.sin(a), field.cos(a), field.sqrt(a)].map(defined) == [true; 3]);
                }
                let other = PrimeField { seed: 8, ..circle };
                assert_eq!(circle.sin(a) == other.sin(a), a == 0);
            }
            assert_eq!((circle.cos(0), plane.cos(0), plane.sin(0)), (one, one, 0));
        }
    }

    #[test]
    fn roots_of_short_literals_are_right() {
        for field in fields() {
            for root in [0.0, 1.0, 2.0, 3.0, 0.5, 1.5, 0.25, 4095.0, 40.0] {
                let square = field.literal(root * root);
                assert_eq!(field.sqrt(square), field.literal(root), "{root}");
            }
            for number in [2.0, 3.0, 0.1, -1.0, -4.0] {
                let root = field.sqrt(field.literal(number));
                let other = PrimeField { seed: 8, ..field };
                assert_ne!(root, other.sqrt(field.literal(number)), "{number}");
            }
        }
    }

    #[test]
    fn a_guarded_inverse_is_odd_and_no_inverse() {
        for field in fields() {
            for a in samples(&field) {
                let inverse = field.guarded_inverse(a);
                if a == 0 {
                    assert!(PrimeField::is_undefined(inverse));
                    continue;
                }
                assert_eq!(field.guarded_inverse(field.neg(a)), field.neg(inverse));
                assert_ne!(field.mul(a, inverse), field.literal(1.0));
            }
        }
    }

    #[test]
    fn what_is_undefined_stays_undefined() {
        for field in fields() {
            let one = field.literal(1.0);
            let undefined = field.div(one, 0);
            for result in [
                undefined,
                field.add(undefined, 1),
                field.sub(1, undefined),
                field.mul(0, undefined),
                field.div(undefined, 3),
                field.div(0, 0),
                field.neg(undefined),
                field.sin(undefined),
                field.cos(undefined),
                field.sqrt(undefined),
                field.guarded_inverse(undefined),
                field.literal(f64::NAN),
                field.literal(f64::INFINITY),
            ] {
                assert!(PrimeField::is_undefined(result));
            }
        }
    }
}
