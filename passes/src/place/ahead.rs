//! Placement without buffers: readers are bound to elements before their
//! operands appear.
//!
//! Choosing a reader's element when it is issued, as the sweep does, can find
//! every direct way into every memory taken long ago; with buffers there is
//! another way, without (or with full ones) the program is stuck. Here the
//! first operand of a reader to be issued binds the reader to an element and
//! reserves the write port it will need there, and an operation whose result
//! finds a port taken is not issued yet. Ports of later cycles are always
//! free, so this never gets stuck, whatever the machine; the price is a
//! slightly longer schedule.

use super::graph::Graph;
use super::plan::Verdict;
use super::ports::Ports;
use super::sweep::{Outcome, Sweep};
use robovec_ir::{Function, Operand, Value};

const UNBOUND: u32 = u32::MAX;

/// Elements of operations that are not issued yet.
#[derive(Clone, Debug)]
pub(super) struct Ahead {
    /// Element and sides of each node, or [`UNBOUND`].
    bound: Vec<u32>,
    /// Operations bound to each element and not issued yet.
    load: Vec<u32>,
    banks: usize,
}

/// An operation's element: its number, and whether the operands change sides.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Seat {
    pub(super) element: usize,
    pub(super) swapped: bool,
}

/// What the issue of one operation entails for its readers.
#[derive(Clone, Default, Debug)]
pub(super) struct Booking {
    /// The memories its result is written to.
    pub(super) memories: Vec<usize>,
    /// Readers that get an element by it.
    seats: Vec<(u32, Seat)>,
}

impl Ahead {
    /// Nothing bound.
    pub(super) fn new(nodes: usize, elements: usize, banks: usize) -> Ahead {
        Ahead {
            bound: vec![UNBOUND; nodes],
            load: vec![0; elements],
            banks,
        }
    }

    /// Where a node is bound to.
    pub(super) fn seat(&self, node: usize) -> Option<Seat> {
        let bound = self.bound[node];
        (bound != UNBOUND).then_some(Seat {
            element: (bound >> 1) as usize,
            swapped: bound & 1 == 1,
        })
    }

    /// The node is issued.
    pub(super) fn issued(&mut self, node: usize) {
        if let Some(seat) = self.seat(node) {
            self.load[seat.element] -= 1;
        }
    }

    /// Finds ports for the result of a node in its write-back cycle: at the
    /// elements its readers are bound to, at the least loaded one with a free
    /// port for those that are not. Where a port is taken, `None`, or, when
    /// `partial`, what there is without it.
    pub(super) fn book(
        &self,
        function: &Function,
        graph: &Graph,
        ports: &Ports,
        node: usize,
        back: u32,
        partial: bool,
    ) -> Option<Booking> {
        let mut booking = Booking::default();
        let users = graph.users_of(node);
        for (index, &user) in users.iter().enumerate() {
            // A node that reads the result twice stands there twice in a row.
            if index > 0 && users[index - 1] == user {
                continue;
            }
            let known = self.seat(user as usize);
            let seat = known
                .or_else(|| self.find_seat(function, graph, ports, node, user, back, &booking));
            let Some(seat) = seat else {
                if partial {
                    continue;
                }
                return None;
            };
            if known.is_none() {
                booking.seats.push((user, seat));
            }
            for memory in self.memories(graph, node, user, seat) {
                if booking.memories.contains(&memory) {
                    continue;
                }
                if ports.can_write(back, memory, 1) {
                    booking.memories.push(memory);
                } else if !partial {
                    return None;
                }
            }
        }
        Some(booking)
    }

    /// Any memory that can take the result of an output nobody reads.
    fn book_home(&self, ports: &Ports, back: u32) -> Option<usize> {
        (0..self.load.len() * self.banks).find(|&memory| ports.can_write(back, memory, 1))
    }

    /// Binds the readers of a booking.
    pub(super) fn confirm(&mut self, booking: &Booking) {
        for &(user, seat) in &booking.seats {
            self.bound[user as usize] = (seat.element as u32) << 1 | u32::from(seat.swapped);
            self.load[seat.element] += 1;
        }
    }

