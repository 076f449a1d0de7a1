//! The three zones of thesis 3.3: what more elements do for a program.

use super::program::ProgramFacts;
use super::results::StudyPlacement;
use robovec_present::{MarkFill, MarkZone};

/// Maximum length of a schedule that counts as saturated, in parts of its
/// longest chain, and maximum above full use of the scarcer kind that counts as
/// parallel.
pub(super) const SATURATED: f64 = 1.02;
/// See [`SATURATED`].
pub(super) const BUSY: f64 = 1.10;

/// A zone.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Zone {
    /// More elements shorten the run in proportion.
    Parallelisation,
    /// More elements shorten the run, at the cost of their use.
    Transition,
    /// More elements are of no use.
    Saturation,
}

impl Zone {
    /// The zone's name.
    pub(super) fn name(self) -> &'static str {
        match self {
            Zone::Parallelisation => "parallelisation",
            Zone::Transition => "transition",
            Zone::Saturation => "saturation",
        }
    }

    /// The zone in figures: full while more elements help, tinted in between,
    /// hollow when they no longer do.
    pub(super) fn mark(self) -> MarkZone {
        MarkZone {
            name: self.name(),
            fill: match self {
                Zone::Parallelisation => MarkFill::Full,
                Zone::Transition => MarkFill::Tinted,
                Zone::Saturation => MarkFill::Hollow,
            },
        }
    }
}

/// The zone that a placement lies in: saturated when it takes no longer than
/// the longest chain, parallel when the scarcer kind of elements is busy nearly
/// all the time, and in transition otherwise.
pub(super) fn zone(facts: &ProgramFacts, placed: StudyPlacement<'_>) -> Zone {
    let cycles = f64::from(placed.point.cycles);
    let request = placed.request;
    let add = facts.add_sub as f64 / f64::from(request.n_add);
    let multi = facts.mul as f64 / f64::from(request.n_multi);
    if is_saturated(facts, placed.point.cycles) {
        Zone::Saturation
    } else if cycles <= BUSY * add.max(multi) {
        Zone::Parallelisation
    } else {
        Zone::Transition
    }
}

/// True when a run of so many cycles is as good as the longest chain.
pub(super) fn is_saturated(facts: &ProgramFacts, cycles: u32) -> bool {
    f64::from(cycles) <= SATURATED * f64::from(facts.asap_cycle)
}
