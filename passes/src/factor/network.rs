//! The function as a network of n-ary sums and products.
//!
//! **Invariants.** A node's value never changes, only its computation does, so
//! that its users need not be changed. No two live nodes have values that are
//! equal or opposite: a value that is made is looked up by its fingerprint
//! first. Operands are at lower positions than their user, which keeps the
//! network free of cycles. `uses` counts reads by live nodes and by outputs; a
//! node without uses does not count its operands, so `cost` is the number of
//! operations on which the outputs depend.

use crate::sums::terms::cancel;
use crate::sums::values::ValueTable;
use robovec_framework::fingerprint::{Fingerprint, Images};
use robovec_ir::{Name, Operand, Operation, SourceSet, Symbol};
use robovec_num::arithmetic::Arithmetic;

/// A node with a sign: reading it may negate it for nothing.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct Edge(u32);

impl Edge {
    pub(crate) fn new(node: u32, negative: bool) -> Edge {
        Edge(node << 1 | u32::from(negative))
    }

    pub(crate) fn node(self) -> usize {
        (self.0 >> 1) as usize
    }

    pub(crate) fn negative(self) -> bool {
        self.0 & 1 == 1
    }

    pub(crate) fn flip(self, flip: bool) -> Edge {
        Edge(self.0 ^ u32::from(flip))
    }
}

/// The operation or leaf that a node is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum FactorKind {
    /// An input element.
    Input(Operand),
    /// A literal.
    Constant(f64),
    /// The signed sum of its operands.
    Sum,
    /// The product of its operands.
    Product,
    /// Any other operation, or one on a value that is not defined.
    Other(Operation),
    /// Absorbed: it is part of this node.
    Part(u32),
}

/// A value and one way to compute it.
#[derive(Clone, Debug)]
pub(crate) struct FactorNode {
    pub(crate) kind: FactorKind,
    pub(crate) operands: Vec<Edge>,
    pub(crate) uses: u32,
    /// False for a value without a meaning, such as a quotient by zero, and for
    /// all that depends on it: unchanged, and equal to no other value.
    pub(crate) defined: bool,
    /// Greater than those of the operands.
    pub(crate) position: u64,
    /// [`Name::NONE`] for a value the pass made.
    pub(crate) name: Name,
    /// The symbol with which derived names start.
    pub(crate) owner: Symbol,
    pub(crate) sources: SourceSet,
    /// The rule that made or rewrote it, for the trail.
    pub(crate) rule: Option<&'static str>,
}

/// Names, owner and sources of a node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeOrigin {
    pub(crate) name: Name,
    pub(crate) owner: Symbol,
    pub(crate) sources: SourceSet,
}

impl NodeOrigin {
    /// Origin of nodes of the network without an equation.
    pub(crate) const NONE: NodeOrigin = NodeOrigin {
        name: Name::NONE,
        owner: Name::NONE.base,
        sources: SourceSet::EMPTY,
    };
}

#[derive(Clone)]
pub(crate) struct FactorNetwork {
    /// By node; those of live nodes with a meaning can be found.
    pub(crate) values: ValueTable,
    pub(crate) nodes: Vec<FactorNode>,
    /// The edges that the outputs are set to.
    pub(crate) outputs: Vec<Edge>,
    /// Operations that the outputs need.
    pub(crate) cost: i64,
    /// Places and names of values that are part of others now.
    pub(crate) merged: Vec<(u32, NodeOrigin)>,
}

/// The node of the literal 0.
pub(crate) const ZERO: usize = 0;
/// The node of the literal 1.
pub(crate) const ONE: usize = 1;
/// The distance of positions after [`FactorNetwork::renumber`]: this number of
/// values can be made between two neighbours.
const SPACING: u64 = 1 << 20;

impl FactorNetwork {
    pub(crate) fn new(images: Images) -> FactorNetwork {
        let mut network = FactorNetwork {
            values: ValueTable::new(images),
            nodes: Vec::new(),
            outputs: Vec::new(),
            cost: 0,
            merged: Vec::new(),
        };
        for (place, number) in [(ZERO, 0.0), (ONE, 1.0)] {
            let edge = network.constant(number);
            assert_eq!(edge.node(), place, "the literals 0 and 1 come first");
        }
        network
    }

    pub(crate) fn constant(&mut self, number: f64) -> Edge {
        let value = self.values.images.literal(number);
        if value.is_undefined() {
            let value = self.values.images.random(!(self.nodes.len() as u64));
            return self.push_unknown(
                FactorKind::Constant(number),
                Vec::new(),
                value,
                NodeOrigin::NONE,
            );
        }
        let kind = FactorKind::Constant(number);
        self.find_or_push(kind, Vec::new(), value, NodeOrigin::NONE)
    }