    /// The least loaded seat of a reader whose ports are free; a memory that
    /// gets the result anyway is preferred among equals.
    #[allow(clippy::too_many_arguments)]
    fn find_seat(
        &self,
        function: &Function,
        graph: &Graph,
        ports: &Ports,
        node: usize,
        user: u32,
        back: u32,
        booking: &Booking,
    ) -> Option<Seat> {
        let kind = graph.kinds[graph.kind[user as usize] as usize];
        let commutes = function.node(Value(user)).operation.is_commutative();
        let sides = if self.banks > 1 && commutes { 2 } else { 1 };
        (kind.first as usize..(kind.first + kind.count) as usize)
            .flat_map(|element| {
                (0..sides).map(move |side| Seat {
                    element,
                    swapped: side == 1,
                })
            })
            .filter(|&seat| {
                self.memories(graph, node, user, seat)
                    .all(|memory| ports.can_write(back, memory, 1))
            })
            .min_by_key(|&seat| {
                let new = self
                    .memories(graph, node, user, seat)
                    .filter(|memory| !booking.memories.contains(memory))
                    .count();
                let more = booking
                    .seats
                    .iter()
                    .filter(|(_, other)| other.element == seat.element)
                    .count();
                (self.load[seat.element] as usize + more, new)
            })
    }

    /// The memories in which a reader at a seat wants a datum.
    fn memories(
        &self,
        graph: &Graph,
        node: usize,
        user: u32,
        seat: Seat,
    ) -> impl Iterator<Item = usize> + use<> {
        let banks = self.banks;
        let data = graph.data[user as usize];
        (0..Operand::MOST)
            .filter(move |&operand| data[operand] == node as u32)
            .map(move |operand| {
                let side = operand ^ usize::from(seat.swapped);
                seat.element * banks + side.min(banks - 1)
            })
    }
}

impl Sweep<'_> {
    /// Issues a node if its element is free and its result finds ports.
    pub(super) fn issue_ahead(&mut self, node: usize, cycle: u32) -> Outcome {
        let back = cycle + self.graph.weight(node) - 1;
        self.draft.ports.reach(back);
        let Some(ahead) = &self.ahead else {
            return Outcome::Failed;
        };
        let seat = ahead.seat(node);
        if seat.is_some_and(|seat| self.busy[seat.element] == cycle + 1) {
            return Outcome::Failed;
        }
        let (function, graph, ports) = (self.function, self.graph, &self.draft.ports);
        let Some(mut booking) = ahead.book(function, graph, ports, node, back, false) else {
            return Outcome::Failed;
        };
        if self.is_output[node] && booking.memories.is_empty() {
            match ahead.book_home(ports, back) {
                Some(memory) => booking.memories.push(memory),
                None => return Outcome::Failed,
            }
        }
        let sources = self.graph.data[node].map(|datum| self.source(datum));
        self.mark(sources);
        let plan = self
            .places(node)
            .filter(|at| self.busy[at.element] != cycle + 1)
            .filter(|at| {
                seat.is_none_or(|seat| seat.element == at.element && seat.swapped == at.swapped)
            })
            .find_map(|at| self.plain(sources, at));
        let Some(plan) = plan else {
            return Outcome::Failed;
        };
        self.commit(node, cycle, plan);
        self.write_ahead(node, back, &booking);
        Outcome::Issued
    }

    /// Issues a node where its operands were booked to, and books its result;
    /// where either is impossible the node waits if it can, and else goes to
    /// any element and leaves its result to the buffer.
    pub(super) fn issue_booked(&mut self, node: usize, cycle: u32) -> Outcome {
        let back = cycle + self.graph.weight(node) - 1;
        self.draft.ports.reach(back);
        let Some(ahead) = &self.ahead else {
            return Outcome::Failed;
        };
        let waits = self.can_wait(node, cycle);
        let seat = ahead.seat(node);
        if waits && seat.is_some_and(|seat| self.busy[seat.element] == cycle + 1) {
            return Outcome::Waits;
        }
        let (function, graph, ports) = (self.function, self.graph, &self.draft.ports);
        let Some(booking) = ahead.book(function, graph, ports, node, back, !waits) else {
            return Outcome::Waits;
        };
        match self.consider(node, cycle) {
            Verdict::Issue(plan) => {
                self.commit(node, cycle, plan);
                self.write_ahead(node, back, &booking);
                Outcome::Issued
            }
            Verdict::Wait => Outcome::Waits,
            Verdict::Fail => Outcome::Failed,
        }
    }

    fn write_ahead(&mut self, node: usize, back: u32, booking: &Booking) {
        if let Some(ahead) = &mut self.ahead {
            ahead.issued(node);
            ahead.confirm(booking);
        }
        let draft = &mut self.draft;
        for &memory in &booking.memories {
            draft.ports.write(back, memory);
            draft.live[memory] += 1;
            // The readers extend the life when they are issued.
            draft.locations.add(node as u32, memory, back, back);
        }
    }
}
