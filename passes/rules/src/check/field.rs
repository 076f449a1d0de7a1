//! Prime fields with roots that are roots and angles that are angles.
//!
//! The field of whole functions ([`robovec_num::field::PrimeField`]) has no
//! square roots, since it must be fast and total. A rule may contain roots and
//! sums of angles, so here a number is a pair: its residue modulo a prime `p`,
//! and its residue as an angle, modulo another prime `r` that divides `p + 1`
//! (see [`super::primes`]).
//!
//! - A root is one: half of the elements of the field are squares, and exactly
//!   one of the two roots of a square is a square itself. It represents
//!   the positive root, and the squares represent the positive numbers:
//!   `sqrt(a)*sqrt(a) = a`, `sqrt(a*a)` is `a` or `-a`, products of positive
//!   numbers are positive, and −1 is not. Signs of sums are undetermined in
//!   the field.
//! - Sine and cosine are the coordinates of `g` to the power of the angle,
//!   where `g` generates the `r` points of the unit circle: theorems on sums,
//!   differences and rational multiples of angles hold automatically, and
//!   angles that are different polynomials are independent. Or they are drawn
//!   independently of each other, for equalities that need no theorem.
//! - The residue of a sine, cosine or root as an angle is drawn from its value.

use super::primes::{COFACTOR, primes};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::field::Modulus;
use robovec_num::random::Random;

/// A number of a [`RuleField`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default, Debug)]
pub(crate) struct RuleResidue {
    /// Modulo the prime; all bits set when it is not defined.
    pub(crate) value: u64,
    pub(crate) angle: u64,
}

impl RuleResidue {
    /// The result of a division by zero, of the root of a non-square, and of
    /// every operation on it.
    pub(crate) const UNDEFINED: RuleResidue = RuleResidue {
        value: u64::MAX,
        angle: u64::MAX,
    };

    /// True when some operation was not defined.
    pub(crate) fn is_undefined(self) -> bool {
        self.value == u64::MAX
    }
}

/// A prime field with square roots and angles, at one point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RuleField {
    value: Modulus,
    angle: Modulus,
    /// A point of the unit circle of order `r`: real and imaginary part.
    generator: [u64; 2],
    /// Keeps the draws of one point apart from those of others.
    salt: u64,
    circle: bool,
}

/// The role of a random element; draws for different roles are independent.
#[derive(Clone, Copy)]
enum RuleDrawRole {
    Input = 1,
    Sine = 2,
    Cosine = 3,
    Angle = 4,
}

impl RuleField {
    /// Fields of two primes drawn from a seed, where sine and cosine lie on
    /// the circle.
    pub(crate) fn pair(seed: u64) -> [RuleField; 2] {
        let mut random = Random::new(seed);
        let first = RuleField::draw_from(&mut random);
        let second = loop {
            let field = RuleField::draw_from(&mut random);
            // Twice the same is not two; it does not happen in practice.
            if field.value != first.value {
                break field;
            }
        };
        [first, second]
    }

    fn draw_from(random: &mut Random) -> RuleField {
        let (prime, factor) = primes(random);
        let mut field = RuleField {
            value: Modulus::new(prime),
            angle: Modulus::new(factor),
            generator: [0, 0],
            salt: random.bits(),
            circle: true,
        };
        loop {
            let [a, b] = [0; 2].map(|_| field.value.number(random.bits()));
            let modulus = field.value;
            let (aa, bb) = (modulus.mul(a, a), modulus.mul(b, b));
            let scale = modulus.invert(modulus.add(aa, bb));
            let ab = modulus.mul(a, b);
            // (a + bi) / (a - bi) has norm one.
            let point = [
                modulus.mul(modulus.sub(aa, bb), scale),
                modulus.mul(modulus.add(ab, ab), scale),
            ];
            field.generator = modulus.turned(point, COFACTOR);
            // Its order divides a prime, and is not one.
            if field.generator[1] != 0 {
                return field;
            }
        }
    }

    /// The field at another point.
    pub(crate) fn at(self, point: u64) -> RuleField {
        RuleField {
            salt: mix(self.salt ^ mix(point)),
            ..self
        }
    }

