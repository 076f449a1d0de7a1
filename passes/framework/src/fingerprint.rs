//! Values identified by their images under several evaluations.
//!
//! A pass that searches for equal values cannot compare expressions; it
//! compares their values at one random point in three images: two prime fields
//! and the real numbers.
//!
//! - Two polynomials that differ agree at a random point of a field of `p`
//!   elements with probability at most degree/p (Schwartz and Zippel),
//!   provided that their difference does not vanish modulo `p`. Both primes
//!   are drawn from the constants of the function, so that no constant is
//!   in any relation to them but by accident.
//! - In the real image a value is known in double-double with a bound of its
//!   error ([`Ball`]). Values that are further apart than their bounds allow
//!   are not equal, for any residues.
//!
//! An operation that is not polynomial represents itself: sines, cosines and
//! roots are drawn from their argument, so equal arguments give equal results.
//! So are the inverses of divisors that are not literals: `x/y*y` is not `x`,
//! which has a value where `y` is zero, while `a/y + b/y` is `(a + b)/y`. A
//! value that divides by zero, or a literal that is not finite, is undefined
//! and equal to nothing.

use robovec_ir::{Function, Input, Operand, OperandKind, Operation};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::ball::{Ball, Balls};
use robovec_num::field::{Field, PrimeField};
use robovec_num::random::mix;
use std::hash::{Hash, Hasher};

/// The images of a value. Equal when it is the same number in both fields and
/// the real balls touch.
#[derive(Clone, Copy, Debug)]
pub struct Fingerprint {
    residues: [u64; 2],
    real: Ball<1>,
}

impl PartialEq for Fingerprint {
    #[inline]
    fn eq(&self, other: &Fingerprint) -> bool {
        self.residues == other.residues
            && !self.is_undefined()
            && may_be_equal(&self.real, &other.real)
    }
}

impl Eq for Fingerprint {}

impl Hash for Fingerprint {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.residues.hash(state);
    }
}

impl Fingerprint {
    /// True for a value that an undefined operation has reached.
    pub fn is_undefined(&self) -> bool {
        self.residues.into_iter().any(PrimeField::is_undefined)
    }

    /// True for a value that is zero.
    pub fn is_zero(&self) -> bool {
        self.residues == [0, 0] && may_be_equal(&self.real, &Ball::exact([0.0]))
    }

    /// True when one of two values, known to be equal up to the sign, is the
    /// negation of the other.
    pub fn is_negation_of(&self, other: &Fingerprint) -> bool {
        self.residues != other.residues
    }

    /// Some of its bits, for tables.
    pub fn bits(&self) -> u64 {
        self.residues[0].wrapping_mul(0x9e37_79b9_7f4a_7c15)
    }
}

/// Tests whether two real values can be one. Of a value that is no number at
/// the point (the root of a negative one, an overflow) the fields alone show.
fn may_be_equal(a: &Ball<1>, b: &Ball<1>) -> bool {
    !(a.is_known(0) && b.is_known(0)) || a.touches(b, 0)
}

/// The images in which the values of a function are identified.
#[derive(Clone, Copy, Debug)]
pub struct Images {
    fields: [PrimeField; 2],
}

impl Images {
    /// Images for a function; on the `circle`, values are also equal that
    /// need sin² + cos² = 1 for it.
    pub fn of(function: &Function, circle: bool) -> Images {
        let numbers = function.reads().filter_map(|read| function.number(read));
        let mut constants: Vec<u64> = numbers.map(f64::to_bits).collect();
        constants.sort_unstable();
        constants.dedup();
        let seed = constants
            .into_iter()
            .fold(0x1d_e971_7e5e_ed00, |seed, constant| mix(seed ^ constant));
        Images {
            fields: PrimeField::pair(seed, circle),
        }
    }

    /// Zero.
    pub fn zero(&self) -> Fingerprint {
        self.literal(0.0)
    }

    /// One.
    pub fn one(&self) -> Fingerprint {
        self.literal(1.0)
    }

    /// A value that is equal to nothing but to itself.
    pub fn random(&self, number: u64) -> Fingerprint {
        let bits = mix(self.fields[0].seed ^ !number);
        // Between a half and two, of either sign.
        let size = 0.5 + (bits >> 12) as f64 * (1.5 / (1u64 << 52) as f64);
        Fingerprint {
            residues: self.fields.map(|field| field.input(number)),
            real: Ball::exact([if bits & 1 == 1 { -size } else { size }]),
        }
    }

    /// The value of an input element.
    pub fn input(&self, input: Input) -> Fingerprint {
        self.random(u64::from(input.0))
    }

    /// The product of values.
    pub fn product(&self, values: impl Iterator<Item = Fingerprint>) -> Fingerprint {
        let product = values.reduce(|product, value| self.mul(product, value));
        product.unwrap_or_else(|| self.one())
    }

    /// The sum of values.
    pub fn sum(&self, values: impl Iterator<Item = Fingerprint>) -> Fingerprint {
        let sum = values.reduce(|sum, value| self.add(sum, value));
        sum.unwrap_or_else(|| self.zero())
    }

