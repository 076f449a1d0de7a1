//! Look-ahead: values as linear functions of values further back.
//!
//! The sums of a recursion are linear in what is late: `x = Σ c·u + e`, the
//! coefficients `c` and the remainder `e` being ready long before the `u`.
//! Substituting the same form of each `u` gives `x` as a linear function of
//! what the `u` depend on, two steps back, with coefficients that can be
//! computed beside the recursion. A form that goes back `d` steps is composed
//! of one that goes back `i` and of ones that go back `d - i`; every split is
//! another way to compute the same coefficients and the same remainder, so
//! they meet in the same classes, and choosing among them is choosing a
//! parallel prefix network (Kogge and Stone 1973; Ladner and Fischer 1980) by
//! arrival times. Coefficients are the same for all right-hand sides of a
//! recursion (the columns of a mass matrix), and are found to be.

use super::import::Import;
use super::network::{Class, Form, Network, Signed, Term, add, negate};
use super::timing::{Arrivals, Timing};
use std::rc::Rc;

/// How far and how wide forms go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Cycles from one frontier to the next.
    pub(crate) grid: u32,
    /// How many frontiers a form looks back.
    pub(crate) frontiers: u32,
    /// A form has at most so many late terms.
    pub(crate) width: usize,
    /// A variable that is available so many cycles before the frontier is
    /// summed up with what is known early.
    pub(crate) window: u32,
}

/// `Σ coefficient · variable + rest`, the value of a class with its sign.
#[derive(Clone, PartialEq, Debug)]
struct Linear {
    terms: Vec<(Signed, Class)>,
    rest: Option<Signed>,
}

/// Adds forms that look back to all classes of a function.
pub(crate) fn look_ahead(import: &mut Import, timing: Timing, limits: Limits) {
    let mut composer = Composer {
        network: &mut import.network,
        reference: import.arrivals.clone(),
        arrivals: &mut import.arrivals,
        timing,
        limits,
        bases: Vec::new(),
        forms: Vec::new(),
    };
    for &class in &import.classes {
        let origin = composer.network.origin_of(class);
        composer.network.origin = origin;
        composer.extend(class);
    }
}

struct Composer<'a> {
    network: &'a mut Network,
    /// Arrivals of the function as it was read: they place the frontiers.
    reference: Arrivals,
    /// Earliest arrivals by all forms made so far.
    arrivals: &'a mut Arrivals,
    timing: Timing,
    limits: Limits,
    /// By class: its own form.
    bases: Vec<Option<Linear>>,
    /// By class: the frontier of its first form and its forms, frontier by
    /// frontier back.
    forms: Vec<(u32, Vec<Option<Rc<Linear>>>)>,
}

