//! The search for occurrences of a pattern over bags in the e-graph.
//!
//! A sum pattern matches the same number of terms of a sum, in any selection;
//! at the root of a rule the remaining terms are kept beside the result.
//! Inside, the last free variable takes all that is left, so that `b + c`
//! splits a wide sum into each term and its rest. A sign that the pattern does
//! not contain is given to the last free variable of a product, as signs are.
//!
//! Every step is counted, and matching ends at the limit: the matches found
//! depend on the e-graph alone.

use super::form::{ClassReference, EquivalentForm};
use super::graph::EquivalenceGraph;
use super::pattern::{Bag, SignedPattern};
use egg::Id;

#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum VariableBinding {
    /// One term.
    Term(ClassReference),
    /// The sum of several terms of a wider sum.
    Sum(Vec<ClassReference>),
    /// The product of several factors of a wider product.
    Product(Vec<Id>, bool),
}

/// A place where a rule applies.
#[derive(Clone, Debug)]
pub(crate) struct RuleMatch {
    /// The class of which it states something.
    pub(crate) class: Id,
    pub(crate) bindings: Vec<Option<VariableBinding>>,
    /// The terms beside the matched ones, or the factors.
    pub(crate) rest: Vec<ClassReference>,
    /// The matched part is the negation of the pattern.
    pub(crate) negative: bool,
}

/// Finds matches of one pattern within a number of steps.
pub(crate) struct Matcher<'g> {
    graph: &'g EquivalenceGraph,
    steps: u32,
    bindings: Vec<Option<VariableBinding>>,
    found: Vec<RuleMatch>,
}