    /// The value or its negation.
    pub fn negate_if(&self, negative: bool, value: Fingerprint) -> Fingerprint {
        if negative { self.neg(value) } else { value }
    }

    /// The value or its negation, and a flag: true for the negation. Values
    /// that differ in sign only have the same result.
    pub fn without_sign(&self, value: Fingerprint) -> (Fingerprint, bool) {
        let negative = match value.residues {
            [0, second] => self.fields[1].without_sign(second).1,
            [first, _] => self.fields[0].without_sign(first).1,
        };
        (self.negate_if(negative, value), negative)
    }

    /// The value of every node of a function, in program order.
    pub fn values(&self, function: &Function) -> Vec<Fingerprint> {
        let mut values: Vec<Fingerprint> = Vec::with_capacity(function.nodes().len());
        for node in function.nodes() {
            let value = |operand: Operand| match operand.kind() {
                OperandKind::Value(value) => values[value.index()],
                OperandKind::Input(input) => self.input(input),
                OperandKind::Constant(constant) => self.literal(function.constant_number(constant)),
                OperandKind::None => self.zero(),
            };
            let literal_divisor = node.operands[1].constant().is_some();
            let operands = node.operands.map(value);
            values.push(self.operate(node.operation, operands, literal_divisor));
        }
        values
    }

    /// The result of an operation; a divisor that is a literal is inverted, any
    /// other has a stand-in for its inverse.
    pub fn operate(
        &self,
        operation: Operation,
        operands: [Fingerprint; Operand::MAX_COUNT],
        literal_divisor: bool,
    ) -> Fingerprint {
        if operation == Operation::Div && literal_divisor {
            let [a, b, _] = operands;
            return self.combine(
                |field, k| field.div(a.residues[k], b.residues[k]),
                Balls.div(a.real, b.real),
            );
        }
        self.apply(operation, operands)
    }

    #[inline]
    fn combine(&self, of: impl Fn(&PrimeField, usize) -> u64, real: Ball<1>) -> Fingerprint {
        Fingerprint {
            residues: [of(&self.fields[0], 0), of(&self.fields[1], 1)],
            real,
        }
    }
}

impl Arithmetic for Images {
    type Number = Fingerprint;

    fn literal(&self, number: f64) -> Fingerprint {
        self.combine(|field, _| field.literal(number), Balls.literal(number))
    }

    #[inline]
    fn neg(&self, a: Fingerprint) -> Fingerprint {
        self.combine(|field, k| field.neg(a.residues[k]), Balls.neg(a.real))
    }

    #[inline]
    fn add(&self, a: Fingerprint, b: Fingerprint) -> Fingerprint {
        self.combine(
            |field, k| field.add(a.residues[k], b.residues[k]),
            Balls.add(a.real, b.real),
        )
    }

    #[inline]
    fn sub(&self, a: Fingerprint, b: Fingerprint) -> Fingerprint {
        self.combine(
            |field, k| field.sub(a.residues[k], b.residues[k]),
            Balls.sub(a.real, b.real),
        )
    }

    #[inline]
    fn mul(&self, a: Fingerprint, b: Fingerprint) -> Fingerprint {
        self.combine(
            |field, k| field.mul(a.residues[k], b.residues[k]),
            Balls.mul(a.real, b.real),
        )
    }

    /// The quotient, with a stand-in for the inverse of the divisor.
    fn div(&self, a: Fingerprint, b: Fingerprint) -> Fingerprint {
        self.combine(
            |field, k| field.mul(a.residues[k], field.guarded_inverse(b.residues[k])),
            Balls.div(a.real, b.real),
        )
    }

    fn sin(&self, a: Fingerprint) -> Fingerprint {
        self.combine(|field, k| field.sin(a.residues[k]), Balls.sin(a.real))
    }

    fn cos(&self, a: Fingerprint) -> Fingerprint {
        self.combine(|field, k| field.cos(a.residues[k]), Balls.cos(a.real))
    }

    fn sqrt(&self, a: Fingerprint) -> Fingerprint {
        self.combine(|field, k| field.sqrt(a.residues[k]), Balls.sqrt(a.real))
    }

    #[inline]
    fn fma(&self, a: Fingerprint, b: Fingerprint, c: Fingerprint) -> Fingerprint {
        self.add(self.mul(a, b), c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_equal_only_in_both_fields_and_in_numbers() {
        let print = |residues: [u64; 2], number: f64| Fingerprint {
            residues,
            real: Ball::exact([number]),
        };
        assert_eq!(print([5, 7], 0.5), print([5, 7], 0.5));
        assert_ne!(print([5, 7], 0.5), print([6, 7], 0.5));
        assert_ne!(print([5, 7], 0.5), print([5, 8], 0.5));
        assert_ne!(print([5, 7], 0.5), print([5, 7], 0.25));
        let undefined = print([PrimeField::UNDEFINED, 7], 0.5);
        assert_ne!(undefined, undefined);
        assert!(!print([0, 3], 0.0).is_zero() && !print([0, 0], 1.0).is_zero());
    }
}
