//! The tree of one group.

use super::build::{GroupNaming, GroupTerm, Score, SignedOperand, TreeBuilder, TreeShape};
use super::share::LARGEST_GROUP;
use crate::cse::Key;
use crate::sums::earliest::{TieOrder, finish, join_earliest};
use crate::sums::groups::GroupFamily;
use robovec_ir::{Operand, Operation, Value};
use std::cmp::Reverse;

impl TreeBuilder<'_> {
    /// Negates a leaf of a group that would come out with another sign than
    /// an output needs.
    pub(super) fn negate_early(
        &mut self,
        family: GroupFamily,
        term: &mut GroupTerm,
        naming: &mut GroupNaming,
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
        term.value = SignedOperand {
            operand: self.true_sign(negative, naming),
            negative: false,
        };
        term.arrival = self.arrival(term.value.operand);
        term.leaf = None;
    }

    fn find(&self, operation: Operation, operands: [Operand; 2]) -> Option<Value> {
        self.known.find(&self.out, Key::new(operation, operands))
    }

    fn group_weight(&self, family: GroupFamily) -> u32 {
        match family {
            GroupFamily::Sum => self.weights.of(Operation::Add),
            GroupFamily::Product => self.weights.of(Operation::Mul),
        }
    }

    /// The operation that joins two terms, and the sign of its result. `flip`
    /// chooses the negated form where both cost the same.
    fn join(
        family: GroupFamily,
        a: SignedOperand,
        b: SignedOperand,
        flip: bool,
    ) -> (Operation, [Operand; 2], bool) {
        match (family, a.negative, b.negative) {
            (GroupFamily::Product, _, _) => (Operation::Mul, [a.operand, b.operand], false),
            (GroupFamily::Sum, false, false) => (Operation::Add, [a.operand, b.operand], false),
            (GroupFamily::Sum, true, true) => (Operation::Add, [a.operand, b.operand], true),
            (GroupFamily::Sum, false, true) if !flip => {
                (Operation::Sub, [a.operand, b.operand], false)
            }
            (GroupFamily::Sum, true, false) if flip => {
                (Operation::Sub, [a.operand, b.operand], true)
            }
            (GroupFamily::Sum, true, false) => (Operation::Sub, [b.operand, a.operand], false),
            (GroupFamily::Sum, false, true) => (Operation::Sub, [b.operand, a.operand], true),
        }
    }

    fn merge(
        &mut self,
        family: GroupFamily,
        a: GroupTerm,
        b: GroupTerm,
        last: bool,
        flip: bool,
        naming: &mut GroupNaming,
    ) -> GroupTerm {
        // An equal difference may be stored the other way round.
        let (mut operation, mut operands, mut negative) =
            Self::join(family, a.value, b.value, flip && last);
        if operation == Operation::Sub
            && self.shape == TreeShape::Earliest
            && self.find(operation, operands).is_none()
        {
            let other = Self::join(family, a.value, b.value, !(flip && last));
            if self.find(other.0, other.1).is_some() {
                (operation, operands, negative) = other;
            }
        }
        let name = if last {
            naming.root
        } else {
            self.inner_name(naming)
        };
        let operand = self.emit(operation, operands, name, naming);
        GroupTerm {
            arrival: self.arrival(operand),
            value: SignedOperand { operand, negative },
            leaf: None,
        }
    }

    pub(super) fn cascade(
        &mut self,
        family: GroupFamily,
        terms: &[GroupTerm],
        flip: bool,
        naming: &mut GroupNaming,
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
        SignedOperand {
            operand: self.out.constant(number).into(),
            negative: false,
        }
    }

    pub(super) fn earliest(
        &mut self,
        family: GroupFamily,
        root: Value,
        mut terms: Vec<GroupTerm>,
        flip: bool,
        naming: &mut GroupNaming,
    ) -> SignedOperand {
        if !self.draft && terms.len() > 2 && terms.len() <= LARGEST_GROUP {
            self.share(family, root, &mut terms, naming);
        }
        let arrival = |term: &GroupTerm| term.arrival;
        let joined = join_earliest(terms, TieOrder::Written, arrival, |[a, b], last| {
            self.merge(family, a, b, last, flip, naming)
        });
        joined.map_or_else(|| self.empty(family), |term| term.value)
    }

    /// Combines pairs that exist already or that other groups want too, as
    /// long as the group is not later than it may be.
    fn share(
        &mut self,
        family: GroupFamily,
        root: Value,
        terms: &mut Vec<GroupTerm>,
        naming: &mut GroupNaming,
    ) {
        let weight = self.group_weight(family);
        let best = finish(terms.iter().map(|term| term.arrival), weight);
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
                let arrivals = others.map(|k| terms[k].arrival).chain([arrival]);
                if finish(arrivals, weight) <= deadline {
                    best = Some((score, (i, j)));
                }
            }
        }
        best.map(|(_, pair)| pair)
    }

    /// The worth of sharing a pair, and when it is ready; `None` when nobody
    /// else wants it.
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
            let (operation, operands, _) = Self::join(family, a.value, b.value, flip);
            if let Some(value) = self.find(operation, operands) {
                return Some((u32::MAX, self.arrivals[value.index()]));
            }
        }
        (count > 1).then(|| (count, a.arrival.max(b.arrival) + weight))
    }
}
