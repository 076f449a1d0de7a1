//! The range of the number of a node: bounds, and whether zero is possible.

use robovec_ir::Operation;

/// Bounds of a real number, rounded outwards.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Range {
    /// The lower bound.
    pub low: f64,
    /// The upper bound.
    pub high: f64,
    /// True when it is not zero.
    pub nonzero: bool,
}

impl Range {
    /// Any number.
    pub const ALL: Range = Range {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
        nonzero: false,
    };

    /// Zero or above.
    pub const NOT_NEGATIVE: Range = Range {
        low: 0.0,
        ..Range::ALL
    };

    /// Anything but zero.
    pub const NONZERO: Range = Range {
        nonzero: true,
        ..Range::ALL
    };

    /// Numbers between two bounds.
    pub fn between(low: f64, high: f64) -> Range {
        Range {
            low,
            high,
            nonzero: low > 0.0 || high < 0.0,
        }
    }

    /// 1 when no number is negative, −1 when none is positive, else 0.
    pub fn sign(self) -> i32 {
        match self {
            _ if self.low >= 0.0 => 1,
            _ if self.high <= 0.0 => -1,
            _ => 0,
        }
    }

    /// The range known from two sources.
    #[must_use]
    pub fn and(self, other: Range) -> Range {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        Range {
            low,
            high,
            nonzero: self.nonzero || other.nonzero || low > 0.0 || high < 0.0,
        }
    }

    /// The rest of this range when only the sign of a factor is known.
    #[must_use]
    pub fn scaled(self, sign: i32) -> Range {
        let oriented = match sign {
            1 => self.sign(),
            -1 => -self.sign(),
            _ => 0,
        };
        let range = match oriented {
            1 => Range::NOT_NEGATIVE,
            -1 => Range::NOT_NEGATIVE.negative(),
            _ => Range::ALL,
        };
        Range {
            nonzero: self.nonzero,
            ..range
        }
    }

    /// The range of the negated number.
    #[must_use]
    pub fn negative(self) -> Range {
        Range {
            low: -self.high,
            high: -self.low,
            nonzero: self.nonzero,
        }
    }

    /// The range of a sum.
    #[must_use]
    pub fn plus(self, other: Range) -> Range {
        let sum = Range::between(
            rounded(self.low, other.low, f64::next_down),
            rounded(self.high, other.high, f64::next_up),
        );
        let (signs, nonzero) = (self.sign() + other.sign(), self.nonzero || other.nonzero);
        Range {
            // Terms of one sign do not cancel.
            nonzero: sum.nonzero || nonzero && signs.abs() == 2,
            ..sum.on_side(signs / 2)
        }
    }

    /// The range of a product.
    #[must_use]
    pub fn times(self, other: Range) -> Range {
        let corners = [
            (self.low, other.low),
            (self.low, other.high),
            (self.high, other.low),
            (self.high, other.high),
        ];
        let products = |outwards| corners.map(|(a, b)| product(a, b, outwards));
        let lows = products(f64::next_down);
        let highs = products(f64::next_up);
        let range = Range {
            low: lows.into_iter().fold(f64::INFINITY, f64::min),
            high: highs.into_iter().fold(f64::NEG_INFINITY, f64::max),
            nonzero: self.nonzero && other.nonzero,
        };
        range.on_side(self.sign() * other.sign())
    }

    /// The quotient, where it is defined.
    #[must_use]
    pub fn over(self, other: Range) -> Range {
        let inverse = match other {
            _ if other.low > 0.0 || other.high < 0.0 => {
                Range::between((1.0 / other.high).next_down(), (1.0 / other.low).next_up())
                    .on_side(other.sign())
            }
            _ => Range::ALL.on_side(other.sign()),
        };
        let quotient = self.times(Range {
            nonzero: true,
            ..inverse
        });
        Range {
            nonzero: self.nonzero,
            ..quotient
        }
    }

    /// The square.
    #[must_use]
    pub fn squared(self) -> Range {
        self.times(self).on_side(1)
    }

