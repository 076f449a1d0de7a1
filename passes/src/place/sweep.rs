//! The placement sweep: cycle by cycle, best operation first, each on the
//! element that suits it, with every transfer reserved.
//!
//! Invariants. An operation is issued only when both operands can be read:
//! every entry it uses was written in an earlier cycle. Reservations are
//! never taken back. An operation that finds no element is tried again after
//! a wait that doubles with each failure, so that the work stays proportional
//! to the operations however crowded the ports are.

use super::ahead::{Ahead, Booking};
use super::choice::{
    Choice, Planned, RANKS, Route, Source, buffered_until, indirect_route, plain_route,
};
use super::graph::{Graph, HOST, NO_DATUM};
use super::locations::{Locations, NO_ENTRY, PRELOADED};
use super::order::Order;
use super::ports::Ports;
use super::ready::{Calendar, RankSet};
use robovec_ir::placement::Slot;
use robovec_ir::{Function, Machine};

/// The longest wait between two tries of an operation, in cycles.
const LONGEST_PAUSE: u32 = 64;

/// A schedule with its transfers, before addresses.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    /// Cycle and element of each node.
    pub(super) slots: Vec<Slot>,
    /// The entries each node reads as left and right operand.
    pub(super) reads: Vec<[u32; 2]>,
    /// The nodes whose operands change sides.
    pub(super) swapped: Vec<bool>,
    /// Where the data are.
    pub(super) locations: Locations,
    /// What is taken when.
    pub(super) ports: Ports,
    /// Live words per memory at the end.
    pub(super) live: Vec<u32>,
    /// The first cycle in which every result can be read.
    pub(super) cycles: u32,
}

/// No element can ever take some operation: its operands appeared while every
/// port was taken, and the buffer is full or missing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Stuck;

/// How one operation is carried out.
#[derive(Clone, Copy, Debug)]
struct Plan {
    element: usize,
    swapped: bool,
    memories: [usize; 2],
    routes: [Option<Route>; 2],
}

/// Places every operation in the given order.
///
/// # Errors
///
/// [`Stuck`] when the machine has no buffers or small ones and the greedy
/// choices left an operand without a way; never otherwise.
pub(super) fn sweep(
    function: &Function,
    graph: &Graph,
    machine: &Machine,
    order: &Order,
    choice: Choice,
) -> Result<Draft, Stuck> {
    let mut sweep = Sweep::new(function, graph, machine, order, choice);
    sweep.run()?;
    Ok(sweep.draft)
}

/// Places every operation without ever using a buffer; see [`Ahead`].
pub(super) fn sweep_ahead(
    function: &Function,
    graph: &Graph,
    machine: &Machine,
    order: &Order,
) -> Result<Draft, Stuck> {
    let mut sweep = Sweep::new(function, graph, machine, order, Choice::First);
    sweep.ahead = Some(Ahead::new(graph.kind.len(), sweep.busy.len(), sweep.banks));
    sweep.is_output = vec![false; graph.kind.len()];
    for assignment in &function.assignments {
        if let Some(value) = assignment.operand.value() {
            sweep.is_output[value.index()] = true;
        }
    }
    sweep.run()?;
    Ok(sweep.draft)
}

struct Sweep<'a> {
    function: &'a Function,
    graph: &'a Graph,
    order: &'a Order,
    choice: Choice,
    banks: usize,
    draft: Draft,
    calendar: Calendar,
    ready: Vec<RankSet>,
    /// Operands still to be computed, per node.
    pending: Vec<u8>,
    failures: Vec<u8>,
    /// Reads still to come, per datum; an output has one that never comes.
    readers_left: Vec<u32>,
    /// The last cycle each element issued in, plus one.
    busy: Vec<u32>,
    /// Per operand and memory: the stamp of the last look, and the entry.
    marks: [Vec<(u32, u32)>; 2],
    stamp: u32,
    last_issue: u32,
    /// Set when readers are bound before they are issued.
    ahead: Option<Ahead>,
    /// The outputs, when [`Sweep::ahead`] is set.
    is_output: Vec<bool>,
}

