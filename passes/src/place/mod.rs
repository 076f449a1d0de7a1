//! Scheduling and placement (thesis 2.3): every operation gets a cycle and a
//! processing element, every word an address, every transfer a cycle.
//!
//! The parts, in the order in which they run:
//!
//! - `graph`: dependences, kinds, longest chains before and after each node;
//! - `bound`: a length no schedule can beat;
//! - `order`, `list`: priorities, and how short a schedule they give without
//!   memories;
//! - `sweep`, with `ready`, `plan`, `choice`, `ports` and `locations`: the
//!   placement itself, cycle by cycle; `ahead` does without buffers;
//! - `homes`: words that keep the outputs to the end;
//! - `addresses`, `finish`: addresses by lifetime, and the result.
//!
//! Everything is linear in the operations, up to the sorting of priorities
//! and the number of elements an operation chooses from. Node order, names
//! and sources stay; operands of commutative operations may change sides on
//! machines with a memory per side.

mod addresses;
mod ahead;
mod bound;
mod choice;
mod error;
mod finish;
mod graph;
mod homes;
mod list;
mod locations;
mod order;
mod pass;
mod plan;
mod ports;
mod ready;
#[cfg(test)]
mod rules;
mod statistics;
mod sweep;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

pub use choice::Choice;
pub use error::PlaceError;
pub use order::Priority;
pub use pass::Place;
pub use statistics::{KindStatistics, PlacementStatistics, Spread, placement_statistics};

use graph::Graph;
use locations::NO_ENTRY;
use order::Order;
use robovec_ir::{Function, Machine};
use sweep::{Draft, Manner, Stuck, Task};

/// How many visits of an operation [`Priority::Best`] may spend beyond its
/// first sweep: a few more tries for a model of 30,000 operations, none for
/// one of 600,000, whose first schedule is within a fraction of a per cent.
const WORK_BUDGET: usize = 300_000;

/// The most entries the table of write ports may have: one per memory and
/// cycle, in bytes.
const LARGEST_TABLE: u64 = 1 << 30;

/// The most orders tried for small programs.
const MOST_TRIES: usize = 40;

/// What a sweep visits an operation for, in units of a list schedule.
const SWEEP_COST: usize = 4;

/// How a function is placed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct PlaceOptions {
    /// Which operation goes first.
    pub priority: Priority,
    /// Which element it goes to.
    pub choice: Choice,
}

/// What placement reached.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PlaceSummary {
    /// Length of the schedule, in cycles.
    pub cycles: u32,
    /// No schedule on this machine is shorter.
    pub lower_bound: u32,
    /// The order that gave the schedule.
    pub order: &'static str,
    /// Orders tried, with or without memories.
    pub tries: u32,
}

/// Places a function on a machine.
///
/// # Errors
///
/// When the machine cannot perform the function (an operation it lacks, an
/// angle it would have to compute, a memory too small); the function is then
/// unchanged.
pub fn place(
    function: &mut Function,
    machine: &Machine,
    options: PlaceOptions,
) -> Result<PlaceSummary, PlaceError> {
    let graph = Graph::new(function, machine)?;
    let memories = u64::from(machine.elements.iter().map(|kind| kind.count).sum::<u32>())
        * ports::banks(machine) as u64;
    if u64::from(graph.path) * memories > LARGEST_TABLE {
        return Err(PlaceError::TooLong {
            path: graph.path.into(),
            limit: LARGEST_TABLE / memories,
        });
    }
    let fan_out = Order::fan_out(&graph);
    let lower_bound = bound::lower_bound(&graph, &fan_out);
    let mut search = Search {
        task: Task {
            function,
            graph: &graph,
            machine,
            choice: options.choice,
            target: lower_bound,
        },
        best: None,
        tries: 0,
    };
    match options.priority {
        Priority::Alap => search.sweep("alap", &Order::alap(&graph)),
        Priority::Mobility => search.sweep("mobility", &Order::mobility(&graph)),
        Priority::FanOut => search.sweep("fan-out", &fan_out),
        Priority::Best => search.best(&fan_out),
    }
    let tries = search.tries;
    let Some(best) = search.best else {
        // Binding ahead works wherever a memory can be written at all.
        return Err(PlaceError::NoWritePorts {
            machine: machine.name.clone(),
        });
    };
    let summary = PlaceSummary {
        cycles: best.draft.cycles,
        lower_bound,
        order: best.order,
        tries,
    };
    let settled = finish::Settled {
        draft: best.draft,
        homes: best.homes,
        buffers: best.buffers,
        lower_bound,
    };
    finish::finish(function, graph, machine, settled)?;
    Ok(summary)
}

/// Tries orders and keeps the best placement.
struct Search<'a> {
    task: Task<'a>,
    best: Option<Candidate>,
    tries: u32,
}

