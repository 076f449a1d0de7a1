//! Size of the numbers of a program, and the exponent that holds them.

use super::FitProgram;
use crate::program::view;
use robovec_error::yardstick::{Unmeasurable, Yardstick};
use robovec_ir::evaluate::evaluate_nodes;
use robovec_num::NumberFormat;
use robovec_num::arithmetic::Binary64;

/// The exponent of the largest number that a program meets at the yardstick's
/// states: inputs, constants and every value on the way.
pub(super) fn largest_exponent(
    program: &FitProgram,
    yardstick: &Yardstick,
) -> Result<i32, Unmeasurable> {
    let view = view(&program.module);
    let mut largest = 0.0f64;
    for inputs in yardstick.inputs(view)? {
        let values = evaluate_nodes(view.function, &Binary64, &inputs);
        let numbers = values
            .iter()
            .chain(&inputs)
            .chain(view.function.constants());
        for number in numbers.filter(|number| number.is_finite()) {
            largest = largest.max(number.abs());
        }
    }
    Ok(largest.max(1.0).log2().ceil() as i32)
}

/// Powers of two that the largest number of other states may exceed those of
/// the states looked at.
const MARGIN: i32 = 2;

/// The fewest bits of exponent whose largest number is above `2^exponent`,
/// with a margin; at least 4, since fewer leave no normal numbers below one
/// to speak of.
pub(super) fn exponent_bits(exponent: i32) -> u32 {
    let holds = |bits: &u32| {
        let format = NumberFormat {
            exponent: *bits,
            mantissa: 1,
            subnormals: true,
        };
        format.largest_exponent() >= exponent + MARGIN
    };
    (4..=11).find(holds).unwrap_or(11)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_hold_with_a_margin() {
        assert_eq!(
            [0, 5, 6, 13, 14, 125, 126].map(exponent_bits),
            [4, 4, 5, 5, 6, 8, 9]
        );
        assert_eq!(exponent_bits(4000), 11);
    }
}
