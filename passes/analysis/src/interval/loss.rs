//! Loss by rounding the results of one operation.

use crate::adjoint::half_ulp;
use robovec_ir::{Format, Operation};
use robovec_num::interval::Interval;
use robovec_num::soft_float::FormatArithmetic;

/// The range after rounding, and the largest distance it moves a number, for
/// operands that are numbers of the format.
///
/// Rounding is monotonic: the ends of the range after it are the ends rounded.
pub(crate) fn rounded(
    operation: Operation,
    operands: [Interval; 3],
    range: Interval,
    format: Format,
) -> (Interval, f64) {
    let most = match nearest(range, format) {
        (_, lost) if lost.is_infinite() => return (Interval::WHOLE, lost),
        (_, lost) if operation.is_trigonometric() => {
            // The host's function is that of binary64, within one unit in the
            // last place; for other formats its result is rounded once more.
            let lost = if format == Format::BINARY64 {
                2.0 * lost
            } else {
                lost + f64::EPSILON * range.magnitude()
            };
            return (range.widened(lost), lost);
        }
        (_, lost) => lost,
    };
    let most = match exact(operation, operands, format) {
        Exactness::Always => return (range, 0.0),
        Exactness::Normal => most.min(half_ulp(format, 0.0)),
        Exactness::Never => most.min(smaller_term(operation, operands, format)),
    };
    (nearest(range, format).0, most)
}

/// The numbers of a format nearest to those of a range, and the largest
/// distance between both; infinite where the format has no such numbers.
pub(super) fn nearest(range: Interval, format: Format) -> (Interval, f64) {
    let (small, large) = (range.mignitude(), range.magnitude());
    let overflows = |end: f64| half_ulp(format, end).is_infinite();
    let arithmetic = FormatArithmetic::new(format);
    let ends = [range.low, range.high].map(|end| arithmetic.convert(end));
    if overflows(range.low) || overflows(range.high) || !ends.iter().all(|end| end.is_finite()) {
        return (Interval::WHOLE, f64::INFINITY);
    }
    // A power of two is its own rounding, and what lies below it has units half
    // as large. Numbers near zero have larger ones where they are flushed.
    let lost = if large == 0.0 {
        0.0
    } else if small < large {
        half_ulp(format, large.next_down()).max(half_ulp(format, small))
    } else {
        half_ulp(format, large.next_down())
    };
    (Interval::new(ends[0], ends[1]), lost)
}

/// The most that a sum can lose since either operand is a number of the
/// format: the sum is at least as near to its nearest number.
fn smaller_term(operation: Operation, [a, b, _]: [Interval; 3], format: Format) -> f64 {
    let sum = matches!(operation, Operation::Add | Operation::Sub);
    match format {
        Format::Float(float) if sum && float.subnormals => a.magnitude().min(b.magnitude()),
        _ => f64::INFINITY,
    }
}

/// Cases in which an operation is exact.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Exactness {
    Always,
    /// Range in which the result is a normal number.
    Normal,
    Never,
}

fn exact(operation: Operation, [a, b, _]: [Interval; 3], format: Format) -> Exactness {
    let sum = match operation {
        Operation::Copy | Operation::Neg => return Exactness::Always,
        Operation::Add => Some(-b),
        Operation::Sub => Some(b),
        _ => None,
    };
    let float = match format {
        Format::Float(float) => float,
        Format::Fixed(_) if sum.is_some() => return Exactness::Always,
        Format::Fixed(_) => return Exactness::Never,
    };
    let zero = |interval| interval == Interval::ZERO;
    match (operation, sum) {
        _ if sum.is_some() && (zero(a) || zero(b)) => Exactness::Always,
        // Sterbenz: numbers of one sign, neither more than twice the other.
        (_, Some(b)) if near(a, b) || near(-a, -b) => {
            if float.subnormals {
                Exactness::Always
            } else {
                Exactness::Normal
            }
        }
        (Operation::Mul, _) if power_of_two(a).or(power_of_two(b)).is_some() => {
            let larger = power_of_two(a).or(power_of_two(b)) >= Some(1.0);
            if larger && float.subnormals {
                Exactness::Always
            } else {
                Exactness::Normal
            }
        }
        (Operation::Div, _) if power_of_two(b).is_some() => Exactness::Normal,
        _ => Exactness::Never,
    }
}

/// True when both are positive and neither is more than twice the other;
/// doubling is exact, or gives infinity, which only makes the test stricter.
fn near(a: Interval, b: Interval) -> bool {
    a.low > 0.0 && b.low > 0.0 && a.high <= 2.0 * b.low && b.high <= 2.0 * a.low
}

/// The size of a single number that is a power of two.
fn power_of_two(interval: Interval) -> Option<f64> {
    let number = interval.low.abs();
    let one = interval.low == interval.high && number.is_normal();
    (one && number.to_bits() & ((1 << 52) - 1) == 0).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Loss by rounding numbers to binary64.
    fn lost(operation: Operation, a: [f64; 2], b: [f64; 2]) -> f64 {
        let (a, b) = (Interval::new(a[0], a[1]), Interval::new(b[0], b[1]));
        let range = match operation {
            Operation::Add => a + b,
            Operation::Sub => a - b,
            Operation::Mul => a * b,
            _ => a / b,
        };
        rounded(operation, [a, b, b], range, Format::BINARY64).1
    }

    #[test]
    fn what_is_exact_loses_nothing() {
        assert_eq!(lost(Operation::Sub, [1.0, 1.9], [1.0, 1.7]), 0.0);
        assert_eq!(lost(Operation::Add, [-1.9, -1.0], [1.0, 1.7]), 0.0);
        assert_eq!(lost(Operation::Mul, [1.0, 1.9], [4.0, 4.0]), 0.0);
        assert_eq!(
            lost(Operation::Mul, [-0.5, -0.5], [1.0, 1.9]),
            2f64.powi(-1075).max(0.0)
        );
        assert_eq!(lost(Operation::Add, [0.0, 0.0], [1.0, 1.9]), 0.0);
        for (a, b) in [([1.0, 2.1], [1.0, 1.7]), ([-1.0, 1.0], [-1.0, 1.0])] {
            assert!(lost(Operation::Sub, a, b) > 0.0);
        }
        assert!(lost(Operation::Mul, [1.0, 1.9], [3.0, 3.0]) > 0.0);
    }
}
