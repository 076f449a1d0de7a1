//! Several evaluations at once.
//!
//! Most of the time of an evaluation is spent on decoding operations; decoding
//! once for several states divides that by their number and keeps the
//! processor's pipelines full.

use crate::arithmetic::Arithmetic;
use std::array;

/// `LANES` independent evaluations, each with its arithmetic: a number is an
/// array with one number per lane.
#[derive(Clone, Copy, Debug)]
pub struct Batch<A, const LANES: usize>(pub [A; LANES]);

impl<A: Arithmetic, const LANES: usize> Batch<A, LANES> {
    /// The inputs of all lanes, from the inputs of each.
    ///
    /// # Panics
    ///
    /// Panics when a lane has other inputs than the first.
    pub fn gather(inputs: &[Vec<A::Number>; LANES]) -> Vec<[A::Number; LANES]> {
        const { assert!(LANES > 0, "a batch has a lane") };
        let count = inputs[0].len();
        assert!(
            inputs.iter().all(|lane| lane.len() == count),
            "all lanes have the same inputs"
        );
        (0..count)
            .map(|index| array::from_fn(|lane| inputs[lane][index]))
            .collect()
    }

    #[inline]
    fn unary(
        &self,
        a: [A::Number; LANES],
        operation: impl Fn(&A, A::Number) -> A::Number,
    ) -> [A::Number; LANES] {
        array::from_fn(|lane| operation(&self.0[lane], a[lane]))
    }

    #[inline]
    fn binary(
        &self,
        a: [A::Number; LANES],
        b: [A::Number; LANES],
        operation: impl Fn(&A, A::Number, A::Number) -> A::Number,
    ) -> [A::Number; LANES] {
        array::from_fn(|lane| operation(&self.0[lane], a[lane], b[lane]))
    }
}

impl<A: Arithmetic, const LANES: usize> Arithmetic for Batch<A, LANES> {
    type Number = [A::Number; LANES];

    fn literal(&self, number: f64) -> Self::Number {
        array::from_fn(|lane| self.0[lane].literal(number))
    }
    #[inline]
    fn neg(&self, a: Self::Number) -> Self::Number {
        self.unary(a, A::neg)
    }
    #[inline]
    fn add(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        self.binary(a, b, A::add)
    }
    #[inline]
    fn sub(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        self.binary(a, b, A::sub)
    }
    #[inline]
    fn mul(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        self.binary(a, b, A::mul)
    }
    fn div(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        self.binary(a, b, A::div)
    }
    fn sin(&self, a: Self::Number) -> Self::Number {
        self.unary(a, A::sin)
    }
    fn cos(&self, a: Self::Number) -> Self::Number {
        self.unary(a, A::cos)
    }
    fn sqrt(&self, a: Self::Number) -> Self::Number {
        self.unary(a, A::sqrt)
    }
    fn fma(&self, a: Self::Number, b: Self::Number, c: Self::Number) -> Self::Number {
        array::from_fn(|lane| self.0[lane].fma(a[lane], b[lane], c[lane]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Binary64;

    #[test]
    fn lanes_are_independent() {
        let batch = Batch([Binary64; 3]);
        let (a, b) = ([1.0, 2.0, -3.0], [0.5, 4.0, 9.0]);
        for lane in 0..3 {
            assert_eq!(batch.add(a, b)[lane], a[lane] + b[lane]);
            assert_eq!(batch.sub(a, b)[lane], a[lane] - b[lane]);
            assert_eq!(batch.mul(a, b)[lane], a[lane] * b[lane]);
            assert_eq!(batch.div(a, b)[lane], a[lane] / b[lane]);
            assert_eq!(batch.neg(a)[lane], -a[lane]);
            assert_eq!(batch.sin(a)[lane], a[lane].sin());
            assert_eq!(batch.cos(a)[lane], a[lane].cos());
            assert_eq!(batch.sqrt(b)[lane], b[lane].sqrt());
            assert_eq!(batch.fma(a, b, a)[lane], a[lane].mul_add(b[lane], a[lane]));
        }
        assert_eq!(batch.literal(2.5), [2.5; 3]);
        let lanes = [vec![1.0, 2.0], vec![3.0, 4.0], vec![5.0, 6.0]];
        let gathered = Batch::<Binary64, 3>::gather(&lanes);
        assert_eq!(gathered, [[1.0, 3.0, 5.0], [2.0, 4.0, 6.0]]);
    }
}
