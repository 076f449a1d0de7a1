//! The tree of one group.

use super::build::{GroupTerm, Score, TreeBuilder, TreeShape};
use super::share::LARGEST_GROUP;
use crate::sums::earliest::{TieOrder, finish, join_earliest};
use crate::sums::groups::GroupFamily;
use crate::sums::writer::{SignedOperand, ValueNaming, joining};
use robovec_ir::{Operand, Operation, Value};
use std::cmp::Reverse;

impl TreeBuilder<'_> {
    /// Negates a leaf of a group that would have another sign than an output
    /// needs.
    pub(super) fn negate_early(
        &mut self,
        family: GroupFamily,
        term: &mut GroupTerm,
        naming: &mut ValueNaming,
    ) {
        let negative = match family {
            GroupFamily::Sum => term.value.negative,
            GroupFamily::Product => true,
        };
        if !negative {
            return;
        }
        let negative = SignedOperand {
            negative: true,
            ..term.value
        };
        let negated = self.writer.true_sign(negative, naming);
        term.value = self.writer.signed(negated, false);
        term.leaf = None;
    }

    fn merge(
        &mut self,
        family: GroupFamily,
        a: GroupTerm,
        b: GroupTerm,
        last: bool,
        flip: bool,
        naming: &mut ValueNaming,
    ) -> GroupTerm {
        // An equal difference may be stored the other way round.
        let pair = values(&a, &b);
        let flip = flip && last;
        let (mut operation, mut operands, mut negative) = joining(family, pair, flip);
        if operation == Operation::Sub
            && self.shape == TreeShape::Earliest
            && self.writer.find(operation, operands).is_none()
        {
            let other = joining(family, pair, !flip);
            if self.writer.find(other.0, other.1).is_some() {
                (operation, operands, negative) = other;
            }
        }
        let name = self.writer.name(last, naming);
        let operand = (self.writer).write(operation, operands, name, naming.sources);
        GroupTerm {
            value: self.writer.signed(operand, negative),
            leaf: None,
        }
    }

    pub(super) fn cascade(
        &mut self,
        family: GroupFamily,
        terms: &[GroupTerm],
        flip: bool,
        naming: &mut ValueNaming,
    ) -> SignedOperand {
        let Some((&first, rest)) = terms.split_first() else {
            return self.empty(family);
        };
        let mut sum = first;
        for (index, &term) in rest.iter().enumerate() {
            sum = self.merge(family, sum, term, index + 1 == rest.len(), flip, naming);
        }
        sum.value
    }

    /// A sum of zeros only.
    fn empty(&mut self, family: GroupFamily) -> SignedOperand {
        let number = match family {
            GroupFamily::Sum => 0.0,
            GroupFamily::Product => 1.0,
        };
        self.writer.number(number)
    }

    pub(super) fn earliest(
        &mut self,
        family: GroupFamily,
        root: Value,
        terms: &mut Vec<GroupTerm>,
        flip: bool,
        naming: &mut ValueNaming,
    ) -> SignedOperand {
        if !self.draft && terms.len() > 2 && terms.len() <= LARGEST_GROUP {
            self.share(family, root, terms, naming);
        }
        if let [a, b] = terms[..] {
            return self.merge(family, a, b, true, flip, naming).value;
        }
        let arrival = |term: &GroupTerm| term.value.arrival;
        let joined = join_earliest(terms, TieOrder::Written, arrival, |[a, b], last| {
            self.merge(family, a, b, last, flip, naming)
        });
        match joined {
            Some(term) => term.value,
            None => self.empty(family),
        }
    }

    /// Combines pairs that exist already or that other groups contain too, as
    /// long as the group stays in time.
    fn share(
        &mut self,
        family: GroupFamily,
        root: Value,
        terms: &mut Vec<GroupTerm>,
        naming: &mut ValueNaming,
    ) {
        let weight = family.weight(&self.writer.times.weights);
        let best = finish(terms.iter().map(|term| term.value.arrival), weight);
        let deadline = match &self.deadlines {
            Some(deadlines) => best.max(deadlines.latest[root.index()]),
            None => best,
        };
        while terms.len() > 2 {
            let Some((i, j)) = self.best_pair(family, terms, weight, deadline) else {
                return;
            };
            let b = terms.remove(j);
            let a = terms.remove(i);
            let joined = self.merge(family, a, b, false, false, naming);
            terms.insert(i, joined);
        }
    }

    fn best_pair(
        &self,
        family: GroupFamily,
        terms: &[GroupTerm],
        weight: u32,
        deadline: u32,
    ) -> Option<(usize, usize)> {
        let mut best: Option<(Score, (usize, usize))> = None;
        for i in 0..terms.len() {
            for j in i + 1..terms.len() {
                let Some((worth, arrival)) = self.worth(family, &terms[i], &terms[j], weight)
                else {
                    continue;
                };
                let score = (worth, Reverse(arrival));
                if best.as_ref().is_some_and(|(known, _)| *known >= score) {
                    continue;
                }
                let others = (0..terms.len()).filter(|&k| k != i && k != j);
                let arrivals = others.map(|k| terms[k].value.arrival).chain([arrival]);
                if finish(arrivals, weight) <= deadline {
                    best = Some((score, (i, j)));
                }
            }
        }
        best.map(|(_, pair)| pair)
    }

    /// The benefit of sharing a pair, and its time; `None` without another
    /// user.
    fn worth(
        &self,
        family: GroupFamily,
        a: &GroupTerm,
        b: &GroupTerm,
        weight: u32,
    ) -> Option<(u32, u32)> {
        // Two leaves that no other group has cannot have been combined yet.
        let count = match (a.leaf, b.leaf) {
            (Some(a), Some(b)) => match self.deadlines.as_ref()?.pairs.of(family, a, b) {
                1 => return None,
                count => count,
            },
            (_, _) => 0,
        };
        for flip in [false, true] {
            let (operation, operands, _) = joining(family, values(a, b), flip);
            if let Some(value) = self.writer.find(operation, operands) {
                return Some((u32::MAX, self.writer.times.of(value.into())));
            }
        }
        (count > 1).then(|| (count, a.value.arrival.max(b.value.arrival) + weight))
    }
}

fn values(a: &GroupTerm, b: &GroupTerm) -> [(Operand, bool); 2] {
    [a, b].map(|term| (term.value.operand, term.value.negative))
}