/// The continuation after a part has matched.
type Next<'n> = &'n mut dyn FnMut(&mut Matcher<'_>);
/// The same, with the unmatched terms.
type NextTerms<'n> = &'n mut dyn FnMut(&mut Matcher<'_>, &[ClassReference]);

impl<'g> Matcher<'g> {
    /// A matcher for a pattern of this number of variables.
    pub(crate) fn new(graph: &'g EquivalenceGraph, variables: usize, steps: u32) -> Matcher<'g> {
        Matcher {
            graph,
            steps,
            bindings: vec![None; variables],
            found: Vec::new(),
        }
    }

    /// The matches of a pattern in these classes, and the steps left.
    pub(crate) fn run(mut self, pattern: &SignedPattern, classes: &[Id]) -> (Vec<RuleMatch>, u32) {
        for &class in classes {
            if self.steps == 0 {
                break;
            }
            self.root(pattern, class);
        }
        (self.found, self.steps)
    }

    fn step(&mut self) -> bool {
        self.steps = self.steps.saturating_sub(1);
        self.steps > 0
    }

    fn root(&mut self, pattern: &SignedPattern, class: Id) {
        let report = |matcher: &mut Matcher<'_>, rest: &[ClassReference], negative: bool| {
            matcher.found.push(RuleMatch {
                class,
                bindings: matcher.bindings.clone(),
                rest: rest.to_vec(),
                negative,
            });
        };
        match &pattern.bag {
            Bag::Sum(summands) => {
                let sums: Vec<Vec<ClassReference>> = self.graph.sums(class).collect();
                for terms in sums {
                    self.sum(summands, &terms, true, &mut |matcher, rest| {
                        report(matcher, rest, pattern.negative);
                    });
                    if is_rigid(&pattern.bag) {
                        let turned: Vec<ClassReference> =
                            terms.iter().map(|term| term.negated()).collect();
                        self.sum(summands, &turned, true, &mut |matcher, rest| {
                            let rest: Vec<ClassReference> =
                                rest.iter().map(|term| term.negated()).collect();
                            report(matcher, &rest, !pattern.negative);
                        });
                    }
                }
            }
            Bag::Product(factors) => {
                for factors_here in self.products(class) {
                    let pattern_factors: Vec<&Bag> = factors.iter().collect();
                    self.product(
                        &pattern_factors,
                        &factors_here,
                        false,
                        true,
                        &mut |matcher, rest| report(matcher, rest, pattern.negative),
                    );
                }
            }
            // A variable alone would match everything, a number only itself.
            Bag::Variable(_) | Bag::Number(_) => {}
            Bag::Other(..) => {
                self.term(&pattern.bag, ClassReference::from(class), &mut |matcher| {
                    report(matcher, &[], pattern.negative);
                })
            }
        }
    }

    fn products(&self, class: Id) -> Vec<Vec<Id>> {
        let forms = self.graph.forms(self.graph.find(class)).iter();
        forms
            .filter_map(|form| match form {
                EquivalentForm::Product(children) => Some(children.to_vec()),
                _ => None,
            })
            .collect()
    }

    fn bind(&mut self, variable: u32, binding: VariableBinding, next: Next<'_>) {
        let place = variable as usize;
        match &self.bindings[place] {
            Some(known) if *known == binding => next(self),
            Some(_) => {}
            None => {
                self.bindings[place] = Some(binding);
                next(self);
                self.bindings[place] = None;
            }
        }
    }

    fn term(&mut self, pattern: &Bag, term: ClassReference, next: Next<'_>) {
        if !self.step() {
            return;
        }
        let term = ClassReference {
            class: self.graph.find(term.class),
            ..term
        };
        match pattern {
            Bag::Variable(variable) => self.bind(*variable, VariableBinding::Term(term), next),
            Bag::Number(bits) => {
                let number = self.graph.number_of(term.class).map(f64::to_bits);
                if number == Some(*bits) && (!term.negative || *bits == 0) {
                    next(self);
                }
            }
            Bag::Sum(summands) => {
                let sums: Vec<Vec<ClassReference>> = self.graph.sums(term.class).collect();
                for terms in sums {
                    let terms: Vec<ClassReference> = terms
                        .iter()
                        .map(|inner| inner.signed(term.negative))
                        .collect();
                    self.sum(summands, &terms, false, &mut |matcher, _| next(matcher));
                }
            }
            Bag::Product(factors) => {
                for factors_here in self.products(term.class) {
                    let patterns: Vec<&Bag> = factors.iter().collect();
                    self.product(
                        &patterns,
                        &factors_here,
                        term.negative,
                        false,
                        &mut |matcher, _| next(matcher),
                    );
                }
            }
            Bag::Other(operation, operands) => {
                if term.negative {
                    return;
                }
                let forms: Vec<Vec<Id>> = self
                    .graph
                    .forms(term.class)
                    .iter()
                    .filter_map(|form| match form {
                        EquivalentForm::Other(other, children) if other == operation => {
                            Some(children.to_vec())
                        }
                        _ => None,
                    })
                    .collect();
                for children in forms {
                    self.operands(operands, &children, next);
                }
            }
        }
    }

    fn operands(&mut self, patterns: &[SignedPattern], children: &[Id], next: Next<'_>) {
        let (Some((pattern, patterns)), Some((&child, children))) =
            (patterns.split_first(), children.split_first())
        else {
            return next(self);
        };
        let term = ClassReference {
            class: child,
            negative: pattern.negative,
        };
        self.term(&pattern.bag, term, &mut |matcher| {
            matcher.operands(patterns, children, next);
        });
    }

    /// Matches patterns with terms of a sum. The unmatched terms are bound to
    /// the last free variable, unless they may be left unmatched.
    fn sum(
        &mut self,
        patterns: &[SignedPattern],
        terms: &[ClassReference],
        open: bool,
        next: NextTerms<'_>,
    ) {
        if patterns.len() > terms.len() {
            return;
        }
        let ordered = in_order(patterns.iter().map(|signed| (signed, &signed.bag)));
        self.sum_from(&ordered, terms, open, next);
    }

    fn sum_from(
        &mut self,
        patterns: &[&SignedPattern],
        terms: &[ClassReference],
        open: bool,
        next: NextTerms<'_>,
    ) {
        let Some((pattern, later)) = patterns.split_first() else {
            if open || terms.is_empty() {
                next(self, terms);
            }
            return;
        };
        if !self.step() {
            return;
        }
        if let Bag::Variable(variable) = pattern.bag
            && later.is_empty()
            && !open
            && terms.len() > 1
        {
            let rest: Vec<ClassReference> = terms
                .iter()
                .map(|term| term.signed(pattern.negative))
                .collect();
            return self.bind(variable, VariableBinding::Sum(rest), &mut |matcher| {
                next(matcher, &[]);
            });
        }
        for (place, term) in terms.iter().enumerate() {
            let rest: Vec<ClassReference> = without(terms, place);
            self.term(
                &pattern.bag,
                term.signed(pattern.negative),
                &mut |matcher| {
                    matcher.sum_from(later, &rest, open, next);
                },
            );
        }
    }

    /// Matches patterns with factors; `negative` is a sign still to be placed.
    fn product(
        &mut self,
        patterns: &[&Bag],
        factors: &[Id],
        negative: bool,
        open: bool,
        next: NextTerms<'_>,
    ) {
        if patterns.len() > factors.len() {
            return;
        }
        // Known variables first: they leave no choice.
        let mut ordered = in_order(patterns.iter().map(|&bag| (bag, bag)));
        ordered.sort_by_key(|bag| match bag {
            Bag::Variable(variable) if self.bindings[*variable as usize].is_none() => 1,
            _ => 0,
        });
        self.product_from(&ordered, factors, negative, open, next);
    }

    fn product_from(
        &mut self,
        patterns: &[&Bag],
        factors: &[Id],
        negative: bool,
        open: bool,
        next: NextTerms<'_>,
    ) {
        let Some((pattern, later)) = patterns.split_first() else {
            if negative || !(open || factors.is_empty()) {
                return;
            }
            let rest: Vec<ClassReference> = factors
                .iter()
                .map(|&factor| ClassReference::from(factor))
                .collect();
            return next(self, &rest);
        };
        if !self.step() {
            return;
        }
        let known = match pattern {
            Bag::Variable(variable) => self.bindings[*variable as usize].clone(),
            _ => None,
        };
        if let Some(known) = known {
            return self.known_factor(&known, later, factors, negative, open, next);
        }
        if let Bag::Variable(variable) = pattern
            && later.is_empty()
            && factors.len() > 1
        {
            let rest = VariableBinding::Product(factors.to_vec(), negative);
            self.bind(*variable, rest, &mut |matcher| next(matcher, &[]));
            if !open {
                return;
            }
        }
        let free = matches!(pattern, Bag::Variable(_));
        // The last pattern that can takes the sign.
        let last = free && later.is_empty();
        for (place, &factor) in factors.iter().enumerate() {
            let rest = without(factors, place);
            for turned in [false, true] {
                // A factor that cannot take a sign itself is tried with both.
                if turned && (free || !is_rigid(pattern)) {
                    continue;
                }
                let sign = turned ^ (last && negative);
                let term = ClassReference {
                    class: factor,
                    negative: sign,
                };
                self.term(pattern, term, &mut |matcher| {
                    matcher.product_from(later, &rest, negative ^ sign, open, next);
                });
            }
        }
    }

    /// A variable already bound: its factors must be among those here.
    fn known_factor(
        &mut self,
        known: &VariableBinding,
        later: &[&Bag],
        factors: &[Id],
        negative: bool,
        open: bool,
        next: NextTerms<'_>,
    ) {
        let mut rest = factors.to_vec();
        let (wanted, sign): (&[Id], bool) = match known {
            VariableBinding::Term(term) => (std::slice::from_ref(&term.class), term.negative),
            VariableBinding::Product(classes, sign) => (classes, *sign),
            VariableBinding::Sum(_) => return,
        };
        for class in wanted {
            match rest.iter().position(|factor| factor == class) {
                Some(place) => {
                    rest.remove(place);
                }
                None => return,
            }
        }
        self.product_from(later, &rest, negative ^ sign, open, next);
    }
}

/// Compound patterns come before variables, because they have the fewest
/// matches.
fn in_order<'p, T: Copy>(patterns: impl Iterator<Item = (T, &'p Bag)>) -> Vec<T> {
    let (mut compound, mut variables) = (Vec::new(), Vec::new());
    for (pattern, bag) in patterns {
        match bag {
            Bag::Variable(_) => variables.push(pattern),
            _ => compound.push(pattern),
        }
    }
    compound.append(&mut variables);
    compound
}

fn without<T: Copy>(items: &[T], place: usize) -> Vec<T> {
    let mut rest = items.to_vec();
    rest.remove(place);
    rest
}

/// A sum pattern with a term that has no variable to take a sign must be
/// tried with both.
fn is_rigid(bag: &Bag) -> bool {
    let flexible = |bag: &Bag| match bag {
        Bag::Variable(_) => true,
        Bag::Product(factors) => factors.iter().any(|bag| matches!(bag, Bag::Variable(_))),
        _ => false,
    };
    match bag {
        Bag::Sum(summands) => !summands.iter().all(|term| flexible(&term.bag)),
        _ => false,
    }
}
