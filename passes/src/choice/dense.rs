//! A network seen by class, for going over it again and again.
//!
//! Classes are in order of rank, so that operands come first and lie near
//! their users.

use super::forms::{ChoiceForm, ProductTerm};
use super::network::{ChoiceNetwork, Class};
use crate::sums::earliest::{finish, levels};
use robovec_analysis::critical_path::Weights;
use robovec_ir::Operation;
use smallvec::SmallVec;
use std::ops::Range;

/// The forms of a network by class, in the order they were made.
pub(crate) struct FormsByClass<'a> {
    network: &'a ChoiceNetwork,
    timing: Weights,
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

    /// The network.
    pub(super) fn network(&self) -> &ChoiceNetwork {
        self.network
    }

    /// Weights of operations.
    pub(super) fn timing(&self) -> Weights {
        self.timing
    }

    /// The class of a form.
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
    pub(crate) fn cost(&self, form: u32) -> u32 {
        match self.network.form(form) {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => 0,
            ChoiceForm::Opaque(index) => {
                let operation = self.network.opaques[index as usize].operation;
                u32::from(!operation.is_trigonometric())
            }
            ChoiceForm::Product(factors) => factors.len() as u32 - 1,
            ChoiceForm::Sum(terms) => {
                let products = terms.iter().filter(|term| term.is_product()).count();
                (terms.len() + products) as u32 - 1
            }
        }
    }

    /// Calls a function with the classes a form uses, with one that it uses
    /// twice twice.
    #[inline]
    pub(crate) fn operands(&self, form: u32, mut visit: impl FnMut(usize)) {
        let visit = |class: Class| visit(class.index());
        self.network.operands(form, visit);
    }

    /// When a term is available.
    fn term(&self, arrivals: &[u32], term: ProductTerm) -> u32 {
        let first = arrivals[term.a.index()];
        match term.is_product() {
            true => first
                .max(arrivals[term.b().index()])
                .saturating_add(self.timing.of(Operation::Mul)),
            false => first,
        }
    }

    /// When a form is available.
    pub(crate) fn arrival(&self, arrivals: &[u32], form: u32) -> u32 {
        match self.network.form(form) {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => 0,
            ChoiceForm::Opaque(index) => {
                let mut ready = 0;
                self.operands(form, |operand| ready = ready.max(arrivals[operand]));
                let operation = self.network.opaques[index as usize].operation;
                ready.saturating_add(self.timing.of(operation))
            }
            ChoiceForm::Sum(terms) => {
                let times = terms.iter().map(|&term| self.term(arrivals, term));
                finish(times, self.timing.of(Operation::Add))
            }
            ChoiceForm::Product(factors) => {
                let times = factors.iter().map(|factor| arrivals[factor.a.index()]);
                finish(times, self.timing.of(Operation::Mul))
            }
        }
    }

    /// Hands the time that a form is required at on to its operands.
    pub(crate) fn require(&self, arrivals: &[u32], required: &mut [u32], form: u32, time: u32) {
        let mut demand = |class: Class, time: u32| {
            let known = &mut required[class.index()];
            *known = (*known).min(time);
        };
        let multiply = self.timing.of(Operation::Mul);
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
                let add = self.timing.of(Operation::Add);
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
