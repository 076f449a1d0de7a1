//! Comparison in floating point: bit equality and distance.

use super::pairing::Pairs;
use super::{Deviation, FailureKind};
use crate::analysis::accuracy::evaluate_at;
use robovec_ir::arithmetic::{Arithmetic, Binary32, Binary64};
use robovec_ir::double_double::DoubleDouble;
use robovec_ir::evaluate::{evaluate_nodes, outputs};
use robovec_ir::states::States;
use robovec_ir::{Output, View};

/// The first output that is not bit-equal in binary64 or binary32.
pub(super) fn first_bit_difference(
    pairs: &Pairs<'_>,
    source: &States,
    states: u32,
) -> Option<(Output, FailureKind)> {
    (0..states).find_map(|state| {
        let inputs = pairs.state(source, state);
        compare_bits(pairs, &Binary64, &inputs, ("binary64", state))
            .or_else(|| compare_bits(pairs, &Binary32, &inputs, ("binary32", state)))
    })
}

fn compare_bits<A>(
    pairs: &Pairs<'_>,
    arithmetic: &A,
    [old, new]: &[Vec<f64>; 2],
    (format, state): (&'static str, u32),
) -> Option<(Output, FailureKind)>
where
    A: Arithmetic<Number: Into<f64>>,
{
    let before = finite_outputs(pairs.before, arithmetic, old);
    let after = evaluate_at(pairs.after, arithmetic, new);
    pairs.list.iter().find_map(|pair| {
        // The promise is about numbers: where the function as it was
        // overflows or divides by zero on the way, anything may follow.
        let before: f64 = before[pair.before]?;
        let after: f64 = after[pair.after].into();
        let kind = FailureKind::Bits {
            format,
            state,
            before,
            after,
        };
        // Comparing numbers makes zeros of either sign equal, and a
        // conversion from binary32 loses no bit of a number.
        (before != after).then_some((pair.output, kind))
    })
}

/// The outputs of a function; `None` where a value that is not finite was met
/// on the way.
fn finite_outputs<A>(view: View<'_>, arithmetic: &A, inputs: &[f64]) -> Vec<Option<f64>>
where
    A: Arithmetic<Number: Into<f64>>,
{
    let function = view.function;
    let literals: Vec<A::Number> = inputs
        .iter()
        .map(|&number| arithmetic.literal(number))
        .collect();
    let values = evaluate_nodes(function, arithmetic, &literals);
    let mut finite: Vec<bool> = Vec::with_capacity(values.len());
    for (node, &value) in function.nodes().iter().zip(&values) {
        let mut operands = node.operands().iter().filter_map(|operand| operand.value());
        let known = operands.all(|operand| finite[operand.index()]);
        let value: f64 = value.into();
        finite.push(known && value.is_finite());
    }
    outputs(function, arithmetic, &literals, &values)
        .into_iter()
        .zip(&function.assignments)
        .map(|(number, assignment)| {
            let reached = assignment.operand.value();
            let finite = reached.is_none_or(|value| finite[value.index()]);
            finite.then_some(number.into())
        })
        .collect()
}

/// The first of the given outputs that is a number in double-double before
/// and after, and another one. The tolerance is far above the rounding of
/// double-double and far below any wrong term.
pub(super) fn first_distance(
    pairs: &Pairs<'_>,
    among: &[usize],
    source: &States,
    states: u32,
) -> Option<(Output, FailureKind)> {
    const TOLERANCE: f64 = 1e-9;
    if among.is_empty() {
        return None;
    }
    (0..states).find_map(|state| {
        let [old, new] = pairs.state(source, state);
        let before = evaluate_at(pairs.before, &DoubleDouble, &old);
        let after = evaluate_at(pairs.after, &DoubleDouble, &new);
        among.iter().find_map(|&index| {
            let pair = &pairs.list[index];
            let (before, after) = (before[pair.before], after[pair.after]);
            // What is left of a cancellation has no digits to compare.
            let size = before.high.abs().max(after.high.abs()).max(TOLERANCE);
            let distance = (after - before).high.abs();
            let kind = FailureKind::Distance {
                state,
                before: before.high,
                after: after.high,
            };
            (distance.is_finite() && distance > TOLERANCE * size).then_some((pair.output, kind))
        })
    })
}

/// How far the versions are apart in double-double.
pub(super) fn deviation(pairs: &Pairs<'_>, source: &States, states: u32) -> Deviation {
    let mut deviation = Deviation {
        worst_normwise: 0.0,
        worst_relative: 0.0,
        output: None,
    };
    let arrays = pairs.before.function.outputs();
    for state in 0..states {
        let [old, new] = pairs.state(source, state);
        let before = evaluate_at(pairs.before, &DoubleDouble, &old);
        let after = evaluate_at(pairs.after, &DoubleDouble, &new);
        let mut norms = vec![(0.0f64, 0.0f64); arrays.len()];
        for pair in &pairs.list {
            let (before, after) = (before[pair.before], after[pair.after]);
            let (error, size) = ((after - before).high.abs(), before.high.abs());
            if error == 0.0 || error.is_nan() && after.high.is_nan() && before.high.is_nan() {
                continue;
            }
            // A number that became undefined is as far away as can be.
            let error = if error.is_nan() { f64::INFINITY } else { error };
            let relative = error / size;
            if relative > deviation.worst_relative {
                deviation.worst_relative = relative;
                deviation.output = Some(pair.output);
            }
            let array = arrays.partition_point(|array| array.offset <= pair.output.0) - 1;
            norms[array].0 = norms[array].0.max(error);
        }
        for pair in &pairs.list {
            let array = arrays.partition_point(|array| array.offset <= pair.output.0) - 1;
            norms[array].1 = norms[array].1.max(before[pair.before].high.abs());
        }
        for (error, size) in norms.into_iter().filter(|(error, _)| *error > 0.0) {
            deviation.worst_normwise = deviation.worst_normwise.max(error / size);
        }
    }
    deviation
}
