//! The narrowest formats that meet the tolerances, floating and fixed; errors
//! of a program in a format over the allowed ones, and the size of its numbers.

use super::{FitError, FitProgram, FitTask};
use crate::program::view;
use robovec_error::yardstick::{MeasuredErrors, Unmeasurable, Yardstick, results};
use robovec_framework::scene::Allowed;
use robovec_ir::Format;
use robovec_ir::evaluate::evaluate_nodes;
use robovec_num::arithmetic::Binary64;
use robovec_num::{FixedFormat, NumberFormat};

/// Smallest and largest number of mantissa bits that are tried.
const NARROWEST: u32 = 4;
pub(super) const WIDEST: u32 = 52;

/// Bits of a number in fixed point at most, beside its sign.
const MOST_FIXED: u32 = 53;

/// A format with a program's errors in it at the states of the validation.
pub(super) type MeasuredFormat = (Format, FormatErrors);

/// True for errors that use up a part of the tolerances at most.
pub(super) fn meets(measured: &FormatErrors, part: f64) -> bool {
    measured.errors.normwise.worst.is_finite() && measured.used() <= part
}

/// The yardsticks of a format: few states of the search, many to validate.
#[derive(Clone, Copy)]
pub(super) struct FormatQuestion<'q> {
    pub(super) task: &'q FitTask<'q>,
    pub(super) program: &'q FitProgram,
    pub(super) search: &'q Yardstick,
    pub(super) validation: &'q Yardstick,
}

impl FormatQuestion<'_> {
    /// The formats that float: the narrowest that does, if any, and binary32.
    pub(super) fn floating(&self) -> Result<Vec<MeasuredFormat>, FitError> {
        let mut found = vec![(Format::BINARY32, self.validated(Format::BINARY32)?)];
        if self.program.model_share > self.task.sampled() {
            // No format helps a series that is not exact enough.
            return Ok(found);
        }
        let subnormals = match self.task.machine.number {
            Format::Float(float) => float.subnormals,
            Format::Fixed(_) => true,
        };
        for exponent in exponent_bits(self.largest_exponent()?)..=11 {
            let format = |mantissa| {
                Format::Float(NumberFormat {
                    exponent,
                    mantissa,
                    subnormals,
                })
            };
            // Otherwise numbers sink below the exponents there are.
            if let Some(narrowest) = self.narrowest([NARROWEST, WIDEST], format)? {
                let flushed = self.flushed(narrowest.0)?;
                found.extend([Some(narrowest), flushed].into_iter().flatten());
                break;
            }
        }
        found.dedup_by_key(|(format, _)| *format);
        Ok(found)
    }

    /// A format without subnormal numbers, whose cores are smaller, that meets
    /// the tolerances as well: with the digits of one that does or one more,
    /// and with up to two more bits of exponent, since numbers sink sooner.
    fn flushed(&self, format: Format) -> Result<Option<MeasuredFormat>, FitError> {
        let Format::Float(
            float @ NumberFormat {
                subnormals: true, ..
            },
        ) = format
        else {
            return Ok(None);
        };
        for [digits, exponents] in [[0, 0], [0, 1], [1, 0], [0, 2], [1, 1]] {
            let format = Format::Float(NumberFormat {
                exponent: (float.exponent + exponents).min(11),
                mantissa: (float.mantissa + digits).min(WIDEST),
                subnormals: false,
            });
            if meets(&self.searched(format)?, self.task.sampled()) {
                let errors = self.validated(format)?;
                if meets(&errors, self.task.sampled()) {
                    return Ok(Some((format, errors)));
                }
            }
        }
        Ok(None)
    }

    /// The narrowest fixed point that meets the tolerances, or its absence.
    pub(super) fn fixed(&self) -> Result<Result<MeasuredFormat, String>, FitError> {
        if self.program.model_share > self.task.sampled() {
            return Ok(Err("its series are not exact enough".to_owned()));
        }
        let largest = self.largest_exponent()?;
        let integer = largest.max(0) as u32;
        let reach = format!("numbers reach 2^{largest} over the ranges");
        if integer >= MOST_FIXED {
            return Ok(Err(format!("{reach}, which {MOST_FIXED} bits do not hold")));
        }
        let format = |fraction| Format::Fixed(FixedFormat { integer, fraction });
        let most = MOST_FIXED - integer;
        if let Some(found) = self.narrowest([1, most], format)? {
            return Ok(Ok(found));
        }
        let used = self.validated(format(most))?.used();
        Ok(Err(format!(
            "{reach}, which leaves {most} bits after the point; the error is then \
             {used:.1e} times what is allowed"
        )))
    }

    /// The narrowest of formats by bits; `None` where the widest does not do.
    ///
    /// The bits are halved down at the few states of the search and then
    /// widened until they also hold at the many of the validation.
    fn narrowest(
        &self,
        [least, most]: [u32; 2],
        format: impl Fn(u32) -> Format,
    ) -> Result<Option<MeasuredFormat>, FitError> {
        if !meets(&self.searched(format(most))?, self.task.sampled()) {
            return Ok(None);
        }
        // Invariant: `high` meets the tolerances, `low` does not.
        let (mut low, mut high) = (least - 1, most);
        while low + 1 < high {
            let middle = low.midpoint(high);
            if meets(&self.searched(format(middle))?, self.task.sampled()) {
                high = middle;
            } else {
                low = middle;
            }
        }
        for bits in high..=most {
            let errors = self.validated(format(bits))?;
            if meets(&errors, self.task.sampled()) {
                return Ok(Some((format(bits), errors)));
            }
        }
        Ok(None)
    }

    /// The errors in a format at the states of the validation.
    pub(super) fn validated(&self, format: Format) -> Result<FormatErrors, FitError> {
        FormatErrors::at(self.task, self.program, format, self.validation)
    }

    pub(super) fn searched(&self, format: Format) -> Result<FormatErrors, FitError> {
        FormatErrors::at(self.task, self.program, format, self.search)
    }

    fn largest_exponent(&self) -> Result<i32, FitError> {
        Ok(largest_exponent(self.program, self.validation)?)
    }
}

