//! Intervals of real numbers with ends in binary64.
//!
//! Every operation gives an interval that holds all real results; ends are
//! moved outwards by one number of binary64 unless they are known to be exact.
//! An operation that is undefined somewhere (a division by an interval that
//! contains zero, the root of one that extends below it) gives the whole line.
//!
//! The library's sine and cosine are taken to be within four units in the
//! last place, which every one in use keeps.

use crate::arithmetic::{Arithmetic, by_operators};

/// All numbers from one to another, both included.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Interval {
    /// The lower end; never NaN, never above the upper one.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// The arithmetic of intervals.
#[derive(Clone, Copy, Default, Debug)]
pub struct Enclosing;

impl Interval {
    /// All real numbers.
    pub const WHOLE: Interval = Interval {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };

    /// The interval of zero alone.
    pub const ZERO: Interval = Interval {
        low: 0.0,
        high: 0.0,
    };

    /// The interval between two numbers, in either order; the whole line when
    /// one is NaN.
    pub fn new(one: f64, other: f64) -> Interval {
        if one.is_nan() || other.is_nan() {
            return Interval::WHOLE;
        }
        Interval {
            low: one.min(other),
            high: one.max(other),
        }
    }

    /// The interval of one number; the whole line for NaN.
    pub fn point(number: f64) -> Interval {
        Interval::new(number, number)
    }

    /// The numbers of at most a size, which is not negative; the whole line for
    /// NaN.
    pub fn within(size: f64) -> Interval {
        assert!(size >= 0.0 || size.is_nan(), "a size is not negative");
        Interval::new(-size, size)
    }

    /// True when the number lies inside.
    pub fn contains(self, number: f64) -> bool {
        self.low <= number && number <= self.high
    }

