//! Hard cases: what is built, and what is measured on it.

use super::{ProgramTreatment, StressError, StressVerdict};
use robovec_ir::Format;

/// What a case makes hard.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum CaseClass {
    /// Nothing: what the others are compared with.
    Base,
    /// Long chains of bodies.
    Chain,
    /// Masses, inertias and lengths of very different sizes.
    Ratio,
    /// Large terms of velocity and gravity beside small inertias.
    Swamped,
    /// Sizes at the ends of what a format holds.
    Scale,
    /// Poses near a singular one.
    Pose,
    /// Sums whose terms cancel.
    Cancellation,
    /// Springs so stiff that their stretch is lost in lengths.
    Spring,
    /// Penetrations and slips that are differences of large numbers.
    Contact,
    /// Sensors far from the origin.
    Far,
    /// Closed loops near dead points, and with redundant constraints.
    Loop,
    /// Series in place of sine and cosine.
    Series,
    /// Long simulations.
    Motion,
    /// Closed loops in time, which open.
    Drift,
}

impl CaseClass {
    /// All classes, in the order of reports.
    pub const ALL: [CaseClass; 14] = [
        CaseClass::Base,
        CaseClass::Chain,
        CaseClass::Ratio,
        CaseClass::Swamped,
        CaseClass::Scale,
        CaseClass::Pose,
        CaseClass::Cancellation,
        CaseClass::Spring,
        CaseClass::Contact,
        CaseClass::Far,
        CaseClass::Loop,
        CaseClass::Series,
        CaseClass::Motion,
        CaseClass::Drift,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            CaseClass::Base => "base",
            CaseClass::Chain => "chain",
            CaseClass::Ratio => "ratio",
            CaseClass::Swamped => "swamped",
            CaseClass::Scale => "scale",
            CaseClass::Pose => "pose",
            CaseClass::Cancellation => "cancellation",
            CaseClass::Spring => "spring",
            CaseClass::Contact => "contact",
            CaseClass::Far => "far",
            CaseClass::Loop => "loop",
            CaseClass::Series => "series",
            CaseClass::Motion => "motion",
            CaseClass::Drift => "drift",
        }
    }

    /// The class of a name.
    pub fn from_name(name: &str) -> Option<CaseClass> {
        CaseClass::ALL
            .into_iter()
            .find(|class| class.name() == name)
    }

    /// What its cases make hard, in one line.
    pub fn description(self) -> &'static str {
        match self {
            CaseClass::Base => "nothing in particular: what the others are compared with",
            CaseClass::Chain => "long chains, whose mass matrix loses its small eigenvalues",
            CaseClass::Ratio => "masses, inertias and lengths of very different sizes",
            CaseClass::Swamped => "velocity and gravity terms that swamp what inertia does",
            CaseClass::Scale => "sizes at the ends of the range of a format",
            CaseClass::Pose => "poses near a singular one",
            CaseClass::Cancellation => "sums whose terms cancel",
            CaseClass::Spring => "springs so stiff that lengths hide their stretch",
            CaseClass::Contact => "penetrations and slips: small differences of large numbers",
            CaseClass::Far => "sensors far from the origin",
            CaseClass::Loop => "closed loops near dead points, and with redundant constraints",
            CaseClass::Series => "series in place of sine and cosine",
            CaseClass::Motion => "long simulations, step after step in one format",
            CaseClass::Drift => "closed loops in time, which open step by step",
        }
    }
}

/// A hard case.
pub struct StressCase {
    /// Its name on the command line.
    pub name: String,
    /// What it makes hard.
    pub class: CaseClass,
    /// How it is built, in a few words.
    pub construction: String,
    /// What it breaks.
    pub breaks: &'static str,
    /// The verdict on the untreated program in binary32. Anything else than
    /// this makes `robovec stress` fail.
    pub expected: StressVerdict,
    /// True when it takes long without optimisation.
    pub long: bool,
    /// What is measured.
    pub(super) subject: Box<dyn StressSubject>,
}

impl CaseClass {
    /// A case of the class that does not take long: its name, how it is built
    /// and what it breaks.
    pub(super) fn case(
        self,
        name: impl Into<String>,
        construction: impl Into<String>,
        breaks: &'static str,
        expected: StressVerdict,
        subject: impl StressSubject + 'static,
    ) -> StressCase {
        StressCase {
            name: name.into(),
            class: self,
            construction: construction.into(),
            breaks,
            expected,
            long: false,
            subject: Box::new(subject),
        }
    }
}

/// Something that can be computed with more or less error.
pub(super) trait StressSubject: Send + Sync {
    /// The error that verdicts are about.
    fn metric(&self) -> &'static str;

    /// The program that nothing was done to, in binary32.
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

    /// What else may make the error smaller, beside wider formats of
    /// everything.
    fn candidates(&self) -> Vec<ProgramTreatment> {
        Vec::new()
    }

    /// True when every program can be tried in every format; otherwise only
    /// two of them are, by bisection.
    fn is_small(&self) -> bool {
        false
    }

    /// True when values can have formats of their own: the program is one
    /// function, whose errors the pass `mixed` can weigh.
    fn mixes(&self) -> bool {
        false
    }

    /// True when the error is that of rounding, which wider formats reduce.
    fn rounds(&self) -> bool {
        true
    }

    /// Computes the reference.
    fn prepare(&self) -> Result<Box<dyn StressBench + '_>, StressError>;
}

/// A subject with its reference.
pub(super) trait StressBench: Sync {
    /// How much the result changes, relatively, with the numbers it is
    /// computed from: of the mass matrix where accelerations are asked for.
    fn condition(&self) -> f64 {
        let format = Format::BINARY32;
        self.floor(format) / format.unit_roundoff()
    }

    /// The error that rounding the data once to a format makes: what nobody
    /// can do better than from rounded data.
    fn floor(&self, format: Format) -> f64;

    /// The largest number that a program has to hold, for fixed point; `None`
    /// where that is no candidate.
    fn largest(&self, _treatment: &ProgramTreatment) -> Option<f64> {
        None
    }

    /// Carries out a treatment.
    fn measure(&self, treatment: &ProgramTreatment) -> Result<Measured, StressError>;
}

/// What a treatment led to.
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