    /// The node with this value, made if there is none.
    pub(crate) fn find_or_push(
        &mut self,
        kind: FactorKind,
        operands: Vec<Edge>,
        value: Fingerprint,
        origin: NodeOrigin,
    ) -> Edge {
        match self.find(value) {
            Some(edge) => edge,
            None => self.push(kind, operands, value, origin),
        }
    }

    /// The node with this value, with the sign that makes it equal.
    pub(crate) fn find(&self, value: Fingerprint) -> Option<Edge> {
        let (node, negative) = self.values.find(value)?;
        Some(Edge::new(node, negative))
    }

    pub(crate) fn value(&self, edge: Edge) -> Fingerprint {
        let value = self.values.value(edge.node());
        self.values.images.negate_if(edge.negative(), value)
    }

    /// Appends a node that can be found by its value.
    pub(crate) fn push(
        &mut self,
        kind: FactorKind,
        operands: Vec<Edge>,
        value: Fingerprint,
        origin: NodeOrigin,
    ) -> Edge {
        let edge = self.push_unknown(kind, operands, value, origin);
        self.nodes[edge.node()].defined = true;
        self.values.remember(edge.node() as u32);
        edge
    }

    /// Appends a node that is equal to nothing.
    pub(crate) fn push_unknown(
        &mut self,
        kind: FactorKind,
        operands: Vec<Edge>,
        value: Fingerprint,
        origin: NodeOrigin,
    ) -> Edge {
        let position = operands
            .iter()
            .map(|edge| self.nodes[edge.node()].position + 1)
            .fold(0, u64::max);
        self.nodes.push(FactorNode {
            kind,
            operands,
            uses: 0,
            defined: false,
            position,
            name: origin.name,
            owner: origin.owner,
            sources: origin.sources,
            rule: None,
        });
        let edge = Edge::new(self.values.push(value), false);
        assert_eq!(edge.node() + 1, self.nodes.len(), "every node has a value");
        edge
    }

    /// The sum of some terms: a known value if there is one.
    pub(crate) fn sum(&mut self, terms: &[Edge], origin: NodeOrigin) -> Edge {
        let value = self
            .values
            .images
            .sum(terms.iter().map(|&term| self.value(term)));
        if let Some(edge) = self.find(value) {
            return edge;
        }
        let mut operands = terms.to_vec();
        tidy(&mut operands);
        match operands[..] {
            [single] => single,
            _ => self.push(FactorKind::Sum, operands, value, origin),
        }
    }

    /// The product of some factors: a known value if there is one.
    pub(crate) fn product(&mut self, factors: &[Edge], origin: NodeOrigin) -> Edge {
        let values = factors.iter().map(|&factor| self.value(factor));
        let value = self.values.images.product(values);
        if let Some(edge) = self.find(value) {
            return edge;
        }
        let negative = factors.iter().filter(|edge| edge.negative()).count() % 2 == 1;
        let mut operands: Vec<Edge> = factors
            .iter()
            .map(|edge| edge.flip(edge.negative()))
            .filter(|edge| edge.node() != ONE)
            .collect();
        operands.sort_unstable();
        match operands[..] {
            [single] => single.flip(negative),
            _ => {
                let value = self.values.images.negate_if(negative, value);
                self.push(FactorKind::Product, operands, value, origin)
                    .flip(negative)
            }
        }
    }

    /// The cost of a node while it is used.
    fn own_cost(&self, node: usize) -> i64 {
        match self.nodes[node].kind {
            FactorKind::Input(_) | FactorKind::Constant(_) | FactorKind::Part(_) => 0,
            FactorKind::Sum | FactorKind::Product => self.nodes[node].operands.len() as i64 - 1,
            FactorKind::Other(Operation::Sin | Operation::Cos) => 0,
            FactorKind::Other(_) => 1,
        }
    }

    /// One more read of a node.
    pub(crate) fn acquire(&mut self, edge: Edge) {
        let mut open = vec![edge.node()];
        while let Some(node) = open.pop() {
            self.nodes[node].uses += 1;
            if self.nodes[node].uses == 1 {
                self.cost += self.own_cost(node);
                open.extend(self.nodes[node].operands.iter().map(|edge| edge.node()));
            }
        }
    }

    /// One read of a node less.
    pub(crate) fn release(&mut self, edge: Edge) {
        let mut open = vec![edge.node()];
        while let Some(node) = open.pop() {
            self.nodes[node].uses -= 1;
            if self.nodes[node].uses == 0 {
                self.cost -= self.own_cost(node);
                open.extend(self.nodes[node].operands.iter().map(|edge| edge.node()));
            }
        }
    }

