//! The error of an operator on its own, measured as that of every program.

use robovec_error::yardstick::account::{ErrorAccount, random_states};
use robovec_error::yardstick::{Unmeasurable, Yardstick};
use robovec_fpga::rtl::cores::OperatorCore;
use robovec_ir::Format;
use robovec_ir::parse::parse_module;
use robovec_ir::states::States;

/// The seed of the states, and their number.
const SEED: u64 = 1;
const STATES: u32 = 1024;

/// The error of one operation in a format, on masses as random states have
/// them: positive, from 1/8 to 128, each octave as likely as the others. One
/// rounding is at most 2^-24 of the result in binary32; formats too narrow for
/// the operands round these as well.
///
/// # Errors
///
/// See [`Unmeasurable`], for parts that cannot be measured alone.
pub fn operator_error(core: OperatorCore, format: Format) -> Result<ErrorAccount, Unmeasurable> {
    let value = match core {
        OperatorCore::Add => "m[1] + m[2]",
        OperatorCore::Multiply => "m[1]*m[2]",
        OperatorCore::Divide => "m[1]/m[2]",
        OperatorCore::Root => "sqrt(m[1])",
        OperatorCore::Fused => "fma(m[1], m[2], m[3])",
    };
    let text =
        format!("function f atomic {{\n  in m[1..3]\n  out y\n  %y1 = {value}\n  y = %y1\n}}\n");
    let module = parse_module("operator", &text).expect("one operation is a function");
    let view = module.tables.view(&module.functions[0]);
    let yardstick = Yardstick::new(view, &States::new(SEED), STATES);
    let states = random_states(yardstick.len(), SEED, false);
    ErrorAccount::measured(view, &yardstick, format, states)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_operator_rounds_once() {
        let unit = 2f64.powi(-24);
        for core in [
            OperatorCore::Add,
            OperatorCore::Multiply,
            OperatorCore::Divide,
            OperatorCore::Root,
            OperatorCore::Fused,
        ] {
            let account = operator_error(core, Format::BINARY32).expect("it is one operation");
            let errors = account.normwise;
            assert!(errors.median > unit / 16.0, "{core:?}: {errors:?}");
            assert!(errors.worst <= unit, "{core:?}: {errors:?}");
        }
    }
}
