//! When terms, sums and products are available.

use super::network::{ChoiceForm, ChoiceNetwork, Class, ProductTerm};
use crate::sums::earliest::finish;
use robovec_analysis::critical_path::Weights;
use robovec_ir::Operation;

/// The weights of operations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NetworkTiming {
    pub(crate) weights: Weights,
    pub(crate) add: u32,
    pub(crate) multiply: u32,
}

impl NetworkTiming {
    pub(crate) fn new(weights: Weights) -> NetworkTiming {
        let weights = weights.with_equal_sums();
        NetworkTiming {
            weights,
            add: weights.of(Operation::Add),
            multiply: weights.of(Operation::Mul),
        }
    }
}

/// When the value of each class is available.
#[derive(Clone, Default, Debug)]
pub(crate) struct Arrivals(Vec<u32>);

/// A class that nobody has given a form yet.
pub(crate) const NEVER: u32 = u32::MAX;

impl Arrivals {
    /// The arrival of a class; never, when it has not been updated.
    pub(crate) fn of(&self, class: Class) -> u32 {
        match class {
            Class::ONE => 0,
            _ => self.0.get(class.index()).copied().unwrap_or(NEVER),
        }
    }

    pub(crate) fn set(&mut self, class: Class, arrival: u32) {
        if self.0.len() <= class.index() {
            self.0.resize(class.index() + 1, NEVER);
        }
        self.0[class.index()] = arrival;
    }

    /// Takes the earliest form of a class, its operands being up to date.
    pub(crate) fn update(&mut self, network: &ChoiceNetwork, timing: &NetworkTiming, class: Class) {
        let mut earliest = NEVER;
        for form in network.forms(class) {
            earliest = earliest.min(self.form(network, timing, network.form(form)));
        }
        self.set(class, earliest);
    }

    /// When a term is available.
    pub(crate) fn term(&self, timing: &NetworkTiming, term: ProductTerm) -> u32 {
        let ready = self.of(term.a).max(self.of(term.b));
        match term.is_product() {
            true => ready.saturating_add(timing.multiply),
            false => ready,
        }
    }

    /// When a form is available.
    pub(crate) fn form(
        &self,
        network: &ChoiceNetwork,
        timing: &NetworkTiming,
        form: ChoiceForm,
    ) -> u32 {
        match form {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => 0,
            ChoiceForm::Opaque(index) => {
                let opaque = &network.opaques[index as usize];
                let operands = opaque.operands.iter().flatten();
                let ready = operands.map(|operand| self.of(operand.class)).max();
                ready
                    .unwrap_or(0)
                    .saturating_add(timing.weights.of(opaque.operation))
            }
            ChoiceForm::Sum(..) => {
                let terms = network.terms(form).iter();
                finish(terms.map(|&term| self.term(timing, term)), timing.add)
            }
            ChoiceForm::Product(..) => {
                let factors = network.terms(form).iter();
                finish(factors.map(|term| self.of(term.a)), timing.multiply)
            }
        }
    }
}
