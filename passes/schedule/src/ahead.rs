//! Placement without buffers: operations have a seat before their operands
//! appear.
//!
//! Choosing an operation's element when it is issued, as the sweep does, can
//! find every direct way into every memory taken long ago; with buffers there
//! is another way, without (or with full ones) the program is stuck. So here
//! an operation gets a *seat*, an element and the sides of its operands, when
//! its first operand is issued, and a *claim* on the word of every operand
//! there: write ports are reserved in the cycle in which the operand appears.
//!
//! A seat is a promise, not a decision. An operation that finds its element
//! taken goes to any other one whose ports were free at the right time, and one
//! whose next operand finds no port at its seat moves to a seat where all of
//! its operands find one. A reservation that no operation claims any more is
//! given up, and its ports are free again, even in a past cycle: the word is
//! then not written.
//!
//! Invariant: the words of all issued operands of an operation that is not
//! issued are reserved at its seat. An operation whose readers find no seats is
//! not issued yet; ports of later cycles are always free, so this always makes
//! progress, on any machine.

use super::choice::{IssueDecision, IssuePlan};
use super::graph::{Datum, DependenceGraph};
use super::locations::{Memory, Travel, WriteBack};
use super::ports::{PLANNED, WordTransfer};
use super::seats::{Ahead, Seat};
use super::state::{IssueOutcome, Manner, Sweep};
use robovec_ir::Operand;
use robovec_ir::placement::Element;

/// A word that must be written for a seat.
#[derive(Clone, Copy, Debug)]
struct WordNeed {
    word: WordTransfer,
    memory: Memory,
    arrives: u32,
}

/// The words needed for a seat, one per operand at most.
type Needs = [Option<WordNeed>; Operand::MAX_COUNT];

/// The bookings that the issue of an operation entails for its readers.
#[derive(Default, Debug)]
struct Booking {
    /// The words reserved by it, in this order.
    needs: Vec<WordNeed>,
    /// Readers with the seat they had.
    seats: Vec<(u32, Option<Seat>)>,
}

