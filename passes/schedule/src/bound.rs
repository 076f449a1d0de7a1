//! A length no schedule can beat.
//!
//! Every operation `i` has a *head* `r` (no schedule issues it before cycle
//! `r`) and a *tail* `q` (from its issue, no schedule ends in less than `q`
//! cycles), both longest paths. All constraints except the number `N` of
//! elements of one kind are relaxed: unit tasks with releases `r` are put on
//! `N` machines so that the latest of `issue + q` is least. Since the tasks are
//! of unit length and the releases whole numbers, taking the released task with
//! the largest tail first (Jackson's rule) is optimal, and by Hall's condition
//! on intervals its result is exactly
//!
//! > max over r, q of  r + ceil(|{i: head >= r, tail >= q}| / N) - 1 + q
//!
//! so that one sweep finds the best of all pairs of thresholds. Whole
//! numbers throughout: the bound is proved, not estimated.

use super::graph::DependenceGraph;
use super::order::SchedulingOrder;
use super::ready::RankSet;
use robovec_num::radix;
use std::cmp::Reverse;

/// The longest chain, or the bound of the scarcest kind if that is larger.
///
/// `by_tail` is any order that puts the longest tails first.
pub(super) fn lower_bound(graph: &DependenceGraph, by_tail: &SchedulingOrder) -> u32 {
    (0..graph.kinds.len())
        .map(|kind| kind_bound(graph, by_tail, kind))
        .fold(graph.path, u32::max)
}

fn kind_bound(graph: &DependenceGraph, by_tail: &SchedulingOrder, kind: usize) -> u32 {
    let ranked = &by_tail.nodes[kind];
    debug_assert!(
        ranked.is_sorted_by_key(|&node| Reverse(graph.tail[node as usize])),
        "the order has the longest tails first"
    );
    let head = |node: u32| graph.head[node as usize];
    let mut released = ranked.clone();
    radix::sort_by_key(&mut released, head);
    let mut released = released.into_iter().peekable();
    let mut waiting = RankSet::new(ranked.len());
    let mut cycle = 0;
    let mut bound = 0;
    loop {
        if waiting.is_empty() {
            match released.peek() {
                Some(&node) => cycle = cycle.max(head(node)),
                None => return bound,
            }
        }
        while let Some(node) = released.next_if(|&node| head(node) <= cycle) {
            waiting.insert(by_tail.rank[node as usize]);
        }
        for _ in 0..graph.kinds[kind].count {
            let Some(rank) = waiting.next_from(0) else {
                break;
            };
            waiting.remove(rank);
            bound = bound.max(cycle + graph.tail[ranked[rank as usize] as usize]);
        }
        cycle += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::HOST;
    use crate::list;
    use crate::testing::{machine, random_function};
    use robovec_num::random::Random;

    /// The formula of the module's documentation, pair by pair.
    fn by_thresholds(graph: &DependenceGraph) -> u32 {
        let mut bound = graph.path;
        for (kind, description) in graph.kinds.iter().enumerate() {
            let nodes: Vec<usize> = (0..graph.kind.len())
                .filter(|&node| graph.kind[node] as usize == kind)
                .collect();
            for r in nodes.iter().map(|&node| graph.head[node]) {
                for q in nodes.iter().map(|&node| graph.tail[node]) {
                    let counts = |&&node: &&usize| graph.head[node] >= r && graph.tail[node] >= q;
                    let count = nodes.iter().filter(counts).count() as u32;
                    if count > 0 {
                        bound = bound.max(r + count.div_ceil(description.count) - 1 + q);
                    }
                }
            }
        }
        bound
    }

    /// The smallest length of any schedule without memories, by trying all
    /// shorter than `best`: operations in program order, each in every cycle
    /// that its operands and the elements allow.
    fn optimum(graph: &DependenceGraph, issue: &mut Vec<u32>, mut best: u32) -> u32 {
        let node = issue.len();
        if node == graph.kind.len() {
            let ends = issue.iter().enumerate();
            return ends
                .map(|(node, &cycle)| cycle + graph.weight(node))
                .max()
                .unwrap_or(0);
        }
        let ready = (0..node)
            .filter(|&operand| graph.users_of(operand).contains(&(node as u32)))
            .map(|operand| issue[operand] + graph.weight(operand))
            .max()
            .unwrap_or(0);
        let mut cycle = ready;
        while cycle + graph.tail[node] < best {
            let kind = graph.kind[node] as usize;
            // Nodes of the host take no part.
            if kind == usize::from(HOST) {
                issue.push(0);
                best = best.min(optimum(graph, issue, best));
                issue.pop();
                return best;
            }
            let rivals = (0..node)
                .filter(|&other| graph.kind[other] as usize == kind && issue[other] == cycle)
                .count();
            if rivals < graph.kinds[kind].count as usize {
                issue.push(cycle);
                best = best.min(optimum(graph, issue, best));
                issue.pop();
            }
            cycle += 1;
        }
        best
    }

    #[test]
    fn one_sweep_finds_the_best_pair_of_thresholds() {
        for seed in 0..60 {
            let mut random = Random::new(seed);
            let function = random_function(10 + random.below(80), 1 + random.below(30), seed);
            let adders = 1 + random.below(3) as u32;
            let graph =
                DependenceGraph::new(&function, &machine("thesis", adders, 2)).expect("it fits");
            assert_eq!(
                lower_bound(&graph, &SchedulingOrder::fan_out(&graph)),
                by_thresholds(&graph)
            );
        }
    }

    #[test]
    fn no_schedule_of_a_small_program_beats_the_bound() {
        let mut met = 0;
        for seed in 0..80 {
            let mut random = Random::new(seed);
            let function = random_function(4 + random.below(4), 1 + random.below(6), seed);
            let mut machine = machine("thesis", 1, 1);
            // Short pipelines make elements scarce in small programs.
            machine.elements[0].stages = 2;
            machine.elements[1].stages = 1;
            let graph = DependenceGraph::new(&function, &machine).expect("it fits");
            let order = SchedulingOrder::fan_out(&graph);
            let bound = lower_bound(&graph, &order);
            let reached = list::forward(&graph, &order).cycles;
            let optimum = optimum(&graph, &mut Vec::new(), reached);
            assert!(bound <= optimum && optimum <= reached);
            met += u32::from(bound == optimum);
        }
        assert!(met > 60, "the bound is met in {met} of 80");
    }
}
