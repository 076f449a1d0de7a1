//! Loss by rounding the results of one operation.

use crate::adjoint::half_ulp;
use robovec_ir::{Format, Operation};
use robovec_num::interval::Interval;

/// The range after rounding, and the largest distance it moves a number, for
/// operands that are numbers of the format.
pub(crate) fn rounded(
    operation: Operation,
    operands: [Interval; 3],
    range: Interval,
    format: Format,
) -> (Interval, f64) {
    let ends = half_ulp(format, range.low).max(half_ulp(format, range.high));
    if ends.is_infinite() {
        return (Interval::WHOLE, f64::INFINITY);
    }
    let ends = match exact(operation, operands, format) {
        Exactness::Always => return (range, 0.0),
        Exactness::Normal => ends.min(half_ulp(format, 0.0)),
        Exactness::Never => ends,
    };
    let host = match operation.is_trigonometric() {
        // The host's function is that of binary64, within one unit in the last place.
        true => f64::EPSILON * range.magnitude(),
        false => 0.0,
    };
    (range.widened(ends + host), ends + host)
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
