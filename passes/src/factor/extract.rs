//! Shared parts and common factors.
//!
//! The polynomial form of multilevel logic synthesis (Brayton and McMullen,
//! "The decomposition and factorization of Boolean expressions", 1982; on
//! polynomials Hosangadi, Fallah and Kastner, "Optimizing polynomial
//! expressions by algebraic factorization and common subexpression
//! elimination", 2006), restricted to divisors of two terms or two factors as
//! Rajski and Vasudevamurthy do, so that their number is quadratic in the
//! size of a sum and linear in that of the function. Larger kernels come about
//! one term at a time.
//!
//! A divisor is identified by its value and not by its form: the common part of
//! several sums may be written differently in each, and it may exist already.

use super::network::{Edge, FactorKind, FactorNetwork, NodeOrigin, tidy};
use super::times::NodeTimes;
use crate::sums::values::ValueTable;
use robovec_framework::fingerprint::Fingerprint;
use robovec_num::arithmetic::Arithmetic;

/// In larger sums and products only operands at most this far apart in the
/// order of the operands are paired.
const REACH: usize = 24;

/// The part that is taken out of both terms of a pair.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Common {
    /// No product: the pair itself is the divisor.
    Nothing,
    /// All factors they have in common.
    All,
    /// One factor, given by its node.
    One(u32),
}

/// A pair of operands of a sum or product.
#[derive(Clone, Copy, Debug)]
struct DivisorOccurrence {
    divisor: u32,
    user: u32,
    pair: [Edge; 2],
    common: Common,
}

/// Divisors in order of their expected gain.
struct Divisors {
    /// By divisor, without their signs.
    values: ValueTable,
    /// By divisor, then in program order.
    occurrences: Vec<DivisorOccurrence>,
}

/// The name of the rule in the trail.
const RULE: &str = "common-part";

/// Gains are estimated in these fractions of an operation.
const UNIT: i64 = 12;

/// Finds and applies divisors with a gain, the most promising first; returns
/// the number of operations saved. `times`, if given, has the latest time of
/// each value.
pub(super) fn extract(
    network: &mut FactorNetwork,
    order: &[u32],
    mut times: Option<NodeTimes>,
) -> i64 {
    let before = network.cost;
    let divisors = Divisors::find(network, order);
    let ranked = divisors.rank(network);
    for (start, end) in ranked {
        let occurrences = &divisors.occurrences[start..end];
        let value = divisors.values.value(occurrences[0].divisor as usize);
        apply(network, value, occurrences, times.as_mut());
    }
    before - network.cost
}

impl Divisors {
    fn find(network: &FactorNetwork, order: &[u32]) -> Divisors {
        let mut sketch = DivisorSketch::new(network, order);
        let images = network.values.images;
        for_each_pair(network, order, |value, _, _, _| {
            sketch.count(images.without_sign(value).0)
        });
        let mut divisors = Divisors {
            values: ValueTable::new(images),
            occurrences: Vec::new(),
        };
        for_each_pair(network, order, |value, user, pair, common| {
            let (size, _) = images.without_sign(value);
            if !sketch.several(size) && network.find(size).is_none() && common == Common::Nothing {
                return;
            }
            let (divisor, _) = divisors.values.place(size);
            divisors.occurrences.push(DivisorOccurrence {
                divisor,
                user,
                pair,
                common,
            });
        });
        // Stable: the order of the program stays within a divisor.
        divisors.occurrences.sort_by_key(|one| one.divisor);
        divisors
    }

    /// Ranges of the occurrences of those divisors that may have a gain, best
    /// first.
    fn rank(&self, network: &FactorNetwork) -> Vec<(usize, usize)> {
        let mut ranked = Vec::new();
        let mut start = 0;
        for group in self.occurrences.chunk_by(|a, b| a.divisor == b.divisor) {
            let end = start + group.len();
            let gain: i64 = group.iter().map(|one| one.estimate(network)).sum();
            let exists = network
                .find(self.values.value(group[0].divisor as usize))
                .is_some();
            let price = if exists { 0 } else { group[0].price(network) };
            if gain > price {
                ranked.push((price - gain, start, end));
            }
            start = end;
        }
        ranked.sort_unstable();
        ranked
            .into_iter()
            .map(|(_, start, end)| (start, end))
            .collect()
    }
}

impl DivisorOccurrence {
    /// The operations that the divisor would save here if it existed.
    fn estimate(&self, network: &FactorNetwork) -> i64 {
        if self.common == Common::Nothing {
            return UNIT;
        }
        let freed: i64 = self
            .pair
            .iter()
            .map(|edge| {
                let node = &network.nodes[edge.node()];
                match node.kind {
                    FactorKind::Product => {
                        UNIT * (node.operands.len() as i64 - 1) / i64::from(node.uses.max(1))
                    }
                    _ => 0,
                }
            })
            .sum();
        let (common, _) = self.split(network);
        UNIT + freed - UNIT * common.len() as i64
    }

