//! The error that rounding adds to that of a recipe.
//!
//! The standard forward bound: every operation's result is bounded on a part
//! of the range by interval arithmetic, and its error by those of its
//! operands and the rounding of the operation itself, half a unit of the
//! format. The range is cut into equal parts and the largest bound taken, so
//! that the values are known closely enough. Coefficients that the format
//! does not hold count as rounded.

use super::recipe::Recipe;
use robovec_ir::{Format, Function, Node, Operand, OperandKind, Operation};
use robovec_num::interval::Interval;
use robovec_num::soft_float::FormatArithmetic;

/// Parts the range is cut into.
const PARTS: u32 = 64;

/// A value with a bound of the error of the computed one.
#[derive(Clone, Copy)]
struct Computed {
    exact: Interval,
    error: f64,
}

impl Recipe {
    /// Bounds of the rounding errors of a format, in addition to the errors of
    /// the sine and the cosine, for angles of at most `range` radians that are
    /// numbers of the format; 0 for a function that is not computed.
    pub fn rounding_errors(&self, range: f64, format: Format) -> [f64; 2] {
        let mut worst = [0.0f64; 2];
        for part in 0..PARTS {
            let end = |part: u32| range * f64::from(part) / f64::from(PARTS);
            let angle = Interval {
                low: end(part),
                high: end(part + 1),
            };
            let values = self.bound(angle, format);
            for (worst, &result) in worst.iter_mut().zip(&self.results) {
                let error = if result.is_none() {
                    0.0
                } else {
                    fetch(&self.function, &values, angle, result, format).error
                };
                *worst = worst.max(error);
            }
        }
        worst
    }

    fn bound(&self, angle: Interval, format: Format) -> Vec<Computed> {
        let mut values: Vec<Computed> = Vec::with_capacity(self.function.nodes().len());
        for node in self.function.nodes() {
            let [a, b, _] = node
                .operands
                .map(|operand| fetch(&self.function, &values, angle, operand, format));
            values.push(combine(node, a, b, format));
        }
        values
    }
}

fn fetch(
    function: &Function,
    values: &[Computed],
    angle: Interval,
    operand: Operand,
    format: Format,
) -> Computed {
    match operand.kind() {
        OperandKind::Value(value) => values[value.index()],
        OperandKind::Input(_) => Computed {
            exact: angle,
            error: 0.0,
        },
        OperandKind::Constant(constant) => {
            let number = function.constant_number(constant);
            Computed {
                exact: Interval::point(number),
                // Neighbours subtract exactly.
                error: (FormatArithmetic::new(format).convert(number) - number).abs(),
            }
        }
        OperandKind::None => Computed {
            exact: Interval::point(0.0),
            error: 0.0,
        },
    }
}

/// The operations of recipes are sums, differences and products. Bounds are
/// computed in binary64 and rounded up by a part far above its rounding.
fn combine(node: &Node, a: Computed, b: Computed, format: Format) -> Computed {
    const UP: f64 = 1.0 + 1e-14;
    let (exact, inherited) = match node.operation {
        Operation::Add => (a.exact + b.exact, a.error + b.error),
        Operation::Sub => (a.exact - b.exact, a.error + b.error),
        _ => {
            // A square's operands have the same error.
            let size = a.exact.magnitude() * b.error + b.exact.magnitude() * a.error;
            (a.exact * b.exact, size + a.error * b.error)
        }
    };
    let size = exact.magnitude() + inherited;
    let doubled = node.operation == Operation::Mul && is_two(a)
        || node.operands[0] == node.operands[1] && node.operation == Operation::Add;
    let own = match doubled {
        // Doubling is exact in binary formats.
        true => 0.0,
        false => rounding(node.operation, size, format),
    };
    Computed {
        exact,
        error: (inherited + own) * UP,
    }
}

fn is_two(computed: Computed) -> bool {
    computed.exact == Interval::point(2.0)
}

/// Half a unit in the last place of a number of a size.
fn rounding(operation: Operation, size: f64, format: Format) -> f64 {
    match format {
        // Sums of fixed-point numbers are exact.
        Format::Fixed(_) if operation != Operation::Mul => 0.0,
        Format::Fixed(_) => format.unit_roundoff(),
        Format::Float(float) => {
            let least = 2f64.powi(float.smallest_exponent());
            let small = if float.subnormals {
                least * format.unit_roundoff()
            } else {
                least
            };
            // No number is rounded by more than half the spacing of numbers
            // at the largest power of two not above it.
            half_spacing(size, format).max(small)
        }
    }
}

fn half_spacing(size: f64, format: Format) -> f64 {
    let exponent = match size.to_bits() >> 52 {
        0 => -1022,
        biased => biased as i32 - 1023,
    };
    2f64.powi(exponent) * format.unit_roundoff()
}
