//! A form while it is decided how early each of its classes has to be.

use super::curves::{CurvePoint, Curves, is_beaten};
use super::dense::FormsByClass;
use super::forms::ChoiceForm;
use crate::sums::earliest::{LatestTwo, fits, joined, levels};
use robovec_ir::Operation;
use smallvec::SmallVec;

/// Number of steps from the latest to the earliest time at which a form is
/// evaluated for its curve: half way and at both ends. Three to eight took
/// longer and found no shorter paths.
const STEPS: u32 = 2;

/// A class that a form uses, with a point of its curve.
#[derive(Clone, Copy)]
struct TrialSlot {
    class: u32,
    point: u32,
    arrival: u32,
    flow: f32,
}

/// A class or a product of two: one operand of the form.
#[derive(Clone, Copy)]
struct TrialTerm {
    /// Its classes are those at this place and, in a product, the next.
    first: u32,
    is_product: bool,
    /// True when it cannot be earlier.
    is_earliest: bool,
    time: u32,
}

/// A form with a point for each of its classes, the cheapest of their curves
/// at first.
#[derive(Default)]
pub(super) struct FormTrial {
    form: u32,
    slots: Vec<TrialSlot>,
    terms: Vec<TrialTerm>,
    /// Weight of the operation that combines the terms.
    weight: u32,
    multiply: u32,
    /// True when terms are not joined two by two.
    is_opaque: bool,
    /// The operations of the form and its shares of those of its classes.
    flow: f32,
}

impl FormTrial {
    /// Reads a form. False when one of its classes cannot be computed.
    pub(super) fn read(&mut self, forms: &FormsByClass<'_>, curves: &Curves, form: u32) -> bool {
        let (network, timing) = (forms.network(), forms.timing());
        self.form = form;
        self.slots.clear();
        self.terms.clear();
        self.multiply = timing.of(Operation::Mul);
        self.weight = timing.of(Operation::Add);
        self.is_opaque = false;
        let mut is_known = true;
        match network.form(form) {
            ChoiceForm::Input(..) | ChoiceForm::Constant(_) => self.flow = 0.0,
            ChoiceForm::Opaque(index) => {
                let opaque = &network.opaques[index as usize];
                self.is_opaque = true;
                self.weight = timing.of(opaque.operation);
                self.flow = f32::from(u8::from(!opaque.operation.is_trigonometric()));
                for operand in opaque.operands.iter().flatten() {
                    is_known &= self.push(curves, operand.class.index(), None);
                }
            }
            ChoiceForm::Product(factors) => {
                self.weight = self.multiply;
                self.flow = factors.len() as f32 - 1.0;
                for factor in factors {
                    is_known &= self.push(curves, factor.a.index(), None);
                }
            }
            ChoiceForm::Sum(terms) => {
                self.flow = terms.len() as f32 - 1.0;
                for term in terms {
                    let second = term.is_product().then(|| term.b().index());
                    is_known &= self.push(curves, term.a.index(), second);
                }
            }
        }
        is_known
    }

    fn push(&mut self, curves: &Curves, class: usize, second: Option<usize>) -> bool {
        let first = self.slots.len() as u32;
        let mut time = 0;
        let is_product = second.is_some();
        for class in [Some(class), second].into_iter().flatten() {
            let Some(last) = curves.of(class).len().checked_sub(1) else {
                return false;
            };
            let CurvePoint { arrival, flow, .. } = curves.point(class, last);
            self.slots.push(TrialSlot {
                class: class as u32,
                point: last as u32,
                arrival,
                flow,
            });
            time = time.max(arrival);
            self.flow += flow;
        }
        if is_product {
            self.flow += 1.0;
            time = time.saturating_add(self.multiply);
        }
        self.terms.push(TrialTerm {
            first,
            is_product,
            is_earliest: false,
            time,
        });
        true
    }

