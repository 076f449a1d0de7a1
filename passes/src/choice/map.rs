//! Choosing a form for every class: early enough, then few operations.

use super::network::{Class, Form, Network, Signed, Term};
use crate::analysis::critical_path::Weights;
use robovec_ir::Operation;
use smallvec::SmallVec;

/// What operations weigh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Timing {
    pub(crate) weights: Weights,
    pub(crate) add: u32,
    pub(crate) multiply: u32,
}

impl Timing {
    pub(crate) fn new(weights: Weights) -> Timing {
        Timing {
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
const NEVER: u32 = u32::MAX;

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
    pub(crate) fn update(&mut self, network: &Network, timing: &Timing, class: Class) {
        let mut earliest = NEVER;
        for form in network.forms(class) {
            earliest = earliest.min(self.form(network, timing, network.form(form)));
        }
        self.set(class, earliest);
    }

    /// When a term is available.
    pub(crate) fn term(&self, timing: &Timing, term: Term) -> u32 {
        let ready = self.of(term.a).max(self.of(term.b));
        match term.is_product() {
            true => ready.saturating_add(timing.multiply),
            false => ready,
        }
    }

    /// When a form is available.
    pub(crate) fn form(&self, network: &Network, timing: &Timing, form: Form) -> u32 {
        match form {
            Form::Input(..) | Form::Constant(_) => 0,
            Form::Opaque(index) => {
                let opaque = &network.opaques[index as usize];
                let operands = opaque.operands.iter().flatten();
                let ready = operands.map(|operand| self.of(operand.class)).max();
                ready
                    .unwrap_or(0)
                    .saturating_add(timing.weights.of(opaque.operation))
            }
            Form::Sum(..) => {
                let terms = network.terms(form).iter();
                earliest_first(terms.map(|&term| self.term(timing, term)), timing.add)
            }
            Form::Product(..) => {
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
fn levels(arrivals: &[u32], weight: u32) -> SmallVec<[u32; 16]> {
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

/// One form for every class, and what follows from it.
#[derive(Clone)]
pub(crate) struct Mapping {
    /// The form chosen, by class.
    pub(crate) chosen: Vec<u32>,
    pub(crate) arrivals: Arrivals,
    /// How many chosen forms and outputs use a class.
    pub(crate) uses: Vec<u32>,
    /// Latest arrivals that keep the outputs in time.
    required: Vec<u32>,
    /// Operations of the forms in use.
    pub(crate) operations: u64,
}

/// Chooses forms.
pub(crate) struct Mapper<'a> {
    network: &'a Network,
    timing: Timing,
    outputs: &'a [Option<Signed>],
    /// All classes, operands first.
    order: Vec<Class>,
}

/// Operations of a form.
pub(crate) fn cost(network: &Network, form: Form) -> u32 {
    match form {
        Form::Input(..) | Form::Constant(_) => 0,
        Form::Opaque(index) => {
            let operation = network.opaques[index as usize].operation;
            u32::from(!operation.is_trigonometric())
        }
        Form::Product(start, end) => end - start - 1,
        Form::Sum(start, end) => {
            let products = network.terms(form).iter();
            end - start - 1 + products.filter(|term| term.is_product()).count() as u32
        }
    }
}

impl<'a> Mapper<'a> {
    pub(crate) fn new(
        network: &'a Network,
        timing: Timing,
        outputs: &'a [Option<Signed>],
    ) -> Mapper<'a> {
        let mut order: Vec<Class> = (0..network.len() as u32)
            .map(Class)
            .filter(|&class| network.is_defined(class))
            .collect();
        order.sort_by_key(|&class| (network.rank(class), class));
        Mapper {
            network,
            timing,
            outputs,
            order,
        }
    }

    /// The mapping that takes the earliest form of everything, of several the
    /// cheapest.
    pub(crate) fn earliest(&self) -> Mapping {
        let count = self.network.len();
        let mut mapping = Mapping {
            chosen: vec![u32::MAX; count],
            arrivals: Arrivals::default(),
            uses: vec![1; count],
            required: vec![NEVER; count],
            operations: 0,
        };
        mapping.arrivals.set(Class(count as u32 - 1), NEVER);
        // Nothing is required yet, but everything is to be earliest.
        let mut flow = vec![0.0f64; count];
        for &class in &self.order {
            let best = self.best(&mapping, &flow, class, |arrival, flow| (arrival, flow));
            self.choose(&mut mapping, &mut flow, class, best);
        }
        self.settle(&mut mapping, None);
        mapping
    }

    /// The latest output of a mapping.
    pub(crate) fn path(&self, mapping: &Mapping) -> u32 {
        let outputs = self.outputs.iter().flatten();
        outputs
            .map(|output| mapping.arrivals.of(output.class))
            .max()
            .unwrap_or(0)
    }

    /// Takes operations off a mapping without making an output later than
    /// `latest`.
    pub(crate) fn recover(&self, mapping: &mut Mapping, latest: u32, rounds: u32) {
        self.settle(mapping, Some(latest));
        let mut shares: Vec<f64> = mapping
            .uses
            .iter()
            .map(|&uses| f64::from(uses.max(1)))
            .collect();
        let mut best = mapping.clone();
        for round in 0..rounds {
            if round < rounds / 2 {
                self.flow_round(mapping, &shares);
            } else {
                if round == rounds / 2 {
                    *mapping = best.clone();
                }
                self.exact_round(mapping);
            }
            self.settle(mapping, Some(latest));
            for (share, &uses) in shares.iter_mut().zip(&mapping.uses) {
                *share = (*share + 2.0 * f64::from(uses.max(1))) / 3.0;
            }
            if mapping.operations < best.operations {
                best = mapping.clone();
            }
        }
        *mapping = best;
    }

    /// The form with the smallest key.
    fn best<K: PartialOrd>(
        &self,
        mapping: &Mapping,
        flow: &[f64],
        class: Class,
        key: impl Fn(u32, f64) -> K,
    ) -> (u32, u32, f64) {
        let mut best: Option<(K, (u32, u32, f64))> = None;
        for form in self.network.forms(class) {
            let shape = self.network.form(form);
            let arrival = mapping.arrivals.form(self.network, &self.timing, shape);
            let mut sum = f64::from(cost(self.network, shape));
            self.network
                .operands(shape, |operand| sum += flow[operand.index()]);
            let key = key(arrival, sum);
            if best.as_ref().is_none_or(|(known, _)| key <= *known) {
                best = Some((key, (form, arrival, sum)));
            }
        }
        best.map_or((u32::MAX, NEVER, 0.0), |(_, best)| best)
    }

    fn choose(
        &self,
        mapping: &mut Mapping,
        flow: &mut [f64],
        class: Class,
        (form, arrival, sum): (u32, u32, f64),
    ) {
        mapping.chosen[class.index()] = form;
        mapping.arrivals.set(class, arrival);
        flow[class.index()] = sum / f64::from(mapping.uses[class.index()].max(1));
    }

    /// Chooses by estimated cost, every class's cost divided among those that
    /// used it so far.
    fn flow_round(&self, mapping: &mut Mapping, shares: &[f64]) {
        let mut flow = vec![0.0f64; self.network.len()];
        for &class in &self.order {
            let required = mapping.required[class.index()];
            let (form, arrival, sum) = self.best(mapping, &flow, class, |arrival, flow| {
                (
                    arrival > required,
                    if arrival > required {
                        f64::from(arrival)
                    } else {
                        flow
                    },
                    arrival,
                )
            });
            mapping.chosen[class.index()] = form;
            mapping.arrivals.set(class, arrival);
            flow[class.index()] = sum / shares[class.index()];
        }
    }

    /// Chooses for one class after the other what costs least now.
    fn exact_round(&self, mapping: &mut Mapping) {
        let mut open = Vec::new();
        for &class in &self.order {
            let at = class.index();
            if mapping.uses[at] == 0 {
                mapping.arrivals.set(
                    class,
                    mapping.arrivals.form(
                        self.network,
                        &self.timing,
                        self.network.form(mapping.chosen[at]),
                    ),
                );
                continue;
            }
            let old = mapping.chosen[at];
            self.release(mapping, old, &mut open);
            let mut best: Option<((bool, u64, u32), u32)> = None;
            for form in self.network.forms(class) {
                let shape = self.network.form(form);
                let arrival = mapping.arrivals.form(self.network, &self.timing, shape);
                let late = arrival > mapping.required[at];
                if late && form != old {
                    continue;
                }
                let added = self.acquire(mapping, form, &mut open);
                self.release(mapping, form, &mut open);
                let key = (late, added, arrival);
                if best.is_none_or(|(known, _)| key < known) {
                    best = Some((key, form));
                }
            }
            let (key, form) = best.map_or(((false, 0, 0), old), |best| best);
            self.acquire(mapping, form, &mut open);
            mapping.chosen[at] = form;
            mapping.arrivals.set(class, key.2);
        }
    }

    /// Counts a form's uses of its classes; gives the operations this adds.
    fn acquire(&self, mapping: &mut Mapping, form: u32, open: &mut Vec<Class>) -> u64 {
        let mut added = u64::from(cost(self.network, self.network.form(form)));
        self.network
            .operands(self.network.form(form), |operand| open.push(operand));
        while let Some(class) = open.pop() {
            let uses = &mut mapping.uses[class.index()];
            *uses += 1;
            if *uses == 1 {
                let form = self.network.form(mapping.chosen[class.index()]);
                added += u64::from(cost(self.network, form));
                self.network.operands(form, |operand| open.push(operand));
            }
        }
        added
    }

    /// The opposite of [`Mapper::acquire`].
    fn release(&self, mapping: &mut Mapping, form: u32, open: &mut Vec<Class>) {
        self.network
            .operands(self.network.form(form), |operand| open.push(operand));
        while let Some(class) = open.pop() {
            let uses = &mut mapping.uses[class.index()];
            *uses -= 1;
            if *uses == 0 {
                let form = self.network.form(mapping.chosen[class.index()]);
                self.network.operands(form, |operand| open.push(operand));
            }
        }
    }

    /// Counts uses and operations anew, and required times when a latest time
    /// is given.
    fn settle(&self, mapping: &mut Mapping, latest: Option<u32>) {
        mapping.uses.fill(0);
        mapping.required.fill(NEVER);
        mapping.operations = 0;
        for output in self.outputs.iter().flatten() {
            mapping.uses[output.class.index()] += 1;
            mapping.required[output.class.index()] = latest.unwrap_or(NEVER);
        }
        for &class in self.order.iter().rev() {
            if mapping.uses[class.index()] == 0 {
                continue;
            }
            let form = self.network.form(mapping.chosen[class.index()]);
            mapping.operations += u64::from(cost(self.network, form));
            self.network
                .operands(form, |operand| mapping.uses[operand.index()] += 1);
            if latest.is_some() {
                self.require(mapping, form, mapping.required[class.index()]);
            }
        }
    }

    /// Hands the required time of a form's class on to its operands.
    fn require(&self, mapping: &mut Mapping, form: Form, required: u32) {
        let mut lower = |class: Class, time: u32| {
            let known = &mut mapping.required[class.index()];
            *known = (*known).min(time);
        };
        match form {
            Form::Input(..) | Form::Constant(_) => {}
            Form::Opaque(index) => {
                let opaque = &self.network.opaques[index as usize];
                let weight = self.timing.weights.of(opaque.operation);
                for operand in opaque.operands.iter().flatten() {
                    lower(operand.class, required.saturating_sub(weight));
                }
            }
            Form::Product(..) => {
                let factors = self.network.terms(form);
                let times: SmallVec<[u32; 16]> = factors
                    .iter()
                    .map(|term| mapping.arrivals.of(term.a))
                    .collect();
                let levels = levels(&times, self.timing.multiply);
                for (term, level) in factors.iter().zip(levels) {
                    lower(
                        term.a,
                        required.saturating_sub(level * self.timing.multiply),
                    );
                }
            }
            Form::Sum(..) => {
                let terms = self.network.terms(form);
                let times: SmallVec<[u32; 16]> = terms
                    .iter()
                    .map(|&term| mapping.arrivals.term(&self.timing, term))
                    .collect();
                let levels = levels(&times, self.timing.add);
                for (term, level) in terms.iter().zip(levels) {
                    let mut time = required.saturating_sub(level * self.timing.add);
                    if term.is_product() {
                        time = time.saturating_sub(self.timing.multiply);
                        lower(term.b, time);
                    }
                    lower(term.a, time);
                }
            }
        }
    }
}
