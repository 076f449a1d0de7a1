//! Look-ahead: values as linear functions of values further back.
//!
//! The sums of a recursion are linear in what is late: `x = Σ c·u + e`, the
//! coefficients `c` and the remainder `e` being ready long before the `u`.
//! Substituting the same form of each `u` gives `x` as a linear function of
//! what the `u` depend on, with coefficients that can be computed beside the
//! recursion.
//!
//! How far back is measured in time: at a *frontier* a class is written in
//! what was available then, every variable behind it having been replaced by
//! its own form at the same frontier. Variables of one frontier are thus of
//! one age, and few: the state of the recursion. A form is composed directly,
//! of the class's equation and the forms of its operands, and of the form at a
//! nearer frontier and the forms of its variables. Both ways compute the same
//! coefficients and the same remainder, so they meet in the same classes, and
//! choosing among them is choosing a parallel prefix network (Sklansky 1960;
//! Kogge and Stone 1973; Ladner and Fischer 1980) by arrival times.
//! Coefficients are the same for all right-hand sides of a recursion (the
//! columns of a mass matrix), and are found to be.

use super::import::{Import, import};
use super::network::{ChoiceForm, ChoiceNetwork, Class, ProductTerm, SignedClass};
use super::timing::Arrivals;
use robovec_analysis::critical_path::Weights;
use robovec_framework::pass::Context;
use robovec_ir::Function;
use std::rc::Rc;

/// The limits on the reach and the width of forms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CompositionLimits {
    /// Cycles from one frontier to the next.
    pub(crate) grid: u32,
    /// The number of frontiers a form looks back; of every distance.
    pub(crate) frontiers: u32,
    /// The number of times that the distance between frontiers is doubled for
    /// looking further back.
    pub(crate) doublings: u32,
    /// A form has at most so many late terms.
    pub(crate) width: usize,
    /// A variable that is available so many cycles before the frontier is
    /// summed up with what is known early.
    pub(crate) window: u32,
}

/// `Σ coefficient · variable + rest`, the value of a class with its sign.
#[derive(Clone, PartialEq, Debug)]
struct Linear {
    terms: Vec<(SignedClass, Class)>,
    rest: Option<SignedClass>,
}

/// A function as a network whose classes have forms that look back, and the
/// number of equations of the longest chain that is linear in its latest
/// values. `None`, with a remark, when nothing can be said of the function.
pub(crate) fn look_ahead(
    function: &Function,
    context: &mut Context<'_>,
    timing: Weights,
    limits: CompositionLimits,
) -> Option<(Import, u32)> {
    let Some(mut import) = import(function, context.tables, timing) else {
        let reason = "a value is undefined everywhere; nothing is changed";
        context.remarks.push(reason.to_owned());
        return None;
    };
    let chain = add_forms(&mut import, limits);
    Some((import, chain))
}

fn add_forms(import: &mut Import, limits: CompositionLimits) -> u32 {
    let mut composer = Composer {
        network: &mut import.network,
        reference: &import.arrivals,
        limits,
        chains: Vec::new(),
        forms: Vec::new(),
    };
    for &class in &import.classes {
        let origin = composer.network.origin_of(class);
        composer.network.origin = origin;
        composer.extend(class);
    }
    composer.chains.into_iter().max().unwrap_or(0)
}

struct Composer<'a> {
    network: &'a mut ChoiceNetwork,
    /// Arrivals of the function as it was read: they place the frontiers.
    reference: &'a Arrivals,
    limits: CompositionLimits,
    /// By class: how many equations lie behind it, one linear in the latest
    /// value of the next.
    chains: Vec<u32>,
    /// By class: its forms by frontier, the nearest first.
    forms: Vec<Vec<(u32, Option<Rc<Linear>>)>>,
}

