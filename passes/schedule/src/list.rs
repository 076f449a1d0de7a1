//! List scheduling without memories: the length of the schedule for an order.
//!
//! It takes a fraction of the time of the placement sweep, so orders are tried
//! with it. It also runs from the end of the program backwards; the issue
//! cycles of such a schedule are in turn an order, which takes into account
//! scarce elements late in the program as no longest path can.

use super::graph::{DependenceGraph, HOST};
use super::order::SchedulingOrder;
use super::ready::ReadyNodes;
use robovec_ir::Function;

/// A schedule without memories.
#[derive(Clone, Debug)]
pub(super) struct ListSchedule {
    /// Cycle of issue of each node, from 0; counted from the end when
    /// scheduled backwards (0 is then the end of the program).
    pub(super) issue: Vec<u32>,
    /// Length in cycles.
    pub(super) cycles: u32,
}

/// Schedules from the start; operations wait for their operands.
pub(super) fn forward(graph: &DependenceGraph, order: &SchedulingOrder) -> ListSchedule {
    let mut run = ListScheduler::new(
        graph,
        order,
        graph.computed_operands.iter().map(|&n| n.into()),
    );
    for node in 0..graph.kind.len() {
        if graph.kind[node] != HOST && graph.computed_operands[node] == 0 {
            run.ready.calendar.enter(0, node as u32);
        }
    }
    run.sweep(|run, node, cycle| {
        let ready = cycle + graph.weight(node);
        run.cycles = run.cycles.max(ready);
        for &user in graph.users_of(node) {
            run.satisfied(user as usize, ready, 0);
        }
    })
}

/// Schedules from the end; operations wait for their readers.
pub(super) fn backward(
    graph: &DependenceGraph,
    function: &Function,
    order: &SchedulingOrder,
) -> ListSchedule {
    let readers = (0..graph.kind.len()).map(|node| graph.users_of(node).len() as u32);
    let mut run = ListScheduler::new(graph, order, readers);
    for node in 0..graph.kind.len() {
        if graph.kind[node] != HOST && graph.users_of(node).is_empty() {
            run.ready.calendar.enter(graph.weight(node), node as u32);
        }
    }
    run.sweep(|run, node, cycle| {
        run.cycles = run.cycles.max(cycle);
        let nodes = function.nodes();
        for value in nodes[node]
            .operands()
            .iter()
            .filter_map(|read| read.value())
        {
            let operand = value.index();
            if graph.kind[operand] != HOST {
                run.satisfied(operand, cycle, graph.weight(operand));
            }
        }
    })
}

struct ListScheduler<'a> {
    graph: &'a DependenceGraph,
    order: &'a SchedulingOrder,
    waits_for: Vec<u32>,
    issue: Vec<u32>,
    ready: ReadyNodes,
    cycles: u32,
}

impl<'a> ListScheduler<'a> {
    fn new(
        graph: &'a DependenceGraph,
        order: &'a SchedulingOrder,
        waits_for: impl Iterator<Item = u32>,
    ) -> ListScheduler<'a> {
        ListScheduler {
            graph,
            order,
            waits_for: waits_for.collect(),
            issue: vec![0; graph.kind.len()],
            ready: ReadyNodes::new(order, graph.largest_weight()),
            cycles: 0,
        }
    }

    /// One operand of the node is available from a cycle on; after the last
    /// one, the node enters the calendar. Until a node is issued, `issue` holds
    /// the latest such cycle.
    fn satisfied(&mut self, node: usize, from: u32, delay: u32) {
        self.issue[node] = self.issue[node].max(from);
        self.waits_for[node] -= 1;
        if self.waits_for[node] == 0 {
            self.ready
                .calendar
                .enter(self.issue[node] + delay, node as u32);
        }
    }

    fn sweep(mut self, mut issued: impl FnMut(&mut ListScheduler<'a>, usize, u32)) -> ListSchedule {
        let graph = self.graph;
        let order = self.order;
        let mut cycle = 0;
        while let Some(next) = self.ready.advance(graph, order, cycle) {
            for (kind, nodes) in order.nodes.iter().enumerate() {
                for _ in 0..graph.kinds[kind].count {
                    let Some(rank) = self.ready.sets[kind].next_from(0) else {
                        break;
                    };
                    self.ready.sets[kind].remove(rank);
                    let node = nodes[rank as usize] as usize;
                    self.issue[node] = next;
                    issued(&mut self, node, next);
                }
            }
            cycle = next + 1;
        }
        debug_assert!(
            (graph.kind.iter().zip(&self.waits_for))
                .all(|(&kind, &waits_for)| kind == HOST || waits_for == 0),
            "every operation was issued"
        );
        ListSchedule {
            issue: self.issue,
            cycles: self.cycles,
        }
    }
}
