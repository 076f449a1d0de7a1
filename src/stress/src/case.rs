//! Hard cases, their construction, their measurement, and causes of errors.

use super::{ProgramTreatment, StressError};
use robovec_ir::Format;
use serde::Deserialize;
use std::fmt;
use std::sync::{Mutex, PoisonError};

/// Class of cases.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct CaseClass {
    /// The name on the command line.
    pub name: &'static str,
    /// Property that makes its cases hard, in one line.
    pub description: &'static str,
}

const fn class(name: &'static str, description: &'static str) -> CaseClass {
    CaseClass { name, description }
}

impl CaseClass {
    /// All classes, in the order of reports; the first is the others' baseline.
    pub const ALL: [CaseClass; 14] = [
        class("base", "ordinary models, for comparison with the others"),
        class(
            "chain",
            "long chains, whose mass matrix loses its small eigenvalues",
        ),
        class(
            "ratio",
            "masses, inertias and lengths of very different sizes",
        ),
        class(
            "swamped",
            "velocity and gravity terms that are much larger than inertia terms",
        ),
        class("scale", "sizes at the ends of the range of a format"),
        class("pose", "poses near a singular one"),
        class("cancellation", "sums whose terms cancel"),
        class("spring", "springs so stiff that lengths hide their stretch"),
        class(
            "contact",
            "penetrations and slips: small differences of large numbers",
        ),
        class("far", "sensors far from the origin"),
        class(
            "loop",
            "closed loops near dead points, and with redundant constraints",
        ),
        class("series", "series in place of sine and cosine"),
        class("motion", "long simulations, step after step in one format"),
        class("drift", "closed loops in time, which open step by step"),
    ];

    /// The class with this name.
    pub fn from_name(name: &str) -> Option<CaseClass> {
        CaseClass::ALL.into_iter().find(|class| class.name == name)
    }
}

/// A hard case.
pub struct StressCase {
    /// Its name on the command line.
    pub name: String,
    /// Class of the case.
    pub class: CaseClass,
    /// Construction, in a few words.
    pub construction: String,
    /// Quantities that lose precision, in a few words.
    pub breaks: String,
    /// The recorded verdict on the untreated program in binary32, if any.
    pub expected: Option<StressVerdict>,
    /// True when it takes long without optimisation.
    pub long: bool,
    pub(super) subject: Box<dyn StressSubject>,
}

/// Something that can be computed with more or less error.
pub(super) trait StressSubject: Send + Sync {
    /// The error that verdicts are about.
    fn metric(&self) -> &'static str;

    /// The untreated program, in binary32.
    fn untreated(&self) -> ProgramTreatment {
        ProgramTreatment::default()
    }

    /// The program in binary64 that cures are compared with.
    fn standard(&self) -> ProgramTreatment {
        self.untreated().with(|it| it.format = Format::BINARY64)
    }

    /// Other programs for the same, in the untreated format.
    fn programs(&self) -> Vec<ProgramTreatment> {
        Vec::new()
    }

    /// Treatments that may make the error smaller, besides wider formats.
    fn candidates(&self) -> Vec<ProgramTreatment> {
        Vec::new()
    }

    /// True when every program can be tried in every format.
    fn is_small(&self) -> bool {
        false
    }

    /// True when the pass `mixed` can give each value a format.
    fn mixes(&self) -> bool {
        false
    }

    /// True when the error comes from rounding, which wider formats reduce.
    fn rounds(&self) -> bool {
        true
    }

    /// Computes the reference.
    fn prepare(&self) -> Result<Box<dyn StressBench + '_>, StressError>;
}

/// A subject with its reference.
pub(super) trait StressBench: Sync {
    /// The condition number: the relative change of the result over that of the
    /// data. For accelerations it is that of the mass matrix.
    fn condition(&self) -> f64 {
        let format = Format::BINARY32;
        self.floor(format) / format.unit_roundoff()
    }

    /// The error from rounding the data once to a format, the least possible.
    fn floor(&self, format: Format) -> f64;

    /// The largest number of a program, for fixed point; `None` without that.
    fn largest(&self, _treatment: &ProgramTreatment) -> Option<f64> {
        None
    }

    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError>;
}

/// Result of a treatment.
#[derive(Clone, PartialEq, Debug)]
pub struct Measured {
    /// Relative error that verdicts are about; not finite without a result.
    pub error: f64,
    /// Other errors and facts, by name.
    pub others: Vec<(&'static str, f64)>,
    /// The share of inputs and values outside the range of the format's
    /// normal numbers, zeros not counted.
    pub outside: f64,
    /// False when a computed matrix or another result contradicts itself.
    pub consistent: bool,
    /// Operations times bits of their numbers.
    pub cost: f64,
}

/// A few results, with their keys.
pub(super) struct Memo<K, V>(Mutex<Vec<(K, V)>>);

impl<K, V> Default for Memo<K, V> {
    fn default() -> Memo<K, V> {
        Memo(Mutex::default())
    }
}

impl<K: PartialEq, V: Clone> Memo<K, V> {
    /// The result for a key, computed if there is none.
    pub(super) fn get<E>(&self, key: K, compute: impl FnOnce() -> Result<V, E>) -> Result<V, E> {
        // A thread that panicked left nothing half done here.
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock()
            .iter()
            .find(|(known, _)| *known == key)
            .map(|(_, result)| result.clone());
        if let Some(known) = known {
            return Ok(known);
        }
        // Not under the lock: a computation may need another result first.
        let result = compute()?;
        lock().push((key, result.clone()));
        Ok(result)
    }
}

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
        /// The error is much larger than that: another computation is better.
        BadCode = "bad code",
        /// Numbers leave the range of the format; a wider exponent alone helps.
        OutOfRange = "out of range",
        /// Result that contradicts itself: a mass matrix not positive definite.
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

/// Least gain of a wider exponent for the range to be the reason.
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
