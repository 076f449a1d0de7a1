//! Two versions of a function, compared bit by bit.

use super::Tally;
use crate::mutations::outputs;
use crate::referee;
use robovec_ir::{Format, View, print};

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
    let before = outputs(old.function, Format::BINARY64, &inputs[0]);
    let after = outputs(new.function, Format::BINARY64, &inputs[1]);
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
