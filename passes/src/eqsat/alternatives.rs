//! What extraction chooses from: classes of values, each with its forms.
//!
//! The e-graph keeps a value and its negation apart, and signs outside of
//! products. Here both become classes of their own where somebody needs them,
//! so that `b - a` costs no more than `a - b` when the opposite is wanted.

use super::form::{Form, terms};
use super::graph::Graph;
use crate::reassociate::finish;
use egg::Id;
use hashbrown::HashMap;
use robovec_analysis::critical_path::Weights;
use robovec_ir::Operation;
use rustc_hash::FxBuildHasher;

/// What an alternative computes from its children.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
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
    pub(crate) kind: Kind,
    /// Classes; one may stand several times.
    pub(crate) children: Vec<u32>,
}

impl Alternative {
    /// How many operations the alternative adds to its children.
    pub(crate) fn operations(&self) -> u32 {
        let count = self.children.len() as u32;
        match self.kind {
            Kind::Leaf(_) | Kind::Number(_) => 0,
            Kind::Sum(signs) => count - 1 + u32::from(all_negative(signs, count)),
            Kind::Product => count - 1,
            Kind::Other(_) => 1,
        }
    }

    /// When the result is ready if the children are ready at these times: sums
    /// and products combine the two earliest first, which is the best tree
    /// (Golumbic 1976).
    pub(crate) fn arrival(
        &self,
        times: &Times<'_>,
        scratch: &mut Vec<u32>,
        child: impl Fn(u32) -> u32,
    ) -> u32 {
        self.ready(times, scratch, |place| child(self.children[place]))
    }

    /// The same, from the times of the children in order.
    pub(crate) fn arrival_of(
        &self,
        times: &Times<'_>,
        scratch: &mut Vec<u32>,
        arrivals: &[u32],
    ) -> u32 {
        self.ready(times, scratch, |place| arrivals[place])
    }

    fn ready(
        &self,
        times: &Times<'_>,
        scratch: &mut Vec<u32>,
        child: impl Fn(usize) -> u32,
    ) -> u32 {
        let places = 0..self.children.len();
        let (weight, zero) = match self.kind {
            Kind::Leaf(number) => return times.leaves[number as usize],
            Kind::Number(_) => return 0,
            Kind::Other(operation) => {
                let ready = places.map(child).max();
                let weight = times.weights.of(operation);
                return ready.unwrap_or(0).saturating_add(weight);
            }
            Kind::Sum(signs) => (
                times.weights.of(Operation::Add),
                all_negative(signs, self.children.len() as u32),
            ),
            Kind::Product => (times.weights.of(Operation::Mul), false),
        };
        if places.len() == 2 && !zero {
            return child(0).max(child(1)).saturating_add(weight);
        }
        scratch.clear();
        if zero {
            scratch.push(0);
        }
        scratch.extend(places.map(child));
        scratch.sort_unstable();
        finish(scratch, weight)
    }
}

/// True for a sum that subtracts all its terms, which starts with a zero.
pub(crate) fn all_negative(signs: u64, count: u32) -> bool {
    signs.count_ones() == count
}

/// The times of the surroundings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Times<'a> {
    /// What operations weigh.
    pub(crate) weights: &'a Weights,
    /// When each leaf is ready.
    pub(crate) leaves: &'a [u32],
}

/// Classes with their alternatives.
#[derive(Clone, Default, Debug)]
pub(crate) struct Alternatives {
    pub(crate) classes: Vec<Vec<Alternative>>,
    /// For each alternative the form of the e-graph it came from.
    pub(crate) origins: Vec<Vec<Option<Form>>>,
}

impl Alternatives {
    /// All that can take part in computing these classes of an e-graph; also
    /// the place of each of them.
    pub(crate) fn of(graph: &Graph, roots: &[Id]) -> (Alternatives, Vec<u32>) {
        let mut collector = Collector {
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

struct Collector<'g> {
    graph: &'g Graph,
    places: HashMap<(Id, bool), u32, FxBuildHasher>,
    order: Vec<(Id, bool)>,
}

impl Collector<'_> {
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
        found: &mut Vec<(Alternative, Option<Form>)>,
    ) {
        let graph = self.graph;
        if negative {
            let child = self.place(class, false);
            let minus = Alternative {
                kind: Kind::Sum(1),
                children: vec![child],
            };
            found.push((minus, None));
        }
        for form in graph.forms(class) {
            match form {
                Form::Sum(1, children) if children.len() == 1 => {
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
                            kind: Kind::Sum(1),
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

    fn positive(&mut self, class: Id, found: &mut Vec<(Alternative, Option<Form>)>) {
        for form in self.graph.forms(class) {
            if !matches!(form, Form::Sum(_, children) if children.len() == 1) {
                self.form(form, found);
            }
        }
    }

    fn negated(&mut self, class: Id, found: &mut Vec<(Alternative, Option<Form>)>) {
        for form in self.graph.forms(class) {
            if !matches!(form, Form::Sum(_, children) if children.len() == 1) {
                self.negated_form(form, found);
            }
        }
    }

    fn form(&mut self, form: &Form, found: &mut Vec<(Alternative, Option<Form>)>) {
        let kind = match form {
            Form::Leaf(number) => Kind::Leaf(*number),
            Form::Number(bits) => Kind::Number(*bits),
            Form::Sum(signs, _) => Kind::Sum(*signs),
            Form::Product(_) => Kind::Product,
            Form::Other(operation, _) => Kind::Other(*operation),
        };
        let children = self.all(egg::Language::children(form));
        found.push((Alternative { kind, children }, Some(form.clone())));
    }

    /// The negation of a form, where it costs no operation more.
    fn negated_form(&mut self, form: &Form, found: &mut Vec<(Alternative, Option<Form>)>) {
        let mut add = |kind, children| {
            found.push((Alternative { kind, children }, Some(form.clone())));
        };
        match form {
            Form::Number(bits) => {
                add(Kind::Number((-f64::from_bits(*bits)).to_bits()), Vec::new());
            }
            Form::Sum(signs, children) => {
                let turned = terms(*signs, children)
                    .enumerate()
                    .fold(0, |bits, (place, term)| {
                        bits | u64::from(!term.negative) << place
                    });
                add(Kind::Sum(turned), self.all(children));
            }
            Form::Product(children) => {
                for (place, &factor) in children.iter().enumerate() {
                    if !self.turns(factor) {
                        continue;
                    }
                    let mut factors = self.all(children);
                    factors[place] = self.place(factor, true);
                    add(Kind::Product, factors);
                }
            }
            Form::Other(operation @ (Operation::Div | Operation::Sin), children) => {
                if self.turns(children[0]) {
                    let mut operands = self.all(children);
                    operands[0] = self.place(children[0], true);
                    add(Kind::Other(*operation), operands);
                }
            }
            Form::Leaf(_) | Form::Other(..) => {}
        }
    }

    /// True when a class can be had with the other sign at no cost, or
    /// earlier than after the product it is in.
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
        let mut graph = Graph::new();
        let (a, b) = (graph.leaf(0), graph.leaf(1));
        let difference = graph
            .sum(&[a.into(), super::super::form::Term::from(b).negated()])
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
