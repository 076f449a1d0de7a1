//! Double-double for several states at once.
//!
//! The halves of all lanes lie side by side and no operation branches on a
//! single lane, so that a compiler can keep several lanes in one register of
//! the processor. One test over all lanes finds the special cases (infinities,
//! products near the ends of the range); the operation is then repeated lane
//! by lane with [`Double`]. Both ways give the same bits.

use super::{Double, DoubleDouble, fast_two_sum, product_error, two_sum};
use crate::arithmetic::Arithmetic;

/// `LANES` double-double numbers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct DoubleLanes<const LANES: usize> {
    /// The numbers rounded to binary64.
    pub high: [f64; LANES],
    /// The remainders of the rounding.
    pub low: [f64; LANES],
}

/// The arithmetic of [`DoubleLanes`].
#[derive(Clone, Copy, Default, Debug)]
pub struct DoubleDoubleLanes<const LANES: usize>;

impl<const LANES: usize> DoubleLanes<LANES> {
    /// One binary64 number per lane.
    pub fn new(high: [f64; LANES]) -> DoubleLanes<LANES> {
        DoubleLanes {
            high,
            low: [0.0; LANES],
        }
    }

    /// The number of a lane.
    #[inline]
    pub fn lane(&self, lane: usize) -> Double {
        Double {
            high: self.high[lane],
            low: self.low[lane],
        }
    }

    /// The numbers of a function of the lane.
    pub fn from_lanes(number: impl Fn(usize) -> Double) -> DoubleLanes<LANES> {
        let mut result = DoubleLanes::new([0.0; LANES]);
        for lane in 0..LANES {
            let number = number(lane);
            result.high[lane] = number.high;
            result.low[lane] = number.low;
        }
        result
    }

    /// True when all lanes and all intermediate results are finite: an infinity
    /// or NaN anywhere in an operation makes the low half NaN.
    #[inline]
    fn is_regular(&self) -> bool {
        // NaN and infinity times zero are NaN, and a sum with NaN is NaN.
        self.low.iter().fold(0.0, |sum, low| sum + low * 0.0) == 0.0
    }
}

impl<const LANES: usize> Arithmetic for DoubleDoubleLanes<LANES> {
    type Number = DoubleLanes<LANES>;

    fn literal(&self, number: f64) -> Self::Number {
        DoubleLanes::new([number; LANES])
    }

    #[inline]
    fn neg(&self, a: Self::Number) -> Self::Number {
        DoubleLanes {
            high: a.high.map(|half| -half),
            low: a.low.map(|half| -half),
        }
    }

    #[inline]
    fn add(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        let mut result = a;
        for lane in 0..LANES {
            let sum = two_sum(a.high[lane], b.high[lane]);
            let rest = two_sum(a.low[lane], b.low[lane]);
            let joined = fast_two_sum(sum.high, sum.low + rest.high);
            let number = fast_two_sum(joined.high, joined.low + rest.low);
            result.high[lane] = number.high;
            result.low[lane] = number.low;
        }
        if result.is_regular() {
            return result;
        }
        DoubleLanes::from_lanes(|lane| a.lane(lane) + b.lane(lane))
    }

    #[inline]
    fn sub(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        self.add(a, self.neg(b))
    }

    #[inline]
    fn mul(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        let mut result = a;
        for lane in 0..LANES {
            let (x, y) = (a.high[lane], b.high[lane]);
            let product = x * y;
            let error = if cfg!(target_feature = "fma") {
                x.mul_add(y, -product)
            } else {
                product_error(x, y, product)
            };
            let cross = x * b.low[lane] + a.low[lane] * y;
            let number = fast_two_sum(product, error + cross);
            result.high[lane] = number.high;
            result.low[lane] = number.low;
        }
        if result.is_regular() {
            return result;
        }
        DoubleLanes::from_lanes(|lane| a.lane(lane) * b.lane(lane))
    }

    fn div(&self, a: Self::Number, b: Self::Number) -> Self::Number {
        DoubleLanes::from_lanes(|lane| a.lane(lane) / b.lane(lane))
    }

    fn sin(&self, a: Self::Number) -> Self::Number {
        DoubleLanes::from_lanes(|lane| DoubleDouble.sin(a.lane(lane)))
    }

    fn cos(&self, a: Self::Number) -> Self::Number {
        DoubleLanes::from_lanes(|lane| DoubleDouble.cos(a.lane(lane)))
    }

    fn sqrt(&self, a: Self::Number) -> Self::Number {
        DoubleLanes::from_lanes(|lane| a.lane(lane).sqrt())
    }

    #[inline]
    fn fma(&self, a: Self::Number, b: Self::Number, c: Self::Number) -> Self::Number {
        self.add(self.mul(a, b), c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{mix, unit};
    use std::array;

    /// Numbers of all sizes, and the special ones.
    fn numbers() -> Vec<Double> {
        let mut numbers: Vec<Double> = [
            0.0,
            -0.0,
            1.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
            f64::MAX,
            1.5e308,
            1e-300,
            f64::MIN_POSITIVE,
            5e-324,
        ]
        .map(Double::from)
        .to_vec();
        for index in 0..60u64 {
            let unit = |salt| unit(mix(index * 3 + salt)) - 0.5;
            let exponent = (unit(0) * 600.0) as i32;
            let high = unit(1) * 2f64.powi(exponent);
            numbers.push(fast_two_sum(high, unit(2) * high * 2f64.powi(-53)));
        }
        numbers
    }

    fn same(a: Double, b: Double) -> bool {
        let bits = |number: Double| (number.high.to_bits(), number.low.to_bits());
        bits(a) == bits(b) || a.high.is_nan() && b.high.is_nan()
    }

    #[test]
    fn lanes_give_the_bits_of_single_numbers() {
        type One = fn(&DoubleDouble, Double, Double) -> Double;
        type All = fn(&DoubleDoubleLanes<4>, DoubleLanes<4>, DoubleLanes<4>) -> DoubleLanes<4>;
        let operations: [(One, All); 7] = [
            (Arithmetic::add, Arithmetic::add),
            (Arithmetic::sub, Arithmetic::sub),
            (Arithmetic::mul, Arithmetic::mul),
            (Arithmetic::div, Arithmetic::div),
            (|d, a, _| d.sqrt(a), |d, a, _| d.sqrt(a)),
            (|d, a, _| d.sin(a), |d, a, _| d.sin(a)),
            (|d, a, b| d.fma(a, b, a), |d, a, b| d.fma(a, b, a)),
        ];
        let numbers = numbers();
        for (shift, &a) in numbers.iter().enumerate() {
            for first in (0..numbers.len()).step_by(4) {
                let pick = |lane: usize| numbers[(first + lane * (1 + shift % 3)) % numbers.len()];
                let b: [Double; 4] = array::from_fn(pick);
                let gathered = DoubleLanes {
                    high: b.map(|number| number.high),
                    low: b.map(|number| number.low),
                };
                let spread = DoubleLanes {
                    high: [a.high; 4],
                    low: [a.low; 4],
                };
                for (one, all) in operations {
                    let result = all(&DoubleDoubleLanes, spread, gathered);
                    for (lane, &b) in b.iter().enumerate() {
                        let expected = one(&DoubleDouble, a, b);
                        let found = result.lane(lane);
                        assert!(same(found, expected), "{a:?} {b:?}: {found:?} {expected:?}");
                    }
                }
            }
        }
    }
}
