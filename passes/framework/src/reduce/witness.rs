//! A pair of numbers that anybody can check: small inputs for which the
//! function before a pass and the one after it differ.

use robovec_ir::evaluate::evaluate;
use robovec_ir::{Function, Input, Operand, Tables, print};
use robovec_num::arithmetic::Binary64;
use std::fmt;

/// Inputs, and an output before and after.
#[derive(Clone, PartialEq, Debug)]
pub struct Witness {
    /// Inputs that are read, as text, and their numbers.
    pub inputs: Vec<(String, f64)>,
    /// The output, as text.
    pub output: String,
    /// Its number before the pass.
    pub before: f64,
    /// Its number after it.
    pub after: f64,
}

/// The number of small states that are tried.
const STATES: u64 = 64;

/// Looks for whole numbers from −4 to 4 as inputs at which two versions of a
/// function differ, in binary64.
pub(super) fn find(tables: &Tables, before: &Function, after: &Function) -> Option<Witness> {
    (0..STATES).find_map(|state| {
        let inputs: Vec<f64> = (0..before.input_len() as u64)
            .map(|place| small(state, place))
            .collect();
        let old = evaluate(before, &Binary64, &inputs);
        let new = evaluate(after, &Binary64, &inputs);
        let place = (0..old.len()).find(|&place| differ(old[place], new[place]))?;
        let view = tables.view(before);
        Some(Witness {
            inputs: (0..)
                .map(Input)
                .zip(&inputs)
                .map(|(input, &number)| (print::print_operand(view, Operand::from(input)), number))
                .collect(),
            output: print::print_output(view, before.assignments[place].output),
            before: old[place],
            after: new[place],
        })
    })
}

/// More apart than rounding explains, both being numbers.
fn differ(before: f64, after: f64) -> bool {
    let size = before.abs().max(after.abs());
    size.is_finite() && (before - after).abs() > 1e-9 * size.max(1e-3)
}

/// Whole numbers from 1 to 4, in the later states of either sign.
fn small(state: u64, place: u64) -> f64 {
    let mixed = (state * 31 + place + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
    let size = (mixed % 4 + 1) as f64;
    if state >= STATES / 2 && mixed & 16 == 0 {
        -size
    } else {
        size
    }
}

impl fmt::Display for Witness {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let inputs: Vec<String> = self
            .inputs
            .iter()
            .map(|(name, number)| format!("{name} = {number}"))
            .collect();
        if !inputs.is_empty() {
            write!(formatter, "for {}: ", inputs.join(", "))?;
        }
        write!(
            formatter,
            "{} is {} before the pass and {} after it",
            self.output, self.before, self.after
        )
    }
}
