//! Comparison in floating point: bit equality and distance.

use super::Deviation;
use super::failure::{Failed, FailureKind, Values};
use super::pairing::Pairs;
use super::states::{SCALES, StatePlace, StateScale};
use robovec_analysis::accuracy::evaluate_at;
use robovec_ir::evaluate::{evaluate_mixed_nodes, evaluate_nodes};
use robovec_ir::states::States;
use robovec_ir::{Format, Function, OperandKind, View};
use robovec_num::arithmetic::{Arithmetic, Binary32, Binary64};
use robovec_num::double_double::DoubleDouble;

/// States for comparing bits: usual ones, and one of every other scale.
fn places(states: u32) -> impl Iterator<Item = StatePlace> {
    let usual = (0..states).map(StatePlace::usual);
    let others = SCALES
        .into_iter()
        .filter(|scale| !matches!(scale, StateScale::Usual | StateScale::UsualAgain));
    usual.chain(others.map(|scale| StatePlace { scale, number: 0 }))
}

/// The first output that is not bit-equal in binary64 or binary32, values
/// that have their own formats being in those.
pub(super) fn first_bit_difference(
    pairs: &Pairs<'_>,
    source: &States,
    states: u32,
) -> Option<(usize, FailureKind)> {
    let versions = [pairs.before.function, pairs.after.function];
    let plain = versions.into_iter().all(is_plain);
    places(states).find_map(|state| {
        let inputs = pairs.numbers(source, state);
        if plain {
            return compare_bits(pairs, &inputs, ("binary64", state), native(&Binary64))
                .or_else(|| compare_bits(pairs, &inputs, ("binary32", state), native(&Binary32)));
        }
        [
            ("binary64", Format::BINARY64),
            ("binary32", Format::BINARY32),
        ]
        .into_iter()
        .find_map(|(name, format)| {
            compare_bits(pairs, &inputs, (name, state), |function, inputs| {
                evaluate_mixed_nodes(function, format, inputs)
            })
        })
    })
}

/// True for a function whose values are all in the format of the run, and
/// whose sines and cosines are true ones.
pub(super) fn is_plain(function: &Function) -> bool {
    function.formats.is_none() && function.trigonometry_unit().is_none()
}

/// Evaluation in an arithmetic of the processor's.
fn native<A>(arithmetic: &A) -> impl Fn(&Function, &[f64]) -> Vec<f64>
where
    A: Arithmetic<Number: Into<f64>>,
{
    move |function, inputs| {
        let literals: Vec<A::Number> = inputs
            .iter()
            .map(|&number| arithmetic.literal(number))
            .collect();
        let values = evaluate_nodes(function, arithmetic, &literals);
        values.into_iter().map(Into::into).collect()
    }
}

