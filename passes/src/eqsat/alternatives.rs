//! The alternatives that extraction chooses from: classes of values, each with
//! its forms.
//!
//! The e-graph keeps a value and its negation apart, and signs outside of
//! products. Here both become their own classes on demand, so that `b - a`
//! costs no more than `a - b` when the opposite is wanted.

use super::form::{EquivalentForm, terms};
use super::graph::EquivalenceGraph;
use crate::sums::earliest::finish;
use egg::Id;
use hashbrown::HashMap;
use robovec_analysis::critical_path::Weights;
use robovec_ir::Operation;
use rustc_hash::FxBuildHasher;

/// A result that is wanted, and when.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct RequiredResult {
    pub(crate) class: u32,
    /// The latest time of the result; if it cannot be met, the result is made
    /// as early as possible.
    pub(crate) required: u32,
}

/// The operation of an alternative on its children.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum AlternativeKind {
    /// A value of the surroundings, by its number.
    Leaf(u32),
    /// A number, by its bits.
    Number(u64),
    /// A sum; bit `i` is set when child `i` is subtracted.
    Sum(u64),
    /// A product.
    Product,
    /// Any other operation.
    Other(Operation),
}

/// One way to compute the value of a class.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Alternative {
    pub(crate) kind: AlternativeKind,
    /// Classes; one may occur several times.
    pub(crate) children: Vec<u32>,
}

impl Alternative {
    /// The number of operations that the alternative adds to its children.
    pub(crate) fn operations(&self) -> u32 {
        let count = self.children.len() as u32;
        match self.kind {
            AlternativeKind::Leaf(_) | AlternativeKind::Number(_) => 0,
            AlternativeKind::Sum(signs) => count - 1 + u32::from(all_negative(signs, count)),
            AlternativeKind::Product => count - 1,
            AlternativeKind::Other(_) => 1,
        }
    }

    /// Time at which the result is ready if the children are ready at these
    /// times: sums and products combine the two earliest first, which is the
    /// best tree (Golumbic 1976).
    pub(crate) fn arrival(&self, times: &SurroundingTimes<'_>, child: impl Fn(u32) -> u32) -> u32 {
        self.ready(times, |place| child(self.children[place]))
    }

    /// The same, from the times of the children in order.
    pub(crate) fn arrival_of(&self, times: &SurroundingTimes<'_>, arrivals: &[u32]) -> u32 {
        self.ready(times, |place| arrivals[place])
    }

    fn ready(&self, times: &SurroundingTimes<'_>, child: impl Fn(usize) -> u32) -> u32 {
        let places = 0..self.children.len();
        let (weight, zero) = match self.kind {
            AlternativeKind::Leaf(number) => return times.leaves[number as usize],
            AlternativeKind::Number(_) => return 0,
            AlternativeKind::Other(operation) => {
                let ready = places.map(child).fold(0, u32::max);
                return ready.saturating_add(times.weights.of(operation));
            }
            AlternativeKind::Sum(signs) => (
                times.weights.of(Operation::Add),
                all_negative(signs, self.children.len() as u32),
            ),
            AlternativeKind::Product => (times.weights.of(Operation::Mul), false),
        };
        if places.len() == 2 && !zero {
            return child(0).max(child(1)).saturating_add(weight);
        }
        let zero = zero.then_some(0);
        finish(places.map(child).chain(zero), weight)
    }
}

/// True for a sum that subtracts all its terms, which starts with a zero.
pub(crate) fn all_negative(signs: u64, count: u32) -> bool {
    signs.count_ones() == count
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct SurroundingTimes<'a> {
    /// The weights of operations.
    pub(crate) weights: &'a Weights,
    /// Time at which each leaf is ready.
    pub(crate) leaves: &'a [u32],
}

/// Classes with their alternatives.
#[derive(Clone, Default, Debug)]
pub(crate) struct Alternatives {
    pub(crate) classes: Vec<Vec<Alternative>>,
    /// For each alternative its form in the e-graph.
    pub(crate) origins: Vec<Vec<Option<EquivalentForm>>>,
}

impl Alternatives {
    /// All forms that can contribute to these classes of an e-graph, with the
    /// place of each class.
    pub(crate) fn of(graph: &EquivalenceGraph, roots: &[Id]) -> (Alternatives, Vec<u32>) {
        let mut collector = AlternativeCollector {
            graph,
            places: HashMap::default(),
            order: Vec::new(),
        };
        let roots = roots
            .iter()
            .map(|&root| collector.place(root, false))
            .collect();
        let mut alternatives = Alternatives::default();
        let mut next = 0;
        while let Some(&(class, negative)) = collector.order.get(next) {
            next += 1;
            let mut found = Vec::new();
            collector.alternatives(class, negative, &mut found);
            let (forms, origins) = found.into_iter().unzip();
            alternatives.classes.push(forms);
            alternatives.origins.push(origins);
        }
        (alternatives, roots)
    }
}

struct AlternativeCollector<'g> {
    graph: &'g EquivalenceGraph,
    places: HashMap<(Id, bool), u32, FxBuildHasher>,
    order: Vec<(Id, bool)>,
}