impl Composer<'_> {
    /// All forms of a class whose operands have theirs.
    fn extend(&mut self, class: Class) {
        let Some(base) = self.base(class) else {
            return;
        };
        let count = class.index() + 1;
        if self.bases.len() < count {
            self.bases.resize(count, None);
            self.forms.resize(count, (0, Vec::new()));
        }
        let arrival = self.reference.of(class);
        let first = (arrival.max(1) - 1) / self.limits.grid;
        self.bases[class.index()] = Some(base.clone());
        self.forms[class.index()] = (first, Vec::new());
        let base = Rc::new(base);
        for back in 0..self.limits.frontiers.min(first + 1) {
            let frontier = first - back;
            let mut made = self.compose(class, &base, frontier);
            if back >= 2 {
                let middle = self.form_of(class, first - back / 2);
                if let Some(middle) = middle {
                    let split = self.compose(class, &middle, frontier);
                    made = made.or(split);
                }
            }
            self.forms[class.index()].1.push(made);
        }
    }

    /// The form of a class at a frontier.
    fn form_of(&self, class: Class, frontier: u32) -> Option<Rc<Linear>> {
        let (first, forms) = self.forms.get(class.index())?;
        let back = first.checked_sub(frontier)? as usize;
        let nearest = forms.iter().take(back + 1).rev().find_map(Option::as_ref);
        nearest.cloned()
    }

    /// The class's own form.
    fn base(&mut self, class: Class) -> Option<Linear> {
        let first = self.network.forms(class).last()?;
        let form = self.network.form(first);
        let terms: Vec<(Signed, Class)> = match form {
            Form::Sum(..) => {
                let terms = self.network.terms(form).to_vec();
                terms.into_iter().map(|term| self.split(term)).collect()
            }
            Form::Product(..) => {
                let mut factors: Vec<Class> =
                    self.network.terms(form).iter().map(|term| term.a).collect();
                factors.sort_by_key(|&factor| (self.arrivals.of(factor), factor));
                let last = factors.pop()?;
                let coefficient = self.network.product(&mut factors);
                self.arrivals
                    .update(self.network, &self.timing, coefficient.class);
                vec![(coefficient, last)]
            }
            _ => return None,
        };
        let value = terms.iter().fold([0, 0], |sum, &term| {
            add(sum, self.network.term_value(as_term(term)))
        });
        let negated = value != self.network.value(class);
        debug_assert!(!negated || negate(value) == self.network.value(class));
        let signed = |(coefficient, variable): (Signed, Class)| {
            let negative = coefficient.negative ^ negated;
            (
                Signed {
                    negative,
                    ..coefficient
                },
                variable,
            )
        };
        Some(Linear {
            terms: terms.into_iter().map(signed).collect(),
            rest: None,
        })
    }

    /// A term as coefficient and variable, the variable being the later one.
    fn split(&self, term: Term) -> (Signed, Class) {
        let key = |class: Class| (self.reference.of(class), class);
        let (class, variable) = match key(term.a) <= key(term.b) {
            true => (term.a, term.b),
            false => (term.b, term.a),
        };
        let negative = term.negative;
        (Signed { class, negative }, variable)
    }

    /// Substitutes the forms at a frontier for the variables behind it; adds
    /// the result to the class.
    fn compose(&mut self, class: Class, outer: &Linear, frontier: u32) -> Option<Rc<Linear>> {
        let time = frontier * self.limits.grid;
        let mut collected: Vec<(Class, Vec<Term>)> = Vec::new();
        let mut rest: Vec<Term> = Vec::new();
        rest.extend(outer.rest.map(plain));
        let mut collect = |variable: Class, term: Term| match collected
            .iter_mut()
            .find(|(known, _)| *known == variable)
        {
            Some((_, terms)) => terms.push(term),
            None => collected.push((variable, vec![term])),
        };
        for &(outer_coefficient, variable) in &outer.terms {
            let arrival = self.reference.of(variable);
            if arrival.saturating_add(self.limits.window) <= time || arrival == 0 {
                rest.push(as_term((outer_coefficient, variable)));
                continue;
            }
            let inner = match arrival > time {
                true => self.form_of(variable, frontier),
                false => None,
            };
            let Some(inner) = inner else {
                collect(variable, plain(outer_coefficient));
                continue;
            };
            for &(coefficient, variable) in &inner.terms {
                collect(variable, product(outer_coefficient, coefficient));
            }
            rest.extend(inner.rest.map(|rest| product(outer_coefficient, rest)));
        }
        if collected.is_empty() || collected.len() > self.limits.width {
            return None;
        }
        let mut terms = Vec::with_capacity(collected.len());
        for (variable, coefficient) in collected {
            if let Some(coefficient) = self.sum(coefficient) {
                terms.push((coefficient, variable));
            }
        }
        let rest = self.sum(rest);
        let mut form: Vec<Term> = terms.iter().map(|&term| as_term(term)).collect();
        form.extend(rest.map(plain));
        self.network.tidy(&mut form);
        self.network.add_sum(class, &mut form);
        self.arrivals.update(self.network, &self.timing, class);
        Some(Rc::new(Linear { terms, rest }))
    }

    fn sum(&mut self, terms: Vec<Term>) -> Option<Signed> {
        let sum = self.network.sum(terms);
        if let Some(signed) = sum {
            self.arrivals
                .update(self.network, &self.timing, signed.class);
        }
        sum
    }
}

/// A signed class as a term.
fn plain(signed: Signed) -> Term {
    Term {
        a: signed.class,
        b: Class::ONE,
        negative: signed.negative,
    }
}

fn as_term((coefficient, variable): (Signed, Class)) -> Term {
    Term {
        a: coefficient.class,
        b: variable,
        negative: coefficient.negative,
    }
}

fn product(a: Signed, b: Signed) -> Term {
    Term {
        a: a.class,
        b: b.class,
        negative: a.negative ^ b.negative,
    }
}
