//! When the values of a network are available, and how late they may be.
//!
//! A sum or product is taken as the tree that combines the two earliest
//! operands first, as `balance` builds it. The latest time of an operand is
//! that of the result less the operations above it in that tree: if every
//! operand were that late, the result would still be in time.

use super::network::{Edge, FactorKind, FactorNetwork};
use robovec_analysis::critical_path::Weights;
use robovec_ir::Operation;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Times in cycles of the machine, by node.
pub(super) struct NodeTimes {
    weights: Weights,
    arrivals: Vec<u32>,
    latest: Vec<u32>,
}

impl NodeTimes {
    /// The times of the live nodes, given in order; no output may be later
    /// than `limit`, or, without one, than the last is now.
    pub(super) fn find(
        network: &FactorNetwork,
        order: &[u32],
        weights: Weights,
        limit: Option<u32>,
    ) -> NodeTimes {
        let count = network.nodes.len();
        let mut times = NodeTimes {
            weights,
            arrivals: vec![0; count],
            latest: vec![u32::MAX; count],
        };
        for &node in order {
            let node = node as usize;
            times.arrivals[node] = times.result(network, node);
        }
        let limit = limit.unwrap_or_else(|| times.longest(network));
        for edge in &network.outputs {
            times.latest[edge.node()] = limit;
        }
        for &node in order.iter().rev() {
            times.hand_down(network, node as usize);
        }
        times
    }

    /// When the last output is available.
    pub(super) fn longest(&self, network: &FactorNetwork) -> u32 {
        let arrivals = network
            .outputs
            .iter()
            .map(|edge| self.arrivals[edge.node()]);
        arrivals.max().unwrap_or(0)
    }

    /// True when a node may be computed from these operands in this way.
    pub(super) fn allow(
        &mut self,
        network: &FactorNetwork,
        node: usize,
        kind: FactorKind,
        operands: &[Edge],
    ) -> bool {
        self.extend(network);
        self.tree(kind, operands).0 <= self.latest[node]
    }

    /// Takes note of rewritten nodes, and of the values from `first` on that
    /// were made for them.
    pub(super) fn update(&mut self, network: &FactorNetwork, rewritten: &[usize], first: usize) {
        self.extend(network);
        for &node in rewritten {
            self.arrivals[node] = self.result(network, node);
            self.hand_down(network, node);
        }
        for node in (first..network.nodes.len()).rev() {
            if network.nodes[node].uses > 0 {
                self.hand_down(network, node);
            }
        }
    }

    /// Arrivals of the values made since.
    fn extend(&mut self, network: &FactorNetwork) {
        for node in self.arrivals.len()..network.nodes.len() {
            let arrival = self.result(network, node);
            self.arrivals.push(arrival);
            self.latest.push(u32::MAX);
        }
    }

    fn result(&self, network: &FactorNetwork, node: usize) -> u32 {
        let node = &network.nodes[node];
        self.tree(node.kind, &node.operands).0
    }

    fn hand_down(&mut self, network: &FactorNetwork, node: usize) {
        let (kind, operands) = (network.nodes[node].kind, &network.nodes[node].operands);
        let (_, above) = self.tree(kind, operands);
        for (edge, above) in operands.iter().zip(above) {
            let latest = self.latest[node].saturating_sub(above);
            let own = &mut self.latest[edge.node()];
            *own = latest.min(*own);
        }
    }

    /// When a result is available, and how many cycles of work lie above each
    /// operand.
    fn tree(&self, kind: FactorKind, operands: &[Edge]) -> (u32, Vec<u32>) {
        let weight = match kind {
            FactorKind::Sum => self.weights.of(Operation::Add),
            FactorKind::Product => self.weights.of(Operation::Mul),
            FactorKind::Other(operation) => {
                let weight = self.weights.of(operation);
                let arrivals = operands.iter().map(|edge| self.arrivals[edge.node()]);
                let ready = arrivals.max().unwrap_or(0).saturating_add(weight);
                return (ready, vec![weight; operands.len()]);
            }
            FactorKind::Input(_) | FactorKind::Constant(_) | FactorKind::Part(_) => {
                return (0, Vec::new());
            }
        };
        let count = operands.len();
        let mut heap: BinaryHeap<Reverse<(u32, usize)>> = operands
            .iter()
            .enumerate()
            .map(|(place, edge)| Reverse((self.arrivals[edge.node()], place)))
            .collect();
        let mut parents: Vec<usize> = vec![usize::MAX; count];
        while let (Some(Reverse(a)), Some(Reverse(b))) = (heap.pop(), heap.pop()) {
            let joined = parents.len();
            parents.push(usize::MAX);
            parents[a.1] = joined;
            parents[b.1] = joined;
            if heap.is_empty() {
                let mut above = vec![0; parents.len()];
                for place in (0..joined).rev() {
                    above[place] = above[parents[place]] + weight;
                }
                above.truncate(count);
                return (b.0.saturating_add(weight), above);
            }
            heap.push(Reverse((b.0.saturating_add(weight), joined)));
        }
        // A single operand is passed on.
        let arrivals = operands.iter().map(|edge| self.arrivals[edge.node()]);
        (arrivals.max().unwrap_or(0), vec![0; count])
    }
}
