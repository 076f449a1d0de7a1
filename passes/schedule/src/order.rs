//! Priorities: which of the operations that could be issued goes first.

use super::graph::{DependenceGraph, HOST};
use robovec_framework::option_words;
use robovec_num::radix;
use serde::{Deserialize, Serialize};

option_words! {
    /// Rank of the operations in list scheduling (thesis 2.2 and 2.3.1).
    #[derive(Default, PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Priority {
        /// [`Priority::FanOut`]; where its schedule is longer than the bound
        /// and the program small enough, also [`Priority::Alap`], orders
        /// between it and program order, and those that schedules from the
        /// end backwards suggest: the shortest is kept.
        #[default]
        Best = "best",
        /// The thesis' "classical" order: ALAPCycle, then ASAPCycle.
        Alap = "alap",
        /// ALAPCycle, then the operation with more readers.
        FanOut = "fan-out",
        /// Least mobility (ALAPCycle minus ASAPCycle), then ALAPCycle.
        Mobility = "mobility",
    }
}

/// The operations of each kind of element, ranked.
#[derive(Clone, Debug)]
pub(super) struct SchedulingOrder {
    /// The rank of each node among those of its kind, from 0; meaningless
    /// for nodes of the host.
    pub(super) rank: Vec<u32>,
    /// For each kind, the nodes in order of rank.
    pub(super) nodes: Vec<Vec<u32>>,
}

impl SchedulingOrder {
    /// Ranks by a key, smallest first; equal keys keep program order.
    pub(super) fn by_key(graph: &DependenceGraph, key: impl Fn(usize) -> u64) -> SchedulingOrder {
        SchedulingOrder::by_pair(
            graph,
            |node| (key(node) >> 32) as u32,
            |node| key(node) as u32,
        )
    }

    /// Ranks by two keys, the second one among equals; equal pairs keep
    /// program order.
    fn by_pair(
        graph: &DependenceGraph,
        first: impl Fn(usize) -> u32,
        second: impl Fn(usize) -> u32,
    ) -> SchedulingOrder {
        let mut rank = vec![0; graph.kind.len()];
        let mut nodes = vec![Vec::new(); graph.kinds.len()];
        for (node, &kind) in graph.kind.iter().enumerate() {
            if kind != HOST {
                nodes[usize::from(kind)].push(node as u32);
            }
        }
        for ranked in &mut nodes {
            // By the second key first: sorting is stable.
            radix::sort_by_key(ranked, |node| second(node as usize));
            radix::sort_by_key(ranked, |node| first(node as usize));
            for (place, &node) in ranked.iter().enumerate() {
                rank[node as usize] = place as u32;
            }
        }
        assert!(
            graph.kinds.len() <= HOST as usize,
            "the host is none of the kinds"
        );
        SchedulingOrder { rank, nodes }
    }

    /// ALAPCycle, then ASAPCycle. Within a kind all weights are equal, so
    /// the times of issue order like the times of completion.
    pub(super) fn alap(graph: &DependenceGraph) -> SchedulingOrder {
        SchedulingOrder::by_pair(graph, |node| graph.latest(node), |node| graph.head[node])
    }

    /// Mobility, then ALAPCycle.
    pub(super) fn mobility(graph: &DependenceGraph) -> SchedulingOrder {
        SchedulingOrder::by_pair(
            graph,
            |node| graph.latest(node) - graph.head[node],
            |node| graph.latest(node),
        )
    }

    /// ALAPCycle, then the number of readers, most first.
    pub(super) fn fan_out(graph: &DependenceGraph) -> SchedulingOrder {
        SchedulingOrder::by_pair(
            graph,
            |node| graph.latest(node),
            |node| u32::MAX - graph.user_count(node),
        )
    }
}

impl SchedulingOrder {
    /// ALAPCycle plus `share / 64` of the place in program order, both on the
    /// scale of the longest chain.
    ///
    /// Pure ALAPCycle does all of one stage before the next; where stages
    /// consist of additions or of products mostly, the other elements idle. The
    /// program as written follows the stages of one body after the other, so
    /// that a bias towards it mixes the kinds.
    pub(super) fn towards_program(graph: &DependenceGraph, share: u64) -> SchedulingOrder {
        let nodes = graph.kind.len().max(1) as u64;
        SchedulingOrder::by_key(graph, |node| {
            let place = node as u64 * u64::from(graph.path) / nodes;
            u64::from(graph.latest(node)) * 64 + place * share
        })
    }
}
