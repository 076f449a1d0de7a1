//! A length no schedule can beat.
//!
//! Every operation `i` has a *head* `r` (no schedule issues it before cycle
//! `r`) and a *tail* `q` (from its issue, no schedule ends in less than `q`
//! cycles), both longest paths. Forget everything else but the number `N` of
//! elements of one kind: what remains is to put unit tasks with releases `r`
//! on `N` machines so that the latest of `issue + q` is least. Since the
//! tasks are of unit length and the releases whole numbers, taking the
//! released task with the largest tail first (Jackson's rule) is optimal, and
//! by Hall's condition on intervals its result is exactly
//!
//! > max over r, q of  r + ceil(|{i: head >= r, tail >= q}| / N) - 1 + q
//!
//! so that one sweep finds the best of all pairs of thresholds. Whole
//! numbers throughout: the bound is proved, not estimated.

use super::graph::Graph;
use super::order::Order;
use super::ready::RankSet;

/// The longest chain, or the bound of the scarcest kind if that is larger.
pub(super) fn lower_bound(graph: &Graph) -> u32 {
    let by_tail = Order::by_key(graph, |node| u64::from(graph.path - graph.tail[node]));
    (0..graph.kinds.len())
        .map(|kind| kind_bound(graph, &by_tail, kind))
        .fold(graph.path, u32::max)
}

fn kind_bound(graph: &Graph, by_tail: &Order, kind: usize) -> u32 {
    let ranked = &by_tail.nodes[kind];
    let mut released = ranked.clone();
    released.sort_unstable_by_key(|&node| graph.head[node as usize]);
    let mut released = released.into_iter().peekable();
    let mut waiting = RankSet::new(ranked.len());
    let mut cycle = 0;
    let mut bound = 0;
    loop {
        if waiting.is_empty() {
            match released.peek() {
                Some(&next) => cycle = cycle.max(graph.head[next as usize]),
                None => return bound,
            }
        }
        while let Some(node) = released.next_if(|&node| graph.head[node as usize] <= cycle) {
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
