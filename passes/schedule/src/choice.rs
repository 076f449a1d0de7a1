//! The choice of the element of an operation (thesis 2.3 and Table 2.1).
//!
//! An element can take an operation when all operands are in its memory or can
//! still get there: *directly*, through a write port that is free in the very
//! cycle the operand appeared on the crossbar, or *indirectly*, through the
//! producer's buffer in a later cycle that is past. Table 2.1 ranks the nine
//! combinations; direct transfers never need the resources of indirect ones, so
//! indirect ones are considered only when every element needs one.

use super::graph::Datum;
use super::locations::{Entry, Locations, Memory, WriteBack};
use super::ports::{PLANNED, Ports, WordTransfer};
use super::seats::Seat;
use super::state::ScheduleDraft;
use robovec_framework::option_words;
use robovec_ir::Operand;
use robovec_ir::placement::Element;
use serde::{Deserialize, Serialize};

option_words! {
    /// Way in which the processing element is chosen among those that can take
    /// an operation.
    #[derive(Default, PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum ElementChoice {
        /// The smallest rank of Table 2.1; among equals the shortest stay in
        /// buffers, the fewest new words of initial data, the fewest live
        /// words. An operation that needs a buffer waits, while its chain
        /// has time, for an element that does without.
        #[default]
        Preferential = "preferential",
        /// The naive scheme: the first free element that can.
        First = "first",
    }
}

/// Table 2.1: preference by status of the left (row) and right (column)
/// operand, each in the order memory, direct, indirect.
pub(super) const RANKS: [[u8; 3]; 3] = [[1, 2, 5], [3, 4, 7], [6, 8, 9]];

/// The rank that the addend of a fused operation adds to that of its factors,
/// by status. The thesis has no such operation; as in its table an operand in
/// memory is best, and one through a buffer is worse than anything without.
pub(super) const ADDEND_RANKS: [u8; 3] = [0, 2, 9];

/// The number of cycles after its write-back in which an indirect write of an
/// operand is searched for, and the number before the issue. The cycles
/// between are busy anyway; the limit keeps the search independent of the length
/// of the program.
const EARLY_WINDOW: u32 = 96;
const LATE_WINDOW: u32 = 24;

/// An operand at the moment its reader is to be issued.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct OperandSource {
    pub(super) datum: Datum,
    /// Time and place at which it appears; `None` for initial data.
    pub(super) result: Option<WriteBack>,
}

/// The way in which an operand gets into (or is in) a memory.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Route {
    /// It is there, by an earlier transfer: the entry.
    Held(Entry),
    /// Initial data, to be preloaded there as well.
    Load,
    /// A write in the write-back cycle.
    Direct(u32),
    /// A write through the producer's buffer in a later cycle.
    Indirect(u32),
}

impl Route {
    /// Row or column of Table 2.1.
    pub(super) fn status(self) -> usize {
        match self {
            Route::Held(_) | Route::Load => 0,
            Route::Direct(_) => 1,
            Route::Indirect(_) => 2,
        }
    }

    /// True for a route that writes the word in the cycle.
    #[inline]
    pub(super) fn writes_in(self, cycle: u32) -> bool {
        matches!(self, Route::Direct(at) | Route::Indirect(at) if at == cycle)
    }

    /// True for a route that takes a port: the word is not there yet.
    #[inline]
    pub(super) fn moves(self) -> bool {
        matches!(self, Route::Direct(_) | Route::Indirect(_))
    }
}

/// A transfer that is planned for the other operand of the same operation
/// and not yet reserved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planned {
    source: OperandSource,
    memory: Memory,
    route: Route,
    /// The cycle in which the word departs, unless it is already in place.
    word: Option<WordTransfer>,
}

impl Planned {
    pub(super) fn new(
        ports: &Ports,
        source: OperandSource,
        memory: Memory,
        route: Route,
    ) -> Planned {
        Planned {
            source,
            memory,
            route,
            word: word(ports, source, memory, route),
        }
    }

    fn writes(&self, cycle: u32, memory: Memory) -> u8 {
        u8::from(self.route.writes_in(cycle) && self.memory == memory)
    }

    fn reads_buffer(&self, cycle: u32, element: Element) -> bool {
        matches!(self.route, Route::Indirect(_))
            && self
                .word
                .is_some_and(|word| (word.departs, word.from) == (cycle, element))
    }
}

/// The word that a route puts during the run.
pub(super) fn word(
    ports: &Ports,
    source: OperandSource,
    memory: Memory,
    route: Route,
) -> Option<WordTransfer> {
    let (Route::Direct(at) | Route::Indirect(at)) = route else {
        return None;
    };
    let from = source.result?.element;
    let departs = at - ports.latency(from, memory);
    Some(ports.transfer(source.datum, from, memory, departs))
}

/// The transfers planned for the other operands; no two of them bring the
/// same datum to the same memory.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct Others([Option<Planned>; PLANNED]);

