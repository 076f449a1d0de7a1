//! Choosing a form for every class: early enough, then few operations.

use super::dense::{FlowState, FormsByClass};
use super::network::{ChoiceNetwork, Class, SignedClass};
use super::timing::NEVER;
use robovec_analysis::critical_path::Weights;

/// One form for every class, and what follows from it. Indexed by class.
#[derive(Clone)]
pub(crate) struct Mapping {
    /// The form chosen.
    chosen: Vec<u32>,
    arrivals: Vec<u32>,
    /// The number of chosen forms and outputs that use each class.
    uses: Vec<u32>,
    /// Latest arrivals that keep the outputs in time.
    required: Vec<u32>,
    /// Operations of the forms in use.
    pub(crate) operations: u64,
}

/// How often each class is used in a mapping.
#[derive(Clone)]
pub(crate) struct ClassUses(Vec<u32>);

impl Mapping {
    /// How often each class is used.
    pub(crate) fn into_uses(self) -> ClassUses {
        ClassUses(self.uses)
    }
}

/// The largest network whose choices are improved one by one, in classes: the
/// operations that hang on a choice are counted anew for every form.
const LARGEST_EXACT: usize = 200_000;

/// Chooses forms.
pub(crate) struct Mapper<'a> {
    forms: FormsByClass<'a>,
    outputs: Vec<usize>,
}

