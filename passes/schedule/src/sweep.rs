//! The placement sweep: cycle by cycle, best operation first, each on the
//! element that suits it, with every transfer reserved.
//!
//! Invariants. An operation is issued only when all operands can be read:
//! every entry it uses was written in an earlier cycle. Reservations are
//! never taken back. An operation that finds no element is tried again after
//! a wait that doubles with each failure, so that the work stays proportional
//! to the operations however crowded the ports are.

use super::ahead::Ahead;
use super::choice::{ElementChoice, OperandSource, Route, word};
use super::graph::{Datum, DependenceGraph, HOST};
use super::locations::{Entry, Locations, Memory, Travel, WriteBack};
use super::order::SchedulingOrder;
use super::plan::{IssueDecision, IssuePlan, OperandSources};
use super::ports::{Ports, WordTransfer};
use super::ready::{Calendar, RankSet};
use robovec_ir::{Function, Machine, Operand};

/// The longest wait between two tries of an operation, in cycles.
const LONGEST_PAUSE: u32 = 64;

/// A schedule with its transfers, before addresses.
#[derive(Clone, Debug)]
pub(super) struct ScheduleDraft {
    /// The entries each node reads as its operands.
    pub(super) reads: Vec<[Option<Entry>; Operand::MAX_COUNT]>,
    /// The nodes whose operands change sides.
    pub(super) swapped: Vec<bool>,
    /// The places of the data.
    pub(super) locations: Locations,
    /// The reserved ports and links.
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

/// The outcome of trying to issue an operation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum IssueOutcome {
    /// It is issued.
    Issued,
    /// It stays ready.
    Waits,
    /// It found no way.
    Failed,
}

/// The placement task: function, machine and manner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task<'a> {
    /// The function.
    pub(super) function: &'a Function,
    /// Its dependences.
    pub(super) graph: &'a DependenceGraph,
    /// The machine.
    pub(super) machine: &'a Machine,
    /// The rule for which element an operation goes to.
    pub(super) choice: ElementChoice,
    /// The length aimed at: the bound.
    pub(super) target: u32,
}

/// When the element of an operation is decided.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Manner {
    /// When it is issued; its operands are sent after it, through write ports
    /// that were left free, or through buffers.
    AtIssue,
    /// When its first operand is issued, and ports are booked then; but an
    /// element or a buffer that avoids idling is preferred to the booking.
    Booked,
    /// When its first operand is issued, without exception; needs no buffer.
    Ahead,
}

/// Places every operation in the given order.
///
/// # Errors
///
/// [`Stuck`] when the machine has no buffers or small ones and the choices
/// left an operand without a way; with [`Manner::Ahead`], only when memories
/// take no writes at all.
pub(super) fn sweep(
    task: Task<'_>,
    order: &SchedulingOrder,
    manner: Manner,
) -> Result<ScheduleDraft, Stuck> {
    let mut sweep = Sweep::new(task, order, manner);
    sweep.run()?;
    Ok(sweep.draft)
}

/// The state of a node that is not issued.
#[derive(Clone, Copy, Debug)]
pub(super) struct Waiting {
    /// When the operands issued so far can all be read.
    pub(super) ready: u32,
    /// Operands still to be issued.
    pub(super) operands: u8,
    /// Tries that failed.
    pub(super) failures: u8,
}

/// The state of a sweep.
pub(super) struct Sweep<'a> {
    pub(super) function: &'a Function,
    pub(super) graph: &'a DependenceGraph,
    pub(super) order: &'a SchedulingOrder,
    pub(super) choice: ElementChoice,
    pub(super) banks: usize,
    pub(super) draft: ScheduleDraft,
    pub(super) calendar: Calendar,
    pub(super) ready: Vec<RankSet>,
    /// The state of each node that is not issued.
    pub(super) waiting: Vec<Waiting>,
    /// The last cycle each element issued in, plus one.
    pub(super) busy: Vec<u32>,
    /// Per operand and memory: the stamp of the last look, and the entry.
    pub(super) marks: [Vec<(u32, Option<Entry>)>; Operand::MAX_COUNT],
    pub(super) stamp: u32,
    pub(super) last_issue: u32,
    /// Operations wait for an element that needs no buffer while the schedule
    /// need not become longer than [`Sweep::target`].
    pub(super) picky: bool,
    pub(super) target: u32,
    pub(super) manner: Manner,
    /// The bookings, unless elements are decided at issue.
    pub(super) ahead: Option<Ahead>,
    /// For each node whether it is an output.
    pub(super) is_output: Vec<bool>,
}

