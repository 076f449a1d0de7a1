//! The elimination of the vertices between the ends of a linearised graph.
//!
//! The elimination of a vertex multiplies the weights of every edge into it
//! with those of every edge out of it and adds the products to the edges past
//! it. When no vertex between the ends is left, the edges are the elements of
//! the Jacobian. Eliminating in program order is the forward mode, against it
//! the reverse mode; which order costs least is NP-hard to find (Naumann 2008).
//! Two rules of thumb use the present graph: the vertex with the fewest
//! products minus the edges removed (Markowitz 1957; Griewank and Reese 1991),
//! and that with the fewest additional edges. Of equal ones the last is taken,
//! since reverse is the better mode for most functions of robots.
//!
//! Parts of the graph that share nothing but ends are counted each for
//! itself, on a copy, and each is then eliminated in its cheapest order.

use super::graph::{LinearisedGraph, Vertex};
use super::weights::{PartialOrigin, WeightWriter};
use std::cmp::Reverse;
use std::collections::BTreeSet;

/// An order in which vertices are eliminated.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum EliminationOrder {
    /// In the order of the program.
    Forward,
    /// Against that.
    Reverse,
    /// Those with the fewest products first, minus the edges removed.
    FewestProducts,
    /// Those first that leave the fewest edges.
    LeastFill,
}

impl EliminationOrder {
    /// All orders; of equally good ones the first is taken.
    pub(super) const ALL: [EliminationOrder; 4] = [
        EliminationOrder::Forward,
        EliminationOrder::Reverse,
        EliminationOrder::FewestProducts,
        EliminationOrder::LeastFill,
    ];

    /// Name of the operations that it needs, for statistics.
    pub(super) fn count_name(self) -> &'static str {
        match self {
            EliminationOrder::Forward => "operations forward",
            EliminationOrder::Reverse => "operations in reverse",
            EliminationOrder::FewestProducts => "operations fewest products first",
            EliminationOrder::LeastFill => "operations least fill first",
        }
    }
}

/// The work of an elimination went beyond its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct TooMuchWork;

/// Limit of the cost of an elimination.
#[derive(Clone, Copy, Debug)]
pub(super) struct EliminationLimit {
    /// Operations of the function that is written.
    pub(super) operations: usize,
    /// Products of weights, also of those that cost no operation.
    pub(super) products: u64,
}