impl Mapper<'_> {
    /// Chooses among the forms of a network in
    /// [order of rank](ChoiceNetwork::sort).
    pub(crate) fn new<'a>(
        network: &'a ChoiceNetwork,
        timing: Weights,
        outputs: &[Option<SignedClass>],
    ) -> Mapper<'a> {
        let outputs = outputs.iter().flatten();
        Mapper {
            forms: FormsByClass::new(network, timing),
            outputs: outputs.map(|output| output.class.index()).collect(),
        }
    }

    /// The classes a mapping uses, operands first, with the forms chosen.
    pub(crate) fn used<'a>(
        &'a self,
        mapping: &'a Mapping,
    ) -> impl Iterator<Item = (Class, u32)> + 'a {
        let classes = 0..self.forms.len();
        let used = classes.filter(|&at| mapping.uses[at] > 0);
        used.map(|at| (Class(at as u32), mapping.chosen[at]))
    }

    /// A mapping in which nothing has a form.
    fn unmapped(&self) -> Mapping {
        let count = self.forms.len();
        Mapping {
            chosen: vec![u32::MAX; count],
            arrivals: vec![NEVER; count],
            uses: vec![0; count],
            required: vec![NEVER; count],
            operations: 0,
        }
    }

    /// The mapping that takes the earliest form of everything, of several the
    /// cheapest.
    pub(crate) fn earliest(&self) -> Mapping {
        let mut mapping = self.unmapped();
        let mut states = vec![FlowState::default(); self.forms.len()];
        for at in 0..self.forms.len() {
            let mut best: Option<((u32, f64), u32)> = None;
            for form in self.forms.of(at) {
                let (sum, time, exact) = self.forms.flow(&states, form);
                if best.is_some_and(|((known, _), _)| time > known) {
                    continue;
                }
                let key = (self.refine(&mapping, form, (time, exact)), sum);
                if best.is_none_or(|(known, _)| key < known) {
                    best = Some((key, form));
                }
            }
            let Some(((arrival, flow), form)) = best else {
                continue;
            };
            mapping.chosen[at] = form;
            mapping.arrivals[at] = arrival;
            states[at] = FlowState { flow, arrival };
        }
        self.settle(&mut mapping, None);
        mapping
    }

    /// The mapping with few operations, however late: it starts from the forms
    /// the function came with.
    pub(crate) fn cheapest(&self, rounds: u32) -> ClassUses {
        let mut mapping = self.unmapped();
        for at in 0..self.forms.len() {
            let Some(form) = self.forms.of(at).next() else {
                continue;
            };
            mapping.chosen[at] = form;
            mapping.arrivals[at] = self.arrival(&mapping, form);
        }
        self.recover(&mut mapping, NEVER, rounds, None);
        mapping.into_uses()
    }

    /// The latest output of a mapping.
    pub(crate) fn path(&self, mapping: &Mapping) -> u32 {
        let outputs = self.outputs.iter();
        let arrivals = outputs.map(|&output| mapping.arrivals[output]);
        arrivals.max().unwrap_or(0)
    }

    /// Takes operations off a mapping without making an output later than
    /// `latest`.
    ///
    /// What a class costs each of its users is estimated from how often it is
    /// used in a `model`, a mapping for a later time, when there is one.
    pub(crate) fn recover(
        &self,
        mapping: &mut Mapping,
        latest: u32,
        rounds: u32,
        model: Option<ClassUses>,
    ) {
        self.settle(mapping, Some(latest));
        let share = |&uses: &u32| f64::from(uses.max(1));
        let uses = model.as_ref().map_or(&mapping.uses, |model| &model.0);
        let mut shares: Vec<f64> = uses.iter().map(share).collect();
        drop(model);
        let mut best = (mapping.operations, mapping.chosen.clone());
        let flow_rounds = match self.forms.len() > LARGEST_EXACT {
            true => rounds,
            false => rounds / 2,
        };
        for round in 0..rounds {
            if round < flow_rounds {
                self.flow_round(mapping, &shares);
            } else if !self.exact_round(mapping) {
                break;
            }
            self.settle(mapping, Some(latest));
            for (known, uses) in shares.iter_mut().zip(&mapping.uses) {
                *known = (*known + 2.0 * share(uses)) / 3.0;
            }
            if mapping.operations < best.0 {
                best.0 = mapping.operations;
                best.1.clone_from(&mapping.chosen);
            }
            if round + 1 == flow_rounds {
                self.take(mapping, &best, latest);
            }
        }
        self.take(mapping, &best, latest);
    }

    /// Takes the forms chosen in another mapping, unless they are those of this
    /// one already.
    fn take(&self, mapping: &mut Mapping, (operations, chosen): &(u64, Vec<u32>), latest: u32) {
        if mapping.operations == *operations && mapping.chosen == *chosen {
            return;
        }
        mapping.chosen.clone_from(chosen);
        for (at, &form) in chosen.iter().enumerate() {
            if form != u32::MAX {
                mapping.arrivals[at] = self.arrival(mapping, form);
            }
        }
        self.settle(mapping, Some(latest));
    }

    /// When a form is available, of which a bound is known or the time itself.
    fn refine(&self, mapping: &Mapping, form: u32, (time, exact): (u32, bool)) -> u32 {
        match exact {
            true => time,
            false => self.arrival(mapping, form),
        }
    }

    fn arrival(&self, mapping: &Mapping, form: u32) -> u32 {
        self.forms.arrival(&mapping.arrivals, form)
    }

    /// Chooses by estimated cost, every class's cost divided among those that
    /// used it so far.
    fn flow_round(&self, mapping: &mut Mapping, shares: &[f64]) {
        let mut states = vec![FlowState::default(); self.forms.len()];
        for at in 0..self.forms.len() {
            let required = mapping.required[at];
            let forms = self.forms.of(at);
            // The form chosen last is mostly chosen again: it comes first, and
            // what is surely later or dearer need not be timed.
            let last = mapping.chosen[at];
            let last = forms.contains(&last).then_some(last);
            let others = forms.filter(|&form| Some(form) != last);
            let mut best: Option<((u32, f64, u32), u32, f64)> = None;
            for form in last.into_iter().chain(others) {
                let (sum, time, exact) = self.forms.flow(&states, form);
                let least = (time.saturating_sub(required), sum);
                if best.is_some_and(|((late, known, _), ..)| least > (late, known)) {
                    continue;
                }
                let arrival = self.refine(mapping, form, (time, exact));
                // In time comes first, then cheap, then early; of equal ones
                // the first made.
                let key = (arrival.saturating_sub(required), sum, arrival);
                if best.is_none_or(|(known, first, _)| (key, form) < (known, first)) {
                    best = Some((key, form, sum));
                }
            }
            let Some((key, form, sum)) = best else {
                continue;
            };
            mapping.chosen[at] = form;
            mapping.arrivals[at] = key.2;
            states[at] = FlowState {
                flow: sum / shares[at],
                arrival: key.2,
            };
        }
    }

    /// Chooses for one class after the other what costs least now. False when
    /// that changes nothing.
    fn exact_round(&self, mapping: &mut Mapping) -> bool {
        let mut counter = UseCounter::default();
        // Arrivals are always those of the forms chosen: only what is behind a
        // change is timed again.
        let mut moved = vec![false; self.forms.len()];
        let mut changed = false;
        for at in 0..self.forms.len() {
            let old = mapping.chosen[at];
            if old == u32::MAX {
                continue;
            }
            let mut arrival = mapping.arrivals[at];
            let mut is_behind = false;
            self.forms
                .operands(old, |operand| is_behind |= moved[operand]);
            if is_behind {
                arrival = self.arrival(mapping, old);
            }
            if mapping.uses[at] == 0 {
                moved[at] = arrival != mapping.arrivals[at];
                changed |= moved[at];
                mapping.arrivals[at] = arrival;
                continue;
            }
            let freed = counter.release(&self.forms, mapping, old);
            let mut best = ((arrival > mapping.required[at], freed, arrival), old);
            for form in self.forms.of(at) {
                let cost = u64::from(self.forms.cost(form));
                if form == old || cost > best.0.1 && !best.0.0 {
                    continue;
                }
                let arrival = self.arrival(mapping, form);
                if arrival > mapping.required[at] {
                    continue;
                }
                let most = if best.0.0 { u64::MAX } else { best.0.1 };
                let Some(added) = counter.try_out(&self.forms, mapping, form, most) else {
                    continue;
                };
                let key = (false, added, arrival);
                if key < best.0 {
                    best = (key, form);
                }
            }
            let (key, form) = best;
            counter.acquire(&self.forms, mapping, form, u64::MAX);
            moved[at] = key.2 != mapping.arrivals[at];
            changed |= moved[at] || form != old;
            mapping.chosen[at] = form;
            mapping.arrivals[at] = key.2;
        }
        changed
    }

    /// Counts uses and operations anew, and required times when a latest time
    /// is given.
    fn settle(&self, mapping: &mut Mapping, latest: Option<u32>) {
        mapping.uses.fill(0);
        mapping.required.fill(NEVER);
        mapping.operations = 0;
        for &output in &self.outputs {
            mapping.uses[output] += 1;
            mapping.required[output] = latest.unwrap_or(NEVER);
        }
        for at in (0..self.forms.len()).rev() {
            if mapping.uses[at] == 0 {
                continue;
            }
            let form = mapping.chosen[at];
            mapping.operations += u64::from(self.forms.cost(form));
            let uses = &mut mapping.uses;
            self.forms.operands(form, |operand| uses[operand] += 1);
            if latest.is_some() {
                let time = mapping.required[at];
                self.forms
                    .require(&mapping.arrivals, &mut mapping.required, form, time);
            }
        }
    }
}

