//! The places where a value is negated that an output needs with the other
//! sign.
//!
//! A sign that [`super::signs`] cannot absorb costs one `0 - x`. After the
//! result it comes latest; before it, on a leaf that is early enough, or inside
//! a leaf without another reader, it may cost no time. For every group the
//! earliest arrival with either sign follows from those of its leaves, which
//! makes the choice exact.

use super::signs::{NaturalSigns, Wishes};
use crate::sums::earliest::finish;
use crate::sums::groups::{GroupFamily, GroupLeaf, OperandGroups};
use robovec_analysis::critical_path::Weights;
use robovec_ir::{Function, Operation, Value};

/// The leaf of a group that is negated before the group is combined.
#[derive(Default)]
pub(super) struct Negations(Vec<(Value, u32)>);

impl Negations {
    /// The leaf to negate in a group, by its place.
    pub(super) fn leaf(&self, root: Value) -> Option<u32> {
        let found = self.0.binary_search_by_key(&root, |&(root, _)| root);
        found.ok().map(|place| self.0[place].1)
    }

    /// Decides for every group with the wrong sign; `latest`, once known, is
    /// the latest time of each result: results with slack get the `0 - x` after
    /// them. Wishes are passed on to leaves.
    pub(super) fn plan<'t>(
        (function, groups): (&Function, &OperandGroups),
        natural: &NaturalSigns,
        wishes: &mut Wishes,
        times: impl FnOnce() -> &'t Turns,
        (weights, latest): (&Weights, Option<&[u32]>),
    ) -> Negations {
        let wrong = |wishes: &Wishes, root: Value, node: Operation| {
            let own = natural.of(root);
            GroupFamily::of(node).is_some()
                && !groups.is_absorbed(root)
                && !own.flippable
                && wishes.of(root).is_some_and(|wish| wish != own.negative)
        };
        let mut values = function.values();
        if !values.any(|(root, node)| wrong(wishes, root, node.operation)) {
            return Negations::default();
        }
        let times = times();
        let mut inside = vec![false; function.nodes().len()];
        let mut negations = Vec::new();
        for (root, node) in function.values().rev() {
            if !wrong(wishes, root, node.operation) {
                continue;
            }
            let late = times.arrivals[root.index()] + weights.of(Operation::Sub);
            let time_enough = latest.is_some_and(|latest| late <= latest[root.index()]);
            if !inside[root.index()] && time_enough {
                continue;
            }
            match times.turns[root.index()] {
                Turn::After => {}
                Turn::Leaf(place) => negations.push((root, place)),
                Turn::Inside(place) => {
                    let leaf = groups.leaves(root)[place as usize].operand;
                    if let Some(value) = leaf.value() {
                        inside[value.index()] = true;
                        wishes.ask(value, !natural.of(value).negative);
                    }
                }
            }
        }
        negations.reverse();
        Negations(negations)
    }
}

/// The earliest negation of a group.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Turn {
    /// By a `0 - x` after it.
    After,
    /// By negating this leaf.
    Leaf(u32),
    /// By this leaf being stored with its other sign.
    Inside(u32),
}

/// Arrivals with the natural sign, and with the other.
pub(super) struct Turns {
    arrivals: Vec<u32>,
    turned: Vec<u32>,
    turns: Vec<Turn>,
}

/// Leaves of a group that are tried; wider sums have other terms to negate.
const LEAVES: usize = 32;

impl Turns {
    pub(super) fn find(
        function: &Function,
        groups: &OperandGroups,
        natural: &NaturalSigns,
        weights: &Weights,
    ) -> Turns {
        let count = function.nodes().len();
        let uses = function.use_counts();
        let mut times = Turns {
            arrivals: Vec::with_capacity(count),
            turned: Vec::with_capacity(count),
            turns: Vec::with_capacity(count),
        };
        let minus = weights.of(Operation::Sub);
        for (root, node) in function.values() {
            let mut found = (0, 0, Turn::After);
            match GroupFamily::of(node.operation) {
                _ if groups.is_absorbed(root) => {}
                None => {
                    let ready = node.values().map(|value| times.arrivals[value.index()]);
                    let arrival = ready.fold(0, u32::max) + weights.of(node.operation);
                    found = (arrival, arrival + minus, Turn::After);
                }
                Some(family) => {
                    let weight = family.weight(weights);
                    let leaves = groups.leaves(root);
                    let free = natural.of(root).flippable_alone;
                    found = times.group(function, leaves, weight, minus, &uses);
                    if free {
                        found = (found.0, found.0, Turn::After);
                    }
                }
            }
            times.arrivals.push(found.0);
            times.turned.push(found.1);
            times.turns.push(found.2);
        }
        times
    }

    /// Arrivals of a group with either sign.
    fn group(
        &self,
        function: &Function,
        leaves: &[GroupLeaf],
        weight: u32,
        minus: u32,
        uses: &[u32],
    ) -> (u32, u32, Turn) {
        let arrival = |leaf: &GroupLeaf| leaf.operand.entry_or_default(&self.arrivals);
        let finish_with = |changed: Option<(usize, u32)>| {
            let arrivals = leaves.iter().enumerate().map(|(at, leaf)| match changed {
                Some((place, time)) if place == at => time,
                _ => arrival(leaf),
            });
            finish(arrivals, weight)
        };
        let natural = finish_with(None);
        let mut best = (natural + minus, Turn::After);
        for (place, leaf) in leaves.iter().enumerate().take(LEAVES) {
            let own = arrival(leaf);
            let negated = match function.number(leaf.operand) {
                Some(_) => 0,
                None => own + minus,
            };
            let here = finish_with(Some((place, negated)));
            if here < best.0 {
                best = (here, Turn::Leaf(place as u32));
            }
            if let Some(value) = leaf.operand.value()
                && uses[value.index()] == 1
                && self.turned[value.index()] < negated
            {
                let inside = finish_with(Some((place, self.turned[value.index()])));
                if inside < best.0 {
                    best = (inside, Turn::Inside(place as u32));
                }
            }
        }
        (natural, best.0, best.1)
    }
}