impl Search<'_> {
    /// Places in an order, in the manners that suit the machine, and keeps
    /// the result if it is better than what there is.
    fn sweep(&mut self, name: &'static str, order: &Order) {
        self.tries += 1;
        let Task {
            graph,
            machine,
            choice,
            target,
            ..
        } = self.task;
        let widest = graph.kinds.iter().map(|kind| kind.count).max().unwrap_or(0);
        // With one or two elements of a kind there is hardly a choice at
        // issue, and what keeps the buffers small is not to let results
        // appear together; with more of them, booking only ties hands.
        let books = choice == Choice::Preferential
            && machine.buffer.is_some()
            && widest <= 2
            && graph.operations() * SWEEP_COST <= WORK_BUDGET;
        if books {
            self.consider(name, sweep::sweep(self.task, order, Manner::Booked));
        }
        if self.best_cycles() > target {
            self.consider(name, sweep::sweep(self.task, order, Manner::AtIssue));
        }
        if self.best.is_none() {
            self.consider(name, sweep::sweep(self.task, order, Manner::Ahead));
        }
    }

    fn consider(&mut self, name: &'static str, draft: Result<Draft, Stuck>) {
        if let Ok(candidate) = draft.and_then(|draft| Candidate::new(&self.task, name, draft))
            && self
                .best
                .as_ref()
                .is_none_or(|best| candidate.cost < best.cost)
        {
            self.best = Some(candidate);
        }
    }

    fn best_cycles(&self) -> u32 {
        self.best
            .as_ref()
            .map_or(u32::MAX, |best| best.draft.cycles)
    }

    /// See [`Priority::Best`].
    fn best(&mut self, fan_out: &Order) {
        self.sweep("fan-out", fan_out);
        if self.best_cycles() > self.task.target {
            let graph = self.task.graph;
            let budget = (WORK_BUDGET / graph.operations().max(1)).min(MOST_TRIES);
            let trials = Trials::run(&self.task, budget.saturating_sub(SWEEP_COST));
            self.tries += trials.tries;
            if let Some((cycles, name, order)) = trials.best
                && cycles < self.best_cycles()
            {
                self.sweep(name, &order);
            }
        }
    }
}

/// Orders tried without memories.
struct Trials<'a> {
    task: &'a Task<'a>,
    budget: usize,
    tries: u32,
    best: Option<(u32, &'static str, Order)>,
}

impl<'a> Trials<'a> {
    /// Tries orders, from the simple to the elaborate, until one reaches the
    /// bound or `budget` schedules have been made.
    fn run(task: &'a Task<'a>, budget: usize) -> Trials<'a> {
        let mut trials = Trials {
            task,
            budget,
            tries: 0,
            best: None,
        };
        let graph = task.graph;
        trials.schedule("alap", || Order::alap(graph));
        for share in [32, 8, 64, 16, 128] {
            trials.schedule("program", || Order::towards_program(graph, share));
        }
        let mut schedule = list::forward(graph, &Order::fan_out(graph));
        while trials.budget > 0 {
            // What is late in a schedule from the end must be early here.
            let late = |node: usize| u64::from(u32::MAX - schedule.issue[node]);
            let backward = list::backward(graph, task.function, &Order::by_key(graph, late));
            trials.budget = trials.budget.saturating_sub(1);
            let early = |node: usize| u64::from(backward.cycles - backward.issue[node]);
            match trials.schedule("backward", || Order::by_key(graph, early)) {
                Some(next) if next.issue != schedule.issue => schedule = next,
                _ => break,
            }
        }
        trials
    }

    fn schedule(
        &mut self,
        name: &'static str,
        order: impl Fn() -> Order,
    ) -> Option<list::ListSchedule> {
        let least = self.best.as_ref().map_or(u32::MAX, |&(least, _, _)| least);
        if self.budget == 0 || least <= self.task.target {
            self.budget = 0;
            return None;
        }
        self.budget -= 1;
        self.tries += 1;
        let order = order();
        let schedule = list::forward(self.task.graph, &order);
        if schedule.cycles < least {
            self.best = Some((schedule.cycles, name, order));
        }
        Some(schedule)
    }
}

/// A complete placement, but for addresses.
struct Candidate {
    draft: Draft,
    homes: Vec<u32>,
    buffers: Vec<u32>,
    order: &'static str,
    /// Smaller is better: cycles above the bound, in steps of 1/4096 of it;
    /// the deepest buffer; cycles.
    cost: (u32, u32, u32),
}

impl Candidate {
    fn new(task: &Task<'_>, order: &'static str, mut draft: Draft) -> Result<Candidate, Stuck> {
        let homes = homes::settle_homes(task.function, task.graph, &mut draft)?;
        draft.locations.drop_unread();
        let buffers = addresses::allocate_buffers(task.graph, &draft);
        let used = buffers.iter().filter(|&&word| word != NO_ENTRY);
        let depth = used.map(|word| word + 1).max().unwrap_or(0);
        let above = draft.cycles - task.target;
        Ok(Candidate {
            cost: (above / (task.target / 4096 + 1), depth, above),
            draft,
            homes,
            buffers,
            order,
        })
    }
}