impl<'a> Sweep<'a> {
    fn new(task: Task<'a>, order: &'a SchedulingOrder, manner: Manner) -> Sweep<'a> {
        let Task {
            function,
            graph,
            machine,
            choice,
            target,
        } = task;
        let nodes = graph.kind.len();
        let banks = super::ports::banks(machine);
        let elements: usize = graph.kinds.iter().map(|kind| kind.count as usize).sum();
        let ports = Ports::new(machine);
        let longest_wait = graph.largest_weight() + ports.longest_travel();
        Sweep {
            function,
            graph,
            order,
            choice,
            banks,
            draft: ScheduleDraft {
                reads: vec![[None; Operand::MAX_COUNT]; nodes],
                swapped: vec![false; nodes],
                locations: Locations::new(count_readers(function, graph).into_iter()),
                ports,
                live: vec![0; elements * banks],
                cycles: 0,
            },
            calendar: Calendar::new(longest_wait.max(LONGEST_PAUSE)),
            ready: order
                .nodes
                .iter()
                .map(|nodes| RankSet::new(nodes.len()))
                .collect(),
            waiting: graph
                .computed_operands
                .iter()
                .map(|&operands| Waiting {
                    ready: 0,
                    operands,
                    failures: 0,
                })
                .collect(),
            busy: vec![0; elements],
            marks: std::array::from_fn(|_| vec![(0, None); elements * banks]),
            stamp: 0,
            last_issue: 0,
            picky: true,
            target,
            manner,
            ahead: (manner != Manner::AtIssue).then(|| Ahead::new(nodes, elements, banks)),
            is_output: outputs(function),
        }
    }

    fn run(&mut self) -> Result<(), Stuck> {
        for node in 0..self.graph.kind.len() {
            if self.graph.kind[node] != HOST && self.waiting[node].operands == 0 {
                self.calendar.enter(0, node as u32);
            }
        }
        let travel = self.draft.ports.longest_travel();
        let patience = 4 * (self.graph.largest_weight() + travel + LONGEST_PAUSE);
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

    /// Issues what the elements of one kind can take in one cycle: first what
    /// needs no buffer or cannot wait, then, on elements still free, the rest.
    fn issue_kind(&mut self, kind: usize, cycle: u32) -> Result<(), Stuck> {
        let mut free = self.graph.kinds[kind].count;
        let tries = 8 * free + 64;
        for picky in [true, false] {
            self.picky = picky;
            let (mut tries_left, mut waiting, mut rank) = (tries, 0, 0);
            while free > 0 && tries_left > 0 {
                let Some(next) = self.ready[kind].next_from(rank) else {
                    break;
                };
                rank = next + 1;
                let node = self.order.nodes[kind][next as usize] as usize;
                match self.issue(node, cycle) {
                    IssueOutcome::Issued => {
                        self.ready[kind].remove(next);
                        free -= 1;
                    }
                    IssueOutcome::Waits => {
                        waiting += 1;
                        tries_left -= 1;
                    }
                    IssueOutcome::Failed => {
                        self.ready[kind].remove(next);
                        self.postpone(node, cycle)?;
                        tries_left -= 1;
                    }
                }
            }
            if waiting == 0 {
                break;
            }
        }
        Ok(())
    }

    fn issue(&mut self, node: usize, cycle: u32) -> IssueOutcome {
        match self.manner {
            Manner::AtIssue => {}
            Manner::Booked => return self.issue_booked(node, cycle),
            Manner::Ahead => return self.issue_ahead(node, cycle),
        }
        match self.consider(node, cycle) {
            IssueDecision::Issue(plan, sources) => {
                self.commit(node, cycle, plan, &sources);
                IssueOutcome::Issued
            }
            IssueDecision::Wait => IssueOutcome::Waits,
            IssueDecision::Fail => IssueOutcome::Failed,
        }
    }

    fn postpone(&mut self, node: usize, cycle: u32) -> Result<(), Stuck> {
        if self.manner == Manner::Ahead {
            self.calendar.enter(cycle + 1, node as u32);
            return Ok(());
        }
        let failures = self.waiting[node].failures;
        let ports = &self.draft.ports;
        if (!ports.has_buffer() || ports.buffers_are_limited()) && !self.can_ever(node, cycle) {
            return Err(Stuck);
        }
        self.waiting[node].failures = failures.saturating_add(1);
        // One cycle for the first tries, then 2, 4, … 64.
        let pause = (1 << (failures / 4).min(6)).min(LONGEST_PAUSE);
        self.calendar.enter(cycle + pause, node as u32);
        Ok(())
    }

    /// Issues a node as planned, its operands being these.
    pub(super) fn commit(
        &mut self,
        node: usize,
        cycle: u32,
        plan: IssuePlan,
        sources: &OperandSources,
    ) {
        debug_assert_eq!(
            self.waiting[node].operands, 0,
            "an operation is issued after all its operands"
        );
        debug_assert!(
            self.busy[plan.element.index()] <= cycle,
            "an element issues one operation in a cycle"
        );
        let mut reads = [None; Operand::MAX_COUNT];
        for operand in 0..Operand::MAX_COUNT {
            let (Some(route), Some(source)) = (plan.routes[operand], sources[operand]) else {
                continue;
            };
            let same_word = |&before: &usize| {
                sources[before].is_some_and(|other| other.datum == source.datum)
                    && plan.memories[before] == plan.memories[operand]
            };
            reads[operand] = match (0..operand).find(same_word) {
                Some(before) => reads[before],
                None => Some(self.transfer(source, route, plan.memories[operand], cycle)),
            };
        }
        for source in sources.iter().flatten() {
            self.has_read(source.datum);
        }
        self.draft.locations.data[node].result = Some(WriteBack {
            cycle: cycle + self.graph.weight(node) - 1,
            element: plan.element,
        });
        if plan.swapped {
            reads.swap(0, 1);
            self.draft.swapped[node] = true;
        }
        self.draft.reads[node] = reads;
        self.busy[plan.element.index()] = cycle + 1;
        self.last_issue = cycle;
        self.announce(node, cycle);
    }

    /// Reserves a transfer and returns the entry that is read.
    fn transfer(
        &mut self,
        source: OperandSource,
        route: Route,
        memory: Memory,
        cycle: u32,
    ) -> Entry {
        let draft = &mut self.draft;
        // Over a crossbar a word takes no link and arrives when it departs.
        let word = match draft.ports.has_network() {
            true => word(&draft.ports, source, memory, route),
            false => None,
        };
        let travel = |arrives| Travel {
            departs: word.map_or(arrives, |word| word.departs),
            arrives,
        };
        let travel = match route {
            Route::Held(entry) => {
                draft.locations.entries[entry.index()].set_last_read(Some(cycle));
                return entry;
            }
            Route::Load => None,
            Route::Direct(at) => {
                draft.ports.write(at, memory);
                if let Some(word) = word {
                    draft.ports.travel(&draft.locations, word);
                }
                Some(travel(at))
            }
            Route::Indirect(at) => {
                reserve_indirect(draft, source, memory, travel(at));
                Some(travel(at))
            }
        };
        draft.live[memory.index()] += 1;
        let datum = source.datum;
        draft.locations.add(datum, memory, travel, Some(cycle))
    }

    fn has_read(&mut self, datum: Datum) {
        let left = &mut self.draft.locations.data[datum.index()].readers_left;
        *left -= 1;
        if *left == 0 {
            for (_, entry) in self.draft.locations.of(datum) {
                self.draft.live[entry.memory.index()] -= 1;
            }
        }
    }

    /// Tells the readers of an issued node when its result can be read.
    fn announce(&mut self, node: usize, cycle: u32) {
        let ready = cycle + self.graph.weight(node);
        self.draft.cycles = self.draft.cycles.max(ready);
        for &user in self.graph.users_of(node) {
            let waiting = &mut self.waiting[user as usize];
            waiting.ready = waiting.ready.max(ready);
            waiting.operands -= 1;
            if waiting.operands == 0 {
                let ready = match self.draft.ports.has_network() {
                    true => self.first_arrival(user as usize),
                    false => waiting.ready,
                };
                self.calendar.enter(ready.max(cycle + 1), user);
            }
        }
    }

    /// The first cycle in which some element can have all operands of a node
    /// whose operands are issued, as far as the network's latency goes.
    fn first_arrival(&self, node: usize) -> u32 {
        let draft = &self.draft;
        let sources = self.sources(node);
        let at = |element: u32| {
            let memory = Memory::new(element * self.banks as u32);
            let results = sources.iter().flatten().filter_map(|source| source.result);
            let arrivals =
                results.map(|back| back.cycle + draft.ports.latency(back.element, memory) + 1);
            arrivals.max().unwrap_or(0)
        };
        let kind = self.graph.kinds[self.graph.kind[node] as usize];
        let elements = kind.first..kind.first + kind.count;
        elements.map(at).min().unwrap_or(0)
    }
}

