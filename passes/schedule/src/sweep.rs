//! The placement sweep: cycle by cycle, best operation first, each on the
//! element that suits it, with every transfer reserved.
//!
//! Invariants. An operation is issued only when all operands can be read: every
//! entry it uses was written in an earlier cycle. Reservations are never taken
//! back. An operation that finds no element is tried again after a wait that
//! doubles with each failure, so that the work stays proportional to the
//! operations for any load of the ports.

use super::choice::IssueDecision;
use super::graph::HOST;
use super::order::SchedulingOrder;
use super::state::{IssueOutcome, LONGEST_PAUSE, Manner, ScheduleDraft, Stuck, Sweep, Task};

/// Places every operation in the given order.
///
/// # Errors
///
/// [`Stuck`] when the machine has no buffers or small ones and the choices left
/// an operand without a path; with [`Manner::Ahead`], only when memories take
/// no writes at all.
pub(super) fn sweep(
    task: Task<'_>,
    order: &SchedulingOrder,
    manner: Manner,
) -> Result<ScheduleDraft, Stuck> {
    let mut sweep = Sweep::new(task, order, manner);
    sweep.run()?;
    Ok(sweep.draft)
}

impl Sweep<'_> {
    fn run(&mut self) -> Result<(), Stuck> {
        for node in 0..self.task.graph.kind.len() {
            if self.task.graph.kind[node] != HOST && self.waiting[node].operands == 0 {
                self.ready.calendar.enter(0, node as u32);
            }
        }
        let travel = self.draft.ports.longest_travel();
        let patience = 4 * (self.task.graph.largest_weight() + travel + LONGEST_PAUSE);
        let mut cycle = 0;
        while let Some(next) = self.ready.advance(self.task.graph, self.order, cycle) {
            cycle = next;
            self.draft.ports.reach(cycle);
            for kind in 0..self.task.graph.kinds.len() {
                self.issue_kind(kind, cycle)?;
            }
            if cycle > self.last_issue + patience {
                return Err(Stuck);
            }
            cycle += 1;
        }
        Ok(())
    }

    /// Issues as many operations as the elements of one kind can take in one
    /// cycle: first those that need no buffer or cannot wait, then, on elements
    /// still free, the rest.
    fn issue_kind(&mut self, kind: usize, cycle: u32) -> Result<(), Stuck> {
        let mut free = self.task.graph.kinds[kind].count;
        let tries = 8 * free + 64;
        for picky in [true, false] {
            self.picky = picky;
            let (mut tries_left, mut waiting, mut rank) = (tries, 0, 0);
            while free > 0 && tries_left > 0 {
                let Some(next) = self.ready.sets[kind].next_from(rank) else {
                    break;
                };
                rank = next + 1;
                let node = self.order.nodes[kind][next as usize] as usize;
                match self.issue(node, cycle) {
                    IssueOutcome::Issued => {
                        self.ready.sets[kind].remove(next);
                        free -= 1;
                    }
                    IssueOutcome::Waits => {
                        waiting += 1;
                        tries_left -= 1;
                    }
                    IssueOutcome::Failed => {
                        self.ready.sets[kind].remove(next);
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
            self.ready.calendar.enter(cycle + 1, node as u32);
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
        self.ready.calendar.enter(cycle + pause, node as u32);
        Ok(())
    }
}
