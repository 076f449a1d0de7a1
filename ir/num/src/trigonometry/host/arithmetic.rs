//! Arithmetics whose sines and cosines are those of a unit.

use super::TrigonometricUnit;
use crate::arithmetic::Arithmetic;

/// An arithmetic that takes sines and cosines from a unit, rounded to its own
/// numbers; all other operations are unchanged.
#[derive(Clone, Copy, Debug)]
pub struct WithTrigonometry<'a, A> {
    /// The arithmetic of all other operations.
    pub arithmetic: A,
    /// Computes sines and cosines.
    pub unit: &'a TrigonometricUnit,
}

impl<A> Arithmetic for WithTrigonometry<'_, A>
where
    A: Arithmetic<Number: Into<f64>>,
{
    type Number = A::Number;

    fn literal(&self, number: f64) -> A::Number {
        self.arithmetic.literal(number)
    }
    fn neg(&self, a: A::Number) -> A::Number {
        self.arithmetic.neg(a)
    }
    fn add(&self, a: A::Number, b: A::Number) -> A::Number {
        self.arithmetic.add(a, b)
    }
    fn sub(&self, a: A::Number, b: A::Number) -> A::Number {
        self.arithmetic.sub(a, b)
    }
    fn mul(&self, a: A::Number, b: A::Number) -> A::Number {
        self.arithmetic.mul(a, b)
    }
    fn div(&self, a: A::Number, b: A::Number) -> A::Number {
        self.arithmetic.div(a, b)
    }
    fn sin(&self, a: A::Number) -> A::Number {
        let [sine, _] = self.unit.sine_and_cosine(a.into());
        self.arithmetic.literal(sine)
    }
    fn cos(&self, a: A::Number) -> A::Number {
        let [_, cosine] = self.unit.sine_and_cosine(a.into());
        self.arithmetic.literal(cosine)
    }
    fn sqrt(&self, a: A::Number) -> A::Number {
        self.arithmetic.sqrt(a)
    }
    fn fma(&self, a: A::Number, b: A::Number, c: A::Number) -> A::Number {
        self.arithmetic.fma(a, b, c)
    }
    fn fms(&self, a: A::Number, b: A::Number, c: A::Number) -> A::Number {
        self.arithmetic.fms(a, b, c)
    }
    fn fnma(&self, a: A::Number, b: A::Number, c: A::Number) -> A::Number {
        self.arithmetic.fnma(a, b, c)
    }
}
