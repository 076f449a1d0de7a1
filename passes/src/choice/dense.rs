//! A network seen by class, for going over it again and again.
//!
//! Classes are in order of rank, so that operands come first and are stored
//! near their users.

use super::forms::ChoiceForm;
use super::network::ChoiceNetwork;
use super::term::{Class, ProductTerm};
use crate::sums::earliest::{LatestTwo, joined, levels};
use robovec_analysis::critical_path::Weights;
use robovec_ir::Operation;
use smallvec::SmallVec;
use std::ops::Range;

/// State of a class that its users read while forms are chosen.
#[derive(Clone, Copy, Default, Debug)]
pub(crate) struct FlowState {
    /// The operations that each user has; no number while nothing is known.
    pub(crate) flow: f64,
    pub(crate) arrival: u32,
}

impl FlowState {
    /// The state of a class that no form was chosen for yet.
    pub(crate) const UNKNOWN: FlowState = FlowState {
        flow: f64::NAN,
        arrival: 0,
    };

    pub(crate) fn is_known(&self) -> bool {
        !self.flow.is_nan()
    }
}

/// Cost and time of a form, as far as the states of its operands are known.
pub(crate) enum FormFlow {
    /// Its operations and its share of those of its operands, a time before
    /// which it is not available, and a flag: true when it is available then.
    Found(f64, (u32, bool)),
    /// The operations are more than was requested.
    TooMuch,
    /// The first operand whose state is missing, which is needed.
    Missing(usize),
}

/// The forms of a network by class, in the order they were made.
pub(crate) struct FormsByClass<'a> {
    network: &'a ChoiceNetwork,
    timing: Weights,
    add: u32,
    multiply: u32,
    /// The operations of each form: most forms are dearer than the best, and
    /// their terms need not be considered.
    costs: Vec<u32>,
    /// The start of the forms of each class, and the end of the last ones.
    starts: Vec<u32>,
}