impl Sweep<'_> {
    /// Issues a node if an element can take it and its result finds ports.
    pub(super) fn issue_ahead(&mut self, node: usize, cycle: u32) -> IssueOutcome {
        let Some(first) = self.plan_ahead(node, cycle, None) else {
            return IssueOutcome::Failed;
        };
        let Some(booking) = self.book(node, cycle, first.element, false) else {
            return IssueOutcome::Failed;
        };
        // What was just reserved may have taken the ports of the plan.
        let Some(plan) = self.plan_ahead(node, cycle, Some(first)) else {
            self.undo(node, &booking);
            return IssueOutcome::Failed;
        };
        self.finish_ahead(node, cycle, plan, &booking);
        IssueOutcome::Issued
    }

    /// Issues a node where its operands were booked to, and books its result;
    /// where either is impossible the node waits if it can, and else goes to
    /// any element and leaves its result to the buffer.
    pub(super) fn issue_booked(&mut self, node: usize, cycle: u32) -> IssueOutcome {
        let waits = self.can_wait(node, cycle);
        let seat = self.ahead.as_ref().and_then(|ahead| ahead.seat(node));
        if waits && seat.is_some_and(|seat| self.busy[seat.element.index()] == cycle + 1) {
            return IssueOutcome::Waits;
        }
        let plan = match self.consider(node, cycle) {
            IssueDecision::Issue(plan, _) => plan,
            IssueDecision::Wait => return IssueOutcome::Waits,
            IssueDecision::Fail => return IssueOutcome::Failed,
        };
        let Some(booking) = self.book(node, cycle, plan.element, !waits) else {
            return IssueOutcome::Waits;
        };
        match self.consider(node, cycle) {
            IssueDecision::Issue(plan, _) => {
                self.finish_ahead(node, cycle, plan, &booking);
                IssueOutcome::Issued
            }
            IssueDecision::Wait => {
                self.undo(node, &booking);
                IssueOutcome::Waits
            }
            IssueDecision::Fail => {
                self.undo(node, &booking);
                IssueOutcome::Failed
            }
        }
    }

    /// The plan to issue a node without buffers: at its seat if that is free,
    /// else wherever the operands can have been written; or again as a plan
    /// states.
    fn plan_ahead(
        &mut self,
        node: usize,
        cycle: u32,
        again: Option<IssuePlan>,
    ) -> Option<IssuePlan> {
        let sources = self.sources(node);
        self.mark(sources);
        let seat = match again {
            Some(plan) => Some(plan.seat()),
            None => self.ahead.as_ref()?.seat(node),
        };
        let is_free = |at: &IssuePlan| self.busy[at.element.index()] != cycle + 1;
        let is_seat = |at: &IssuePlan| seat == Some(at.seat());
        let own = self.places(node).filter(is_free).find(is_seat);
        let own = own.and_then(|at| self.plain(&sources, at, cycle));
        if own.is_some() || again.is_some() {
            return own;
        }
        let free = self.places(node).filter(is_free);
        self.cheapest_plain(&sources, node, free, cycle)
    }

    /// Reserves the ports for the result of a node that is issued in a cycle, at
    /// the seats of its readers, which get a seat for it if they have none.
    /// Where that is impossible no seat is reserved and the result is `None`,
    /// or, when `partial`, those readers get no seat.
    fn book(
        &mut self,
        node: usize,
        cycle: u32,
        element: Element,
        partial: bool,
    ) -> Option<Booking> {
        let result = self.write_back(node, cycle, element);
        self.draft.ports.reach(result.cycle);
        self.draft.locations.data[node].result = Some(result);
        let mut booking = Booking::default();
        let graph = self.task.graph;
        let users = graph.users_of(node);
        for (index, &user) in users.iter().enumerate() {
            // A node that reads the result twice stands there twice in a row.
            if index > 0 && users[index - 1] == user {
                continue;
            }
            match self.find_seat(user as usize) {
                Some((seat, needs)) => self.take_seat(user, seat, needs, &mut booking),
                None if partial => {}
                None => {
                    self.undo(node, &booking);
                    return None;
                }
            }
        }
        if self.manner == Manner::Ahead && self.is_output[node] && users.is_empty() {
            match self.find_home(node, result) {
                Some(need) => self.reserve(need, &mut booking),
                None => {
                    self.undo(node, &booking);
                    return None;
                }
            }
        }
        Some(booking)
    }

    /// The seat of an operation and the words to be written for it: its present
    /// seat, or the least loaded possible one; among equals the one with fewer
    /// new words and shorter transfers.
    fn find_seat(&self, user: usize) -> Option<(Seat, Needs)> {
        let ahead = self.ahead.as_ref()?;
        if let Some(seat) = ahead.seat(user)
            && let Some(needs) = self.needs(user, seat)
        {
            return Some((seat, needs));
        }
        let places = self.places(user).map(|at| at.seat());
        let possible = places.filter_map(|seat| Some((seat, self.needs(user, seat)?)));
        possible.min_by_key(|(seat, needs)| {
            let new = needs.iter().flatten();
            let travels: u32 = new
                .clone()
                .map(|need| need.arrives - need.word.departs)
                .sum();
            (travels + ahead.load[seat.element.index()], new.count())
        })
    }

    /// The words that must be written so that an operation has its issued
    /// operands at a seat; `None` when a port or a link is taken.
    fn needs(&self, user: usize, seat: Seat) -> Option<Needs> {
        let ahead = self.ahead.as_ref()?;
        let (ports, locations) = (&self.draft.ports, &self.draft.locations);
        let mut needs: Needs = [None; Operand::MAX_COUNT];
        for (operand, source) in self.sources(user).into_iter().enumerate() {
            let Some((datum, result)) =
                source.and_then(|source| Some((source.datum, source.result?)))
            else {
                continue;
            };
            let memory = ahead.memory(seat, operand);
            let same = |need: &WordNeed| need.word.datum == datum && need.memory == memory;
            if needs.iter().flatten().any(same) || locations.find(datum, memory).is_some() {
                continue;
            }
            let arrives = result.cycle + ports.latency(result.element, memory);
            let beside = needs.iter().flatten();
            let beside = beside.filter(|need| (need.memory, need.arrives) == (memory, arrives));
            let word = ports.transfer(datum, result.element, memory, result.cycle);
            let planned = || -> [Option<WordTransfer>; PLANNED] {
                std::array::from_fn(|other| needs[other].map(|need| need.word))
            };
            if !ports.can_write(arrives, memory, beside.count() as u8 + 1)
                || !ports.can_travel(locations, word, planned)
            {
                return None;
            }
            needs[operand] = Some(WordNeed {
                word,
                memory,
                arrives,
            });
        }
        Some(needs)
    }

    /// Any memory that can take the result of an unread output.
    fn find_home(&self, node: usize, result: WriteBack) -> Option<WordNeed> {
        let (ports, locations) = (&self.draft.ports, &self.draft.locations);
        let datum = Datum::new(node as u32);
        let need = |memory: Memory| WordNeed {
            word: ports.transfer(datum, result.element, memory, result.cycle),
            memory,
            arrives: result.cycle + ports.latency(result.element, memory),
        };
        let free = |need: &WordNeed| {
            ports.can_write(need.arrives, need.memory, 1)
                && ports.can_travel(locations, need.word, || [None; PLANNED])
        };
        ports
            .memories()
            .map(need)
            .filter(free)
            .min_by_key(|need| need.arrives)
    }

    fn take_seat(&mut self, user: u32, seat: Seat, needs: Needs, booking: &mut Booking) {
        for need in needs.into_iter().flatten() {
            self.reserve(need, booking);
        }
        if let Some(ahead) = &mut self.ahead {
            booking.seats.push((user, ahead.seat(user as usize)));
            ahead.bind(user as usize, Some(seat));
        }
    }

    fn reserve(&mut self, need: WordNeed, booking: &mut Booking) {
        let draft = &mut self.draft;
        draft.ports.write(need.arrives, need.memory);
        draft.ports.travel(&draft.locations, need.word);
        draft.live[need.memory.index()] += 1;
        let travel = Travel {
            departs: need.word.departs,
            arrives: need.arrives,
        };
        // The readers extend the life when they are issued.
        let (datum, read) = (need.word.datum, Some(need.arrives));
        draft.locations.add(datum, need.memory, Some(travel), read);
        booking.needs.push(need);
    }

    /// Takes a booking back, and forgets when the node's result appears.
    fn undo(&mut self, node: usize, booking: &Booking) {
        if let Some(ahead) = &mut self.ahead {
            for &(user, old) in booking.seats.iter().rev() {
                ahead.bind(user as usize, old);
            }
        }
        let draft = &mut self.draft;
        for need in booking.needs.iter().rev() {
            draft.locations.remove_last(need.word.datum);
            let (arrives, memory) = (need.arrives, need.memory);
            draft
                .ports
                .retract(&draft.locations, need.word, arrives, memory);
            draft.live[memory.index()] -= 1;
        }
        draft.locations.data[node].result = None;
    }

    /// Issues a node, and settles the claims that changed.
    fn finish_ahead(&mut self, node: usize, cycle: u32, plan: IssuePlan, booking: &Booking) {
        if let Some(ahead) = &mut self.ahead {
            let seat = ahead.seat(node);
            ahead.bind(node, None);
            if let Some(seat) = seat {
                let read: [Option<Memory>; Operand::MAX_COUNT] = std::array::from_fn(|operand| {
                    plan.routes[operand].map(|_| plan.memories[operand])
                });
                self.release(node, seat, None, read);
            }
        }
        let datum = Datum::new(node as u32);
        // Its words must be known to be read before others give theirs up.
        let sources = self.sources(node);
        self.commit(node, cycle, plan, &sources);
        for &(user, old) in &booking.seats {
            let user = user as usize;
            let Some(seat) = self.ahead.as_ref().and_then(|ahead| ahead.seat(user)) else {
                continue;
            };
            let moved = old.filter(|&old| old != seat);
            // A reader that keeps its seat has its other claims already.
            let only = (old == Some(seat)).then_some(datum);
            self.claim_seat(user, seat, only);
            if let Some(old) = moved {
                self.release(user, old, Some(datum), [None; Operand::MAX_COUNT]);
            }
        }
    }

    /// Claims the words of the issued operands of a node at a seat; of one
    /// of them only, if it is given.
    fn claim_seat(&mut self, user: usize, seat: Seat, only: Option<Datum>) {
        let data = self.data(user);
        let Some(ahead) = &mut self.ahead else { return };
        for (memory, datum) in claimed(self.task.graph, ahead, data, seat)
            .into_iter()
            .flatten()
        {
            if only.is_none_or(|only| only == datum)
                && let Some(entry) = self.draft.locations.find(datum, memory)
            {
                ahead.claim(entry, true);
            }
        }
    }

    /// Gives up the claims of a node at a seat, except on a datum that was not
    /// issued at its reservation; words without a remaining claim are not
    /// written, except those in memories that the node now reads.
    fn release(
        &mut self,
        user: usize,
        seat: Seat,
        except: Option<Datum>,
        read: [Option<Memory>; Operand::MAX_COUNT],
    ) {
        let data = self.data(user);
        let Some(ahead) = &mut self.ahead else { return };
        let draft = &mut self.draft;
        for (memory, datum) in claimed(self.task.graph, ahead, data, seat)
            .into_iter()
            .flatten()
        {
            if except == Some(datum) {
                continue;
            }
            let Some(entry) = draft.locations.find(datum, memory) else {
                continue;
            };
            let left = ahead.claim(entry, false);
            let is_read = (0..Operand::MAX_COUNT)
                .any(|operand| data[operand] == Some(datum) && read[operand] == Some(memory));
            let stored = draft.locations.entries[entry.index()];
            if left > 0 || is_read || !stored.is_unread() {
                continue;
            }
            let travel = stored
                .travel()
                .expect("only words on their way are claimed");
            let from = draft.locations.computed(datum).element;
            let word = draft.ports.transfer(datum, from, memory, travel.departs);
            draft.locations.forget(datum, entry);
            draft
                .ports
                .retract(&draft.locations, word, travel.arrives, memory);
            draft.live[memory.index()] -= 1;
        }
    }
}

/// The memories and data that a node at a seat claims, each pair once; the
/// data are those it reads.
fn claimed(
    graph: &DependenceGraph,
    ahead: &Ahead,
    data: [Option<Datum>; Operand::MAX_COUNT],
    seat: Seat,
) -> [Option<(Memory, Datum)>; Operand::MAX_COUNT] {
    let mut pairs = [None; Operand::MAX_COUNT];
    for (operand, datum) in data.into_iter().enumerate() {
        let Some(datum) = datum.filter(|&datum| graph.is_computed(datum)) else {
            continue;
        };
        let pair = Some((ahead.memory(seat, operand), datum));
        if !pairs.contains(&pair) {
            pairs[operand] = pair;
        }
    }
    pairs
}