    /// True when both ends are numbers.
    pub fn is_finite(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// The largest absolute value inside.
    pub fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// The smallest absolute value inside.
    pub fn mignitude(self) -> f64 {
        if self.contains(0.0) {
            0.0
        } else {
            self.low.abs().min(self.high.abs())
        }
    }

    /// The smallest interval that holds both.
    #[must_use]
    pub fn hull(self, other: Interval) -> Interval {
        Interval {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// The members that are in another interval too; `self` when there are
    /// none, which only rounding can cause.
    #[must_use]
    pub fn clamped(self, other: Interval) -> Interval {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        if low <= high {
            Interval { low, high }
        } else {
            self
        }
    }

    /// The interval with both ends moved outwards.
    #[must_use]
    pub fn widened(self, by: f64) -> Interval {
        assert!(by >= 0.0 || by.is_nan(), "ends move outwards");
        Interval::outward(self.low - by, self.high + by)
    }

    /// Ends that were rounded, moved outwards.
    fn outward(low: f64, high: f64) -> Interval {
        if low.is_nan() || high.is_nan() {
            return Interval::WHOLE;
        }
        assert!(low <= high, "the lower end is never above the upper one");
        Interval {
            low: low.next_down(),
            high: high.next_up(),
        }
    }

    /// The square: unlike the product with itself never negative.
    #[must_use]
    pub fn square(self) -> Interval {
        let (small, large) = (self.mignitude(), self.magnitude());
        Interval {
            low: product(small, small, false).max(0.0),
            high: product(large, large, true),
        }
    }
}

/// The bits of a number from its first one to its last one.
fn bits(number: f64) -> u32 {
    let fraction = number.to_bits() & ((1 << 52) - 1);
    53 - (fraction | 1 << 52).trailing_zeros()
}

/// True when a factor and the other one, or the quotient, are numbers of so
/// few bits that their rounded product is exact.
fn is_short(a: f64, b: f64, product: f64) -> bool {
    a.is_normal() && b.is_normal() && product.is_normal() && bits(a) + bits(b) <= 53
}

/// A product rounded down or up: moved only where it may have been rounded. No
/// number of an interval is infinite, so zero times an end is zero.
fn product(a: f64, b: f64, up: bool) -> f64 {
    if a == 0.0 || b == 0.0 {
        return 0.0;
    }
    let product = a * b;
    match up {
        _ if is_short(a, b, product) => product,
        true => product.next_up(),
        false => product.next_down(),
    }
}

/// A quotient rounded down or up: moved only where it may have been rounded.
fn quotient(a: f64, b: f64, up: bool) -> f64 {
    let quotient = a / b;
    match up {
        _ if is_short(quotient, b, a) && quotient * b == a => quotient,
        true => quotient.next_up(),
        false => quotient.next_down(),
    }
}

/// A sum rounded down or up: moved only where it was rounded.
fn sum(a: f64, b: f64, up: bool) -> f64 {
    let sum = a + b;
    let part = sum - a;
    let error = (a - (sum - part)) + (b - part);
    match up {
        // The error is exact, or NaN near an overflow.
        _ if error == 0.0 || sum.is_infinite() => sum,
        true if error < 0.0 => sum,
        false if error > 0.0 => sum,
        true => sum.next_up(),
        false => sum.next_down(),
    }
}

impl std::ops::Neg for Interval {
    type Output = Interval;

    fn neg(self) -> Interval {
        Interval {
            low: -self.high,
            high: -self.low,
        }
    }
}

impl std::ops::Add for Interval {
    type Output = Interval;

    fn add(self, other: Interval) -> Interval {
        let (low, high) = (
            sum(self.low, other.low, false),
            sum(self.high, other.high, true),
        );
        // Finite ends whose sum overflows leave the line open on that side;
        // opposite infinities, both.
        if low.is_nan() || high.is_nan() {
            Interval::WHOLE
        } else {
            Interval {
                low: if low == f64::INFINITY { f64::MAX } else { low },
                high: if high == f64::NEG_INFINITY {
                    f64::MIN
                } else {
                    high
                },
            }
        }
    }
}

impl std::ops::Sub for Interval {
    type Output = Interval;

    fn sub(self, other: Interval) -> Interval {
        self + -other
    }
}

impl std::ops::Mul for Interval {
    type Output = Interval;

    fn mul(self, other: Interval) -> Interval {
        if self == Interval::ZERO || other == Interval::ZERO {
            return Interval::ZERO;
        }
        let pairs = [
            (self.low, other.low),
            (self.low, other.high),
            (self.high, other.low),
            (self.high, other.high),
        ];
        let ends = Interval {
            low: (pairs.iter()).fold(f64::INFINITY, |low, &(a, b)| low.min(product(a, b, false))),
            high: (pairs.iter()).fold(f64::NEG_INFINITY, |high, &(a, b)| {
                high.max(product(a, b, true))
            }),
        };
        // A sign that is certain stays so: rounding never passes zero.
        let signs = [
            self.low >= 0.0,
            self.high <= 0.0,
            other.low >= 0.0,
            other.high <= 0.0,
        ];
        match signs {
            [true, _, true, _] | [_, true, _, true] => Interval {
                low: ends.low.max(0.0),
                ..ends
            },
            [true, _, _, true] | [_, true, true, _] => Interval {
                high: ends.high.min(0.0),
                ..ends
            },
            _ => ends,
        }
    }
}

impl std::ops::Div for Interval {
    type Output = Interval;

    fn div(self, other: Interval) -> Interval {
        if other.contains(0.0) {
            return Interval::WHOLE;
        }
        if self == Interval::ZERO {
            return Interval::ZERO;
        }
        let pairs = [
            (self.low, other.low),
            (self.low, other.high),
            (self.high, other.low),
            (self.high, other.high),
        ];
        if pairs.iter().any(|(a, b)| (a / b).is_nan()) {
            return Interval::WHOLE;
        }
        Interval {
            low: (pairs.iter()).fold(f64::INFINITY, |low, &(a, b)| low.min(quotient(a, b, false))),
            high: (pairs.iter()).fold(f64::NEG_INFINITY, |high, &(a, b)| {
                high.max(quotient(a, b, true))
            }),
        }
    }
}

/// Both numbers of binary64 around a multiple of π/2 (1 to 4).
fn quarter_turns(count: u32) -> Interval {
    let rounded = f64::from(count) * std::f64::consts::FRAC_PI_2;
    // 3π/2 rounds once more than the others; two steps cover both.
    Interval {
        low: rounded.next_down().next_down(),
        high: rounded.next_up().next_up(),
    }
}

/// True when an angle may be a phase plus a whole number of turns.
fn reaches(angle: Interval, phase: Interval) -> bool {
    let turns = (angle - phase) / quarter_turns(4);
    turns.high.floor() >= turns.low.ceil()
}

/// Angles beyond this are any angle.
const LARGEST_ANGLE: f64 = 1e9;

/// A wave that is greatest at one phase and least at another.
fn wave(angle: Interval, function: fn(f64) -> f64, top: Interval, bottom: Interval) -> Interval {
    // Not beyond it, so that NaN would be any angle as well.
    let small = angle.magnitude() <= LARGEST_ANGLE;
    if !small || angle.high - angle.low >= 6.0 {
        return Interval {
            low: -1.0,
            high: 1.0,
        };
    }
    let (one, other) = (function(angle.low), function(angle.high));
    let ends = Interval::new(one, other).widened(4.0 * f64::EPSILON * one.abs().max(other.abs()));
    Interval {
        low: if reaches(angle, bottom) {
            -1.0
        } else {
            ends.low.max(-1.0)
        },
        high: if reaches(angle, top) {
            1.0
        } else {
            ends.high.min(1.0)
        },
    }
}

impl Arithmetic for Enclosing {
    type Number = Interval;

    fn literal(&self, number: f64) -> Interval {
        Interval::point(number)
    }
    by_operators!();
    fn sin(&self, a: Interval) -> Interval {
        if a == Interval::ZERO {
            return a;
        }
        wave(a, f64::sin, quarter_turns(1), quarter_turns(3))
    }
    fn cos(&self, a: Interval) -> Interval {
        wave(a, f64::cos, Interval::ZERO, quarter_turns(2))
    }
    fn sqrt(&self, a: Interval) -> Interval {
        if a.low < 0.0 {
            return Interval::WHOLE;
        }
        let [low, high] = [a.low.sqrt(), a.high.sqrt()];
        let exact = |root: f64, square: f64| is_short(root, root, square) && root * root == square;
        Interval {
            low: if exact(low, a.low) {
                low
            } else {
                low.next_down().max(0.0)
            },
            high: if high == 0.0 || exact(high, a.high) {
                high
            } else {
                high.next_up()
            },
        }
    }
    fn fma(&self, a: Interval, b: Interval, c: Interval) -> Interval {
        a * b + c
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::double_double::{Double, DoubleDouble};
    use crate::random::Random;

    /// Numbers of all sizes and signs.
    fn draw(random: &mut Random) -> f64 {
        let scale = 2f64.powi(random.below(13) as i32 - 6);
        (random.unit() - 0.5) * scale
    }

    #[test]
    fn quotients_by_an_interval_that_ends_at_zero_are_anything() {
        for divisor in [Interval::new(-1.0, 0.0), Interval::new(0.0, 1.0)] {
            let quotient = Interval::new(1.0, 2.0) / divisor;
            assert!(quotient.contains(-1e9) && quotient.contains(1e9));
        }
    }

    #[test]
    fn squares_and_roots_that_round_either_way_are_enclosed() {
        // A fused operation gives the error of a rounded square exactly.
        let mut ways = [0, 0];
        for number in (1..200).map(|step| 1.0 + f64::from(step) / 7.0) {
            let square = Interval::point(number).square();
            let rounded = number * number;
            let error = number.mul_add(number, -rounded);
            ways[usize::from(error < 0.0)] += 1;
            assert!(error >= 0.0 || square.low < rounded, "{number}");
            assert!(error <= 0.0 || square.high > rounded, "{number}");
            let root = Enclosing.sqrt(Interval::point(number));
            let rounded = number.sqrt();
            let error = rounded.mul_add(rounded, -number);
            assert!(error <= 0.0 || root.low < rounded, "{number}");
            assert!(error >= 0.0 || root.high > rounded, "{number}");
        }
        assert!(ways[0] > 50 && ways[1] > 50, "{ways:?}");
    }

    #[test]
    fn results_of_members_are_members() {
        let mut random = Random::new(1);
        let mut draw = || draw(&mut random);
        let inside = |result: Double, interval: Interval| {
            let low = result - Double::from(interval.low);
            let high = Double::from(interval.high) - result;
            (low.high >= 0.0 || interval.low.is_infinite())
                && (high.high >= 0.0 || interval.high.is_infinite())
        };
        for _ in 0..20_000 {
            let (x, y) = (Interval::new(draw(), draw()), Interval::new(draw(), draw()));
            // The ends are members, and so is what lies between.
            for (a, b) in [
                (x.low, y.high),
                (x.high, y.low),
                (0.5 * (x.low + x.high), y.low),
            ] {
                let (wide_a, wide_b) = (Double::from(a), Double::from(b));
                let pairs = [
                    (wide_a + wide_b, x + y),
                    (wide_a - wide_b, x - y),
                    (wide_a * wide_b, x * y),
                    (wide_a / wide_b, x / y),
                    (DoubleDouble.sin(wide_a), Enclosing.sin(x)),
                    (DoubleDouble.cos(wide_a), Enclosing.cos(x)),
                    (
                        DoubleDouble.sqrt(wide_a * wide_a),
                        Enclosing.sqrt(x.square()),
                    ),
                    (wide_a * wide_b + wide_a, Enclosing.fma(x, y, x)),
                ];
                for (place, (result, interval)) in pairs.into_iter().enumerate() {
                    assert!(
                        inside(result, interval),
                        "{place}: {x:?} {y:?} {interval:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn waves_reach_their_extremes_where_they_do() {
        let pi = std::f64::consts::PI;
        let narrow = Enclosing.cos(Interval::new(0.5, 1.0));
        assert!(narrow.high < 0.88 && narrow.low > 0.54);
        assert_eq!(Enclosing.cos(Interval::new(-0.1, 0.1)).high, 1.0);
        assert_eq!(Enclosing.cos(Interval::new(3.0, 3.5)).low, -1.0);
        assert_eq!(Enclosing.sin(Interval::new(1.5, 1.6)).high, 1.0);
        assert_eq!(Enclosing.sin(Interval::new(-1.6, -1.5)).low, -1.0);
        assert_eq!(
            Enclosing
                .sin(Interval::new(4.0 * pi + 1.5, 4.0 * pi + 1.6))
                .high,
            1.0
        );
        assert!(Enclosing.sin(Interval::new(1.6, 1.7)).high < 1.0);
        let any = Interval::new(-1.0, 1.0);
        assert_eq!(Enclosing.sin(Interval::new(-4.0, 4.0)), any);
        assert_eq!(Enclosing.cos(Interval::WHOLE), any);
    }

    #[test]
    fn what_is_undefined_is_the_whole_line() {
        let unit = Interval::new(-1.0, 1.0);
        assert_eq!(Interval::point(1.0) / unit, Interval::WHOLE);
        assert_eq!(Enclosing.sqrt(unit), Interval::WHOLE);
        assert_eq!(Interval::WHOLE - Interval::WHOLE, Interval::WHOLE);
        assert_eq!(Interval::WHOLE * Interval::ZERO, Interval::ZERO);
        let large = Interval::point(f64::MAX);
        assert_eq!((large + large).high, f64::INFINITY);
        assert!((large + large).low.is_finite());
        assert_eq!(Interval::point(0.5) - Interval::point(0.5), Interval::ZERO);
        assert_eq!(unit.square().low, 0.0);
    }

    #[test]
    fn clamping_keeps_an_interval() {
        let unit = Interval::within(1.0);
        let inside = Interval::point(0.5).widened(0.75).clamped(unit);
        assert!(inside.high == 1.0 && inside.low < -0.24);
        assert_eq!(Interval::point(2.0).clamped(unit), Interval::point(2.0));
    }
}