impl AlternativeCollector<'_> {
    fn place(&mut self, class: Id, negative: bool) -> u32 {
        let key = (self.graph.find(class), negative);
        *self.places.entry(key).or_insert_with(|| {
            self.order.push(key);
            self.order.len() as u32 - 1
        })
    }

    fn all(&mut self, children: &[Id]) -> Vec<u32> {
        let place = |&class| self.place(class, false);
        children.iter().map(place).collect()
    }

    fn alternatives(
        &mut self,
        class: Id,
        negative: bool,
        found: &mut Vec<(Alternative, Option<EquivalentForm>)>,
    ) {
        let graph = self.graph;
        if negative {
            let child = self.place(class, false);
            let minus = Alternative {
                kind: AlternativeKind::Sum(1),
                children: vec![child],
            };
            found.push((minus, None));
        }
        for form in graph.forms(class) {
            match form {
                EquivalentForm::Sum(1, children) if children.len() == 1 => {
                    let inner = graph.find(children[0]);
                    if inner == class {
                        continue;
                    }
                    if negative {
                        // The negation of a negation: what it is of.
                        self.positive(inner, found);
                    } else {
                        let child = self.place(inner, false);
                        let minus = Alternative {
                            kind: AlternativeKind::Sum(1),
                            children: vec![child],
                        };
                        found.push((minus, Some(form.clone())));
                        self.negated(inner, found);
                    }
                }
                _ if negative => self.negated_form(form, found),
                _ => self.form(form, found),
            }
        }
    }

    fn positive(&mut self, class: Id, found: &mut Vec<(Alternative, Option<EquivalentForm>)>) {
        for form in self.graph.forms(class) {
            if !matches!(form, EquivalentForm::Sum(_, children) if children.len() == 1) {
                self.form(form, found);
            }
        }
    }

    fn negated(&mut self, class: Id, found: &mut Vec<(Alternative, Option<EquivalentForm>)>) {
        for form in self.graph.forms(class) {
            if !matches!(form, EquivalentForm::Sum(_, children) if children.len() == 1) {
                self.negated_form(form, found);
            }
        }
    }

    fn form(
        &mut self,
        form: &EquivalentForm,
        found: &mut Vec<(Alternative, Option<EquivalentForm>)>,
    ) {
        let kind = match form {
            EquivalentForm::Leaf(number) => AlternativeKind::Leaf(*number),
            EquivalentForm::Number(bits) => AlternativeKind::Number(*bits),
            EquivalentForm::Sum(signs, _) => AlternativeKind::Sum(*signs),
            EquivalentForm::Product(_) => AlternativeKind::Product,
            EquivalentForm::Other(operation, _) => AlternativeKind::Other(*operation),
        };
        let children = self.all(egg::Language::children(form));
        found.push((Alternative { kind, children }, Some(form.clone())));
    }

    /// The negation of a form, where it costs no operation more.
    fn negated_form(
        &mut self,
        form: &EquivalentForm,
        found: &mut Vec<(Alternative, Option<EquivalentForm>)>,
    ) {
        let mut add = |kind, children| {
            found.push((Alternative { kind, children }, Some(form.clone())));
        };
        match form {
            EquivalentForm::Number(bits) => {
                add(
                    AlternativeKind::Number((-f64::from_bits(*bits)).to_bits()),
                    Vec::new(),
                );
            }
            EquivalentForm::Sum(signs, children) => {
                let turned = terms(*signs, children)
                    .enumerate()
                    .fold(0, |bits, (place, term)| {
                        bits | u64::from(!term.negative) << place
                    });
                add(AlternativeKind::Sum(turned), self.all(children));
            }
            EquivalentForm::Product(children) => {
                for (place, &factor) in children.iter().enumerate() {
                    if !self.turns(factor) {
                        continue;
                    }
                    let mut factors = self.all(children);
                    factors[place] = self.place(factor, true);
                    add(AlternativeKind::Product, factors);
                }
            }
            EquivalentForm::Other(operation @ (Operation::Div | Operation::Sin), children) => {
                if self.turns(children[0]) {
                    let mut operands = self.all(children);
                    operands[0] = self.place(children[0], true);
                    add(AlternativeKind::Other(*operation), operands);
                }
            }
            EquivalentForm::Leaf(_) | EquivalentForm::Other(..) => {}
        }
    }

    /// True when a class is available with the other sign at no cost, or
    /// earlier than after its product.
    fn turns(&self, class: Id) -> bool {
        !self.graph.forms(self.graph.find(class)).is_empty()
    }
}

/// The sum with all its terms turned costs an operation more only when it had
/// no subtracted term.
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_turns_for_free() {
        let mut graph = EquivalenceGraph::new();
        let (a, b) = (graph.leaf(0), graph.leaf(1));
        let difference = graph
            .sum(&[
                a.into(),
                super::super::form::ClassReference::from(b).negated(),
            ])
            .expect("narrow");
        let opposite = graph.value(difference.negated());
        graph.egraph.rebuild();
        let (alternatives, roots) = Alternatives::of(&graph, &[opposite]);
        let cheapest = alternatives.classes[roots[0] as usize]
            .iter()
            .filter(|form| form.children.len() == 2)
            .map(Alternative::operations)
            .min();
        assert_eq!(cheapest, Some(1));
    }
}