impl FormsByClass<'_> {
    /// The forms of a network in [order of rank](ChoiceNetwork::sort).
    pub(crate) fn new(network: &ChoiceNetwork, timing: Weights) -> FormsByClass<'_> {
        let count = network.form_count() as u32;
        let mut starts = vec![0; network.len() + 1];
        for form in 0..count {
            starts[network.class_of(form).index() + 1] = form + 1;
        }
        // A class without forms has those before it end where they begin.
        for class in 0..network.len() {
            starts[class + 1] = starts[class + 1].max(starts[class]);
        }
        let by_class = FormsByClass {
            network,
            timing,
            add: timing.of(Operation::Add),
            multiply: timing.of(Operation::Mul),
            costs: (0..count).map(|form| cost(network, form)).collect(),
            starts,
        };
        debug_assert!(
            (0..network.len()).all(|class| by_class.is_above_operands(class)),
            "a form uses only earlier classes"
        );
        by_class
    }

    fn is_above_operands(&self, class: usize) -> bool {
        let mut is_above = true;
        for form in self.of(class) {
            let below = |operand: Class| is_above &= operand.index() < class;
            self.network.operands(form, below);
        }
        is_above
    }

    pub(super) fn network(&self) -> &ChoiceNetwork {
        self.network
    }

    /// Weights of operations.
    pub(super) fn timing(&self) -> Weights {
        self.timing
    }

    pub(super) fn class_of(&self, form: u32) -> usize {
        self.network.class_of(form).index()
    }

    /// Number of classes.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The forms of a class, in the order they were made.
    pub(crate) fn of(&self, class: usize) -> Range<u32> {
        self.starts[class]..self.starts[class + 1]
    }

    /// Operations of a form.
    #[inline]
    pub(crate) fn cost(&self, form: u32) -> u32 {
        self.costs[form as usize]
    }

    /// Calls a function with the classes a form uses, with one that it uses
    /// twice twice.
    #[inline]
    pub(crate) fn operands(&self, form: u32, mut visit: impl FnMut(usize)) {
        let visit = |class: Class| visit(class.index());
        self.network.operands(form, visit);
    }

    /// Cost and time of a form, as far as its operations are no more than
    /// `most`.
    #[inline]
    pub(crate) fn flow(&self, states: &[FlowState], form: u32, most: f64) -> FormFlow {
        let cost = f64::from(self.cost(form));
        // What is added is not negative, so too much stays too much, rounded as
        // it is. What is unknown makes the sum no number.
        let is_allowed = |sum: f64| cost + sum <= most;
        let mut sum = 0.0;
        if !is_allowed(sum) {
            return FormFlow::TooMuch;
        }
        let mut latest = LatestTwo::default();
        let bound = match self.network.form(form) {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => (0, true),
            ChoiceForm::Opaque(index) => {
                let mut ready = 0;
                self.operands(form, |operand| {
                    sum += states[operand].flow;
                    ready = ready.max(states[operand].arrival);
                });
                let operation = self.network.opaques[index as usize].operation;
                (ready.saturating_add(self.timing.of(operation)), true)
            }
            ChoiceForm::Product(factors) => {
                for factor in factors {
                    let state = &states[factor.a.index()];
                    sum += state.flow;
                    latest.add(state.arrival);
                }
                latest.finish(self.multiply)
            }
            ChoiceForm::Sum(terms) => {
                for term in terms {
                    // The class of 1 costs nothing and is always there.
                    let (a, b) = (&states[term.a.index()], &states[term.b().index()]);
                    sum += a.flow;
                    sum += b.flow;
                    if !is_allowed(sum) {
                        break;
                    }
                    latest.add(self.term_time(a.arrival, b.arrival, *term));
                }
                latest.finish(self.add)
            }
        };
        match (is_allowed(sum), sum.is_nan()) {
            (true, _) => FormFlow::Found(cost + sum, bound),
            (false, false) => FormFlow::TooMuch,
            (false, true) => FormFlow::Missing(self.missing(states, form)),
        }
    }

    /// The first operand of a form whose state is missing.
    #[cold]
    fn missing(&self, states: &[FlowState], form: u32) -> usize {
        let mut missing = None;
        self.operands(form, |operand| {
            if missing.is_none() && !states[operand].is_known() {
                missing = Some(operand);
            }
        });
        missing.expect("a sum of numbers is one")
    }

    /// Time at which a term of available classes is available.
    #[inline]
    fn term_time(&self, a: u32, b: u32, term: ProductTerm) -> u32 {
        let weight = if term.is_product() { self.multiply } else { 0 };
        a.max(b).saturating_add(weight)
    }

    /// Time at which a term is available.
    #[inline]
    fn term(&self, arrivals: &[u32], term: ProductTerm) -> u32 {
        let [a, b] = [term.a, term.b()].map(|class| arrivals[class.index()]);
        self.term_time(a, b, term)
    }

    /// A time before which a form is not available, and a flag: true when it is
    /// available then.
    #[inline]
    pub(crate) fn bound(&self, arrivals: &[u32], form: u32) -> (u32, bool) {
        let mut latest = LatestTwo::default();
        match self.network.form(form) {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => (0, true),
            ChoiceForm::Opaque(index) => {
                let mut ready = 0;
                self.operands(form, |operand| ready = ready.max(arrivals[operand]));
                let operation = self.network.opaques[index as usize].operation;
                (ready.saturating_add(self.timing.of(operation)), true)
            }
            ChoiceForm::Sum(terms) => {
                for &term in terms {
                    latest.add(self.term(arrivals, term));
                }
                latest.finish(self.add)
            }
            ChoiceForm::Product(factors) => {
                for factor in factors {
                    latest.add(arrivals[factor.a.index()]);
                }
                latest.finish(self.multiply)
            }
        }
    }

    /// Time at which a form is available, of which a
    /// [bound](FormsByClass::bound) is known.
    #[inline]
    pub(crate) fn refine(&self, arrivals: &[u32], form: u32, (time, exact): (u32, bool)) -> u32 {
        if exact {
            time
        } else {
            self.joined(arrivals, form)
        }
    }

    /// Time at which a form is available.
    #[inline]
    pub(crate) fn arrival(&self, arrivals: &[u32], form: u32) -> u32 {
        self.refine(arrivals, form, self.bound(arrivals, form))
    }

    /// Time at which a sum or product is available.
    fn joined(&self, arrivals: &[u32], form: u32) -> u32 {
        match self.network.form(form) {
            ChoiceForm::Sum(terms) => {
                let times = terms.iter().map(|&term| self.term(arrivals, term));
                joined(times.collect(), self.add)
            }
            ChoiceForm::Product(factors) => {
                let times = factors.iter().map(|factor| arrivals[factor.a.index()]);
                joined(times.collect(), self.multiply)
            }
            other => unreachable!("{other:?} has no operands to join"),
        }
    }

    /// Hands the time that a form is required at on to its operands.
    pub(crate) fn require(&self, arrivals: &[u32], required: &mut [u32], form: u32, time: u32) {
        let mut demand = |class: Class, time: u32| {
            let known = &mut required[class.index()];
            *known = (*known).min(time);
        };
        let (add, multiply) = (self.add, self.multiply);
        match self.network.form(form) {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => {}
            ChoiceForm::Opaque(index) => {
                let operation = self.network.opaques[index as usize].operation;
                let time = time.saturating_sub(self.timing.of(operation));
                self.network.operands(form, |class| demand(class, time));
            }
            ChoiceForm::Product(factors) => {
                let times: SmallVec<[u32; 16]> = factors
                    .iter()
                    .map(|factor| arrivals[factor.a.index()])
                    .collect();
                for (factor, level) in factors.iter().zip(levels(&times, multiply)) {
                    demand(factor.a, time.saturating_sub(level * multiply));
                }
            }
            ChoiceForm::Sum(terms) => {
                let times: SmallVec<[u32; 16]> = terms
                    .iter()
                    .map(|&term| self.term(arrivals, term))
                    .collect();
                for (term, level) in terms.iter().zip(levels(&times, add)) {
                    let mut time = time.saturating_sub(level * add);
                    if term.is_product() {
                        time = time.saturating_sub(multiply);
                        demand(term.b(), time);
                    }
                    demand(term.a, time);
                }
            }
        }
    }
}

/// Operations of a form.
fn cost(network: &ChoiceNetwork, form: u32) -> u32 {
    match network.form(form) {
        ChoiceForm::Input(..) | ChoiceForm::Constant(_) => 0,
        ChoiceForm::Opaque(index) => {
            let operation = network.opaques[index as usize].operation;
            u32::from(!operation.is_trigonometric())
        }
        ChoiceForm::Product(factors) => factors.len() as u32 - 1,
        ChoiceForm::Sum(terms) => {
            let products = terms.iter().filter(|term| term.is_product()).count();
            (terms.len() + products) as u32 - 1
        }
    }
}