    /// The operations that making the divisor costs.
    fn price(&self, network: &FactorNetwork) -> i64 {
        if self.common == Common::Nothing {
            return UNIT;
        }
        let (_, rest) = self.split(network);
        let products: usize = rest.iter().map(|rest| rest.len().saturating_sub(1)).sum();
        UNIT * (1 + products as i64)
    }

    /// The common factors, and the rest of the two terms.
    fn split(&self, network: &FactorNetwork) -> (Vec<Edge>, [Vec<Edge>; 2]) {
        let [(_, left), (_, right)] = self.pair.map(|edge| factors(network, edge));
        match self.common {
            Common::Nothing => (Vec::new(), [left, right]),
            Common::All => divide(&left, &right),
            Common::One(node) => {
                let factor = Edge::new(node, false);
                (
                    vec![factor],
                    [without(&left, factor), without(&right, factor)],
                )
            }
        }
    }
}

/// The factors of a term, sorted and without signs, and its sign.
fn factors(network: &FactorNetwork, term: Edge) -> (bool, Vec<Edge>) {
    let node = &network.nodes[term.node()];
    if node.kind != FactorKind::Product {
        return (term.negative(), vec![term.flip(term.negative())]);
    }
    let odd = node.operands.iter().filter(|edge| edge.negative()).count() % 2 == 1;
    let mut factors: Vec<Edge> = node
        .operands
        .iter()
        .map(|edge| edge.flip(edge.negative()))
        .collect();
    factors.sort_unstable();
    (term.negative() ^ odd, factors)
}

/// The common part of two sorted lists, and the rest of each.
fn divide(left: &[Edge], right: &[Edge]) -> (Vec<Edge>, [Vec<Edge>; 2]) {
    let (mut common, mut rest) = (Vec::new(), [Vec::new(), Vec::new()]);
    let (mut i, mut j) = (0, 0);
    while i < left.len() || j < right.len() {
        match (left.get(i), right.get(j)) {
            (Some(a), Some(b)) if a == b => {
                common.push(*a);
                i += 1;
                j += 1;
            }
            (Some(a), other) if other.is_none_or(|b| a < b) => {
                rest[0].push(*a);
                i += 1;
            }
            (_, other) => {
                rest[1].extend(other);
                j += 1;
            }
        }
    }
    (common, rest)
}

fn without(factors: &[Edge], factor: Edge) -> Vec<Edge> {
    let mut rest = factors.to_vec();
    if let Some(at) = rest.iter().position(|&edge| edge == factor) {
        rest.remove(at);
    }
    rest
}

/// Calls back for every pair of operands, with each divisor that it contains:
/// the divisor's value, the user, the pair.
fn for_each_pair(
    network: &FactorNetwork,
    order: &[u32],
    mut found: impl FnMut(Fingerprint, u32, [Edge; 2], Common),
) {
    let images = &network.values.images;
    let product =
        |factors: &[Edge]| images.product(factors.iter().map(|&edge| network.value(edge)));
    let mut split: Vec<(bool, Vec<Edge>)> = Vec::new();
    for &user in order {
        let node = &network.nodes[user as usize];
        let operands = &node.operands;
        match node.kind {
            FactorKind::Sum => {
                split.clear();
                split.extend(operands.iter().map(|&term| factors(network, term)));
            }
            FactorKind::Product if operands.len() > 2 => {}
            _ => continue,
        }
        for (i, &a) in operands.iter().enumerate() {
            for (j, &b) in operands.iter().enumerate().skip(i + 1).take(REACH) {
                let (left, right) = (network.value(a), network.value(b));
                if node.kind == FactorKind::Product {
                    found(images.mul(left, right), user, [a, b], Common::Nothing);
                    continue;
                }
                if operands.len() > 2 {
                    found(images.add(left, right), user, [a, b], Common::Nothing);
                }
                let mut take = |common: Common, rest: [&[Edge]; 2]| {
                    let signed = |negative: bool, factors: &[Edge]| {
                        images.negate_if(negative, product(factors))
                    };
                    let value =
                        images.add(signed(split[i].0, rest[0]), signed(split[j].0, rest[1]));
                    found(value, user, [a, b], common);
                };
                let (common, [p, q]) = divide(&split[i].1, &split[j].1);
                if common.is_empty() {
                    continue;
                }
                take(Common::All, [&p, &q]);
                if common.len() > 1 {
                    for (at, &factor) in common.iter().enumerate() {
                        if at == 0 || common[at - 1] != factor {
                            let one = Common::One(factor.node() as u32);
                            let rest = [&split[i].1, &split[j].1].map(|all| without(all, factor));
                            take(one, [&rest[0], &rest[1]]);
                        }
                    }
                }
            }
        }
    }
}

