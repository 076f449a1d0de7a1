//! Two versions of a function, compared bit by bit.

use super::Tally;
use crate::referee;
use robovec_ir::evaluate::evaluate_mixed_nodes;
use robovec_ir::{Format, Function, OperandKind, View, print};

pub(super) fn bit_by_bit(
    old: View<'_>,
    new: View<'_>,
    pairs: &[(usize, usize)],
    inputs: &[Vec<f64>; 2],
    tally: &mut Tally,
) -> std::result::Result<(), String> {
    if old.function.formats.is_some() {
        return in_formats(old, new, pairs, inputs, tally);
    }
    for single in [false, true] {
        let before = referee::in_hardware(old.function, &inputs[0], single);
        let after = referee::in_hardware(new.function, &inputs[1], single);
        for &(first, second) in pairs {
            let Some(number) = before[first] else {
                continue;
            };
            tally.bits += 1;
            // Zeros of either sign are equal.
            if after[second] != Some(number) {
                let format = if single { "binary32" } else { "binary64" };
                return Err(format!(
                    "{} in {format} is {number:?} before and {:?} after",
                    print::print_output(old, old.function.assignments[first].output),
                    after[second]
                ));
            }
        }
    }
    Ok(())
}

/// Each value in its own format.
fn in_formats(
    old: View<'_>,
    new: View<'_>,
    pairs: &[(usize, usize)],
    inputs: &[Vec<f64>; 2],
    tally: &mut Tally,
) -> std::result::Result<(), String> {
    let evaluate = |function: &Function, inputs: &[f64]| -> Vec<Option<f64>> {
        let values = evaluate_mixed_nodes(function, Format::BINARY64, inputs);
        let whole = values.iter().all(|value| value.is_finite());
        let assignments = function.assignments.iter();
        assignments
            .map(|assignment| match assignment.operand.kind() {
                OperandKind::Value(value) => Some(values[value.index()]).filter(|_| whole),
                _ => None,
            })
            .collect()
    };
    let before = evaluate(old.function, &inputs[0]);
    let after = evaluate(new.function, &inputs[1]);
    for &(first, second) in pairs {
        let (Some(before), Some(after)) = (before[first], after[second]) else {
            continue;
        };
        tally.bits += 1;
        if before != after {
            return Err(format!(
                "{} in formats of values is {before:?} before and {after:?} after",
                print::print_output(old, old.function.assignments[first].output)
            ));
        }
    }
    Ok(())
}
