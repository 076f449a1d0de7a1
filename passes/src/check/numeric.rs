//! Comparison in floating point: bit equality and distance.

use super::pairing::Pairs;
use super::{Deviation, FailureKind};
use crate::analysis::accuracy::evaluate_at;
use robovec_ir::Output;
use robovec_ir::arithmetic::{Binary32, Binary64};
use robovec_ir::double_double::DoubleDouble;
use robovec_ir::states::States;

/// The first output that is not bit-equal in binary64 or binary32.
pub(super) fn first_bit_difference(
    pairs: &Pairs<'_>,
    states: u32,
    seed: u64,
) -> Option<(Output, FailureKind)> {
    let source = States::new(seed);
    (0..states).find_map(|state| {
        let inputs = source.draw(pairs.before, state);
        let wide = [pairs.before, pairs.after].map(|view| evaluate_at(view, &Binary64, &inputs));
        let narrow = [pairs.before, pairs.after].map(|view| {
            let outputs = evaluate_at(view, &Binary32, &inputs);
            outputs.into_iter().map(f64::from).collect::<Vec<f64>>()
        });
        [("binary64", wide), ("binary32", narrow)]
            .into_iter()
            .find_map(|(format, [before, after])| {
                pairs.list.iter().find_map(|pair| {
                    let (before, after) = (before[pair.before], after[pair.after]);
                    // Comparing numbers makes zeros of either sign equal, and
                    // a conversion from binary32 loses no bit of a number.
                    let equal = before == after || before.is_nan() && after.is_nan();
                    let kind = FailureKind::Bits {
                        format,
                        state,
                        before,
                        after,
                    };
                    (!equal).then_some((pair.output, kind))
                })
            })
    })
}

/// The first of the given outputs that is a number in double-double before
/// and after, and another one. The tolerance is far above the rounding of
/// double-double and far below any wrong term.
pub(super) fn first_distance(
    pairs: &Pairs<'_>,
    among: &[usize],
    states: u32,
    seed: u64,
) -> Option<(Output, FailureKind)> {
    const TOLERANCE: f64 = 1e-9;
    if among.is_empty() {
        return None;
    }
    let source = States::new(seed);
    (0..states).find_map(|state| {
        let inputs = source.draw(pairs.before, state);
        let before = evaluate_at(pairs.before, &DoubleDouble, &inputs);
        let after = evaluate_at(pairs.after, &DoubleDouble, &inputs);
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
pub(super) fn deviation(pairs: &Pairs<'_>, states: u32, seed: u64) -> Deviation {
    let mut deviation = Deviation {
        worst_normwise: 0.0,
        worst_relative: 0.0,
        output: None,
    };
    let source = States::new(seed);
    let arrays = pairs.before.function.outputs();
    for state in 0..states {
        let inputs = source.draw(pairs.before, state);
        let before = evaluate_at(pairs.before, &DoubleDouble, &inputs);
        let after = evaluate_at(pairs.after, &DoubleDouble, &inputs);
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
