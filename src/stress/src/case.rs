//! Hard cases, their construction and their measurement.

use super::{ProgramTreatment, StressError, StressVerdict};
use robovec_ir::Format;

/// Class of cases, by the property that makes them hard.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct CaseClass {
    name: &'static str,
    description: &'static str,
}

const fn class(name: &'static str, description: &'static str) -> CaseClass {
    CaseClass { name, description }
}

impl CaseClass {
    /// All classes, in the order of reports. The first is the baseline of the
    /// others.
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

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// The class with this name.
    pub fn from_name(name: &str) -> Option<CaseClass> {
        CaseClass::ALL.into_iter().find(|class| class.name == name)
    }

    /// Property that makes its cases hard, in one line.
    pub fn description(self) -> &'static str {
        self.description
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
    /// The verdict on the untreated program in binary32, where one is recorded;
    /// `robovec stress` fails on any other.
    pub expected: Option<StressVerdict>,
    /// True when it takes long without optimisation.
    pub long: bool,
    /// Measured subject.
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
        ProgramTreatment {
            format: Format::BINARY64,
            ..self.untreated()
        }
    }

    /// Other programs for the same, in the format of the untreated one: other
    /// recursions, passes, partitions of coordinates.
    fn programs(&self) -> Vec<ProgramTreatment> {
        Vec::new()
    }

    /// Treatments that may make the error smaller, besides wider formats.
    fn candidates(&self) -> Vec<ProgramTreatment> {
        Vec::new()
    }

    /// True when every program can be tried in every format; otherwise only
    /// two of them are, by bisection.
    fn is_small(&self) -> bool {
        false
    }

    /// True when each value can have its own format: the program is one
    /// function, whose errors the pass `mixed` can weigh.
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

    /// The error from rounding the data once to a format: a lower limit for any
    /// program that reads rounded data.
    fn floor(&self, format: Format) -> f64;

    /// The largest number that a program has to hold, for fixed point; `None`
    /// where that is no candidate.
    fn largest(&self, _treatment: &ProgramTreatment) -> Option<f64> {
        None
    }

    /// Carries out a treatment.
    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError>;
}

/// Result of a treatment.
#[derive(Clone, PartialEq, Debug)]
pub struct Measured {
    /// The error that verdicts are about, relative; not finite when there is
    /// no result.
    pub error: f64,
    /// Other errors and facts, by name.
    pub others: Vec<(&'static str, f64)>,
    /// The share of inputs and values outside the range of the format's
    /// normal numbers, zeros not counted.
    pub outside: f64,
    /// False when the matrix computed is not positive definite, or a result
    /// contradicts another.
    pub consistent: bool,
    /// Operations times bits of their numbers.
    pub cost: f64,
}
