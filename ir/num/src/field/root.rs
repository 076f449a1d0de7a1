//! The prime field with square roots that are roots.
//!
//! In [`PrimeField`](super::PrimeField) the square of a root is unrelated to
//! its argument, so that `(√a − √b)(√a + √b)` is not `a − b`. Half of its
//! elements are no squares; but −1 is none of them, and with a root `i` of −1
//! every element has one: that of `a`, or `i` times that of `−a`. So numbers
//! are `re + i·im` here. A root of a number that has an imaginary part itself
//! (a root under a root) is drawn from it, and has no law.
//!
//! Of the two roots of a square that is taken which is a square itself, as in
//! the rules' field; the signs of roots are decided by numbers.

use super::{DrawRole, Field, FieldPoint, Prime, PrimeField};
use crate::arithmetic::Arithmetic;
use crate::random::mix;

/// A number of the field and of its imaginary part.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Gaussian {
    /// [`PrimeField::UNDEFINED`] as there.
    real: u64,
    imaginary: u64,
}

/// The prime field with a root of −1, at a point.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct RootField {
    plain: PrimeField,
}

impl Gaussian {
    const UNDEFINED: Gaussian = Gaussian::real(PrimeField::UNDEFINED);

    const fn real(real: u64) -> Gaussian {
        Gaussian { real, imaginary: 0 }
    }

    fn is_undefined(self) -> bool {
        PrimeField::is_undefined(self.real)
    }
}

impl RootField {
    /// An element that represents a number in draws, odd in it: its size and a
    /// flag, true for the negation.
    fn size(&self, a: Gaussian) -> (u64, bool) {
        let (real, negative) = self.plain.without_sign(a.real);
        if a.imaginary == 0 {
            return (real, negative);
        }
        let (imaginary, other) = self.plain.without_sign(a.imaginary);
        // The sign of one part relative to the other belongs to the size.
        let (relative, negative) = match real {
            0 => (false, other),
            _ => (negative != other, negative),
        };
        let bits = mix(real ^ mix(imaginary ^ u64::from(relative)));
        (self.plain.prime.field.spread(bits), negative)
    }

    fn drawn(&self, a: Gaussian, role: DrawRole) -> Gaussian {
        Gaussian::real(self.plain.draw(self.size(a).0, role))
    }
}

impl Field for RootField {
    fn at(prime: Prime, point: FieldPoint) -> RootField {
        RootField {
            plain: PrimeField::at(prime, point),
        }
    }

    fn prime(&self) -> Prime {
        self.plain.prime
    }

    fn input(&self, index: u64) -> Gaussian {
        Gaussian::real(self.plain.input(index))
    }

    fn value(number: Gaussian) -> u64 {
        match number.imaginary {
            0 => number.real,
            // Below every prime; only compared and shown.
            other => mix(number.real ^ mix(other)) >> 5,
        }
    }

    fn residue(&self, value: u64) -> Option<u64> {
        self.plain.residue(value)
    }
}

impl Arithmetic for RootField {
    type Number = Gaussian;

    fn literal(&self, number: f64) -> Gaussian {
        Gaussian::real(self.plain.literal(number))
    }

    fn neg(&self, a: Gaussian) -> Gaussian {
        if a.is_undefined() {
            return a;
        }
        let field = &self.plain.prime.field;
        Gaussian {
            real: field.neg(a.real),
            imaginary: field.neg(a.imaginary),
        }
    }

    fn add(&self, a: Gaussian, b: Gaussian) -> Gaussian {
        if a.is_undefined() || b.is_undefined() {
            return Gaussian::UNDEFINED;
        }
        let field = &self.plain.prime.field;
        Gaussian {
            real: field.add(a.real, b.real),
            imaginary: field.add(a.imaginary, b.imaginary),
        }
    }

    fn sub(&self, a: Gaussian, b: Gaussian) -> Gaussian {
        self.add(a, self.neg(b))
    }

    fn mul(&self, a: Gaussian, b: Gaussian) -> Gaussian {
        if a.is_undefined() || b.is_undefined() {
            return Gaussian::UNDEFINED;
        }
        let field = &self.plain.prime.field;
        let product = |one: u64, other: u64| field.mul(one, other);
        Gaussian {
            real: field.sub(product(a.real, b.real), product(a.imaginary, b.imaginary)),
            imaginary: field.add(product(a.real, b.imaginary), product(a.imaginary, b.real)),
        }
    }

    fn div(&self, a: Gaussian, b: Gaussian) -> Gaussian {
        let field = &self.plain.prime.field;
        if b.is_undefined() || b == Gaussian::real(0) {
            return Gaussian::UNDEFINED;
        }
        // Not zero, since −1 is no square.
        let squares = [b.real, b.imaginary].map(|part| field.mul(part, part));
        let scale = Gaussian::real(field.invert(field.add(squares[0], squares[1])));
        let conjugate = Gaussian {
            imaginary: field.neg(b.imaginary),
            ..b
        };
        self.mul(a, self.mul(conjugate, scale))
    }

    fn sin(&self, a: Gaussian) -> Gaussian {
        if a.imaginary == 0 {
            return Gaussian::real(self.plain.sin(a.real));
        }
        let drawn = self.drawn(a, DrawRole::Sine);
        if self.size(a).1 {
            self.neg(drawn)
        } else {
            drawn
        }
    }

    fn cos(&self, a: Gaussian) -> Gaussian {
        match a.imaginary {
            0 => Gaussian::real(self.plain.cos(a.real)),
            _ => self.drawn(a, DrawRole::Cosine),
        }
    }

    fn sqrt(&self, a: Gaussian) -> Gaussian {
        if a.is_undefined() {
            return a;
        }
        let field = &self.plain.prime.field;
        if a.imaginary != 0 {
            // Not even in the number.
            let bits = mix(a.real ^ mix(a.imaginary));
            return Gaussian::real(self.plain.draw(field.spread(bits), DrawRole::Root));
        }
        if let Some(root) = self.plain.exact_root(a.real) {
            return Gaussian::real(root);
        }
        // A square to the power (p + 1) / 4 is its root that is a square.
        let root = |a: u64| field.power(a, field.modulus().div_ceil(4));
        let real = root(a.real);
        if field.mul(real, real) == a.real {
            return Gaussian::real(real);
        }
        Gaussian {
            real: 0,
            imaginary: root(field.neg(a.real)),
        }
    }

    fn fma(&self, a: Gaussian, b: Gaussian, c: Gaussian) -> Gaussian {
        self.add(self.mul(a, b), c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_obey_their_law_and_quotients_undo_products() {
        for prime in Prime::pair(3) {
            let mut imaginary = 0;
            for seed in 0..40 {
                let field = RootField::at(prime, FieldPoint { seed });
                let [a, b] = [0, 1].map(|index| field.input(index));
                let [root, other] = [a, b].map(|number| field.sqrt(number));
                assert_eq!(field.mul(root, root), a);
                imaginary += u32::from(root.imaginary != 0);
                let both = field.add(root, other);
                let conjugate = field.div(field.sub(a, b), both);
                assert_eq!(conjugate, field.sub(root, other));
                assert_eq!(field.mul(field.div(other, both), both), other);
                assert_eq!(field.sin(field.neg(both)), field.neg(field.sin(both)));
                assert_eq!(field.cos(field.neg(both)), field.cos(both));
                assert_ne!(field.sqrt(both), field.sqrt(field.neg(both)));
                assert!(RootField::is_undefined(field.div(a, field.literal(0.0))));
            }
            // Half of the elements are no squares.
            assert!((5..35).contains(&imaginary), "{imaginary}");
        }
    }
}