/// Reserves the ports, the links and the buffer words of an indirect write.
pub(super) fn reserve_indirect(
    draft: &mut ScheduleDraft,
    source: OperandSource,
    memory: Memory,
    travel: Travel,
) {
    let result = source.result.expect("only results are written");
    let producer = result.element;
    draft.ports.write(travel.arrives, memory);
    let departs = travel.departs;
    let word = WordTransfer {
        datum: source.datum,
        from: producer,
        to: draft.ports.element_of(memory),
        departs,
    };
    draft.ports.travel(&draft.locations, word);
    let mut sent = draft.locations.of(source.datum);
    if !sent.any(|(_, entry)| entry.departed() == Some(departs)) {
        draft.ports.read_buffer(departs, producer);
    }
    let from = draft
        .locations
        .buffered_until(source.datum)
        .map_or(result.cycle, |until| until + 1);
    draft.ports.occupy(from..=departs, producer);
}

fn outputs(function: &Function) -> Vec<bool> {
    let mut is_output = vec![false; function.nodes().len()];
    for assignment in &function.assignments {
        if let Some(value) = assignment.operand.value() {
            is_output[value.index()] = true;
        }
    }
    is_output
}

/// The number of reads of each datum; an output counts once more, so that its
/// words are never taken for dead.
fn count_readers(function: &Function, graph: &DependenceGraph) -> Vec<u32> {
    let mut readers = vec![0; graph.data_len()];
    for node in function.nodes() {
        for datum in graph.data_of(node).into_iter().flatten() {
            readers[datum.index()] += 1;
        }
    }
    for assignment in &function.assignments {
        if let Some(value) = assignment.operand.value() {
            readers[value.index()] += 1;
        }
    }
    readers
}