impl Composer<'_> {
    /// All forms of a class whose operands have theirs.
    fn extend(&mut self, class: Class) {
        let Some(base) = self.base(class) else {
            return;
        };
        let count = class.index() + 1;
        if self.chains.len() < count {
            self.chains.resize(count, 0);
            self.forms.resize(count, Vec::new());
        }
        let latest = base.terms.iter().map(|&(_, variable)| variable);
        let latest = latest.max_by_key(|&variable| (self.reference.of(variable), variable));
        let behind = latest.and_then(|variable| self.chains.get(variable.index()));
        self.chains[class.index()] = 1 + behind.copied().unwrap_or(0);
        let frontiers = self.frontiers(self.reference.of(class));
        for &frontier in &frontiers {
            let mut made = self.compose(class, &base, frontier);
            if let Some(middle) = self.middle(class, frontiers[0], frontier) {
                let split = self.compose(class, &middle, frontier);
                made = made.or(split);
            }
            self.forms[class.index()].push((frontier, made));
        }
    }

    /// The frontiers of a class, the nearest first. Whatever lies between the
    /// class and one of its frontiers has that frontier too.
    fn frontiers(&self, arrival: u32) -> Vec<u32> {
        let first = (arrival.max(1) - 1) / self.limits.grid;
        let mut frontiers: Vec<u32> = Vec::new();
        for level in 0..=self.limits.doublings.min(31) {
            let nearest = first >> level << level;
            for back in 0..self.limits.frontiers {
                let Some(frontier) = nearest.checked_sub(back << level) else {
                    break;
                };
                if frontiers.last().is_none_or(|&last| frontier < last) {
                    frontiers.push(frontier);
                }
            }
        }
        frontiers
    }

    /// The form half way to a frontier.
    fn middle(&self, class: Class, first: u32, frontier: u32) -> Option<Rc<Linear>> {
        let half = frontier + (first - frontier).div_ceil(2);
        let forms = self.forms[class.index()].iter();
        let made = forms.filter_map(|(at, form)| Some((*at, form.as_ref()?)));
        let nearest = made.min_by_key(|(at, _)| at.abs_diff(half));
        nearest.map(|(_, form)| Rc::clone(form))
    }

    /// The form of a class at a frontier, or at the nearest one before it.
    fn form_of(&self, class: Class, frontier: u32) -> Option<Rc<Linear>> {
        let forms = self.forms.get(class.index())?;
        let near = forms.iter().take_while(|(at, _)| *at >= frontier);
        near.filter_map(|(_, form)| form.as_ref()).last().cloned()
    }

    /// The class's own form.
    fn base(&mut self, class: Class) -> Option<Linear> {
        let first = self.network.forms(class).last()?;
        let form = self.network.form(first);
        let terms: Vec<(SignedClass, Class)> = match form {
            ChoiceForm::Sum(..) => {
                let terms = self.network.terms(form).to_vec();
                terms.into_iter().map(|term| self.split(term)).collect()
            }
            ChoiceForm::Product(..) => {
                let mut factors: Vec<Class> =
                    self.network.terms(form).iter().map(|term| term.a).collect();
                factors.sort_by_key(|&factor| (self.reference.of(factor), factor));
                let last = factors.pop()?;
                let coefficient = self.network.product(&mut factors);
                vec![(coefficient, last)]
            }
            _ => return None,
        };
        let plain: Vec<ProductTerm> = terms.iter().map(|&term| as_term(term)).collect();
        let value = self.network.sum_value(&plain);
        let negated = value.is_negation_of(&self.network.value(class));
        let signed = |(coefficient, variable): (SignedClass, Class)| {
            let negative = coefficient.negative ^ negated;
            (
                SignedClass {
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
    fn split(&self, term: ProductTerm) -> (SignedClass, Class) {
        let key = |class: Class| (self.reference.of(class), class);
        let (class, variable) = match key(term.a) <= key(term.b) {
            true => (term.a, term.b),
            false => (term.b, term.a),
        };
        let negative = term.negative;
        (SignedClass { class, negative }, variable)
    }

    /// Substitutes the forms at a frontier for the variables behind it; adds
    /// the result to the class.
    fn compose(&mut self, class: Class, outer: &Linear, frontier: u32) -> Option<Rc<Linear>> {
        let time = frontier * self.limits.grid;
        let mut collected: Vec<(Class, Vec<ProductTerm>)> = Vec::new();
        let mut rest: Vec<ProductTerm> = Vec::new();
        rest.extend(outer.rest.map(plain));
        let mut collect = |variable: Class, term: ProductTerm| match collected
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
            if let Some(coefficient) = self.network.sum(coefficient) {
                terms.push((coefficient, variable));
            }
        }
        let rest = self.network.sum(rest);
        let mut form: Vec<ProductTerm> = terms.iter().map(|&term| as_term(term)).collect();
        form.extend(rest.map(plain));
        self.network.tidy(&mut form);
        self.network.add_sum(class, &mut form);
        Some(Rc::new(Linear { terms, rest }))
    }
}

/// A signed class as a term.
fn plain(signed: SignedClass) -> ProductTerm {
    ProductTerm {
        a: signed.class,
        b: Class::ONE,
        negative: signed.negative,
    }
}

fn as_term((coefficient, variable): (SignedClass, Class)) -> ProductTerm {
    ProductTerm {
        a: coefficient.class,
        b: variable,
        negative: coefficient.negative,
    }
}

fn product(a: SignedClass, b: SignedClass) -> ProductTerm {
    ProductTerm {
        a: a.class,
        b: b.class,
        negative: a.negative ^ b.negative,
    }
}
