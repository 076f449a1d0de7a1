//! Dual numbers: a number with its derivative along a direction.
//!
//! `a + a' ε` with `ε² = 0`, over numbers of any kind: in a prime field the
//! derivative of a rational function is exact, so that a program for it is
//! refuted by one point (Clifford 1871; Griewank and Walther, *Evaluating
//! Derivatives*, 2008, section 3.1). Sine and cosine are each other's
//! derivative in every representation, and the derivative of a root is half of
//! one over it.
//!
//! A number that does not depend on the direction has no derivative instead of
//! a zero one: a root of a constant zero is then no `0/0`.

use crate::arithmetic::Arithmetic;

/// Arithmetic on dual numbers over another arithmetic.
#[derive(Clone, Copy, Debug)]
pub struct Duals<A>(pub A);

/// A number and its derivative.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Dual<N> {
    /// The number.
    pub value: N,
    /// The derivative; `None` for a number that does not depend on the
    /// direction.
    pub slope: Option<N>,
}

impl<N> Dual<N> {
    /// A number that does not depend on the direction.
    pub fn fixed(value: N) -> Dual<N> {
        Dual { value, slope: None }
    }
}

impl<A: Arithmetic> Duals<A> {
    fn plus(&self, a: Option<A::Number>, b: Option<A::Number>) -> Option<A::Number> {
        match (a, b) {
            (Some(a), Some(b)) => Some(self.0.add(a, b)),
            (one, None) | (None, one) => one,
        }
    }

    fn minus(&self, a: Option<A::Number>) -> Option<A::Number> {
        a.map(|a| self.0.neg(a))
    }

    /// The derivative of a product.
    fn product(&self, a: Dual<A::Number>, b: Dual<A::Number>) -> Option<A::Number> {
        let left = a.slope.map(|slope| self.0.mul(slope, b.value));
        let right = b.slope.map(|slope| self.0.mul(a.value, slope));
        self.plus(left, right)
    }
}

impl<A: Arithmetic> Arithmetic for Duals<A> {
    type Number = Dual<A::Number>;

    fn literal(&self, number: f64) -> Self::Number {
        Dual::fixed(self.0.literal(number))
    }

    fn neg(&self, a: Self::Number) -> Self::Number {
        Dual {
            value: self.0.neg(a.value),
            slope: self.minus(a.slope),
        }
    }

    fn add(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        Dual {
            value: self.0.add(a.value, b.value),
            slope: self.plus(a.slope, b.slope),
        }
    }

    fn sub(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        Dual {
            value: self.0.sub(a.value, b.value),
            slope: self.plus(a.slope, self.minus(b.slope)),
        }
    }

    fn mul(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        Dual {
            value: self.0.mul(a.value, b.value),
            slope: self.product(a, b),
        }
    }

    /// `(a/b)' = (a' - (a/b) b') / b`.
    fn div(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        let value = self.0.div(a.value, b.value);
        let drop = b.slope.map(|slope| self.0.mul(value, slope));
        let above = self.plus(a.slope, self.minus(drop));
        Dual {
            value,
            slope: above.map(|above| self.0.div(above, b.value)),
        }
    }

    fn sin(&self, a: Self::Number) -> Self::Number {
        let slope = |slope| self.0.mul(self.0.cos(a.value), slope);
        Dual {
            value: self.0.sin(a.value),
            slope: a.slope.map(slope),
        }
    }

    fn cos(&self, a: Self::Number) -> Self::Number {
        let slope = |slope| self.0.neg(self.0.mul(self.0.sin(a.value), slope));
        Dual {
            value: self.0.cos(a.value),
            slope: a.slope.map(slope),
        }
    }

    fn sqrt(&self, a: Self::Number) -> Self::Number {
        let value = self.0.sqrt(a.value);
        let slope = |slope| self.0.div(slope, self.0.add(value, value));
        Dual {
            value,
            slope: a.slope.map(slope),
        }
    }

    fn fma(&self, a: Self::Number, b: Self::Number, c: Self::Number) -> Self::Number {
        Dual {
            value: self.0.fma(a.value, b.value, c.value),
            slope: self.plus(self.product(a, b), c.slope),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Binary64;

    /// An operation as a function of numbers, in any arithmetic.
    type Of<A> =
        fn(&A, <A as Arithmetic>::Number, <A as Arithmetic>::Number) -> <A as Arithmetic>::Number;

    #[test]
    fn derivatives_are_those_of_differences() {
        let pairs: [(Of<Duals<Binary64>>, Of<Binary64>); 8] = [
            (Duals::add, Binary64::add),
            (Duals::sub, Binary64::sub),
            (Duals::mul, Binary64::mul),
            (Duals::div, Binary64::div),
            (|d, a, _| d.sin(a), |d, a, _| d.sin(a)),
            (|d, a, _| d.cos(a), |d, a, _| d.cos(a)),
            (|d, a, _| d.sqrt(a), |d, a, _| d.sqrt(a)),
            (|d, a, b| d.fma(a, b, a), |d, a, b| d.fma(a, b, a)),
        ];
        let (a, b, along) = (0.7, -1.3, [0.4, 0.9]);
        for (number, (dual, plain)) in pairs.into_iter().enumerate() {
            let with = |value, slope| Dual {
                value,
                slope: Some(slope),
            };
            let found = dual(&Duals(Binary64), with(a, along[0]), with(b, along[1]));
            let step = 1e-5;
            let at = |t: f64| plain(&Binary64, a + t * along[0], b + t * along[1]);
            let difference = (at(step) - at(-step)) / (2.0 * step);
            let slope = found.slope.expect("it depends on the direction");
            assert!(
                (slope - difference).abs() < 1e-8,
                "{number}: {slope} {difference}"
            );
            assert_eq!(found.value, at(0.0));
        }
    }

    #[test]
    fn what_is_fixed_has_no_derivative() {
        let arithmetic = Duals(Binary64);
        let root = arithmetic.sqrt(arithmetic.literal(0.0));
        assert_eq!(root.slope, None);
        let moving = Dual {
            value: 2.0,
            slope: Some(1.0),
        };
        assert_eq!(arithmetic.mul(root, moving).slope, Some(0.0));
    }
}
