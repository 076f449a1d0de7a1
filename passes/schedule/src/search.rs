//! The search for the placement that is kept: orders and manners are tried
//! while the work is in proportion, and the best result wins.

use super::choice::ElementChoice;
use super::locations::Entry;
use super::order::SchedulingOrder;
use super::state::{Manner, ScheduleDraft, Stuck, Task};
use super::sweep::sweep;
use super::{addresses, homes, list};
use robovec_ir::machine::Interconnect;
use robovec_ir::placement::BufferWord;

/// The number of visits of an operation that [`Priority::Best`] may spend
/// beyond its first sweep: a few more tries for a model of 30,000 operations,
/// none for one of 600,000, whose first schedule is within a fraction of a per
/// cent.
const WORK_BUDGET: usize = 300_000;

/// The number of operations that may be placed beyond that on a machine without
/// buffers.
const BUFFERLESS_BUDGET: usize = 150_000;

/// The maximum number of orders tried for small programs.
const MAX_TRIES: usize = 40;

/// A buffer of this many words is not worth another try.
const SHALLOW: u32 = 2;

/// The cost of a visit of an operation in a sweep, in units of a list schedule.
const SWEEP_COST: usize = 4;

/// Tries orders and keeps the best placement.
pub(super) struct PlacementSearch<'a> {
    pub(super) task: Task<'a>,
    /// The best placement so far.
    pub(super) best: Option<PlacementCandidate>,
    /// Orders tried.
    pub(super) tries: u32,
}

impl PlacementSearch<'_> {
    /// Places operations in an order, in the manners that suit the machine, and
    /// keeps the result if it is better than the best so far.
    pub(super) fn sweep(&mut self, name: &'static str, order: &SchedulingOrder) {
        self.tries += 1;
        if self.books() {
            self.consider(name, sweep(self.task, order, Manner::Booked));
        }
        if self.best_cycles() > self.task.target {
            self.consider(name, sweep(self.task, order, Manner::AtIssue));
        }
        let bufferless = self.task.machine.buffer.is_none();
        if self.best.is_none() || bufferless && self.best_cycles() > self.task.target {
            self.consider(name, sweep(self.task, order, Manner::Ahead));
        }
    }

    /// True when ports are booked before operations are issued. With one or two
    /// elements of a kind there is hardly a choice, and the buffers stay small
    /// when results appear at different times; with more of them, reservations
    /// only remove freedom.
    fn books(&self) -> bool {
        let graph = self.task.graph;
        self.task.choice == ElementChoice::Preferential
            && self.task.machine.buffer.is_some()
            && self.task.machine.interconnect == Interconnect::Crossbar
            && graph.kinds.iter().all(|kind| kind.count <= 2)
            && graph.operations() * SWEEP_COST <= WORK_BUDGET
    }

    fn consider(&mut self, name: &'static str, draft: Result<ScheduleDraft, Stuck>) {
        if let Ok(candidate) =
            draft.and_then(|draft| PlacementCandidate::new(&self.task, name, draft))
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
    pub(super) fn best(&mut self, fan_out: &SchedulingOrder) {
        self.sweep("fan-out", fan_out);
        if self.books() && self.best.as_ref().is_some_and(|best| best.cost.1 > SHALLOW) {
            self.sweep("alap", &SchedulingOrder::alap(self.task.graph));
        }
        if self.best_cycles() > self.task.target {
            let graph = self.task.graph;
            let budget = (WORK_BUDGET / graph.operations().max(1)).min(MAX_TRIES);
            let trials = Trials::run(&self.task, budget.saturating_sub(SWEEP_COST));
            self.tries += trials.tries;
            if let Some((cycles, name, order)) = trials.best
                && cycles < self.best_cycles()
            {
                self.sweep(name, &order);
            }
        }
        self.without_buffers();
    }

    /// Tries more orders on a machine without buffers: there list schedules
    /// without memories predict little about port conflicts, so every order is
    /// swept.
    fn without_buffers(&mut self) {
        if self.task.machine.buffer.is_some() {
            return;
        }
        let graph = self.task.graph;
        let tries = BUFFERLESS_BUDGET / graph.operations().max(1);
        for share in [16, 4, 32, 8, 64].into_iter().take(tries) {
            if self.best_cycles() <= self.task.target {
                return;
            }
            self.sweep("program", &SchedulingOrder::towards_program(graph, share));
        }
    }
}

/// Orders tried without memories.
struct Trials<'a> {
    task: &'a Task<'a>,
    budget: usize,
    tries: u32,
    best: Option<(u32, &'static str, SchedulingOrder)>,
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
        trials.schedule("alap", || SchedulingOrder::alap(graph));
        for share in [32, 8, 64, 16, 128] {
            trials.schedule("program", || SchedulingOrder::towards_program(graph, share));
        }
        if trials.budget == 0 {
            return trials;
        }
        let mut schedule = list::forward(graph, &SchedulingOrder::fan_out(graph));
        while trials.budget > 0 {
            // What is late in a schedule from the end must be early here.
            let late = |node: usize| u64::from(u32::MAX - schedule.issue[node]);
            let backward =
                list::backward(graph, task.function, &SchedulingOrder::by_key(graph, late));
            trials.budget = trials.budget.saturating_sub(1);
            let early = |node: usize| u64::from(backward.cycles - backward.issue[node]);
            match trials.schedule("backward", || SchedulingOrder::by_key(graph, early)) {
                Some(next) if next.issue != schedule.issue => schedule = next,
                _ => break,
            }
        }
        trials
    }

    fn schedule(
        &mut self,
        name: &'static str,
        order: impl Fn() -> SchedulingOrder,
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

/// A complete placement, except for addresses.
pub(super) struct PlacementCandidate {
    /// Cycles, elements and transfers.
    pub(super) draft: ScheduleDraft,
    /// The entry that keeps each assignment, if the machine computes it.
    pub(super) homes: Vec<Option<Entry>>,
    /// The buffer word of each node that needs one.
    pub(super) buffers: Vec<Option<BufferWord>>,
    /// The name of its order.
    pub(super) order: &'static str,
    /// Smaller is better: cycles above the bound, in steps of 1/4096 of it;
    /// the deepest buffer; cycles.
    cost: (u32, u32, u32),
}

impl PlacementCandidate {
    fn new(
        task: &Task<'_>,
        order: &'static str,
        mut draft: ScheduleDraft,
    ) -> Result<PlacementCandidate, Stuck> {
        let homes = homes::settle_homes(task.function, task.graph, &mut draft)?;
        draft.locations.drop_unread();
        let buffers = addresses::allocate_buffers(task.graph, &draft);
        let used = buffers.iter().flatten().max();
        let depth = used.map_or(0, |word| word.number() + 1);
        let above = draft.cycles - task.target;
        Ok(PlacementCandidate {
            cost: (above / (task.target / 4096 + 1), depth, above),
            draft,
            homes,
            buffers,
            order,
        })
    }
}