    /// The square root, where it is defined.
    #[must_use]
    pub fn root(self) -> Range {
        Range {
            low: self.low.max(0.0).sqrt().next_down().max(0.0),
            high: self.high.max(0.0).sqrt().next_up(),
            nonzero: self.nonzero,
        }
    }

    /// The range of the result of an operation where it is defined;
    /// `is_square` for the product of a number with itself.
    #[must_use]
    pub fn of(operation: Operation, [a, b, c]: [Range; 3], is_square: bool) -> Range {
        let product = || if is_square { a.squared() } else { a.times(b) };
        match operation {
            Operation::Copy => a,
            Operation::Neg => a.negative(),
            Operation::Add => a.plus(b),
            Operation::Sub => a.plus(b.negative()),
            Operation::Mul => product(),
            Operation::Div => a.over(b),
            Operation::Sin | Operation::Cos => Range::between(-1.0, 1.0),
            Operation::Sqrt => a.root(),
            Operation::Fma => product().plus(c),
            Operation::Fms => product().plus(c.negative()),
            Operation::Fnma => c.plus(product().negative()),
        }
    }

    /// The range without the part beyond zero that outward rounding added.
    fn on_side(self, sign: i32) -> Range {
        match sign {
            1 => Range {
                low: self.low.max(0.0),
                ..self
            },
            -1 => Range {
                high: self.high.min(0.0),
                ..self
            },
            _ => self,
        }
    }
}

/// A sum, moved outwards when it was rounded.
fn rounded(a: f64, b: f64, outwards: fn(f64) -> f64) -> f64 {
    let sum = a + b;
    if !sum.is_finite() {
        return match sum.is_nan() {
            // No bound of one term meets the opposite infinity of the other.
            true => outwards(0.0) * f64::INFINITY,
            false => outwards(sum),
        };
    }
    let part = sum - a;
    if (a - (sum - part)) + (b - part) == 0.0 {
        sum
    } else {
        outwards(sum)
    }
}

/// A product, moved outwards when it was rounded. No bound is reached at
/// infinity, so that nothing times any number is nothing.
fn product(a: f64, b: f64, outwards: fn(f64) -> f64) -> f64 {
    if a == 0.0 || b == 0.0 {
        return 0.0;
    }
    let product = a * b;
    if product.is_normal() && a.mul_add(b, -product) == 0.0 {
        product
    } else {
        outwards(product)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_follow_from_bounds() {
        let wave = Range::between(-1.0, 1.0);
        let one = Range::between(1.0, 1.0);
        assert_eq!(one.plus(wave).sign(), 1);
        assert!(!one.plus(wave).nonzero);
        assert!(Range::between(2.0, 2.0).plus(wave).nonzero);
        let square = Range::ALL.squared();
        assert_eq!((square.sign(), square.nonzero), (1, false));
        assert!(square.plus(one).nonzero);
        let positive = Range {
            nonzero: true,
            ..Range::NOT_NEGATIVE
        };
        assert!(positive.plus(square).nonzero);
        assert!(positive.times(positive).nonzero);
        assert_eq!(positive.over(positive.negative()).sign(), -1);
        assert_eq!(positive.root().sign(), 1);
        assert_eq!(Range::ALL.plus(Range::ALL), Range::ALL);
        assert_eq!(positive.plus(positive.negative()).sign(), 0);
    }

    #[test]
    fn bounds_are_rounded_outwards() {
        let tenth = Range::between(0.1, 0.1);
        let sum = tenth.plus(Range::between(0.2, 0.2));
        assert!(sum.low < 0.1 + 0.2 && 0.1 + 0.2 < sum.high);
        let tiny = Range::between(1e-200, 1e-200);
        let product = tiny.times(tiny);
        assert!(product.low == 0.0 && product.high > 0.0 && product.nonzero);
        let huge = Range::between(1e200, 1e200);
        assert_eq!(huge.times(huge).high, f64::INFINITY);
        assert!(huge.times(huge).low < f64::INFINITY);
    }
}