impl<'a> Sweep<'a> {
    fn new(
        function: &'a Function,
        graph: &'a Graph,
        machine: &Machine,
        order: &'a Order,
        choice: Choice,
    ) -> Sweep<'a> {
        let nodes = graph.kind.len();
        let banks = super::ports::banks(machine);
        let elements: usize = graph.kinds.iter().map(|kind| kind.count as usize).sum();
        let host = Slot {
            cycle: 0,
            element: Slot::HOST,
        };
        Sweep {
            function,
            graph,
            order,
            choice,
            banks,
            draft: Draft {
                slots: vec![host; nodes],
                reads: vec![[NO_ENTRY; 2]; nodes],
                swapped: vec![false; nodes],
                locations: Locations::new(graph.data_len()),
                ports: Ports::new(machine),
                live: vec![0; elements * banks],
                cycles: 0,
            },
            calendar: Calendar::new(graph.largest_weight().max(LONGEST_PAUSE)),
            ready: order
                .nodes
                .iter()
                .map(|nodes| RankSet::new(nodes.len()))
                .collect(),
            pending: graph.computed_operands.clone(),
            failures: vec![0; nodes],
            readers_left: count_readers(function, graph),
            busy: vec![0; elements],
            marks: [
                vec![(0, 0); elements * banks],
                vec![(0, 0); elements * banks],
            ],
            stamp: 0,
            last_issue: 0,
            ahead: None,
            is_output: Vec::new(),
        }
    }

    fn run(&mut self) -> Result<(), Stuck> {
        for node in 0..self.graph.kind.len() {
            if self.graph.kind[node] != HOST && self.pending[node] == 0 {
                self.calendar.enter(0, node as u32);
            }
        }
        let patience = 4 * (self.graph.largest_weight() + LONGEST_PAUSE);
        let mut cycle = 0;
        loop {
            if self.ready.iter().all(RankSet::is_empty) {
                match self.calendar.next_from(cycle) {
                    Some(next) => cycle = next,
                    None => return Ok(()),
                }
            }
            let (graph, order, ready) = (self.graph, self.order, &mut self.ready);
            self.calendar.drain(cycle, |node| {
                let node = node as usize;
                ready[graph.kind[node] as usize].insert(order.rank[node]);
            });
            self.draft.ports.reach(cycle);
            for kind in 0..self.graph.kinds.len() {
                self.issue_kind(kind, cycle)?;
            }
            if cycle > self.last_issue + patience {
                return Err(Stuck);
            }
            cycle += 1;
        }
    }

    /// Issues what the elements of one kind can take in one cycle.
    fn issue_kind(&mut self, kind: usize, cycle: u32) -> Result<(), Stuck> {
        let mut free = self.graph.kinds[kind].count;
        let mut failures_left = 8 * free + 64;
        let mut rank = 0;
        while free > 0 && failures_left > 0 {
            let Some(next) = self.ready[kind].next_from(rank) else {
                return Ok(());
            };
            let node = self.order.nodes[kind][next as usize] as usize;
            self.ready[kind].remove(next);
            let issued = match self.ahead {
                Some(_) => self.issue_ahead(node, cycle),
                None => self.issue_now(node, cycle),
            };
            if issued {
                free -= 1;
            } else {
                failures_left -= 1;
                self.postpone(node, cycle)?;
            }
            rank = next + 1;
        }
        Ok(())
    }

    fn issue_now(&mut self, node: usize, cycle: u32) -> bool {
        let plan = self.consider(node, cycle);
        if let Some(plan) = plan {
            self.commit(node, cycle, plan);
        }
        plan.is_some()
    }

    /// Issues a node if its element is free and its result finds ports.
    fn issue_ahead(&mut self, node: usize, cycle: u32) -> bool {
        let back = cycle + self.graph.weight(node) - 1;
        self.draft.ports.reach(back);
        let Some(ahead) = &self.ahead else {
            return false;
        };
        let seat = ahead.seat(node);
        if seat.is_some_and(|seat| self.busy[seat.element] == cycle + 1) {
            return false;
        }
        let (function, graph, ports) = (self.function, self.graph, &self.draft.ports);
        let is_output = self.is_output[node];
        let Some(booking) = ahead.book(function, graph, ports, node, back, is_output) else {
            return false;
        };
        let sources = self.graph.data[node].map(|datum| self.source(datum));
        self.mark(sources);
        let kind = self.graph.kinds[self.graph.kind[node] as usize];
        let plan = (kind.first as usize..(kind.first + kind.count) as usize)
            .filter(|&element| self.busy[element] != cycle + 1)
            .filter(|&element| seat.is_none_or(|seat| seat.element == element))
            .flat_map(|element| self.sides(node, element))
            .filter(|at| seat.is_none_or(|seat| seat.swapped == at.swapped))
            .find_map(|at| self.plain(sources, at));
        let Some(plan) = plan else {
            return false;
        };
        self.commit(node, cycle, plan);
        self.write_ahead(node, back, &booking);
        true
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

    fn postpone(&mut self, node: usize, cycle: u32) -> Result<(), Stuck> {
        if self.ahead.is_some() {
            self.calendar.enter(cycle + 1, node as u32);
            return Ok(());
        }
        let failures = self.failures[node];
        let ports = &self.draft.ports;
        if (!ports.has_buffer() || ports.buffers_are_limited()) && !self.can_ever(node, cycle) {
            return Err(Stuck);
        }
        self.failures[node] = failures.saturating_add(1);
        // One cycle for the first tries, then 2, 4, … 64.
        let pause = (1 << (failures / 4).min(6)).min(LONGEST_PAUSE);
        self.calendar.enter(cycle + pause, node as u32);
        Ok(())
    }

    /// The operand as data flow, `None` for the absent second one.
    fn source(&self, datum: u32) -> Option<Source> {
        if datum == NO_DATUM {
            return None;
        }
        let result = self.graph.is_computed(datum).then(|| {
            let slot = self.draft.slots[datum as usize];
            let back = slot.cycle + self.graph.weight(datum as usize) - 1;
            (back, slot.element as usize)
        });
        Some(Source { datum, result })
    }

    fn mark(&mut self, sources: [Option<Source>; 2]) {
        self.stamp += 1;
        for (marks, source) in self.marks.iter_mut().zip(sources) {
            let Some(source) = source else { continue };
            for (index, entry) in self.draft.locations.of(source.datum) {
                marks[entry.memory as usize] = (self.stamp, index);
            }
        }
    }

    fn held(&self, operand: usize, memory: usize) -> Option<u32> {
        let (stamp, entry) = self.marks[operand][memory];
        (stamp == self.stamp).then_some(entry)
    }

    /// The best plan for a node whose operands have been computed.
    fn consider(&mut self, node: usize, cycle: u32) -> Option<Plan> {
        let sources = self.graph.data[node].map(|datum| self.source(datum));
        self.mark(sources);
        let kind = self.graph.kinds[self.graph.kind[node] as usize];
        let elements = kind.first as usize..(kind.first + kind.count) as usize;
        let free = elements.filter(|&element| self.busy[element] != cycle + 1);
        match self.choice {
            Choice::First => free
                .flat_map(|element| self.sides(node, element))
                .find_map(|at| {
                    self.plain(sources, at)
                        .or_else(|| self.indirect(sources, at, cycle))
                }),
            Choice::Preferential => {
                let plain = free
                    .clone()
                    .flat_map(|element| self.sides(node, element))
                    .filter_map(|at| self.plain(sources, at))
                    .min_by_key(|plan| self.cost(plan));
                plain.or_else(|| {
                    free.flat_map(|element| self.sides(node, element))
                        .filter_map(|at| self.indirect(sources, at, cycle))
                        .min_by_key(|plan| self.cost(plan))
                })
            }
        }
    }

    /// The ways to feed a node's operands to an element: the second with
    /// sides exchanged, where that is possible and makes a difference.
    fn sides(&self, node: usize, element: usize) -> impl Iterator<Item = Plan> + use<> {
        let first = element * self.banks;
        let last = first + self.banks - 1;
        let straight = Plan {
            element,
            swapped: false,
            memories: [first, last],
            routes: [None; 2],
        };
        let exchanged = Plan {
            swapped: true,
            memories: [last, first],
            ..straight
        };
        let [left, right] = self.graph.data[node];
        let operation = self.function.nodes()[node].operation;
        let both = self.banks > 1 && operation.is_commutative() && left != right;
        std::iter::once(straight).chain(both.then_some(exchanged))
    }

    /// The plan without buffers.
    fn plain(&self, sources: [Option<Source>; 2], at: Plan) -> Option<Plan> {
        let ports = &self.draft.ports;
        let [Some(left), right] = sources else {
            return None;
        };
        let [left_memory, right_memory] = at.memories;
        let first = plain_route(ports, left, left_memory, self.held(0, left_memory), None)?;
        let second = match right {
            None => None,
            Some(right) if right == left && left_memory == right_memory => Some(first),
            Some(right) => {
                let other = Planned::new(left, left_memory, first);
                let held = self.held(1, right_memory);
                Some(plain_route(ports, right, right_memory, held, Some(other))?)
            }
        };
        Some(Plan {
            routes: [Some(first), second],
            ..at
        })
    }

    /// The plan with at least one operand through a buffer; called when there
    /// is none without. What can go directly does.
    fn indirect(&self, sources: [Option<Source>; 2], at: Plan, cycle: u32) -> Option<Plan> {
        let draft = &self.draft;
        if !draft.ports.has_buffer() {
            return None;
        }
        let mut routes = [None; 2];
        for operand in 0..2 {
            if let Some(source) = sources[operand] {
                let memory = at.memories[operand];
                let other = self.planned(sources, &at, &routes, 1 - operand);
                let held = self.held(operand, memory);
                routes[operand] = plain_route(&draft.ports, source, memory, held, other);
            }
        }
        for operand in 0..2 {
            let Some(source) = sources[operand] else {
                continue;
            };
            if routes[operand].is_some() {
                continue;
            }
            let memory = at.memories[operand];
            if operand == 1 && sources[0] == sources[1] && memory == at.memories[0] {
                routes[1] = routes[0];
                continue;
            }
            let other = self.planned(sources, &at, &routes, 1 - operand);
            let ports = &draft.ports;
            let route = indirect_route(ports, &draft.locations, source, memory, cycle, other)?;
            routes[operand] = Some(route);
        }
        Some(Plan { routes, ..at })
    }

    fn planned(
        &self,
        sources: [Option<Source>; 2],
        at: &Plan,
        routes: &[Option<Route>; 2],
        operand: usize,
    ) -> Option<Planned> {
        // One datum in one memory is one transfer, not two that compete.
        if sources[0] == sources[1] && at.memories[0] == at.memories[1] {
            return None;
        }
        let (source, route) = (sources[operand]?, routes[operand]?);
        Some(Planned::new(source, at.memories[operand], route))
    }

    /// What [`Choice::Preferential`] minimises.
    fn cost(&self, plan: &Plan) -> (u8, u8, u32) {
        let status = |side: usize| {
            // Exchanged, the first operand is the one on the right.
            plan.routes[side ^ usize::from(plan.swapped)].map_or(0, Route::status)
        };
        let rank = RANKS[status(0)][status(1)];
        let loads = plan
            .routes
            .iter()
            .filter(|&&route| route == Some(Route::Load))
            .count() as u8;
        let words = plan
            .memories
            .iter()
            .map(|&memory| self.draft.live[memory])
            .sum();
        (rank, loads, words)
    }

    fn commit(&mut self, node: usize, cycle: u32, plan: Plan) {
        let data = self.graph.data[node];
        let same_word = data[0] == data[1] && plan.memories[0] == plan.memories[1];
        let mut reads = [NO_ENTRY; 2];
        for operand in 0..2 {
            let (Some(route), Some(source)) = (plan.routes[operand], self.source(data[operand]))
            else {
                continue;
            };
            reads[operand] = if operand == 1 && same_word {
                reads[0]
            } else {
                self.transfer(source, route, plan.memories[operand], cycle)
            };
        }
        for datum in data.into_iter().filter(|&datum| datum != NO_DATUM) {
            self.has_read(datum);
        }
        self.draft.slots[node] = Slot {
            cycle,
            element: plan.element as u32,
        };
        if plan.swapped {
            reads.swap(0, 1);
            self.draft.swapped[node] = true;
        }
        self.draft.reads[node] = reads;
        self.busy[plan.element] = cycle + 1;
        self.last_issue = cycle;
        self.announce(node, cycle);
    }

    /// Reserves a transfer and returns the entry that is read.
    fn transfer(&mut self, source: Source, route: Route, memory: usize, cycle: u32) -> u32 {
        let draft = &mut self.draft;
        let written = match route {
            Route::Held(entry) => {
                draft.locations.entries[entry as usize].last_read = cycle;
                return entry;
            }
            Route::Load => PRELOADED,
            Route::Direct(at) => {
                draft.ports.write(at, memory);
                at
            }
            Route::Indirect(at) => {
                reserve_indirect(draft, source, memory, at);
                at
            }
        };
        draft.live[memory] += 1;
        draft.locations.add(source.datum, memory, written, cycle)
    }

    fn has_read(&mut self, datum: u32) {
        let left = &mut self.readers_left[datum as usize];
        *left -= 1;
        if *left == 0 {
            for (_, entry) in self.draft.locations.of(datum) {
                self.draft.live[entry.memory as usize] -= 1;
            }
        }
    }

    /// Tells the readers of an issued node when its result can be read.
    fn announce(&mut self, node: usize, cycle: u32) {
        let ready = cycle + self.graph.weight(node);
        self.draft.cycles = self.draft.cycles.max(ready);
        for &user in self.graph.users_of(node) {
            let pending = &mut self.pending[user as usize];
            *pending -= 1;
            if *pending == 0 {
                let from = self.graph.data[user as usize]
                    .into_iter()
                    .filter_map(|datum| self.source(datum)?.result)
                    .map(|(back, _)| back + 1)
                    .max()
                    .unwrap_or(ready);
                self.calendar.enter(from, user);
            }
        }
    }

    /// False when no element, free now or not, can take the node in this or
    /// any later cycle.
    fn can_ever(&mut self, node: usize, cycle: u32) -> bool {
        let sources = self.graph.data[node].map(|datum| self.source(datum));
        self.mark(sources);
        let kind = self.graph.kinds[self.graph.kind[node] as usize];
        (kind.first as usize..(kind.first + kind.count) as usize)
            .flat_map(|element| self.sides(node, element))
            .any(|at| {
                self.plain(sources, at).is_some()
                    || self.indirect(sources, at, cycle).is_some()
                    || self.may_wait(sources, at, cycle)
            })
    }

    /// True when every operand is there, can go directly, or can stay in its
    /// buffer until now, so that a later cycle may find a port.
    fn may_wait(&self, sources: [Option<Source>; 2], at: Plan, cycle: u32) -> bool {
        let draft = &self.draft;
        draft.ports.has_buffer()
            && (0..2).all(|operand| {
                let Some(source) = sources[operand] else {
                    return true;
                };
                let memory = at.memories[operand];
                let held = self.held(operand, memory);
                let Some((back, producer)) = source.result else {
                    return true;
                };
                if plain_route(&draft.ports, source, memory, held, None).is_some() {
                    return true;
                }
                let from = buffered_until(&draft.locations, source.datum, back)
                    .map_or(back, |until| until + 1);
                (from..=cycle).all(|at| draft.ports.has_room(at, producer, 1))
            })
    }
}

/// Reserves the ports and the buffer words of an indirect write.
pub(super) fn reserve_indirect(draft: &mut Draft, source: Source, memory: usize, at: u32) {
    let Some((back, producer)) = source.result else {
        return;
    };
    draft.ports.write(at, memory);
    let mut written = draft.locations.of(source.datum);
    if !written.any(|(_, entry)| entry.written == at) {
        draft.ports.read_buffer(at, producer);
    }
    let from = buffered_until(&draft.locations, source.datum, back).map_or(back, |until| until + 1);
    draft.ports.occupy(from..=at, producer);
}

/// How often each datum is read; an output counts once more, so that its
/// words are never taken for dead.
fn count_readers(function: &Function, graph: &Graph) -> Vec<u32> {
    let mut readers = vec![0; graph.data_len()];
    for datum in graph.data.iter().flatten() {
        if *datum != NO_DATUM {
            readers[*datum as usize] += 1;
        }
    }
    for assignment in &function.assignments {
        if let Some(value) = assignment.operand.value() {
            readers[value.index()] += 1;
        }
    }
    readers
}