/// Counts the uses of classes as forms are taken and given up. Its vectors are
/// kept from one form to the next.
#[derive(Default)]
struct UseCounter {
    open: Vec<u32>,
    /// The classes whose uses the last form added to.
    touched: Vec<usize>,
}

impl UseCounter {
    /// Counts a form's uses of its classes; the operations this adds, as far
    /// as they are no more than `most`: `None`, and uses counted in part,
    /// otherwise.
    fn acquire(
        &mut self,
        forms: &FormsByClass<'_>,
        mapping: &mut Mapping,
        form: u32,
        most: u64,
    ) -> Option<u64> {
        self.open.clear();
        self.open.push(form);
        self.touched.clear();
        let (open, touched) = (&mut self.open, &mut self.touched);
        let mut added = 0;
        while let Some(form) = open.pop() {
            added += u64::from(forms.cost(form));
            if added > most {
                return None;
            }
            forms.operands(form, |at| {
                touched.push(at);
                let uses = &mut mapping.uses[at];
                *uses += 1;
                if *uses == 1 {
                    open.push(mapping.chosen[at]);
                }
            });
        }
        Some(added)
    }

    /// The operations that taking a form adds, unless they are more than
    /// `most`. Uses stay as they were.
    fn try_out(
        &mut self,
        forms: &FormsByClass<'_>,
        mapping: &mut Mapping,
        form: u32,
        most: u64,
    ) -> Option<u64> {
        let added = self.acquire(forms, mapping, form, most);
        for &at in &self.touched {
            mapping.uses[at] -= 1;
        }
        added
    }

    /// Gives up a form: the opposite of [`UseCounter::acquire`]. The operations
    /// this saves.
    fn release(&mut self, forms: &FormsByClass<'_>, mapping: &mut Mapping, form: u32) -> u64 {
        self.open.clear();
        self.open.push(form);
        let open = &mut self.open;
        let mut freed = 0;
        while let Some(form) = open.pop() {
            freed += u64::from(forms.cost(form));
            forms.operands(form, |at| {
                let uses = &mut mapping.uses[at];
                *uses -= 1;
                if *uses == 0 {
                    open.push(mapping.chosen[at]);
                }
            });
        }
        freed
    }
}