    /// The field with sines and cosines independent of each other, or not.
    pub(crate) fn on_circle(self, circle: bool) -> RuleField {
        RuleField { circle, ..self }
    }

    /// The arithmetic of values, without angles.
    pub(crate) fn modulus(self) -> Modulus {
        self.value
    }

    /// Random inputs; those that must be positive are squares.
    pub(crate) fn inputs(&self, positive: &[bool]) -> Vec<RuleResidue> {
        let draw = |(index, positive): (usize, &bool)| {
            let value = self.draw(index as u64, RuleDrawRole::Input);
            RuleResidue {
                value: if *positive {
                    self.value.mul(value, value)
                } else {
                    value
                },
                angle: self.angle.number(mix(self.salt ^ index as u64)),
            }
        };
        positive.iter().enumerate().map(draw).collect()
    }

    /// 1 for a square, which represents a positive number, −1 for another
    /// number, 0 for zero and for undefined results.
    pub(super) fn sign(&self, number: RuleResidue) -> i32 {
        if number.is_undefined() {
            return 0;
        }
        let prime = self.value.modulus();
        match self.value.power(number.value, (prime - 1) / 2) {
            0 => 0,
            one if one == self.value.number(1) => 1,
            _ => -1,
        }
    }

    fn draw(&self, number: u64, role: RuleDrawRole) -> u64 {
        let salt = mix(self.salt ^ (role as u64).rotate_left(56));
        self.value.number(mix(number.wrapping_add(salt)))
    }

    /// A draw that changes its sign with its argument.
    fn draw_odd(&self, number: u64, role: RuleDrawRole) -> u64 {
        let opposite = self.value.neg(number);
        match number.cmp(&opposite) {
            // Zero is its own opposite.
            std::cmp::Ordering::Equal => 0,
            std::cmp::Ordering::Less => self.draw(number, role),
            std::cmp::Ordering::Greater => self.value.neg(self.draw(opposite, role)),
        }
    }

    /// A value without a known angle.
    fn with_angle(&self, value: u64) -> RuleResidue {
        let opposite = self.value.neg(value);
        let angle = |number| {
            let salt = mix(self.salt ^ (RuleDrawRole::Angle as u64).rotate_left(56));
            self.angle.number(mix(number ^ salt))
        };
        RuleResidue {
            value,
            angle: match value.cmp(&opposite) {
                std::cmp::Ordering::Equal => 0,
                std::cmp::Ordering::Less => angle(value),
                std::cmp::Ordering::Greater => self.angle.neg(angle(opposite)),
            },
        }
    }

    /// An operation on the values and on the angles of two numbers.
    fn both(
        &self,
        a: RuleResidue,
        b: RuleResidue,
        apply: impl Fn(&Modulus, u64, u64) -> u64,
    ) -> RuleResidue {
        if a.is_undefined() || b.is_undefined() {
            return RuleResidue::UNDEFINED;
        }
        RuleResidue {
            value: apply(&self.value, a.value, b.value),
            angle: apply(&self.angle, a.angle, b.angle),
        }
    }

    /// Cosine and sine of an angle on the circle.
    fn circle_point(&self, angle: u64) -> [u64; 2] {
        self.value.turned(self.generator, self.angle.plain(angle))
    }
}

impl Arithmetic for RuleField {
    type Number = RuleResidue;

    fn literal(&self, number: f64) -> RuleResidue {
        if !number.is_finite() {
            return RuleResidue::UNDEFINED;
        }
        RuleResidue {
            value: self.value.literal(number),
            angle: self.angle.literal(number),
        }
    }

    fn neg(&self, a: RuleResidue) -> RuleResidue {
        if a.is_undefined() {
            return a;
        }
        RuleResidue {
            value: self.value.neg(a.value),
            angle: self.angle.neg(a.angle),
        }
    }

    fn add(&self, a: RuleResidue, b: RuleResidue) -> RuleResidue {
        self.both(a, b, Modulus::add)
    }

    fn sub(&self, a: RuleResidue, b: RuleResidue) -> RuleResidue {
        self.add(a, self.neg(b))
    }

