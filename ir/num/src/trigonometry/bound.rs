//! The largest error over a range, from enclosures on its parts.

use crate::interval::Interval;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Parts a range may be cut into before the bound is good enough; the count,
/// not the time, limits the work.
const MAX_PARTS: usize = 600;

/// A bound may be this much above an error that is known to occur.
const CLOSE: f64 = 1.02;

struct RangePart {
    low: f64,
    high: f64,
    /// No error on it is larger.
    upper: f64,
}

impl PartialEq for RangePart {
    fn eq(&self, other: &RangePart) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for RangePart {}

impl PartialOrd for RangePart {
    fn partial_cmp(&self, other: &RangePart) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for RangePart {
    fn cmp(&self, other: &RangePart) -> Ordering {
        let order = self.upper.total_cmp(&other.upper);
        order.then(other.low.total_cmp(&self.low))
    }
}

/// A number that no error exceeds for angles from 0 to `range`, where
/// `enclosure` holds the errors for all angles between its two arguments.
///
/// The part with the largest bound is cut in two until that bound is close to
/// an error that certainly occurs (the smallest member of an enclosure of one
/// angle), or until there are very many parts.
pub fn worst(range: f64, enclosure: impl Fn(f64, f64) -> Interval) -> f64 {
    let part = |low: f64, high: f64| RangePart {
        low,
        high,
        upper: enclosure(low, high).magnitude(),
    };
    let at = |angle: f64| enclosure(angle, angle).mignitude();
    let mut reached = at(0.0).max(at(range));
    let mut parts = BinaryHeap::from([part(0.0, range)]);
    for _ in 0..MAX_PARTS {
        let top = parts.peek().expect("the parts cover the range");
        let middle = 0.5 * (top.low + top.high);
        let divisible = top.low < middle && middle < top.high;
        // An error of NaN is larger than all, and stays.
        if top.upper <= CLOSE * reached || top.upper == 0.0 || !divisible {
            break;
        }
        let top = parts.pop().expect("the parts cover the range");
        reached = reached.max(at(middle));
        parts.push(part(top.low, middle));
        parts.push(part(middle, top.high));
    }
    let top = parts.peek().expect("the parts cover the range");
    if top.upper.is_nan() {
        f64::INFINITY
    } else {
        top.upper
    }
}

#[cfg(test)]
mod tests {
    use super::super::polynomial::{Circular, Polynomial};
    use super::*;

    #[test]
    fn the_largest_value_of_a_function_is_found() {
        // x (1 - x) on [0, 1], by intervals.
        let bound = worst(1.0, |low, high| {
            let x = Interval { low, high };
            x * (Interval::point(1.0) - x)
        });
        assert!((0.25..0.26).contains(&bound), "{bound}");
        assert_eq!(worst(1.0, |_, _| Interval::point(0.0)), 0.0);
        assert_eq!(worst(1.0, |_, _| Interval::within(f64::NAN)), f64::INFINITY);
    }

    /// The largest errors of sine and cosine on a range, for orders 1, 3, 5
    /// and 7, to the digits given.
    const TABLE: [(f64, [(f64, f64); 4]); 4] = [
        (
            0.1,
            [
                (1.7e-4, 5.0e-3),
                (8.3e-8, 4.2e-6),
                (2.0e-11, 1.4e-9),
                (2.8e-15, 2.5e-13),
            ],
        ),
        (
            0.5,
            [
                (2.1e-2, 1.2e-1),
                (2.6e-4, 2.6e-3),
                (1.5e-6, 2.2e-5),
                (5.4e-9, 9.7e-8),
            ],
        ),
        (
            std::f64::consts::FRAC_PI_2,
            [
                (0.57, 1.0),
                (7.5e-2, 0.23),
                (4.5e-3, 2.0e-2),
                (1.6e-4, 8.9e-4),
            ],
        ),
        (
            std::f64::consts::PI,
            [(3.1, 2.0), (2.0, 2.9), (0.52, 1.1), (7.5e-2, 0.21)],
        ),
    ];

    #[test]
    fn series_of_taylor_err_as_is_known() {
        for (range, errors) in TABLE {
            for (order, (sine, cosine)) in [1, 3, 5, 7].into_iter().zip(errors) {
                for (of, known) in [(Circular::Sine, sine), (Circular::Cosine, cosine)] {
                    let proved = Polynomial::taylor(of, order).proved_error(range);
                    assert!(
                        (known * 0.95..known * 1.08).contains(&proved),
                        "{} of order {order} on {range}: {proved} instead of {known}",
                        of.name()
                    );
                }
            }
        }
    }

    #[test]
    fn ranges_that_are_none_have_no_bound() {
        let sine = Polynomial::taylor(Circular::Sine, 5);
        assert_eq!(sine.proved_error(f64::NAN), f64::INFINITY);
        assert_eq!(sine.proved_error(-1.0), f64::INFINITY);
        assert_eq!(sine.proved_error(1e3), f64::INFINITY);
        assert!(sine.proved_error(0.0) < 1e-300);
    }
}
