//! One form for every class, with costs and times.
//!
//! Forms are chosen by [curves](super::curve_map) or by [flow](super::flow);
//! the common parts are here.

use super::dense::FormsByClass;
use super::network::ChoiceNetwork;
use super::term::{Class, SignedClass};
use super::timing::NEVER;
use robovec_analysis::critical_path::Weights;

/// One form for every class, with costs and times. Indexed by class.
#[derive(Clone)]
pub(crate) struct Mapping {
    /// The form chosen.
    pub(super) chosen: Vec<u32>,
    pub(super) arrivals: Vec<u32>,
    /// The number of chosen forms and outputs that use each class.
    pub(super) uses: Vec<u32>,
    /// Latest arrivals that keep the outputs in time.
    pub(super) required: Vec<u32>,
    /// The classes that were considered when forms were chosen by flow: those
    /// that a form of another might have used.
    pub(super) demanded: Vec<bool>,
    /// Operations of the forms in use.
    pub(crate) operations: u64,
}

/// Forms to choose from.
pub(crate) struct Mapper<'a> {
    pub(super) forms: FormsByClass<'a>,
    pub(super) outputs: Vec<usize>,
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

    /// A mapping in which no class has a form.
    pub(super) fn unmapped(&self) -> Mapping {
        let count = self.forms.len();
        let mut demanded = vec![false; count];
        demanded[Class::ONE.index()] = true;
        for &output in &self.outputs {
            demanded[output] = true;
        }
        Mapping {
            chosen: vec![u32::MAX; count],
            arrivals: vec![NEVER; count],
            uses: vec![0; count],
            required: vec![NEVER; count],
            demanded,
            operations: 0,
        }
    }

    /// The latest output of a mapping.
    pub(crate) fn path(&self, mapping: &Mapping) -> u32 {
        let outputs = self.outputs.iter();
        let arrivals = outputs.map(|&output| mapping.arrivals[output]);
        arrivals.fold(0, u32::max)
    }

    /// Takes the forms chosen in another mapping. Unused classes have no time.
    pub(super) fn take(&self, mapping: &mut Mapping, chosen: &[u32], latest: u32) {
        mapping.chosen.copy_from_slice(chosen);
        self.settle(mapping, None);
        mapping.arrivals.fill(NEVER);
        mapping.arrivals[Class::ONE.index()] = 0;
        for at in 0..self.forms.len() {
            if mapping.uses[at] > 0 {
                mapping.arrivals[at] = self.arrival(mapping, mapping.chosen[at]);
            }
        }
        self.settle(mapping, Some(latest));
    }

    pub(super) fn arrival(&self, mapping: &Mapping, form: u32) -> u32 {
        self.forms.arrival(&mapping.arrivals, form)
    }

    /// Chooses for each class in turn the form that costs least at present.
    /// False when that changes nothing.
    ///
    /// Arrivals are always those of the chosen forms: only classes after a
    /// change are timed again. Classes that become unused have no time until a
    /// form that uses them is tried.
    pub(super) fn exact_round(&self, mapping: &mut Mapping) -> bool {
        let mut counter = UseCounter::default();
        let mut moved = vec![false; self.forms.len()];
        let mut changed = false;
        for at in 0..self.forms.len() {
            let old = mapping.chosen[at];
            if old == u32::MAX || mapping.arrivals[at] == NEVER {
                continue;
            }
            let mut is_behind = false;
            self.forms
                .operands(old, |operand| is_behind |= moved[operand]);
            if mapping.uses[at] == 0 {
                moved[at] = is_behind;
                if is_behind {
                    mapping.arrivals[at] = NEVER;
                }
                continue;
            }
            let mut arrival = mapping.arrivals[at];
            if is_behind {
                arrival = self.arrival(mapping, old);
            }
            let (form, arrival) = self.choose_exactly(at, mapping, &mut counter, arrival);
            moved[at] = arrival != mapping.arrivals[at];
            changed |= moved[at] || form != old;
            mapping.chosen[at] = form;
            mapping.arrivals[at] = arrival;
        }
        changed
    }

    /// The form that costs a class least now, and its arrival; that of the form
    /// it has is given. Uses are counted for it.
    fn choose_exactly(
        &self,
        at: usize,
        mapping: &mut Mapping,
        counter: &mut UseCounter,
        arrival: u32,
    ) -> (u32, u32) {
        let (old, required) = (mapping.chosen[at], mapping.required[at]);
        let freed = counter.release(&self.forms, mapping, old);
        let mut best = ((arrival > required, freed, arrival), old);
        for form in self.forms.of(at) {
            let cost = u64::from(self.forms.cost(form));
            if form == old || cost > best.0.1 && !best.0.0 {
                continue;
            }
            let mut bound = self.forms.bound(&mapping.arrivals, form);
            if bound.0 == NEVER {
                self.time_operands(mapping, &mut counter.open, form);
                bound = self.forms.bound(&mapping.arrivals, form);
            }
            if bound.0 > required {
                continue;
            }
            let most = if best.0.0 { u64::MAX } else { best.0.1 };
            let Some(added) = counter.try_out(&self.forms, mapping, form, most) else {
                continue;
            };
            let arrival = self.forms.refine(&mapping.arrivals, form, bound);
            let key = (false, added, arrival);
            if arrival <= required && key < best.0 {
                best = (key, form);
            }
        }
        let ((_, _, arrival), form) = best;
        counter.acquire(&self.forms, mapping, form, u64::MAX);
        (form, arrival)
    }

    /// Times the operands of a form that have no time, by the forms they have.
    fn time_operands(&self, mapping: &mut Mapping, open: &mut Vec<u32>, form: u32) {
        open.clear();
        let untimed = |mapping: &Mapping, open: &mut Vec<u32>, form: u32| {
            self.forms.operands(form, |operand| {
                if mapping.arrivals[operand] == NEVER && mapping.chosen[operand] != u32::MAX {
                    open.push(operand as u32);
                }
            });
        };
        untimed(mapping, open, form);
        while let Some(&class) = open.last() {
            let (class, known) = (class as usize, open.len());
            let chosen = mapping.chosen[class];
            if mapping.arrivals[class] == NEVER {
                untimed(mapping, open, chosen);
            }
            if open.len() == known {
                mapping.arrivals[class] = self.arrival(mapping, chosen);
                open.pop();
            }
        }
    }

    /// Counts uses and operations again, and required times when a latest time
    /// is given.
    pub(super) fn settle(&self, mapping: &mut Mapping, latest: Option<u32>) {
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

/// Counts the uses of classes as forms are selected and deselected. Its vectors
/// are kept from one form to the next.
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
    /// `most`. Numbers of uses are unchanged.
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
