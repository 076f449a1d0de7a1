//! The narrowest formats that meet the tolerances, floating and fixed.

use super::ranges::{exponent_bits, largest_exponent};
use super::tolerance::FormatErrors;
use super::{FitError, FitProgram, FitTask};
use crate::program::ExplorationError;
use robovec_error::yardstick::Yardstick;
use robovec_ir::Format;
use robovec_num::{FixedFormat, NumberFormat};

/// Mantissas that are looked at.
const NARROWEST: u32 = 4;
pub(super) const WIDEST: u32 = 52;

/// Bits of a number in fixed point at most, beside its sign.
const MOST_FIXED: u32 = 53;

/// The part of a tolerance that the errors at the states of the search and of
/// the validation may use up: other states have other worst cases, and a
/// challenge that fails costs more than a bit.
pub(super) const PART: f64 = 0.7;

/// A format with the errors of a program in it at the states of the
/// validation.
pub(super) type MeasuredFormat = (Format, FormatErrors);

/// True for errors that use up a part of the tolerances at most.
pub(super) fn meets(measured: &FormatErrors, part: f64) -> bool {
    measured.errors.normwise.worst.is_finite() && measured.used() <= part
}

/// The yardsticks that a format is looked for at: the few states of the search
/// and the many of the validation.
#[derive(Clone, Copy)]
pub(super) struct FormatQuestion<'q> {
    pub(super) task: &'q FitTask<'q>,
    pub(super) program: &'q FitProgram,
    pub(super) search: &'q Yardstick,
    pub(super) validation: &'q Yardstick,
}

impl FormatQuestion<'_> {
    /// The formats that float a program is measured in: the narrowest that
    /// meets the tolerances, if any does, and binary32, which everybody knows.
    pub(super) fn floating(&self) -> Result<Vec<MeasuredFormat>, FitError> {
        let mut found = vec![(Format::BINARY32, self.validated(Format::BINARY32)?)];
        if self.program.model_share > PART {
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
            if meets(&self.searched(format)?, PART) {
                let errors = self.validated(format)?;
                if meets(&errors, PART) {
                    return Ok(Some((format, errors)));
                }
            }
        }
        Ok(None)
    }

    /// The narrowest format of fixed point that meets the tolerances; why
    /// there is none, in words.
    pub(super) fn fixed(&self) -> Result<Result<MeasuredFormat, String>, FitError> {
        if self.program.model_share > PART {
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
            "{reach}, which leaves {most} bits behind the point, with which an error is \
             {used:.1e} times what is allowed"
        )))
    }

    /// The narrowest of formats that are numbered by their bits; `None` where
    /// the widest does not do.
    ///
    /// The bits are halved down at the few states of the search and then
    /// widened until they also hold at the many of the validation.
    fn narrowest(
        &self,
        [least, most]: [u32; 2],
        format: impl Fn(u32) -> Format,
    ) -> Result<Option<MeasuredFormat>, FitError> {
        if !meets(&self.searched(format(most))?, PART) {
            return Ok(None);
        }
        // Invariant: `high` meets the tolerances, `low` does not.
        let (mut low, mut high) = (least - 1, most);
        while low + 1 < high {
            let middle = low.midpoint(high);
            if meets(&self.searched(format(middle))?, PART) {
                high = middle;
            } else {
                low = middle;
            }
        }
        for bits in high..=most {
            let errors = self.validated(format(bits))?;
            if meets(&errors, PART) {
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
        let largest = largest_exponent(self.program, self.validation);
        Ok(largest.map_err(ExplorationError::from)?)
    }
}
