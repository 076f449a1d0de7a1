//! Possible and actual loss of one operation.

use super::only_moves;
use super::tape::Tape;
use robovec_ir::{Format, Operation};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::double_double::{Double, DoubleDouble};

/// The largest distance of the sine and cosine of the host's library from the
/// true ones, relative to them, before they are rounded to the format: one unit
/// in the last place of binary64.
const HOST: f64 = f64::EPSILON;

/// The largest error of rounding to a format when the result is `value`: half a
/// unit in its last place; near zero half the smallest subnormal number, or the
/// smallest normal one where subnormal numbers are flushed to zero; half a step
/// in fixed point. Infinite for results that overflowed or saturated.
pub fn half_ulp(format: Format, value: f64) -> f64 {
    match format {
        Format::Float(float) => {
            let (smallest, largest) = (float.smallest_exponent(), float.largest_exponent());
            let size = value.abs();
            let exponent = match size.to_bits() >> 52 {
                // Zero and the subnormal numbers of binary64.
                0 => -1023,
                biased => biased as i32 - 1023,
            };
            if exponent > largest || size.is_nan() {
                return f64::INFINITY;
            }
            if !float.subnormals && exponent < smallest {
                return power(smallest);
            }
            power(exponent.max(smallest) - float.mantissa as i32 - 1)
        }
        Format::Fixed(fixed) => {
            let limit = power(fixed.integer as i32);
            let step = power(-(fixed.fraction as i32));
            // The greatest number is one step below the limit.
            if value > -limit && value < limit - step {
                0.5 * step
            } else {
                f64::INFINITY
            }
        }
    }
}

/// A power of two down to the smallest subnormal number of binary64, and zero
/// below.
fn power(exponent: i32) -> f64 {
    if exponent >= -1022 {
        // The exponents of formats end at that of binary64.
        f64::from_bits(((exponent + 1023) as u64) << 52)
    } else if exponent >= -1074 {
        f64::from_bits(1 << (exponent + 1074))
    } else {
        0.0
    }
}

/// For every slot the largest possible rounding error, given its `computed`
/// value and its `errors`; the exact values decide where they are larger, so
/// that the bound of a result just below a power of two does not depend on
/// chance.
///
/// Operations that never round have none: copies, negations, sums with a
/// literal zero, and in fixed point all sums. A literal or an input that the
/// format holds has none either, and the error of others is known. Where
/// formats change from one value to the next, any operation may round, and
/// literals are rounded as well: the actual rounding error always counts.
pub(super) fn bounds(
    tape: &Tape,
    format: impl Fn(usize) -> Format,
    [exact, computed, errors]: [&[f64]; 3],
) -> Vec<f64> {
    let nodes = tape.nodes();
    let is_zero = |slot: usize| slot >= nodes + tape.inputs() && exact[slot] == 0.0;
    let mut bounds = Vec::with_capacity(tape.slots());
    for node in 0..nodes {
        let (operation, format) = (tape.operation(node), format(node));
        let [a, b, _] = tape.operands(node);
        let size = if computed[node].is_nan() {
            f64::NAN
        } else {
            computed[node].abs().max(exact[node].abs())
        };
        let fixed = matches!(format, Format::Fixed(_));
        let sum = matches!(operation, Operation::Add | Operation::Sub);
        let moves = only_moves(operation) || sum && (fixed || is_zero(a) || is_zero(b));
        let rounding = half_ulp(format, size);
        let most = if moves && rounding.is_finite() {
            0.0
        } else if operation.is_trigonometric() {
            rounding + HOST * size
        } else {
            rounding
        };
        bounds.push(most.max(errors[node].abs()));
    }
    bounds.extend(errors[nodes..].iter().map(|error| error.abs()));
    bounds
}

/// For every slot its rounding error: the computed number minus the exact
/// result of the operation on the computed operands, in double-double.
pub(super) fn errors(tape: &Tape, exact: &[f64], computed: &[f64]) -> Vec<f64> {
    let nodes = tape.nodes();
    let mut errors = Vec::with_capacity(tape.slots());
    for node in 0..nodes {
        let operation = tape.operation(node);
        let operands = tape.operands(node).map(|slot| Double::from(computed[slot]));
        let result = DoubleDouble.apply(operation, operands);
        errors.push((Double::from(computed[node]) - result).high);
    }
    let leaves = exact[nodes..].iter().zip(&computed[nodes..]);
    errors.extend(leaves.map(|(exact, computed)| computed - exact));
    errors
}