/// The number of occurrences of each divisor, without the divisors: a byte for
/// each slot of a table. Divisors that share a slot seem more frequent than
/// they are, which costs only one more test.
struct DivisorSketch {
    slots: Vec<u8>,
}

impl DivisorSketch {
    fn new(network: &FactorNetwork, order: &[u32]) -> DivisorSketch {
        let pairs: usize = order
            .iter()
            .map(|&node| network.nodes[node as usize].operands.len())
            .map(|count| count * count.min(REACH))
            .sum();
        DivisorSketch {
            slots: vec![0; pairs.next_power_of_two().clamp(1 << 10, 1 << 26)],
        }
    }

    fn slot(&self, size: Fingerprint) -> usize {
        size.bits() as usize & (self.slots.len() - 1)
    }

    fn count(&mut self, size: Fingerprint) {
        let slot = self.slot(size);
        self.slots[slot] = self.slots[slot].saturating_add(1);
    }

    fn several(&self, size: Fingerprint) -> bool {
        self.slots[self.slot(size)] > 1
    }
}

/// Applies a divisor wherever it still occurs, if there is a gain.
fn apply(
    network: &mut FactorNetwork,
    value: Fingerprint,
    occurrences: &[DivisorOccurrence],
    mut times: Option<&mut NodeTimes>,
) {
    let (before, first) = (network.cost, network.nodes.len());
    let mut undo: Vec<(usize, FactorKind, Vec<Edge>)> = Vec::new();
    for one in occurrences {
        let Some((kind, operands)) = one.rewritten(network, value) else {
            continue;
        };
        let user = one.user as usize;
        let late = |times: &mut &mut NodeTimes| !times.allow(network, user, kind, &operands);
        if times.as_mut().is_some_and(late) {
            continue;
        }
        let (kind, operands) = network.replace(user, kind, operands);
        undo.push((user, kind, operands));
    }
    if network.cost < before {
        let rewritten: Vec<usize> = undo.iter().map(|&(user, _, _)| user).collect();
        for &user in &rewritten {
            network.nodes[user].rule.get_or_insert(RULE);
        }
        if let Some(times) = times {
            times.update(network, &rewritten, first);
        }
        return;
    }
    for (user, kind, operands) in undo.into_iter().rev() {
        network.replace(user, kind, operands);
    }
}

impl DivisorOccurrence {
    /// The operands of the user with the divisor instead of the pair; `None`
    /// when the pair has gone or the divisor would depend on the user.
    fn rewritten(
        &self,
        network: &mut FactorNetwork,
        value: Fingerprint,
    ) -> Option<(FactorKind, Vec<Edge>)> {
        let user = &network.nodes[self.user as usize];
        let (position, kind) = (user.position, user.kind);
        if user.uses == 0 {
            return None;
        }
        let mut rest = user.operands.clone();
        for edge in self.pair {
            let at = rest.iter().position(|&other| other == edge)?;
            rest.remove(at);
        }
        let origin = NodeOrigin {
            name: robovec_ir::Name::NONE,
            owner: user.owner,
            sources: user.sources,
        };
        if kind == FactorKind::Product {
            let divisor = network
                .find(value)
                .unwrap_or_else(|| network.product(&self.pair, origin));
            // The pair's value may be the negation of the divisor's.
            let [x, y] = self.pair.map(|edge| network.value(edge));
            let pair = network.values.images.mul(x, y);
            let divisor = divisor.flip(network.value(divisor).is_negation_of(&pair));
            rest.push(divisor);
            rest.sort_unstable();
            return network.below(&rest, position).then_some((kind, rest));
        }
        let [(left, in_left), (right, in_right)] = self.pair.map(|edge| factors(network, edge));
        // What a term was a product of when the divisors were found may have
        // become part of one of its factors since.
        if let Common::One(node) = self.common {
            let factor = Edge::new(node, false);
            if ![in_left, in_right].iter().all(|all| all.contains(&factor)) {
                return None;
            }
        }
        let (common, [p, q]) = self.split(network);
        let terms = match self.common {
            Common::Nothing => self.pair,
            _ => [
                network.product(&p, origin).flip(left),
                network.product(&q, origin).flip(right),
            ],
        };
        let divisor = network.sum(&terms, origin);
        if network.nodes[divisor.node()].position >= position {
            return None;
        }
        let mut product = common;
        product.push(divisor);
        if rest.is_empty() {
            return Some((FactorKind::Product, product));
        }
        rest.push(network.product(&product, origin));
        tidy(&mut rest);
        (rest.len() > 1 && network.below(&rest, position)).then_some((FactorKind::Sum, rest))
    }
}
