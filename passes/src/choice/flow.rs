//! Choosing forms by flow: quick, for large networks.
//!
//! Every class gets the form that is in time with the least operations, each
//! class's being divided among those that used it so far (*area flow*;
//! Manohararajah, Brown and Vranesic 2006). A class that only one new form
//! needs has no required time, so forms that need new values early are seldom
//! found; [curves](super::curve_map) find them, in several times the time.

use super::dense::{FlowState, FormFlow};
use super::map::{Mapper, Mapping};
use super::timing::NEVER;

/// The largest network whose choices are improved one by one, in classes: the
/// operations that are attached to a choice are counted again for every form.
const LARGEST_EXACT: usize = 1_000_000;

/// In a larger network no more rounds are made when one saved less than one
/// operation in this number.
const LEAST_SAVED: u64 = 10_000;

impl Mapper<'_> {
    /// The mapping with the earliest form of every class, of several the
    /// cheapest.
    pub(crate) fn earliest(&self) -> Mapping {
        let mut mapping = self.unmapped();
        let mut states = vec![FlowState::default(); self.forms.len()];
        for at in 0..self.forms.len() {
            let mut best: Option<((u32, f64), u32)> = None;
            for form in self.forms.of(at) {
                let flow = self.forms.flow(&states, form, f64::INFINITY);
                let FormFlow::Found(sum, bound) = flow else {
                    unreachable!("all operands are known, and infinitely much is allowed");
                };
                if best.is_some_and(|((known, _), _)| bound.0 > known) {
                    continue;
                }
                let key = (self.forms.refine(&mapping.arrivals, form, bound), sum);
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
        let path = self.path(&mapping);
        self.settle(&mut mapping, Some(path));
        mapping
    }

    /// The mapping with few operations, however late: it starts from the forms
    /// of the original function.
    pub(crate) fn cheapest(&self, rounds: u32) -> Mapping {
        let mut mapping = self.unmapped();
        for at in 0..self.forms.len() {
            let Some(form) = self.forms.of(at).next() else {
                continue;
            };
            mapping.chosen[at] = form;
            mapping.arrivals[at] = self.arrival(&mapping, form);
        }
        self.recover(&mut mapping, NEVER, rounds, None);
        mapping
    }

    /// Takes operations off the [earliest](Mapper::earliest) mapping without
    /// making an output later than `latest`, or off any one when there is no
    /// such time.
    ///
    /// The cost of a class per user is estimated from its number of uses in a
    /// `model`, a mapping for a later time, if there is one; a class that is
    /// not considered has its form in the model.
    pub(crate) fn recover(
        &self,
        mapping: &mut Mapping,
        latest: u32,
        rounds: u32,
        model: Option<&Mapping>,
    ) {
        self.postpone(mapping, latest);
        let mut best = (mapping.operations, mapping.chosen.clone());
        let (flow_rounds, exact_rounds) = if self.is_large() {
            (2 * rounds, 0)
        } else {
            (rounds, rounds)
        };
        if flow_rounds > 0 {
            self.flow_rounds(mapping, &mut best, (latest, flow_rounds), model);
            self.take(mapping, &best.1, latest);
        }
        for _ in 0..exact_rounds {
            if !self.exact_round(mapping) {
                break;
            }
            self.settle(mapping, Some(latest));
            if mapping.operations < best.0 {
                best.0 = mapping.operations;
                best.1.clone_from(&mapping.chosen);
            }
        }
        if mapping.operations != best.0 {
            self.take(mapping, &best.1, latest);
        }
    }

    /// True for a network that only estimates choose in.
    fn is_large(&self) -> bool {
        self.forms.len() > LARGEST_EXACT
    }

    /// Chooses by estimated cost in several rounds, every class's cost divided
    /// among those that used it so far. Keeps the forms of the mapping with the
    /// fewest operations. Classes that are not considered are left with times
    /// that are not those of their forms.
    fn flow_rounds(
        &self,
        mapping: &mut Mapping,
        best: &mut (u64, Vec<u32>),
        (latest, rounds): (u32, u32),
        model: Option<&Mapping>,
    ) {
        let share = |&uses: &u32| f64::from(uses.max(1));
        let uses = model.map_or(&mapping.uses, |model| &model.uses);
        let mut shares: Vec<f64> = uses.iter().map(share).collect();
        if let Some(model) = model {
            mapping.chosen.clone_from(&model.chosen);
            mapping.demanded.clone_from(&model.demanded);
        }
        let mut states = Vec::new();
        for _ in 0..rounds {
            self.flow_round(mapping, &shares, &mut states);
            self.settle(mapping, Some(latest));
            for (known, uses) in shares.iter_mut().zip(&mapping.uses) {
                *known = (*known + 2.0 * share(uses)) / 3.0;
            }
            let saved = best.0.saturating_sub(mapping.operations);
            if saved > 0 {
                best.0 = mapping.operations;
                best.1.clone_from(&mapping.chosen);
            }
            if self.is_large() && saved * LEAST_SAVED < best.0 {
                break;
            }
        }
    }

    /// Chooses by estimated cost for the classes that are considered. A class
    /// that becomes one of them is chosen for when it is met.
    fn flow_round(&self, mapping: &mut Mapping, shares: &[f64], states: &mut Vec<FlowState>) {
        states.clear();
        states.resize(self.forms.len(), FlowState::UNKNOWN);
        let mut open = Vec::new();
        for at in 0..self.forms.len() {
            if !mapping.demanded[at] || states[at].is_known() {
                continue;
            }
            open.push(at);
            while let Some(&class) = open.last() {
                if let Some(missing) = self.choose_by_flow(class, mapping, shares, states) {
                    mapping.demanded[missing] = true;
                    open.push(missing);
                } else {
                    open.pop();
                }
            }
        }
    }

    /// Chooses by estimated cost for one class, or returns the class that must be
    /// chosen for before.
    fn choose_by_flow(
        &self,
        at: usize,
        mapping: &mut Mapping,
        shares: &[f64],
        states: &mut [FlowState],
    ) -> Option<usize> {
        let required = mapping.required[at];
        let forms = self.forms.of(at);
        // The form chosen last is mostly chosen again: it comes first, and
        // what is surely later or dearer need not be timed.
        let last = mapping.chosen[at];
        let last = forms.contains(&last).then_some(last);
        let others = forms.filter(|&form| Some(form) != last);
        let mut best: Option<((u32, f64, u32), u32)> = None;
        for form in last.into_iter().chain(others) {
            // What is in time is only given up for what is not dearer.
            let most = match best {
                Some(((0, known, _), _)) => known,
                _ => f64::INFINITY,
            };
            let (sum, bound) = match self.forms.flow(states, form, most) {
                FormFlow::Found(sum, bound) => (sum, bound),
                FormFlow::TooMuch => continue,
                FormFlow::Missing(operand) => return Some(operand),
            };
            let least = (bound.0.saturating_sub(required), sum);
            if best.is_some_and(|((late, known, _), _)| least > (late, known)) {
                continue;
            }
            let arrival = self.forms.refine(&mapping.arrivals, form, bound);
            // In time comes first, then cheap, then early; of equal ones the
            // first made.
            let key = (arrival.saturating_sub(required), sum, arrival);
            if best.is_none_or(|known| (key, form) < known) {
                best = Some((key, form));
            }
        }
        states[at] = FlowState::default();
        if let Some(((_, sum, arrival), form)) = best {
            mapping.chosen[at] = form;
            mapping.arrivals[at] = arrival;
            states[at] = FlowState {
                flow: sum / shares[at],
                arrival,
            };
        }
        None
    }

    /// Makes a mapping whose outputs are required at its path, or at any time,
    /// one with outputs required at `latest`.
    fn postpone(&self, mapping: &mut Mapping, latest: u32) {
        if latest == NEVER {
            return self.settle(mapping, None);
        }
        let later = latest.checked_sub(self.path(mapping));
        let later = later.expect("a mapping is only postponed");
        for required in &mut mapping.required {
            // Required at no time stays that.
            *required = required.saturating_add(later);
        }
    }
}
