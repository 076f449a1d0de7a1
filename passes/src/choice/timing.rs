//! When terms, sums and products are available.
//!
//! A sum or product combines its two earliest operands first, which is optimal
//! for one associative operation (Golumbic 1976; Parker 1979).

use super::network::{ChoiceForm, ChoiceNetwork, Class, ProductTerm};
use robovec_analysis::critical_path::Weights;
use robovec_ir::Operation;
use smallvec::SmallVec;

/// The weights of operations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NetworkTiming {
    pub(crate) weights: Weights,
    pub(crate) add: u32,
    pub(crate) multiply: u32,
}

impl NetworkTiming {
    pub(crate) fn new(weights: Weights) -> NetworkTiming {
        NetworkTiming {
            weights,
            add: weights.of(Operation::Add).max(weights.of(Operation::Sub)),
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
                earliest_first(terms.map(|&term| self.term(timing, term)), timing.add)
            }
            ChoiceForm::Product(..) => {
                let factors = network.terms(form).iter();
                earliest_first(factors.map(|term| self.of(term.a)), timing.multiply)
            }
        }
    }
}

/// When a sum or product is done that combines the two earliest first.
pub(crate) fn earliest_first(arrivals: impl Iterator<Item = u32>, weight: u32) -> u32 {
    let mut sorted: SmallVec<[u32; 16]> = arrivals.collect();
    sorted.sort_unstable();
    let mut first = 0;
    while first + 1 < sorted.len() {
        let combined = sorted[first + 1].saturating_add(weight);
        first += 1;
        let mut at = first;
        while at + 1 < sorted.len() && sorted[at + 1] < combined {
            sorted[at] = sorted[at + 1];
            at += 1;
        }
        sorted[at] = combined;
    }
    sorted.get(first).copied().unwrap_or(0)
}

/// For each leaf of the tree that combines the two earliest first, how many
/// operations it goes through.
pub(crate) fn levels(arrivals: &[u32], weight: u32) -> SmallVec<[u32; 16]> {
    let count = arrivals.len();
    let mut parent: SmallVec<[u32; 32]> = SmallVec::from_elem(u32::MAX, count);
    let mut time: SmallVec<[u32; 32]> = SmallVec::from_slice(arrivals);
    let mut open: SmallVec<[u32; 16]> = (0..count as u32).collect();
    // Sorted with the earliest last; ties in order of making.
    open.sort_by_key(|&at| std::cmp::Reverse((time[at as usize], at)));
    while let (Some(a), Some(b)) = (open.pop(), open.pop()) {
        let made = parent.len() as u32;
        let ready = time[a as usize]
            .max(time[b as usize])
            .saturating_add(weight);
        parent[a as usize] = made;
        parent[b as usize] = made;
        parent.push(u32::MAX);
        time.push(ready);
        let key = |at: u32| (time[at as usize], at);
        let place = open.partition_point(|&other| key(other) > key(made));
        open.insert(place, made);
        if open.len() == 1 {
            break;
        }
    }
    let mut levels: SmallVec<[u32; 32]> = SmallVec::from_elem(0, parent.len());
    for at in (0..parent.len()).rev() {
        if parent[at] != u32::MAX {
            levels[at] = levels[parent[at] as usize] + 1;
        }
    }
    levels.truncate(count);
    levels.into_iter().collect()
}
