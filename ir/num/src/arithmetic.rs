//! Number types as objects: the arithmetic of an evaluator.
//!
//! An [`Arithmetic`] is a value, not only a type, because some of them carry
//! data: the prime field its random seed, a custom float format its widths.

use crate::operation::Operation;

/// Arithmetic on one kind of number.
pub trait Arithmetic {
    /// The numbers.
    type Number: Copy;

    /// The number of a literal.
    fn literal(&self, number: f64) -> Self::Number;
    /// `-a`.
    fn neg(&self, a: Self::Number) -> Self::Number;
    /// `a + b`.
    fn add(&self, a: Self::Number, b: Self::Number) -> Self::Number;
    /// `a - b`.
    fn sub(&self, a: Self::Number, b: Self::Number) -> Self::Number;
    /// `a * b`.
    fn mul(&self, a: Self::Number, b: Self::Number) -> Self::Number;
    /// `a / b`.
    fn div(&self, a: Self::Number, b: Self::Number) -> Self::Number;
    /// `sin(a)`.
    fn sin(&self, a: Self::Number) -> Self::Number;
    /// `cos(a)`.
    fn cos(&self, a: Self::Number) -> Self::Number;
    /// `sqrt(a)`.
    fn sqrt(&self, a: Self::Number) -> Self::Number;
    /// `a * b + c`, rounded once.
    fn fma(&self, a: Self::Number, b: Self::Number, c: Self::Number) -> Self::Number;

    /// The result of an operation; operands beyond its number of operands are
    /// ignored.
    #[inline]
    fn apply(&self, operation: Operation, [a, b, c]: [Self::Number; 3]) -> Self::Number {
        self.apply_read(operation, [&a, &b, &c])
    }

    /// As [`Arithmetic::apply`], of operands that lie elsewhere: of wide
    /// numbers only those that the operation takes are read.
    #[inline(always)]
    fn apply_read(&self, operation: Operation, [a, b, c]: [&Self::Number; 3]) -> Self::Number {
        match operation {
            Operation::Copy => *a,
            Operation::Neg => self.neg(*a),
            Operation::Add => self.add(*a, *b),
            Operation::Sub => self.sub(*a, *b),
            Operation::Mul => self.mul(*a, *b),
            Operation::Div => self.div(*a, *b),
            Operation::Sin => self.sin(*a),
            Operation::Cos => self.cos(*a),
            Operation::Sqrt => self.sqrt(*a),
            Operation::Fma => self.fma(*a, *b, *c),
            Operation::Fms => self.fms(*a, *b, *c),
            Operation::Fnma => self.fnma(*a, *b, *c),
        }
    }

    /// `a * b - c`, rounded once: negation is exact and rounding to nearest
    /// is symmetric.
    #[inline]
    fn fms(&self, a: Self::Number, b: Self::Number, c: Self::Number) -> Self::Number {
        self.fma(a, b, self.neg(c))
    }
    /// `c - a * b`, rounded once.
    #[inline]
    fn fnma(&self, a: Self::Number, b: Self::Number, c: Self::Number) -> Self::Number {
        self.fma(self.neg(a), b, c)
    }
}

/// The operations of an [`Arithmetic`] that are operators of its numbers.
macro_rules! by_operators {
    () => {
        #[inline]
        fn neg(&self, a: Self::Number) -> Self::Number {
            -a
        }
        #[inline]
        fn add(&self, a: Self::Number, b: Self::Number) -> Self::Number {
            a + b
        }
        #[inline]
        fn sub(&self, a: Self::Number, b: Self::Number) -> Self::Number {
            a - b
        }
        #[inline]
        fn mul(&self, a: Self::Number, b: Self::Number) -> Self::Number {
            a * b
        }
        fn div(&self, a: Self::Number, b: Self::Number) -> Self::Number {
            a / b
        }
    };
}
pub(crate) use by_operators;

/// IEEE binary64.
#[derive(Clone, Copy, Default, Debug)]
pub struct Binary64;

/// IEEE binary32. Literals are rounded to it; sine and cosine are those of
/// binary64 rounded once, as a host that prepares inputs would compute them.
#[derive(Clone, Copy, Default, Debug)]
pub struct Binary32;

impl Arithmetic for Binary64 {
    type Number = f64;

    fn literal(&self, number: f64) -> f64 {
        number
    }
    by_operators!();
    fn sin(&self, a: f64) -> f64 {
        a.sin()
    }
    fn cos(&self, a: f64) -> f64 {
        a.cos()
    }
    fn sqrt(&self, a: f64) -> f64 {
        a.sqrt()
    }
    fn fma(&self, a: f64, b: f64, c: f64) -> f64 {
        a.mul_add(b, c)
    }
}

impl Arithmetic for Binary32 {
    type Number = f32;

    fn literal(&self, number: f64) -> f32 {
        number as f32
    }
    by_operators!();
    fn sin(&self, a: f32) -> f32 {
        f64::from(a).sin() as f32
    }
    fn cos(&self, a: f32) -> f32 {
        f64::from(a).cos() as f32
    }
    fn sqrt(&self, a: f32) -> f32 {
        a.sqrt()
    }
    fn fma(&self, a: f32, b: f32, c: f32) -> f32 {
        a.mul_add(b, c)
    }
}
