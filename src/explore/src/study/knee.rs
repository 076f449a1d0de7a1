//! Number of elements that a program is worth: the knee, the zones around it,
//! and the limit of each (thesis 3.3).

use super::program::ProgramFacts;
use super::results::{StudiedProgram, StudyPlacement};
use robovec_present::{MarkFill, MarkZone};
use serde::Serialize;

/// Knee of the placements of one program.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Knee {
    /// The longest chain, in cycles.
    pub chain: u32,
    pub number_y: f64,
    /// The smallest equal numbers within 2 % of the longest chain.
    pub equal: Option<Split>,
    /// Cheapest numbers within 2 % of the longest chain, unequal ones included.
    pub cheapest: Option<Split>,
    /// The largest equal numbers that are busy nearly all the time.
    pub busiest: Option<Split>,
    pub fastest: Option<Split>,
    /// One adder and one multiplier.
    pub single: Option<Split>,
    /// The largest equal numbers placed that fall short of it.
    pub below: Option<Split>,
    /// True when one element of each kind less falls short: the knee is exact.
    pub is_exact: bool,
}

/// Numbers of adders and multipliers, and the length of their schedule.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub(super) struct Split {
    pub n_add: u32,
    pub n_multi: u32,
    /// Length of the schedule.
    pub cycles: u32,
    /// Operations per element and cycle.
    pub rate: f64,
    /// The machine's share of the device.
    pub share: f64,
}

impl Split {
    fn of(placed: &StudyPlacement<'_>) -> Split {
        let [n_add, n_multi] = placed.counts();
        Split {
            n_add,
            n_multi,
            cycles: placed.point.cycles,
            rate: placed.point.rate,
            share: placed.share().expect("it was placed"),
        }
    }

    pub(super) fn elements(&self) -> u32 {
        self.n_add + self.n_multi
    }

    /// `4+4 (8)`, in both counts of the thesis.
    pub(super) fn text(&self) -> String {
        format!("{}+{} ({})", self.n_add, self.n_multi, self.elements())
    }
}

/// The knee of a program; `None` when it was not placed.
pub(super) fn knee(program: &StudiedProgram<'_>) -> Option<Knee> {
    let facts = program.facts;
    let mut placed: Vec<StudyPlacement<'_>> = program.usual().collect();
    placed.sort_by_key(|placed| (placed.elements(), placed.point.cycles, placed.request.n_add));
    if placed.is_empty() {
        return None;
    }
    let reaches = |placed: &&StudyPlacement<'_>| is_saturated(facts, placed.point.cycles);
    let equal = || placed.iter().filter(|placed| placed.is_equal());
    let knee = equal().find(reaches);
    let short =
        |count: u32| equal().any(|placed| placed.request.n_add == count && !reaches(&placed));
    let exact = knee.is_some_and(|knee| match knee.request.n_add {
        1 => true,
        count => short(count - 1),
    });
    let busy = |placed: &&StudyPlacement<'_>| zone(facts, **placed) == Zone::Parallelisation;
    let split = |placed: Option<&StudyPlacement<'_>>| placed.map(Split::of);
    Some(Knee {
        chain: facts.asap_cycle,
        number_y: facts.number_y(),
        equal: split(knee),
        cheapest: split(placed.iter().find(reaches)),
        busiest: split(equal().filter(busy).max_by_key(|placed| placed.elements())),
        fastest: split(
            placed
                .iter()
                .min_by_key(|placed| (placed.point.cycles, placed.elements())),
        ),
        single: split(equal().find(|placed| placed.request.n_add == 1)),
        below: split(
            equal()
                .take_while(|placed| !reaches(placed))
                .max_by_key(|placed| placed.elements()),
        ),
        is_exact: exact,
    })
}

/// Maximum length of a schedule that counts as saturated, relative to its
/// longest chain, and maximum above full use of the scarcer kind that counts as
/// parallel.
pub(super) const SATURATED: f64 = 1.02;
/// See [`SATURATED`].
pub(super) const BUSY: f64 = 1.10;

robovec_num::named! {
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, serde::Serialize)]
    #[serde(rename_all = "kebab-case")]
    pub(super) enum Zone {
        /// More elements shorten the run in proportion.
        Parallelisation = "parallelisation",
        /// More elements shorten the run, at the cost of their use.
        Transition = "transition",
        /// More elements are of no use.
        Saturation = "saturation",
    }
}

impl Zone {
    /// The zone in figures: full, tinted or hollow as more elements help.
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

/// True when a run of this number of cycles is as good as the longest chain.
pub(super) fn is_saturated(facts: &ProgramFacts, cycles: u32) -> bool {
    f64::from(cycles) <= SATURATED * f64::from(facts.asap_cycle)
}