    /// Replaces the computation of a live sum or product; returns the old one.
    /// The operands must give the same value and are at lower positions.
    pub(crate) fn replace(
        &mut self,
        node: usize,
        kind: FactorKind,
        operands: Vec<Edge>,
    ) -> (FactorKind, Vec<Edge>) {
        debug_assert!(
            self.below(&operands, self.nodes[node].position),
            "operands have lower positions"
        );
        for &edge in &operands {
            self.acquire(edge);
        }
        self.cost -= self.own_cost(node);
        let old_kind = std::mem::replace(&mut self.nodes[node].kind, kind);
        let old = std::mem::replace(&mut self.nodes[node].operands, operands);
        self.cost += self.own_cost(node);
        for &edge in &old {
            self.release(edge);
        }
        (old_kind, old)
    }

    /// True when all these are below a position.
    pub(crate) fn below(&self, edges: &[Edge], position: u64) -> bool {
        edges
            .iter()
            .all(|edge| self.nodes[edge.node()].position < position)
    }

    /// The live nodes, operands before users, in an order that follows the
    /// program's where it can.
    pub(crate) fn order(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.nodes.len() as u32)
            .filter(|&node| self.nodes[node as usize].uses > 0)
            .collect();
        order.sort_by_key(|&node| (self.nodes[node as usize].position, node));
        debug_assert!(
            order.iter().all(|&node| {
                let node = &self.nodes[node as usize];
                self.below(&node.operands, node.position)
            }),
            "operands have lower positions than their users"
        );
        order
    }

    /// Spreads positions in the present order, so that there are gaps between
    /// them, and drops unused values.
    pub(crate) fn renumber(&mut self) -> Vec<u32> {
        let order = self.order();
        for (rank, &node) in order.iter().enumerate() {
            self.nodes[node as usize].position = (rank as u64 + 3) * SPACING;
        }
        for node in [ZERO, ONE] {
            self.nodes[node].position = node as u64;
        }
        self.forget_unused(&order);
        order
    }

    /// Forgets the values of all nodes but these, given in order, and of the
    /// literals 0 and 1.
    pub(crate) fn forget_unused(&mut self, order: &[u32]) {
        self.values.forget_all();
        for &node in [ZERO as u32, ONE as u32].iter().chain(order) {
            self.values.remember(node);
        }
    }

    /// Makes sums and products as large as possible: an operand of the same
    /// kind without another user becomes part of its user.
    pub(crate) fn regroup(&mut self, order: &[u32]) {
        for &user in order {
            let user = user as usize;
            let kind = self.nodes[user].kind;
            if !matches!(kind, FactorKind::Sum | FactorKind::Product) || self.nodes[user].uses == 0
            {
                continue;
            }
            let part = |network: &FactorNetwork, edge: Edge| {
                let node = &network.nodes[edge.node()];
                node.kind == kind && node.uses == 1
            };
            while let Some(at) = self.nodes[user]
                .operands
                .iter()
                .position(|&edge| part(self, edge))
            {
                let edge = self.nodes[user].operands.swap_remove(at);
                let inner = &mut self.nodes[edge.node()];
                inner.uses = 0;
                inner.kind = FactorKind::Part(user as u32);
                let origin = NodeOrigin {
                    name: inner.name,
                    owner: inner.owner,
                    sources: inner.sources,
                };
                let parts = std::mem::take(&mut inner.operands);
                self.values.forget(edge.node() as u32);
                self.merged.push((user as u32, origin));
                // A minus reaches all terms of a sum, but one factor only.
                let flipped = if kind == FactorKind::Sum {
                    parts.len()
                } else {
                    1
                };
                let parts = parts.iter().enumerate();
                self.nodes[user]
                    .operands
                    .extend(parts.map(|(at, part)| part.flip(edge.negative() && at < flipped)));
            }
            self.tidy(user);
        }
    }

    /// The node that a node has become part of, or the node itself.
    pub(crate) fn heir(&self, node: u32) -> u32 {
        let mut heir = node;
        while let FactorKind::Part(user) = self.nodes[heir as usize].kind {
            heir = user;
        }
        heir
    }

    /// Sorts the operands of a sum or product; terms that cancel go.
    fn tidy(&mut self, node: usize) {
        let mut operands = self.nodes[node].operands.clone();
        if self.nodes[node].kind == FactorKind::Sum {
            tidy(&mut operands);
        }
        if operands.len() == self.nodes[node].operands.len() {
            self.nodes[node].operands.sort_unstable();
        } else if operands.len() > 1 {
            self.replace(node, FactorKind::Sum, operands);
        }
    }
}

/// Removes pairs of a term and its negation, and zeros; sorts the rest.
pub(super) fn tidy(terms: &mut Vec<Edge>) {
    terms.retain(|edge| edge.node() != ZERO);
    cancel(terms, |edge| edge.flip(true));
}