fn compare_bits(
    pairs: &Pairs<'_>,
    [old, new]: &[Vec<f64>; 2],
    (format, state): (&'static str, StatePlace),
    evaluate: impl Fn(&Function, &[f64]) -> Vec<f64>,
) -> Option<(usize, FailureKind)> {
    let round = |number: f64| match format {
        "binary32" => f64::from(number as f32),
        _ => number,
    };
    let [old, new] = [old, new]
        .map(|inputs| -> Vec<f64> { inputs.iter().map(|&number| round(number)).collect() });
    let before = finite_outputs(
        pairs.before,
        &old,
        &evaluate(pairs.before.function, &old),
        round,
    );
    let values = evaluate(pairs.after.function, &new);
    let after = assigned(pairs.after.function, &new, &values, round);
    pairs.list.iter().enumerate().find_map(|(index, pair)| {
        // The promise is about numbers: where the function as it was
        // overflows or divides by zero on the way, anything may follow.
        let before = before[pair.before]?;
        let after = after[pair.after];
        let values = Values {
            state,
            before,
            after,
            allowed: 0.0,
        };
        // Comparing numbers makes zeros of either sign equal.
        (before != after).then_some((index, FailureKind::Bits { format, values }))
    })
}

/// The first of the given outputs that is a number in double-double before
/// and after, and another one. The tolerance is far above the rounding of
/// double-double and far below any wrong term.
pub(super) fn first_distance(
    pairs: &Pairs<'_>,
    among: &[usize],
    source: &States,
    states: u32,
) -> Option<Failed> {
    const TOLERANCE: f64 = 1e-9;
    if among.is_empty() {
        return None;
    }
    places(states).find_map(|state| {
        let [old, new] = pairs.numbers(source, state);
        let before = evaluate_at(pairs.before.function, &DoubleDouble, &old);
        let after = evaluate_at(pairs.after.function, &DoubleDouble, &new);
        among.iter().find_map(|&index| {
            let pair = &pairs.list[index];
            let (before, after) = (before[pair.before], after[pair.after]);
            // What is left of a cancellation has no digits to compare.
            let size = before.high.abs().max(after.high.abs()).max(TOLERANCE);
            let distance = (after - before).high.abs();
            let values = Values {
                state,
                before: before.high,
                after: after.high,
                allowed: TOLERANCE * size,
            };
            let apart = distance.is_finite() && distance > values.allowed;
            apart.then_some(Failed {
                pair: index,
                values,
                inputs: None,
            })
        })
    })
}

/// The outputs of a function, given the values of its nodes; `None` where a
/// value that is not finite was met on the way.
fn finite_outputs(
    view: View<'_>,
    inputs: &[f64],
    values: &[f64],
    round: impl Fn(f64) -> f64,
) -> Vec<Option<f64>> {
    let function = view.function;
    assert_eq!(values.len(), function.nodes().len(), "one value per node");
    let mut finite: Vec<bool> = Vec::with_capacity(values.len());
    for (node, &value) in function.nodes().iter().zip(values) {
        let mut operands = node.operands().iter().filter_map(|operand| operand.value());
        let known = operands.all(|operand| finite[operand.index()]);
        finite.push(known && value.is_finite());
    }
    let numbers = assigned(function, inputs, values, round);
    let places = numbers.into_iter().zip(&function.assignments);
    let known = places.map(|(number, assignment)| {
        let value = assignment.operand.value();
        let finite = value.is_none_or(|value| finite[value.index()]);
        finite.then_some(number)
    });
    known.collect()
}

/// The outputs of a function, given the values of its nodes.
fn assigned(
    function: &Function,
    inputs: &[f64],
    values: &[f64],
    round: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let numbers = function
        .assignments
        .iter()
        .map(|assignment| match assignment.operand.kind() {
            OperandKind::Value(value) => values[value.index()],
            OperandKind::Input(input) => inputs[input.index()],
            OperandKind::Constant(constant) => round(function.constant_number(constant)),
            OperandKind::None => 0.0,
        });
    numbers.collect()
}

/// The distance between the versions in double-double.
pub(super) fn deviation(pairs: &Pairs<'_>, source: &States, states: u32) -> Deviation {
    let mut deviation = Deviation {
        worst_normwise: 0.0,
        worst_relative: 0.0,
        output: None,
    };
    let function = pairs.before.function;
    for state in 0..states {
        let [old, new] = pairs.state(source, state);
        let before = evaluate_at(pairs.before.function, &DoubleDouble, &old);
        let after = evaluate_at(pairs.after.function, &DoubleDouble, &new);
        let mut norms = vec![(0.0f64, 0.0f64); function.outputs().len()];
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
            let array = function.output_array(pair.output);
            norms[array].0 = norms[array].0.max(error);
        }
        for pair in &pairs.list {
            let array = function.output_array(pair.output);
            norms[array].1 = norms[array].1.max(before[pair.before].high.abs());
        }
        for (error, size) in norms.into_iter().filter(|(error, _)| *error > 0.0) {
            deviation.worst_normwise = deviation.worst_normwise.max(error / size);
        }
    }
    deviation
}