    fn mul(&self, a: RuleResidue, b: RuleResidue) -> RuleResidue {
        self.both(a, b, Modulus::mul)
    }

    fn div(&self, a: RuleResidue, b: RuleResidue) -> RuleResidue {
        if b.value == 0 || b.angle == 0 {
            return RuleResidue::UNDEFINED;
        }
        self.both(a, b, |modulus, a, b| modulus.mul(a, modulus.invert(b)))
    }

    fn sin(&self, a: RuleResidue) -> RuleResidue {
        if a.is_undefined() {
            return a;
        }
        self.with_angle(if self.circle {
            self.circle_point(a.angle)[1]
        } else {
            self.draw_odd(a.value, RuleDrawRole::Sine)
        })
    }

    fn cos(&self, a: RuleResidue) -> RuleResidue {
        if a.is_undefined() {
            return a;
        }
        let opposite = self.value.neg(a.value);
        self.with_angle(match (self.circle, a.value) {
            (true, _) => self.circle_point(a.angle)[0],
            (false, 0) => self.value.number(1),
            (false, angle) => self.draw(angle.min(opposite), RuleDrawRole::Cosine),
        })
    }

    fn sqrt(&self, a: RuleResidue) -> RuleResidue {
        if a.is_undefined() {
            return a;
        }
        // A square to the power (p + 1) / 4 is its root that is a square.
        let root = self.value.power(a.value, self.value.modulus().div_ceil(4));
        if self.value.mul(root, root) == a.value {
            self.with_angle(root)
        } else {
            RuleResidue::UNDEFINED
        }
    }

    fn fma(&self, a: RuleResidue, b: RuleResidue, c: RuleResidue) -> RuleResidue {
        self.add(self.mul(a, b), c)
    }
}

/// A permutation of the 64-bit numbers in which every bit of the argument
/// reaches every bit of the result.
fn mix(number: u64) -> u64 {
    Random::new(number).bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_and_angles_obey_their_laws() {
        for field in RuleField::pair(3) {
            for point in 0..20 {
                let field = field.at(point);
                let [a, b] = field.inputs(&[true, false])[..] else {
                    unreachable!("two inputs")
                };
                let sum = field.add(a, b);
                let (s, c) = (field.sin(sum), field.cos(sum));
                let one = field.add(field.mul(s, s), field.mul(c, c));
                assert_eq!(one.value, field.literal(1.0).value);
                let (sa, ca) = (field.sin(a), field.cos(a));
                let (sb, cb) = (field.sin(b), field.cos(b));
                let sine = field.add(field.mul(sa, cb), field.mul(ca, sb));
                assert_eq!(sine.value, s.value, "sine of a sum");
                let twice = field.mul(field.literal(2.0), field.mul(sa, ca));
                assert_eq!(field.sin(field.add(a, a)).value, twice.value);
                let plane = field.on_circle(false);
                assert_ne!(plane.sin(field.add(a, a)).value, twice.value);
                assert_eq!(plane.sin(field.neg(a)).value, field.neg(plane.sin(a)).value);
                assert_eq!(plane.cos(field.neg(a)).value, plane.cos(a).value);
                let root = field.sqrt(a);
                assert_eq!(field.mul(root, root).value, a.value);
                assert_eq!(field.sign(root), 1);
                let square = field.mul(b, b);
                let expected = match field.sign(b) {
                    1 => b,
                    _ => field.neg(b),
                };
                assert_eq!(field.sqrt(square).value, expected.value);
                assert!(field.sqrt(field.neg(a)).is_undefined());
            }
            let zero = field.literal(0.0);
            assert_eq!(field.sin(zero).value, 0);
            assert_eq!(field.cos(zero).value, field.literal(1.0).value);
            assert_eq!(
                field.sqrt(field.literal(4.0)).value,
                field.literal(2.0).value
            );
        }
    }

    #[test]
    fn the_two_fields_of_a_seed_differ_and_are_the_same_every_time() {
        let [first, second] = RuleField::pair(9);
        assert_ne!(first.modulus(), second.modulus());
        assert_eq!(RuleField::pair(9)[1].modulus(), second.modulus());
        assert_ne!(RuleField::pair(10)[0].modulus(), first.modulus());
    }
}
