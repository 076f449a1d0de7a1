//! Cause of an error.

use super::Measured;
use robovec_ir::Format;
use serde::Deserialize;
use std::fmt;

robovec_num::named! {
    /// Cause of an error.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum StressVerdict {
        /// At least half of the format's digits are right.
        Fine = "fine",
        /// The error is about that of rounding the data to the format: no program
        /// could be better with rounded data.
        HardProblem = "hard problem",
        /// The error is much larger than that: another form of the computation is
        /// better.
        BadCode = "bad code",
        /// Numbers leave the range of the format, and a wider exponent alone
        /// helps.
        OutOfRange = "out of range",
        /// Result that contradicts itself: a mass matrix that is not positive
        /// definite.
        Inconsistent = "inconsistent",
    }
}

impl fmt::Display for StressVerdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// Maximum error relative to that of rounded data before it is the code's
/// fault. Some tens of units of the last place are usual for the hundreds of
/// operations that a result depends on.
pub const ALLOWANCE: f64 = 32.0;

/// Factor by which the error must become smaller with a wider exponent for the
/// range to be the reason.
const RANGE_GAIN: f64 = 4.0;

/// The verdict on the measurements in a format.
///
/// `floor` is the error of rounding the data once; `wide` the error with the
/// same mantissa and the exponent of binary64, where it was measured.
pub fn verdict(
    format: Format,
    measured: &Measured,
    floor: f64,
    wide: Option<f64>,
) -> StressVerdict {
    let error = if measured.error.is_nan() {
        f64::INFINITY
    } else {
        measured.error
    };
    // Half of the digits.
    let fine = format.unit_roundoff().sqrt();
    if error <= fine && measured.consistent {
        return StressVerdict::Fine;
    }
    if measured.outside > 0.0 && wide.is_some_and(|wide| wide * RANGE_GAIN < error) {
        return StressVerdict::OutOfRange;
    }
    if !measured.consistent {
        return StressVerdict::Inconsistent;
    }
    if error <= ALLOWANCE * floor {
        return StressVerdict::HardProblem;
    }
    StressVerdict::BadCode
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(error: f64, outside: f64, consistent: bool) -> Measured {
        Measured {
            error,
            others: Vec::new(),
            outside,
            consistent,
            cost: 1.0,
        }
    }

    #[test]
    fn verdicts_tell_whose_fault_it_is() {
        let f32 = Format::BINARY32;
        let told = |error, outside, consistent, floor, wide| {
            verdict(f32, &measured(error, outside, consistent), floor, wide)
        };
        assert_eq!(told(1e-4, 0.5, true, 0.0, None), StressVerdict::Fine);
        assert_eq!(
            told(1e-2, 0.0, true, 1e-3, None),
            StressVerdict::HardProblem
        );
        assert_eq!(told(1e-2, 0.0, true, 1e-5, None), StressVerdict::BadCode);
        assert_eq!(
            told(1.0, 0.1, false, 1.0, Some(1e-5)),
            StressVerdict::OutOfRange
        );
        assert_eq!(
            told(1.0, 0.1, true, 1.0, Some(0.9)),
            StressVerdict::HardProblem
        );
        assert_eq!(
            told(1e-5, 0.0, false, 1.0, None),
            StressVerdict::Inconsistent
        );
        assert_eq!(
            told(f64::NAN, 0.1, true, 1.0, Some(1e-6)),
            StressVerdict::OutOfRange
        );
        assert_eq!(told(f64::NAN, 0.0, true, 1.0, None), StressVerdict::BadCode);
    }
}
