//! The timing constraints of the project.

use crate::hardware::MachineShape;
use robovec_framework::template::fill;
use std::fmt::Display;

/// The constraints (Synopsys design constraints) of a machine on the board.
///
/// Where a cycle has several clocks, all registers in the elements that change
/// only at the end of a cycle have a whole cycle from register to register:
/// instruction words, operators, operands.
pub(super) fn constraints(shape: &MachineShape, plain: bool) -> String {
    let pll = if plain { "" } else { "derive_pll_clocks\n" };
    let text = fill(include_str!("robovec.sdc"), &[("pll", &pll)]);
    match shape.phases() {
        0 | 1 => text,
        phases => {
            let words: [(&str, &dyn Display); 2] = [("phases", &phases), ("hold", &(phases - 1))];
            text + &fill(include_str!("slow.sdc"), &words)
        }
    }
}
