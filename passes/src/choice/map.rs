//! Choosing a form for every class: early enough, then few operations.

use super::curves::Curves;
use super::dense::FormsByClass;
use super::network::{ChoiceNetwork, Class, SignedClass};
use super::timing::NEVER;
use super::trial::FormTrial;
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

/// The largest network whose choices are made in several rounds and improved
/// one by one, in classes: the operations that hang on a choice are counted
/// anew for every form.
const LARGEST_EXACT: usize = 200_000;

/// Chooses forms.
pub(crate) struct Mapper<'a> {
    forms: FormsByClass<'a>,
    outputs: Vec<usize>,
    curves: Curves,
    /// How many users of each class bear its operations: those of the mappings
    /// made so far, the last ones before all.
    shares: Vec<f32>,
}

impl Mapper<'_> {
    /// Chooses among the forms of a network in
    /// [order of rank](ChoiceNetwork::sort).
    pub(crate) fn new<'a>(
        network: &'a ChoiceNetwork,
        timing: Weights,
        outputs: &[Option<SignedClass>],
    ) -> Mapper<'a> {
        let forms = FormsByClass::new(network, timing);
        let outputs = outputs.iter().flatten();
        let mut mapper = Mapper {
            outputs: outputs.map(|output| output.class.index()).collect(),
            curves: Curves::new(forms.len()),
            shares: Vec::new(),
            forms,
        };
        let mut first = mapper.unmapped();
        for at in 0..mapper.forms.len() {
            if let Some(form) = mapper.forms.of(at).next() {
                first.chosen[at] = form;
            }
        }
        mapper.settle(&mut first, None);
        mapper.shares = first.uses.iter().map(|&uses| share(uses)).collect();
        let Mapper {
            forms,
            shares,
            outputs,
            curves,
        } = &mut mapper;
        curves.update(forms, shares, outputs);
        mapper
    }

    /// The shortest path there is.
    pub(crate) fn shortest(&self) -> u32 {
        let outputs = self.outputs.iter();
        let earliest = outputs.filter_map(|&output| self.curves.of(output).first());
        earliest.map(|point| point.arrival).max().unwrap_or(0)
    }

    /// A mapping with few operations and no output later than `latest`.
    pub(crate) fn map(&mut self, latest: u32, rounds: u32) -> Mapping {
        let rounds = match self.forms.len() > LARGEST_EXACT {
            true => 1,
            false => rounds.max(1),
        };
        let mut best: Option<Mapping> = None;
        for round in 0..rounds {
            let mut mapping = self.select(latest);
            self.settle(&mut mapping, Some(latest));
            let mut rounds = 0..rounds;
            while rounds.next().is_some() && self.improve(&mut mapping, latest) {}
            for (known, &uses) in self.shares.iter_mut().zip(&mapping.uses) {
                *known = (*known + 2.0 * share(uses)) / 3.0;
            }
            match round {
                0 => self.curves.update(&self.forms, &self.shares, &self.outputs),
                _ => self.curves.update_live(&self.forms, &self.shares),
            }
            if best
                .as_ref()
                .is_none_or(|best| mapping.operations < best.operations)
            {
                best = Some(mapping);
            }
        }
        best.expect("there is a round")
    }

    /// The users of each class that bear its operations.
    pub(crate) fn shares(&self) -> Vec<f32> {
        self.shares.clone()
    }

    /// Goes back to former users.
    pub(crate) fn set_shares(&mut self, shares: &[f32]) {
        self.shares.copy_from_slice(shares);
        self.curves.update(&self.forms, &self.shares, &self.outputs);
    }

    /// Chooses from the outputs on, for every class that is used by then what
    /// takes least beyond what is there already.
    fn select(&self, latest: u32) -> Mapping {
        let (forms, curves) = (&self.forms, &self.curves);
        let mut mapping = self.unmapped();
        for &output in &self.outputs {
            mapping.uses[output] += 1;
            mapping.required[output] = latest;
        }
        let (mut trial, mut best) = (FormTrial::default(), FormTrial::default());
        for at in (0..forms.len()).rev() {
            if curves.of(at).is_empty() {
                continue;
            }
            let required = mapping.required[at];
            let point = curves.point(at, curves.in_time(at, required));
            mapping.chosen[at] = point.form;
            if mapping.uses[at] == 0 {
                continue;
            }
            best.read(forms, curves, point.form);
            best.meet(curves, required);
            let known = |class: usize| (mapping.uses[class] > 0).then(|| mapping.required[class]);
            let mut least = best.marginal(curves, known);
            for form in forms.of(at).filter(|&form| form != point.form) {
                if trial.read(forms, curves, form) && trial.meet(curves, required) {
                    let flow = trial.marginal(curves, known);
                    if flow < least {
                        least = flow;
                        mapping.chosen[at] = form;
                        std::mem::swap(&mut trial, &mut best);
                    }
                }
            }
            best.require(required, |class, time| {
                mapping.uses[class] += 1;
                mapping.required[class] = mapping.required[class].min(time);
            });
        }
        for at in 0..forms.len() {
            if mapping.chosen[at] != u32::MAX {
                mapping.arrivals[at] = self.arrival(&mapping, mapping.chosen[at]);
            }
        }
        mapping
    }

    /// Takes operations off one by one, where that is not too much work; whether
    /// it did.
    fn improve(&self, mapping: &mut Mapping, latest: u32) -> bool {
        if self.forms.len() > LARGEST_EXACT {
            return false;
        }
        let before = (mapping.operations, mapping.chosen.clone());
        self.exact_round(mapping);
        self.settle(mapping, Some(latest));
        if mapping.operations > before.0 {
            self.take(mapping, &before, latest);
        }
        mapping.operations < before.0
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

    fn arrival(&self, mapping: &Mapping, form: u32) -> u32 {
        self.forms.arrival(&mapping.arrivals, form)
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

/// Those who bear the operations of a class that is used so often.
fn share(uses: u32) -> f32 {
    uses.max(1) as f32
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
