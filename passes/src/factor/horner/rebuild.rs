//! The network that computes polynomials by their schemes.
//!
//! A new network, in the order of the old one: a value that is found in it is
//! already there, so sharing makes no cycles.

use super::super::network::{Edge, FactorKind, FactorNetwork, NodeOrigin};
use super::polynomials::NetworkPolynomials;
use super::schemes::{Scheme, SchemeBuffers, SchemeRest, SchemeSet};
use robovec_ir::Name;

/// The name of the rule in the trail.
const RULE: &str = "horner";

/// Writes the polynomials of a network, whose live nodes are given in order,
/// with the variables in the order of their ranks.
pub(super) fn rebuild(
    old: &FactorNetwork,
    order: &[u32],
    polynomials: &NetworkPolynomials,
    set: &SchemeSet,
    ranks: &[u32],
) -> FactorNetwork {
    let mut rebuilding = Rebuilding {
        old,
        new: FactorNetwork::new(old.values.images),
        map: vec![None; old.nodes.len()],
        buffers: SchemeBuffers::default(),
    };
    let mut packed = set.polynomials.iter();
    for &node in order {
        if !polynomials.needed[node as usize] {
            continue;
        }
        let before = rebuilding.new.nodes.len();
        let edge = match polynomials.terms[node as usize] {
            Some(_) => {
                let packed = packed.next().expect("every needed polynomial is packed");
                assert_eq!(packed.node, node, "polynomials are packed in order");
                let mut scheme = Scheme::default();
                set.scheme(packed, ranks, &mut rebuilding.buffers, Some(&mut scheme));
                rebuilding.scheme(&scheme, &set.variables.nodes, node)
            }
            None => rebuilding.keep(node),
        };
        assert!(
            rebuilding.new.value(edge) == old.value(Edge::new(node, false))
                || !old.nodes[node as usize].defined,
            "a polynomial has the value of its node"
        );
        rebuilding.name(node, edge, before);
        rebuilding.map[node as usize] = Some(edge);
    }
    rebuilding.finish(&polynomials.heirs)
}

struct Rebuilding<'a> {
    old: &'a FactorNetwork,
    new: FactorNetwork,
    /// By node of the old network.
    map: Vec<Option<Edge>>,
    buffers: SchemeBuffers,
}

impl Rebuilding<'_> {
    fn mapped(&self, edge: Edge) -> Edge {
        self.map[edge.node()]
            .expect("what a needed node reads is needed")
            .flip(edge.negative())
    }

    /// Computes a node in its original form.
    fn keep(&mut self, node: u32) -> Edge {
        let own = &self.old.nodes[node as usize];
        let operands: Vec<Edge> = own.operands.iter().map(|&edge| self.mapped(edge)).collect();
        let origin = unnamed(self.old, node);
        let value = self.old.value(Edge::new(node, false));
        match own.kind {
            FactorKind::Constant(number) => self.new.constant(number),
            FactorKind::Sum => self.new.sum(&operands, origin),
            FactorKind::Product => self.new.product(&operands, origin),
            kind if own.defined => self.new.find_or_push(kind, operands, value, origin),
            kind => self.new.push_unknown(kind, operands, value, origin),
        }
    }

    /// Computes a polynomial: with schemes taken from the end, parts precede
    /// the schemes that contain them.
    fn scheme(&mut self, scheme: &Scheme, variables: &[u32], node: u32) -> Edge {
        let origin = unnamed(self.old, node);
        let mut edges = vec![Edge::new(0, false); scheme.parts.len()];
        for (place, part) in scheme.parts.iter().enumerate().rev() {
            let mut factors = Vec::new();
            let (start, end) = part.common;
            for &(variable, exponent) in &scheme.powers[start as usize..end as usize] {
                let variable = self.mapped(Edge::new(variables[variable as usize], false));
                factors.push(self.power(variable, exponent, origin));
            }
            let rest = match part.rest {
                SchemeRest::Number(number) => self.new.constant(number as f64),
                SchemeRest::Sum(sides) => {
                    let terms = sides.map(|side| edges[side as usize]);
                    self.new.sum(&terms, origin)
                }
            };
            factors.push(rest);
            edges[place] = self.new.product(&factors, origin);
        }
        edges[0]
    }

    /// A power, by squares that others can share.
    fn power(&mut self, base: Edge, exponent: u32, origin: NodeOrigin) -> Edge {
        let mut power = base;
        let top = u32::BITS - 1 - exponent.leading_zeros();
        for bit in (0..top).rev() {
            power = self.new.product(&[power, power], origin);
            if exponent >> bit & 1 == 1 {
                power = self.new.product(&[power, base], origin);
            }
        }
        power
    }

    /// Gives a value its original name; `before` nodes existed when it was
    /// searched for.
    fn name(&mut self, node: u32, edge: Edge, before: usize) {
        let own = &self.old.nodes[node as usize];
        let origin = NodeOrigin {
            name: own.name,
            ..unnamed(self.old, node)
        };
        if edge.node() < before {
            self.new.merged.push((edge.node() as u32, origin));
            return;
        }
        let new = &mut self.new.nodes[edge.node()];
        (new.name, new.owner, new.sources) = (origin.name, origin.owner, origin.sources);
        new.rule = own.rule;
        if matches!(own.kind, FactorKind::Sum | FactorKind::Product) {
            new.rule.get_or_insert(RULE);
        }
    }

    /// Connects the outputs; nodes absorbed by others give them their names.
    fn finish(mut self, heirs: &[u32]) -> FactorNetwork {
        // A node stands above what was taken into it.
        let mut targets = self.map.clone();
        let mut nodes: Vec<usize> = (0..heirs.len()).collect();
        nodes.sort_by_key(|&node| std::cmp::Reverse(self.old.nodes[node].position));
        for node in nodes {
            if targets[node].is_none() {
                targets[node] = targets[heirs[node] as usize];
                if let Some(target) = targets[node] {
                    let origin = NodeOrigin {
                        name: self.old.nodes[node].name,
                        ..unnamed(self.old, node as u32)
                    };
                    self.new.merged.push((target.node() as u32, origin));
                }
            }
        }
        for &(user, origin) in &self.old.merged {
            let user = self.old.heir(user);
            if let Some(target) = targets[user as usize] {
                self.new.merged.push((target.node() as u32, origin));
            }
        }
        let outputs: Vec<Edge> = self
            .old
            .outputs
            .iter()
            .map(|&edge| self.mapped(edge))
            .collect();
        for &edge in &outputs {
            self.new.acquire(edge);
        }
        self.new.outputs = outputs;
        self.new
    }
}

fn unnamed(network: &FactorNetwork, node: u32) -> NodeOrigin {
    let own = &network.nodes[node as usize];
    NodeOrigin {
        name: Name::NONE,
        owner: own.owner,
        sources: own.sources,
    }
}