/// The errors of a program in a format at the states of a yardstick.
#[derive(Clone, Debug)]
pub(super) struct FormatErrors {
    pub(super) errors: MeasuredErrors,
    /// For every state the largest ratio of an output's error to the allowed
    /// one; 0 where the scene allows every error, infinite for NaN.
    pub(super) shares: Vec<f64>,
}

impl FormatErrors {
    /// The errors at the states of a yardstick.
    pub(super) fn at(
        task: &FitTask<'_>,
        program: &FitProgram,
        format: Format,
        yardstick: &Yardstick,
    ) -> Result<FormatErrors, FitError> {
        let view = view(&program.module);
        let inputs = yardstick.inputs(view)?;
        let results = results(view, format, &inputs);
        let errors = yardstick.judge(view, &results);
        Ok(FormatErrors {
            errors: errors?,
            shares: shares(task, program, yardstick, &results)?,
        })
    }

    /// The largest ratio of an error to the allowed one.
    pub(super) fn used(&self) -> f64 {
        self.shares.iter().copied().fold(0.0, f64::max)
    }
}

/// For every state of a yardstick the largest ratio of an error to its limit.
pub(super) fn shares(
    task: &FitTask<'_>,
    program: &FitProgram,
    yardstick: &Yardstick,
    results: &[Vec<f64>],
) -> Result<Vec<f64>, FitError> {
    let view = view(&program.module);
    let allowed = Allowed::new(view, Some(task.scene), f64::INFINITY, &task.sizes);
    let shares = yardstick.shares(view, results, &allowed);
    Ok(shares?)
}

/// Exponent of the largest number that a program meets at these states.
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

/// Margin for other states: the power of two by which they may be larger.
const MARGIN: i32 = 2;

/// The fewest bits of exponent whose largest number is above `2^exponent`, with
/// a margin; at least 4: fewer leave hardly any normal number below one.
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