impl Others {
    /// Adds a transfer, unless it exists.
    pub(super) fn add(&mut self, planned: Planned) {
        let same = |other: &Planned| {
            other.source.datum == planned.source.datum && other.memory == planned.memory
        };
        if !self.iter().any(same)
            && let Some(place) = self.0.iter_mut().find(|place| place.is_none())
        {
            *place = Some(planned);
        }
    }

    fn iter(&self) -> impl Iterator<Item = &Planned> {
        self.0.iter().flatten()
    }

    /// The words they put on their way.
    fn words(&self) -> [Option<WordTransfer>; PLANNED] {
        self.0
            .map(|planned| planned.and_then(|planned| planned.word))
    }

    /// Words they write into a memory in a cycle.
    fn writes(&self, cycle: u32, memory: Memory) -> u8 {
        self.iter().map(|other| other.writes(cycle, memory)).sum()
    }

    /// Words other than this one they read from a buffer in a cycle.
    fn other_words(&self, datum: Datum, cycle: u32, element: Element) -> u8 {
        self.iter()
            .filter(|other| other.source.datum != datum && other.reads_buffer(cycle, element))
            .count() as u8
    }

    /// True when one of them reads this word from the buffer in the cycle.
    fn reads_same(&self, datum: Datum, cycle: u32, element: Element) -> bool {
        self.iter()
            .any(|other| other.source.datum == datum && other.reads_buffer(cycle, element))
    }
}

/// The plan of one operation: element, memories, routes.
#[derive(Clone, Copy, Debug)]
pub(super) struct IssuePlan {
    pub(super) element: Element,
    /// The operands change sides.
    pub(super) swapped: bool,
    /// The memory each operand, as written in the program, is read from.
    pub(super) memories: [Memory; Operand::MAX_COUNT],
    /// The route of each operand; `None` for no operand or not planned yet.
    pub(super) routes: [Option<Route>; Operand::MAX_COUNT],
}

impl IssuePlan {
    /// The element, and the sides of the operands.
    pub(super) fn seat(&self) -> Seat {
        Seat {
            element: self.element,
            swapped: self.swapped,
        }
    }
}

/// The operands of an operation as data flow; `None` after the last one.
pub(super) type OperandSources = [Option<OperandSource>; Operand::MAX_COUNT];

/// The route of an earlier operand that is the same datum in the same memory:
/// one transfer, not two that compete.
#[inline]
pub(super) fn shared(sources: &OperandSources, plan: &IssuePlan, operand: usize) -> Option<Route> {
    let same = |&before: &usize| is_same(sources, plan, before, operand);
    (0..operand)
        .find(same)
        .and_then(|before| plan.routes[before])
}

/// True for two operands that are one word: the same datum, read from the same
/// memory.
#[inline]
pub(super) fn is_same(
    sources: &OperandSources,
    plan: &IssuePlan,
    one: usize,
    other: usize,
) -> bool {
    let datum = |operand: usize| sources[operand].map(|source| source.datum);
    datum(one) == datum(other) && plan.memories[one] == plan.memories[other]
}

/// The transfers that a plan has for the operands other than one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside<'a> {
    pub(super) sources: &'a OperandSources,
    pub(super) plan: &'a IssuePlan,
    pub(super) operand: usize,
}

impl Beside<'_> {
    /// The transfer of another word for an operand; `None` when it is already
    /// in place.
    #[inline]
    fn transfer(&self, other: usize) -> Option<(OperandSource, Route)> {
        let route = self.plan.routes[other].filter(|route| route.moves())?;
        let is_own = is_same(self.sources, self.plan, other, self.operand);
        let source = self.sources[other].filter(|_| !is_own)?;
        Some((source, route))
    }

    /// Words they write into a memory in a cycle, as [`Others::writes`] counts
    /// them, for searches that need no other figure.
    #[inline]
    pub(super) fn writes(&self, cycle: u32, memory: Memory) -> u8 {
        let (mut count, mut first) = (0, None);
        for other in 0..Operand::MAX_COUNT {
            let route = self.plan.routes[other];
            if route.is_some_and(|route| route.writes_in(cycle))
                && self.plan.memories[other] == memory
                && let Some((source, _)) = self.transfer(other)
                && first != Some(source.datum)
            {
                first = Some(source.datum);
                count += 1;
            }
        }
        count
    }

    /// All data about them.
    pub(super) fn others(&self, ports: &Ports) -> Others {
        let mut others = Others::default();
        for other in 0..Operand::MAX_COUNT {
            if let Some((source, route)) = self.transfer(other) {
                let memory = self.plan.memories[other];
                others.add(Planned::new(ports, source, memory, route));
            }
        }
        others
    }
}

/// The decision about an operation in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) enum IssueDecision {
    /// Issue it so, its operands being these.
    Issue(IssuePlan, OperandSources),
    /// An element that is taken in this cycle could do without a buffer.
    Wait,
    /// No free element can take it.
    Fail,
}

