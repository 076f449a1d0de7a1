//! Intervals of binary64 numbers, rounded outwards.
//!
//! Every operation gives an interval that holds the results for all members
//! of its operands: bounds are moved outwards by one number, which covers the
//! rounding of the one operation that made them. No infinities are needed for
//! angles and errors; where one appears it only makes an interval wide.

/// All numbers from `low` to `high`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ErrorInterval {
    /// The least number.
    pub low: f64,
    /// The largest number.
    pub high: f64,
}

impl ErrorInterval {
    /// The interval of one number.
    pub fn point(number: f64) -> ErrorInterval {
        ErrorInterval {
            low: number,
            high: number,
        }
    }

    /// The numbers of at most this size.
    pub fn within(size: f64) -> ErrorInterval {
        debug_assert!(size.is_nan() || size >= 0.0, "a size is not negative");
        ErrorInterval {
            low: -size,
            high: size,
        }
    }

    /// The size of its largest member.
    pub fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// The size of its smallest member.
    pub fn mignitude(self) -> f64 {
        if self.low <= 0.0 && self.high >= 0.0 {
            0.0
        } else {
            self.low.abs().min(self.high.abs())
        }
    }

    /// The interval with a margin on both sides.
    #[must_use]
    pub fn widened(self, margin: f64) -> ErrorInterval {
        outwards(self.low - margin, self.high + margin)
    }

    /// The members that lie in another interval too; `self` when there are
    /// none, which rounding alone can bring about.
    #[must_use]
    pub fn clamped(self, other: ErrorInterval) -> ErrorInterval {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        if low <= high {
            ErrorInterval { low, high }
        } else {
            self
        }
    }

    /// True when both bounds are numbers.
    pub fn is_finite(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }
}

/// The bounds moved outwards by one number; a bound that is zero stays, since
/// sums and products of binary64 numbers round to zero only when they are
/// zero or far below anything an error bound is about.
fn outwards(low: f64, high: f64) -> ErrorInterval {
    let down = |number: f64| match number {
        0.0 => 0.0,
        other => other.next_down(),
    };
    let up = |number: f64| match number {
        0.0 => 0.0,
        other => other.next_up(),
    };
    ErrorInterval {
        low: down(low),
        high: up(high),
    }
}

impl std::ops::Add for ErrorInterval {
    type Output = ErrorInterval;

    fn add(self, other: ErrorInterval) -> ErrorInterval {
        outwards(self.low + other.low, self.high + other.high)
    }
}

impl std::ops::Neg for ErrorInterval {
    type Output = ErrorInterval;

    fn neg(self) -> ErrorInterval {
        ErrorInterval {
            low: -self.high,
            high: -self.low,
        }
    }
}

impl std::ops::Sub for ErrorInterval {
    type Output = ErrorInterval;

    fn sub(self, other: ErrorInterval) -> ErrorInterval {
        self + -other
    }
}

impl std::ops::Mul for ErrorInterval {
    type Output = ErrorInterval;

    fn mul(self, other: ErrorInterval) -> ErrorInterval {
        let products = [
            self.low * other.low,
            self.low * other.high,
            self.high * other.low,
            self.high * other.high,
        ];
        let low = products.into_iter().fold(f64::INFINITY, f64::min);
        let high = products.into_iter().fold(f64::NEG_INFINITY, f64::max);
        outwards(low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_hold_those_of_all_members() {
        let (a, b) = (
            ErrorInterval {
                low: -0.1,
                high: 0.3,
            },
            ErrorInterval {
                low: 0.7,
                high: 1.1,
            },
        );
        for i in 0..=10 {
            for j in 0..=10 {
                let x = -0.1 + 0.4 * f64::from(i) / 10.0;
                let y = 0.7 + 0.4 * f64::from(j) / 10.0;
                let holds = |interval: ErrorInterval, number: f64| {
                    interval.low <= number + 1e-15 && number - 1e-15 <= interval.high
                };
                assert!(holds(a + b, x + y) && holds(a - b, x - y) && holds(a * b, x * y));
            }
        }
        assert_eq!((a.magnitude(), a.mignitude()), (0.3, 0.0));
        assert_eq!((b.magnitude(), (-b).mignitude()), (1.1, 0.7));
        let product = ErrorInterval::point(0.1) * ErrorInterval::point(0.1);
        assert!(product.low < 0.1 * 0.1 && product.high > 0.1 * 0.1);
        let zero = ErrorInterval::point(0.0) * a;
        assert_eq!((zero.low, zero.high), (0.0, 0.0));
    }

    #[test]
    fn clamping_keeps_an_interval() {
        let unit = ErrorInterval::within(1.0);
        let inside = ErrorInterval::point(0.5).widened(0.75).clamped(unit);
        assert!(inside.high == 1.0 && inside.low < -0.24);
        assert_eq!(
            ErrorInterval::point(2.0).clamped(unit),
            ErrorInterval::point(2.0)
        );
    }
}
