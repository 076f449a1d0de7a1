//! The narrowest format that meets the tolerances.

use super::ranges::{exponent_bits, largest_exponent};
use super::tolerance::FormatErrors;
use super::{FitError, FitProgram, FitTask};
use crate::explore::program::ExplorationError;
use crate::yardstick::Yardstick;
use robovec_ir::Format;
use robovec_num::NumberFormat;

/// Mantissas that are looked at.
const NARROWEST: u32 = 4;
const WIDEST: u32 = 52;

/// The part of a tolerance that the errors at the states of the search and of
/// the validation may use up: other states have other worst cases, and a
/// challenge that fails costs more than a bit.
const PART: f64 = 0.7;

/// The formats a program is measured in, with its errors at the states of the
/// validation: the narrowest that meets the tolerances, if any does, and
/// binary32, which everybody knows.
///
/// The mantissa is halved down at the few states of the search and then
/// widened until it also holds at the many of the validation.
pub(super) fn formats(
    task: &FitTask<'_>,
    program: &FitProgram,
    search: &Yardstick,
    validation: &Yardstick,
) -> Result<Vec<(Format, FormatErrors)>, FitError> {
    let measure_at =
        |yardstick: &Yardstick, format| FormatErrors::at(task, program, format, yardstick);
    let measure = |format: Format| measure_at(search, format);
    let mut found = vec![(Format::BINARY32, measure_at(validation, Format::BINARY32)?)];
    if program.model_share > PART {
        // No format helps a series that is not exact enough.
        return Ok(found);
    }
    let exponent = largest_exponent(program, validation).map_err(ExplorationError::from)?;
    let meets = |measured: &FormatErrors| {
        measured.errors.normwise.worst.is_finite() && measured.used() <= PART
    };
    let subnormals = match task.machine.number {
        Format::Float(float) => float.subnormals,
        Format::Fixed(_) => true,
    };
    for exponent in exponent_bits(exponent)..=11 {
        let format = |mantissa| {
            Format::Float(NumberFormat {
                exponent,
                mantissa,
                subnormals,
            })
        };
        if !meets(&measure(format(WIDEST))?) {
            // Numbers sink below the exponents there are.
            continue;
        }
        // Invariant: `high` meets the tolerances, `low` does not.
        let (mut low, mut high) = (NARROWEST - 1, WIDEST);
        while low + 1 < high {
            let middle = low.midpoint(high);
            if meets(&measure(format(middle))?) {
                high = middle;
            } else {
                low = middle;
            }
        }
        for mantissa in high..=WIDEST {
            let errors = measure_at(validation, format(mantissa))?;
            if meets(&errors) {
                if format(mantissa) != Format::BINARY32 {
                    found.push((format(mantissa), errors));
                }
                return Ok(found);
            }
        }
    }
    Ok(found)
}
