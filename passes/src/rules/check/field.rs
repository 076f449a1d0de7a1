//! The prime field with roots that are roots.
//!
//! The field of whole functions ([`PrimeField`]) knows nothing of square
//! roots, since it must be fast and total. A rule may be about roots, so here
//! a root is one: half of the elements of the field are squares, and modulo
//! a prime that leaves 3 modulo 4 exactly one of the two roots of a square
//! is a square itself. It plays the part of the positive root, the squares
//! that of the positive numbers: `sqrt(a)*sqrt(a) = a`, `sqrt(a*a)` is `a` or
//! `-a`, products of positive numbers are positive, and −1 is not. Sums of
//! positive numbers need not be positive here, so that a true rule may fail;
//! a counterexample in the reals decides.

use robovec_ir::arithmetic::Arithmetic;
use robovec_ir::field::PrimeField;

/// [`PrimeField`] with square roots.
#[derive(Clone, Copy, Debug)]
pub(in crate::rules) struct RuleField(pub(in crate::rules) PrimeField);

impl Arithmetic for RuleField {
    type Number = u64;

    fn literal(&self, number: f64) -> u64 {
        self.0.literal(number)
    }
    fn neg(&self, a: u64) -> u64 {
        self.0.neg(a)
    }
    fn add(&self, a: u64, b: u64) -> u64 {
        self.0.add(a, b)
    }
    fn sub(&self, a: u64, b: u64) -> u64 {
        self.0.sub(a, b)
    }
    fn mul(&self, a: u64, b: u64) -> u64 {
        self.0.mul(a, b)
    }
    fn div(&self, a: u64, b: u64) -> u64 {
        self.0.div(a, b)
    }
    fn sin(&self, a: u64) -> u64 {
        self.0.sin(a)
    }
    fn cos(&self, a: u64) -> u64 {
        self.0.cos(a)
    }
    fn fma(&self, a: u64, b: u64, c: u64) -> u64 {
        self.0.fma(a, b, c)
    }

    fn sqrt(&self, a: u64) -> u64 {
        if PrimeField::is_undefined(a) {
            return PrimeField::UNDEFINED;
        }
        // The roots of short literals are known: sqrt(2.25) is 1.5.
        let known = self.0.sqrt(a);
        if self.mul(known, known) == a {
            return known;
        }
        // A square to the power (p + 1) / 4 is its root that is a square.
        let root = self.0.power(a, self.0.prime.modulus().div_ceil(4));
        if self.mul(root, root) == a {
            root
        } else {
            PrimeField::UNDEFINED
        }
    }
}