/// The vertices between the ends, divided into parts without edges from one
/// to another; each part in ascending order.
pub(super) fn parts(graph: &LinearisedGraph) -> Vec<Vec<u32>> {
    let directed = graph.vertices.contains(&Vertex::Source);
    let weighted = graph.vertices.contains(&Vertex::Sink);
    let between = |vertex: u32| match graph.vertices[vertex as usize] {
        Vertex::Node(_) => true,
        Vertex::Column(_) => directed,
        Vertex::Row(_) => weighted,
        Vertex::Source | Vertex::Sink => false,
    };
    let mut found = vec![false; graph.vertices.len()];
    let mut parts = Vec::new();
    for first in (0..graph.vertices.len() as u32).filter(|&vertex| between(vertex)) {
        if found[first as usize] {
            continue;
        }
        found[first as usize] = true;
        let (mut part, mut open) = (Vec::new(), vec![first]);
        while let Some(vertex) = open.pop() {
            part.push(vertex);
            let before = graph.into[vertex as usize].keys();
            for &next in before.chain(&graph.out[vertex as usize]) {
                if between(next) && !found[next as usize] {
                    found[next as usize] = true;
                    open.push(next);
                }
            }
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts
}

/// The elimination of a graph, part by part.
pub(super) struct Elimination<'a> {
    pub(super) graph: LinearisedGraph,
    pub(super) writer: WeightWriter,
    pub(super) limit: EliminationLimit,
    /// Origin of the products at a vertex for an edge to another.
    pub(super) origin: &'a mut dyn FnMut(Vertex, Vertex) -> PartialOrigin,
}

impl Elimination<'_> {
    pub(super) fn part(
        &mut self,
        part: &[u32],
        order: EliminationOrder,
    ) -> Result<(), TooMuchWork> {
        match order {
            EliminationOrder::Forward => part.iter().try_for_each(|&vertex| self.vertex(vertex)),
            EliminationOrder::Reverse => {
                let mut part = part.iter().rev();
                part.try_for_each(|&vertex| self.vertex(vertex))
            }
            EliminationOrder::FewestProducts => self.greedy(part, products),
            EliminationOrder::LeastFill => self.greedy(part, fill),
        }
    }

    /// Eliminates the vertex of the smallest cost next, as costs were when an
    /// edge of the vertex last changed.
    fn greedy(
        &mut self,
        part: &[u32],
        cost: fn(&LinearisedGraph, u32) -> i64,
    ) -> Result<(), TooMuchWork> {
        let mut costs: Vec<i64> = part
            .iter()
            .map(|&vertex| cost(&self.graph, vertex))
            .collect();
        let queued = costs.iter().zip(part);
        let mut queue: BTreeSet<(i64, Reverse<u32>)> = queued
            .map(|(&cost, &vertex)| (cost, Reverse(vertex)))
            .collect();
        while let Some((_, Reverse(vertex))) = queue.pop_first() {
            let at = vertex as usize;
            let before = self.graph.into[at].keys();
            let near: Vec<u32> = before.chain(&self.graph.out[at]).copied().collect();
            self.vertex(vertex)?;
            for other in near {
                let Ok(place) = part.binary_search(&other) else {
                    continue;
                };
                let new = cost(&self.graph, other);
                if new != costs[place] {
                    queue.remove(&(costs[place], Reverse(other)));
                    queue.insert((new, Reverse(other)));
                    costs[place] = new;
                }
            }
        }
        Ok(())
    }

    fn vertex(&mut self, vertex: u32) -> Result<(), TooMuchWork> {
        let into = std::mem::take(&mut self.graph.into[vertex as usize]);
        let out = std::mem::take(&mut self.graph.out[vertex as usize]);
        let products = into.len() as u64 * out.len() as u64;
        if self.limit.products < products || self.writer.len() > self.limit.operations {
            return Err(TooMuchWork);
        }
        self.limit.products -= products;
        for before in into.keys() {
            self.graph.out[*before as usize].remove(&vertex);
        }
        let kinds = |graph: &LinearisedGraph, to: u32| {
            let kind = |vertex: u32| graph.vertices[vertex as usize];
            (kind(vertex), kind(to))
        };
        for to in out {
            let weight = self.graph.into[to as usize].remove(&vertex);
            let weight = weight.expect("an edge is listed at both of its ends");
            let (own, next) = kinds(&self.graph, to);
            let origin = (self.origin)(own, next);
            for (&from, &first) in &into {
                let product = self.writer.product(first, weight, origin);
                self.graph.add(from, to, product, &mut self.writer, origin);
            }
        }
        Ok(())
    }
}

/// The products for eliminating a vertex, minus the edges removed with it.
fn products(graph: &LinearisedGraph, vertex: u32) -> i64 {
    let [into, out] = degrees(graph, vertex);
    into * out - into - out
}

/// The edges that come with eliminating a vertex, less those that go.
fn fill(graph: &LinearisedGraph, vertex: u32) -> i64 {
    let before = &graph.into[vertex as usize];
    let new = graph.out[vertex as usize].iter().map(|&to| {
        let known = &graph.into[to as usize];
        before
            .keys()
            .filter(|from| !known.contains_key(from))
            .count() as i64
    });
    let [into, out] = degrees(graph, vertex);
    new.sum::<i64>() - into - out
}

fn degrees(graph: &LinearisedGraph, vertex: u32) -> [i64; 2] {
    let vertex = vertex as usize;
    [graph.into[vertex].len(), graph.out[vertex].len()].map(|edges| edges as i64)
}
