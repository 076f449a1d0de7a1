//! The state of a sweep, and its initial values.

use super::choice::ElementChoice;
use super::graph::DependenceGraph;
use super::locations::{Entry, Locations};
use super::order::SchedulingOrder;
use super::ports::{Ports, banks};
use super::ready::ReadyNodes;
use super::seats::Ahead;
use robovec_ir::{Function, Machine, Operand};

/// The longest wait between two tries of an operation, in cycles.
pub(super) const LONGEST_PAUSE: u32 = 64;

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
    /// No placement was found.
    Failed,
}

/// The placement task: function, machine and manner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task<'a> {
    pub(super) function: &'a Function,
    pub(super) graph: &'a DependenceGraph,
    pub(super) machine: &'a Machine,
    /// The rule that chooses an element for an operation.
    pub(super) choice: ElementChoice,
    /// The length aimed at: the bound.
    pub(super) target: u32,
}

/// Time at which the element of an operation is decided.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Manner {
    /// At the issue; its operands are sent after it, through write ports that
    /// were left free, or through buffers.
    AtIssue,
    /// At the issue of its first operand, and ports are booked then; but an
    /// element or a buffer that avoids idling is preferred to the booking.
    Booked,
    /// At the issue of its first operand, without exception; needs no buffer.
    Ahead,
}

/// The state of a node that is not issued.
#[derive(Clone, Copy, Debug)]
pub(super) struct Waiting {
    /// Time at which the operands issued so far can all be read.
    pub(super) ready: u32,
    /// Operands still to be issued.
    pub(super) operands: u8,
    /// Tries that failed.
    pub(super) failures: u8,
}

pub(super) struct Sweep<'a> {
    pub(super) task: Task<'a>,
    pub(super) order: &'a SchedulingOrder,
    pub(super) banks: usize,
    pub(super) draft: ScheduleDraft,
    pub(super) ready: ReadyNodes,
    /// The state of each node that is not issued.
    pub(super) waiting: Vec<Waiting>,
    /// The last cycle each element issued in, plus one.
    pub(super) busy: Vec<u32>,
    /// Per operand and memory: the stamp of the last look, and the entry.
    pub(super) marks: [Vec<(u32, Option<Entry>)>; Operand::MAX_COUNT],
    pub(super) stamp: u32,
    pub(super) last_issue: u32,
    /// Operations wait for an element that needs no buffer while the schedule
    /// need not become longer than [`Task::target`].
    pub(super) picky: bool,
    pub(super) manner: Manner,
    /// The bookings, unless elements are decided at issue.
    pub(super) ahead: Option<Ahead>,
    /// For each node whether it is an output.
    pub(super) is_output: Vec<bool>,
}

impl<'a> Sweep<'a> {
    pub(super) fn new(task: Task<'a>, order: &'a SchedulingOrder, manner: Manner) -> Sweep<'a> {
        let (function, graph) = (task.function, task.graph);
        let nodes = graph.kind.len();
        let banks = banks(task.machine);
        let elements: usize = graph.kinds.iter().map(|kind| kind.count as usize).sum();
        let ports = Ports::new(task.machine);
        let longest_wait = graph.largest_weight() + ports.longest_travel();
        Sweep {
            task,
            order,
            banks,
            draft: ScheduleDraft {
                reads: vec![[None; Operand::MAX_COUNT]; nodes],
                swapped: vec![false; nodes],
                locations: Locations::new(count_readers(function, graph).into_iter()),
                ports,
                live: vec![0; elements * banks],
                cycles: 0,
            },
            ready: ReadyNodes::new(order, longest_wait.max(LONGEST_PAUSE)),
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
            manner,
            ahead: (manner != Manner::AtIssue).then(|| Ahead::new(nodes, elements, banks)),
            is_output: outputs(function),
        }
    }
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
