//! Times at which terms, sums and products are available.
//!
//! The weights of operations given here are those with
//! [equal sums](Weights::with_equal_sums): signs are not settled before a
//! network is written.

use super::forms::ChoiceForm;
use super::network::ChoiceNetwork;
use super::term::{Class, ProductTerm};
use crate::sums::earliest::finish;
use robovec_analysis::critical_path::Weights;
use robovec_ir::Operation;

/// Times at which the values of the classes are available.
#[derive(Clone, Default, Debug)]
pub(crate) struct Arrivals(Vec<u32>);

/// A class without a form.
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

    /// Notes when a class is available by a form whose operands are up to date.
    pub(crate) fn take(
        &mut self,
        network: &ChoiceNetwork,
        timing: &Weights,
        class: Class,
        form: u32,
    ) {
        let arrival = self.form(network, timing, network.form(form));
        self.set(class, arrival);
    }

    /// Time at which a term is available.
    fn term(&self, timing: &Weights, term: ProductTerm) -> u32 {
        let ready = self.of(term.a).max(self.of(term.b()));
        if term.is_product() {
            ready.saturating_add(timing.of(Operation::Mul))
        } else {
            ready
        }
    }

    /// Time at which a form is available.
    fn form(&self, network: &ChoiceNetwork, timing: &Weights, form: ChoiceForm<'_>) -> u32 {
        match form {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => 0,
            ChoiceForm::Opaque(index) => {
                let opaque = &network.opaques[index as usize];
                let operands = opaque.operands.iter().flatten();
                let ready = operands.map(|operand| self.of(operand.class));
                ready
                    .fold(0, u32::max)
                    .saturating_add(timing.of(opaque.operation))
            }
            ChoiceForm::Sum(terms) => finish(
                terms.iter().map(|&term| self.term(timing, term)),
                timing.of(Operation::Add),
            ),
            ChoiceForm::Product(factors) => finish(
                factors.iter().map(|term| self.of(term.a)),
                timing.of(Operation::Mul),
            ),
        }
    }
}