/// The route without buffer into a memory, in time for a reading cycle, if
/// ports and links allow one; `held` is the entry of the datum there, and the
/// transfers of other operands are considered only where it takes a port.
// It is asked for every operand at every place, and handing over what it takes
// costs more than the answer.
#[inline(always)]
pub(super) fn plain_route(
    draft: &ScheduleDraft,
    source: OperandSource,
    memory: Memory,
    held: Option<Entry>,
    before: u32,
    beside: Option<Beside<'_>>,
) -> Option<Route> {
    let (ports, locations) = (&draft.ports, &draft.locations);
    if let Some(entry) = held {
        let written = locations.entries[entry.index()].written();
        let in_time = written.is_none_or(|written| written < before);
        return in_time.then_some(Route::Held(entry));
    }
    let Some(back) = source.result else {
        return Some(Route::Load);
    };
    let arrives = back.cycle + ports.latency(back.element, memory);
    // A port that is taken already needs no look at the other operands.
    if arrives >= before || !ports.can_write(arrives, memory, 1) {
        return None;
    }
    let rivals = match &beside {
        Some(beside) => beside.writes(arrives, memory),
        None => 0,
    };
    if rivals > 0 && !ports.can_write(arrives, memory, rivals + 1) {
        return None;
    }
    let route = Route::Direct(arrives);
    let is_free = !ports.has_network() || has_way(ports, locations, source, memory, route, beside);
    is_free.then_some(route)
}

/// Tests whether the links of a network have room for a word. Apart, so that a
/// crossbar does not carry its registers along.
#[inline(never)]
fn has_way(
    ports: &Ports,
    locations: &Locations,
    source: OperandSource,
    memory: Memory,
    route: Route,
    beside: Option<Beside<'_>>,
) -> bool {
    let others = beside.map_or_else(Others::default, |beside| beside.others(ports));
    let word = word(ports, source, memory, route);
    word.is_some_and(|word| ports.can_travel(locations, word, || others.words()))
}

/// The earliest indirect write before the cycle of issue; early, because the
/// word occupies the buffer until then and the latest ports are wanted by the
/// results that just appear.
pub(super) fn indirect_route(
    ports: &Ports,
    locations: &Locations,
    source: OperandSource,
    memory: Memory,
    issue: u32,
    others: &Others,
) -> Option<Route> {
    let result = source.result?;
    let WriteBack {
        cycle: back,
        element: producer,
    } = result;
    if !ports.has_buffer() {
        return None;
    }
    let latency = ports.latency(producer, memory);
    // A word that departs in this cycle arrives too late.
    let end = issue.saturating_sub(latency);
    let early_end = end.min(back + 1 + EARLY_WINDOW);
    let late_start = early_end.max(end.saturating_sub(LATE_WINDOW));
    let mut room = Room::new(ports, locations, source.datum, result, others);
    for cycle in (back + 1..early_end).chain(late_start..end) {
        let arrives = cycle + latency;
        let planned = others.writes(arrives, memory);
        if !ports.can_write(arrives, memory, planned + 1) {
            continue;
        }
        let taken = others.other_words(source.datum, cycle, producer);
        let shared = || {
            others.reads_same(source.datum, cycle, producer)
                || locations
                    .of(source.datum)
                    .any(|(_, entry)| entry.departed() == Some(cycle))
        };
        if !ports.can_read_buffer(cycle, producer, taken + 1) && !shared() {
            continue;
        }
        let route = Route::Indirect(arrives);
        let travels = word(ports, source, memory, route)
            .is_some_and(|word| ports.can_travel(locations, word, || others.words()));
        if !travels {
            continue;
        }
        return room.reaches(ports, cycle).then_some(route);
    }
    None
}

/// The time for which the producer's buffer can keep the word.
struct Room {
    producer: Element,
    /// The first cycle not yet known to have room.
    next: u32,
    words: u16,
}

impl Room {
    fn new(
        ports: &Ports,
        locations: &Locations,
        datum: Datum,
        back: WriteBack,
        others: &Others,
    ) -> Room {
        let producer = back.element;
        let mut next = back.cycle;
        if ports.buffers_are_limited()
            && let Some(until) = locations.buffered_until(datum)
        {
            next = until + 1;
        }
        let rivals = others.iter().filter(|other| {
            matches!(other.route, Route::Indirect(_))
                && other.source.datum != datum
                && (other.source.result).is_some_and(|result| result.element == producer)
        });
        Room {
            producer,
            next,
            words: rivals.count() as u16 + 1,
        }
    }

    fn reaches(&mut self, ports: &Ports, cycle: u32) -> bool {
        if !ports.buffers_are_limited() {
            return true;
        }
        while self.next <= cycle {
            if !ports.has_room(self.next, self.producer, self.words) {
                return false;
            }
            self.next += 1;
        }
        true
    }
}
