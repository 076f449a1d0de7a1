//! Times at which the values of a network are available, and the latest ones
//! allowed.
//!
//! A sum or product is taken as the tree that combines the two earliest
//! operands first, as `balance` builds it. The latest time of an operand is
//! that of the result less the operations above it in that tree: if every
//! operand were that late, the result would still be in time.

use super::network::{Edge, FactorKind, FactorNetwork};
use crate::sums::earliest::{finish, levels};
use robovec_analysis::critical_path::Weights;
use robovec_ir::Operation;
use smallvec::SmallVec;

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

    /// Time at which the last output is available.
    pub(super) fn longest(&self, network: &FactorNetwork) -> u32 {
        let arrivals = network
            .outputs
            .iter()
            .map(|edge| self.arrivals[edge.node()]);
        arrivals.fold(0, u32::max)
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
        self.finish(kind, operands) <= self.latest[node]
    }

    /// Updates the times of rewritten nodes, and of the values from `first` on
    /// that were made for them.
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
        self.finish(node.kind, &node.operands)
    }

    fn hand_down(&mut self, network: &FactorNetwork, node: usize) {
        let (kind, operands) = (network.nodes[node].kind, &network.nodes[node].operands);
        let weight = self.weight(kind);
        let levels = match kind {
            FactorKind::Sum | FactorKind::Product => {
                let arrivals = operands.iter().map(|edge| self.arrivals[edge.node()]);
                levels(&arrivals.collect::<Vec<u32>>(), weight)
            }
            _ => SmallVec::from_elem(1, operands.len()),
        };
        for (edge, level) in operands.iter().zip(levels) {
            let latest = self.latest[node].saturating_sub(level * weight);
            let own = &mut self.latest[edge.node()];
            *own = latest.min(*own);
        }
    }

    fn weight(&self, kind: FactorKind) -> u32 {
        match kind {
            FactorKind::Sum => self.weights.of(Operation::Add),
            FactorKind::Product => self.weights.of(Operation::Mul),
            FactorKind::Other(operation) => self.weights.of(operation),
            FactorKind::Input(_) | FactorKind::Constant(_) | FactorKind::Part(_) => 0,
        }
    }

    /// Time at which a result is available.
    fn finish(&self, kind: FactorKind, operands: &[Edge]) -> u32 {
        let weight = self.weight(kind);
        let arrivals = operands.iter().map(|edge| self.arrivals[edge.node()]);
        match kind {
            FactorKind::Sum | FactorKind::Product => finish(arrivals, weight),
            _ => arrivals.fold(0, u32::max).saturating_add(weight),
        }
    }
}