    fn times(&self) -> impl Iterator<Item = u32> + '_ {
        self.terms.iter().map(|term| term.time)
    }

    /// A time before which the form is not available, and a flag: true when it
    /// is known to be available then.
    #[inline]
    fn bound(&self) -> (u32, bool) {
        if self.is_opaque {
            let ready = self.times().fold(0, u32::max);
            return (ready.saturating_add(self.weight), true);
        }
        let mut two = LatestTwo::default();
        for time in self.times() {
            two.add(time);
        }
        two.finish(self.weight)
    }

    /// Time at which the form is available, which is not before a bound.
    fn arrival(&self, (bound, is_exact): (u32, bool)) -> u32 {
        if is_exact || fits(self.times(), self.weight, bound) {
            bound
        } else {
            joined(self.times().collect(), self.weight)
        }
    }

    fn slots(&self, term: TrialTerm) -> &[TrialSlot] {
        let first = term.first as usize;
        &self.slots[first..=first + usize::from(term.is_product)]
    }

    /// Moves to earlier points for the terms later than `limit`, and at least
    /// for the latest of those that can be earlier. False when none can.
    fn hasten(&mut self, curves: &Curves, limit: u32) -> bool {
        loop {
            let open = self.terms.iter().filter(|term| !term.is_earliest);
            let Some(latest) = open.map(|term| term.time).max() else {
                return false;
            };
            let limit = limit.min(latest.saturating_sub(1));
            let mut is_earlier = false;
            for index in 0..self.terms.len() {
                while self.terms[index].time > limit && self.hasten_term(curves, index) {
                    is_earlier = true;
                }
            }
            if is_earlier {
                return true;
            }
            if latest == 0 {
                return false;
            }
        }
    }

    fn hasten_term(&mut self, curves: &Curves, index: usize) -> bool {
        let term = self.terms[index];
        if term.is_earliest {
            return false;
        }
        let ready = self.slots(term).iter().map(|slot| slot.arrival).max();
        let ready = ready.expect("a term has a class");
        let is_late = |slot: &TrialSlot| slot.arrival == ready;
        let mut late = self.slots(term).iter().filter(|slot| is_late(slot));
        if late.any(|slot| slot.point == 0) {
            self.terms[index].is_earliest = true;
            return false;
        }
        let first = term.first as usize;
        let mut time = 0;
        for slot in &mut self.slots[first..=first + usize::from(term.is_product)] {
            if is_late(slot) {
                slot.point -= 1;
                let point = curves.point(slot.class as usize, slot.point as usize);
                self.flow += point.flow - slot.flow;
                (slot.arrival, slot.flow) = (point.arrival, point.flow);
            }
            time = time.max(slot.arrival);
        }
        let product = if term.is_product { self.multiply } else { 0 };
        self.terms[index].time = time.saturating_add(product);
        true
    }

    /// Adds the possible points of the form to the curve of its class, which
    /// has this number of users. It is not available before a time for any
    /// choice of points.
    pub(super) fn trace(
        &mut self,
        curves: &Curves,
        earliest: u32,
        share: f32,
        curve: &mut Vec<CurvePoint>,
    ) {
        let form = self.form;
        let mut step = None;
        loop {
            let flow = self.flow / share;
            // What comes is earlier, but no cheaper.
            if is_beaten(curve, earliest, flow) {
                return;
            }
            let bound = self.bound();
            if !is_beaten(curve, bound.0, flow) {
                let arrival = self.arrival(bound);
                let point = CurvePoint {
                    arrival,
                    form,
                    flow,
                };
                Curves::add(curve, point);
                if arrival == earliest {
                    return;
                }
            }
            let wanted = bound.0.saturating_sub(earliest);
            let step = *step.get_or_insert(wanted / STEPS);
            let next = bound.0.saturating_sub(step.max(1)).max(earliest);
            if !self.hasten(curves, self.limit(next)) {
                return;
            }
        }
    }

    /// Moves to earlier points until the form is in time; true on success.
    pub(super) fn meet(&mut self, curves: &Curves, required: u32) -> bool {
        loop {
            let (bound, is_exact) = self.bound();
            if bound <= required && (is_exact || fits(self.times(), self.weight, required)) {
                return true;
            }
            if !self.hasten(curves, self.limit(required)) {
                return false;
            }
        }
    }

    /// Time at which each term is needed at the latest for the form to be there
    /// by a time.
    fn limit(&self, required: u32) -> u32 {
        if self.is_opaque || self.terms.len() > 1 {
            required.saturating_sub(self.weight)
        } else {
            required
        }
    }

    /// Additional cost, given the times at which the classes in use are
    /// required.
    pub(super) fn marginal(&self, curves: &Curves, required: &[Option<u32>]) -> f32 {
        let mut flow = self.flow;
        for slot in &self.slots {
            let class = slot.class as usize;
            if let Some(required) = required[class] {
                let there = curves.in_time(class, required);
                flow -= curves.point(class, there).flow.min(slot.flow);
            }
        }
        flow
    }

    /// Hands the time that the form is required at on to its classes.
    pub(super) fn require(&self, time: u32, mut demand: impl FnMut(usize, u32)) {
        let times: SmallVec<[u32; 16]> = self.terms.iter().map(|term| term.time).collect();
        let levels = if self.is_opaque {
            SmallVec::from_elem(1, times.len())
        } else {
            levels(&times, self.weight)
        };
        for (term, level) in self.terms.iter().zip(levels) {
            let mut time = time.saturating_sub(level * self.weight);
            if term.is_product {
                time = time.saturating_sub(self.multiply);
            }
            for slot in self.slots(*term) {
                demand(slot.class as usize, time);
            }
        }
    }
}
