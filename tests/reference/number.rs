//! The numbers the reference can compute with.

use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDouble};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A kind of real number.
pub(crate) trait Real:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Square root.
    fn root(self) -> Self;
    /// The nearest binary64 number.
    fn value(self) -> f64;
    /// 0.
    fn zero() -> Self {
        Self::from(0.0)
    }
}

impl Real for f64 {
    fn sin_cos(self) -> (f64, f64) {
        f64::sin_cos(self)
    }
    fn root(self) -> f64 {
        self.sqrt()
    }
    fn value(self) -> f64 {
        self
    }
}

impl Real for Double {
    fn sin_cos(self) -> (Double, Double) {
        (DoubleDouble.sin(self), DoubleDouble.cos(self))
    }
    fn root(self) -> Double {
        DoubleDouble.sqrt(self)
    }
    fn value(self) -> f64 {
        self.high
    }
}
