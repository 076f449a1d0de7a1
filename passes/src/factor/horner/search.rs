//! The search for orders of the variables.
//!
//! A tree search and, from its best orders and that of occurrences, annealing,
//! as FORM does it (Ruijl, Vermaseren, Plaat and van den Herik, "Combining
//! simulated annealing and Monte Carlo tree search for expression
//! simplification", 2014): a variable moves to another place or two change
//! places, and a worse order is taken with a probability that falls. The number
//! of operations of the schemes, with equal parts shared, is minimised; since
//! the savings of factors and shared pairs afterwards differ from order to
//! order, several orders are kept.

use super::schemes::{SchemeBuffers, SchemeSet};
use super::tree::OrderTree;
use robovec_num::random::Random;
use std::cmp::Reverse;

/// The temperature at the beginning, as a part of the number of operations.
const HOT: f64 = 0.03;
/// Temperature at the end, relative to that at the start.
const COOLING: f64 = 0.02;
/// Number of starts of the annealing, since the first variables of an order
/// hardly change once those after them suit them.
const STARTS: usize = 8;
/// No more orders are tried than this times the square of the number of
/// variables: by then those of few variables have all been seen.
const TRIES: u64 = 200;
/// The part of the work for a tree search: one part in this number.
const TREE_SHARE: u64 = 4;
/// With more variables there is no tree: it would not grow beyond the first
/// variable, and any order is worse there than that of occurrences.
const MAX_TREE: usize = 64;

/// An order of variables: the set before each of them, and the operations.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct RatedOrder {
    pub(super) cost: u64,
    /// By variable.
    pub(super) ranks: Vec<u32>,
}

/// The best orders that were seen since a start, no two of one cost.
struct KeptOrders {
    orders: Vec<RatedOrder>,
    count: usize,
}

impl KeptOrders {
    fn new(count: usize) -> KeptOrders {
        KeptOrders {
            orders: Vec::new(),
            count,
        }
    }

    fn offer(&mut self, cost: u64, ranks: &[u32]) {
        let place = self.orders.partition_point(|order| order.cost < cost);
        let known = self
            .orders
            .get(place)
            .is_some_and(|order| order.cost == cost);
        if place < self.count && !known {
            let ranks = ranks.to_vec();
            self.orders.insert(place, RatedOrder { cost, ranks });
            self.orders.truncate(self.count);
        }
    }
}

/// The maximum number of promising orders for a set of polynomials, best first:
/// that of occurrences, and those found until `work` terms were considered.
///
/// Every start of annealing has its share of them: the savings of factors
/// afterwards are similar for similar orders.
pub(super) fn orders(set: &SchemeSet, work: u64, count: usize, seed: u64) -> Vec<RatedOrder> {
    let occurrences = &set.variables.occurrences;
    let mut usual: Vec<u32> = (0..occurrences.len() as u32).collect();
    usual.sort_by_key(|&variable| Reverse(occurrences[variable as usize]));
    let mut search = OrderSearch {
        set,
        buffers: SchemeBuffers::default(),
        kept: KeptOrders::new(STARTS - 1),
        random: Random::new(seed),
    };
    let cost = search.rate(&usual);
    let tries = TRIES * (usual.len() * usual.len()) as u64;
    let work = work.min(tries.saturating_mul(search.buffers.work));
    let mut starts = vec![(usual, cost)];
    if starts[0].0.len() <= MAX_TREE {
        search.grow_tree(cost, work / TREE_SHARE);
        let found = search.kept.orders.drain(..);
        starts.extend(found.map(|rated| (by_rank(&rated.ranks), rated.cost)));
    }
    search.kept = KeptOrders::new(count.div_ceil(starts.len()));
    let (mut found, spent) = (Vec::new(), search.buffers.work);
    let share = work.saturating_sub(spent) / starts.len() as u64;
    for (number, (order, cost)) in (1..).zip(starts) {
        search.kept.offer(cost, &ranks(&order));
        if order.len() > 1 {
            search.anneal(order, cost, spent + share * number);
        }
        found.append(&mut search.kept.orders);
    }
    found.sort();
    found.dedup();
    found.truncate(count);
    found
}

fn ranks(order: &[u32]) -> Vec<u32> {
    let mut ranks = vec![0; order.len()];
    for (rank, &variable) in (0..).zip(order) {
        ranks[variable as usize] = rank;
    }
    ranks
}

/// The order in which variables have these ranks.
fn by_rank(ranks: &[u32]) -> Vec<u32> {
    let mut order = vec![0; ranks.len()];
    for (variable, &rank) in (0..).zip(ranks) {
        order[rank as usize] = variable;
    }
    order
}

struct OrderSearch<'a> {
    set: &'a SchemeSet,
    buffers: SchemeBuffers,
    kept: KeptOrders,
    random: Random,
}

impl OrderSearch<'_> {
    /// The operations of an order, which is kept if it is good.
    fn rate(&mut self, order: &[u32]) -> u64 {
        let ranks = ranks(order);
        let cost = self.set.cost(&ranks, &mut self.buffers);
        self.kept.offer(cost, &ranks);
        cost
    }

    /// Tries orders from a tree until so much work has been done; `usual` are
    /// the operations of the order of occurrences.
    fn grow_tree(&mut self, usual: u64, work: u64) {
        let end = self.buffers.work + work;
        let mut tree = OrderTree::new(self.set.variables.nodes.len());
        while self.buffers.work < end {
            let (order, path) = tree.next(&mut self.random);
            let cost = self.rate(&order);
            tree.reward(&path, usual as f64 / cost.max(1) as f64);
        }
    }

    /// Anneals an order of some cost until so much work has been done.
    fn anneal(&mut self, mut order: Vec<u32>, mut cost: u64, end: u64) {
        let start = self.buffers.work;
        while self.buffers.work < end {
            let progress = (self.buffers.work - start) as f64 / (end - start) as f64;
            let temperature = cost as f64 * HOT * (COOLING.ln() * progress).exp();
            let next = self.neighbour(&order);
            let next_cost = self.rate(&next);
            let worse = next_cost as f64 - cost as f64;
            if worse <= 0.0 || self.random.unit() < (-worse / temperature).exp() {
                (order, cost) = (next, next_cost);
            }
        }
    }

    /// An order in which one variable has moved, or two have changed places.
    fn neighbour(&mut self, order: &[u32]) -> Vec<u32> {
        let count = order.len();
        let from = self.random.below(count);
        let to = (from + 1 + self.random.below(count - 1)) % count;
        let mut next = order.to_vec();
        if self.random.bits() & 1 == 0 {
            next.swap(from, to);
        } else {
            let variable = next.remove(from);
            next.insert(to, variable);
        }
        next
    }
}
