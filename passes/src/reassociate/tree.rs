//! The tree of one group.

use super::build::{GroupNaming, GroupTerm, Score, SignedOperand, TreeBuilder, TreeShape};
use super::combine::finish;
use super::gather::GroupFamily;
use super::share::LARGEST_GROUP;
use crate::cse::Key;
use robovec_ir::{Operand, Operation, Value};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

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
            order: a.order.min(b.order),
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
        if terms.is_empty() {
            return self.empty(family);
        }
        if let [a, b] = terms[..] {
            return self.merge(family, a, b, true, flip, naming).value;
        }
        if !self.draft && terms.len() > 2 && terms.len() <= LARGEST_GROUP {
            self.share(family, root, &mut terms, naming);
        }
        if terms.len() <= LARGEST_GROUP {
            return self.earliest_of_few(family, terms, flip, naming);
        }
        let mut heap: BinaryHeap<Reverse<(u32, u32, u32)>> = BinaryHeap::new();
        for (index, term) in terms.iter().enumerate() {
            heap.push(Reverse((term.arrival, term.order, index as u32)));
        }
        while heap.len() > 1 {
            let mut earliest = || heap.pop().expect("the heap holds two terms or more").0;
            let (a, b) = (earliest(), earliest());
            let last = heap.is_empty();
            let (a, b) = (terms[a.2 as usize], terms[b.2 as usize]);
            let (a, b) = if a.order <= b.order { (a, b) } else { (b, a) };
            let joined = self.merge(family, a, b, last, flip, naming);
            heap.push(Reverse((joined.arrival, joined.order, terms.len() as u32)));
            terms.push(joined);
        }
        let Reverse((_, _, last)) = heap.pop().expect("a group that is not empty has a root");
        terms[last as usize].value
    }

    /// The two earliest first, found by looking at all: for few terms faster
    /// than a heap.
    fn earliest_of_few(
        &mut self,
        family: GroupFamily,
        mut terms: Vec<GroupTerm>,
        flip: bool,
        naming: &mut GroupNaming,
    ) -> SignedOperand {
        while terms.len() > 1 {
            let first = earliest(&terms, None);
            let second = earliest(&terms, Some(first));
            let (a, b) = (terms[first], terms[second]);
            let (a, b) = if a.order <= b.order { (a, b) } else { (b, a) };
            terms[first] = self.merge(family, a, b, terms.len() == 2, flip, naming);
            terms.swap_remove(second);
        }
        terms[0].value
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
        let mut arrivals: Vec<u32> = terms.iter().map(|term| term.arrival).collect();
        arrivals.sort_unstable();
        let best = finish(&mut arrivals, weight);
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
                let mut arrivals: Vec<u32> = (0..terms.len())
                    .filter(|&k| k != i && k != j)
                    .map(|k| terms[k].arrival)
                    .chain([arrival])
                    .collect();
                arrivals.sort_unstable();
                if finish(&mut arrivals, weight) <= deadline {
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

/// The index of the earliest term, or of the earliest other one.
fn earliest(terms: &[GroupTerm], other_than: Option<usize>) -> usize {
    let mut best: Option<usize> = None;
    for (index, term) in terms.iter().enumerate() {
        let key = (term.arrival, term.order);
        if Some(index) != other_than
            && best.is_none_or(|best| key < (terms[best].arrival, terms[best].order))
        {
            best = Some(index);
        }
    }
    best.expect("there is a term besides the one left out")
}
