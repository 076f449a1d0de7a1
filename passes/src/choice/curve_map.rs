//! Choosing forms by curves: the best known, for networks that are not large.
//!
//! Every class has a [curve](super::curves) of its arrivals and operations.
//! From the outputs back each class that is used gets the form that adds least
//! and is in time, and hands on by when it needs what; then operations are
//! counted exactly.

use super::curves::Curves;
use super::map::{Mapper, Mapping};
use super::trial::FormTrial;

/// Chooses forms by curves.
pub(crate) struct CurveMapper<'a, 'n> {
    mapper: &'a Mapper<'n>,
    curves: Curves,
    /// How many users of each class bear its operations: those of the mappings
    /// made so far, the last ones before all.
    shares: Vec<f32>,
}

impl<'a, 'n> CurveMapper<'a, 'n> {
    /// Users are at first those of the forms that the function came with.
    pub(crate) fn new(mapper: &'a Mapper<'n>) -> CurveMapper<'a, 'n> {
        let mut first = mapper.unmapped();
        for at in 0..mapper.forms.len() {
            if let Some(form) = mapper.forms.of(at).next() {
                first.chosen[at] = form;
            }
        }
        mapper.settle(&mut first, None);
        let shares: Vec<f32> = first.uses.iter().map(|&uses| share(uses)).collect();
        let mut curves = Curves::new(mapper.forms.len());
        curves.update(&mapper.forms, &shares, &mapper.outputs);
        CurveMapper {
            mapper,
            curves,
            shares,
        }
    }

    /// The shortest path there is.
    pub(crate) fn shortest(&self) -> u32 {
        let outputs = self.mapper.outputs.iter();
        let earliest = outputs.filter_map(|&output| self.curves.of(output).first());
        earliest.map(|point| point.arrival).max().unwrap_or(0)
    }

    /// A mapping with few operations and no output later than `latest`.
    pub(crate) fn map(&mut self, latest: u32, rounds: u32) -> Mapping {
        let rounds = rounds.max(1);
        let mut best: Option<Mapping> = None;
        for round in 0..rounds {
            let mut mapping = self.select(latest);
            self.mapper.settle(&mut mapping, Some(latest));
            let mut rounds = 0..rounds;
            while rounds.next().is_some() && self.improve(&mut mapping, latest) {}
            for (known, &uses) in self.shares.iter_mut().zip(&mapping.uses) {
                *known = (*known + 2.0 * share(uses)) / 3.0;
            }
            match round {
                0 => self
                    .curves
                    .update(&self.mapper.forms, &self.shares, &self.mapper.outputs),
                _ => self.curves.update_live(&self.mapper.forms, &self.shares),
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
        self.curves
            .update(&self.mapper.forms, &self.shares, &self.mapper.outputs);
    }

    /// Chooses from the outputs on, for every class that is used by then what
    /// takes least beyond what is there already.
    fn select(&self, latest: u32) -> Mapping {
        let (forms, curves) = (&self.mapper.forms, &self.curves);
        let mut mapping = self.mapper.unmapped();
        for &output in &self.mapper.outputs {
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
                mapping.arrivals[at] = self.mapper.arrival(&mapping, mapping.chosen[at]);
            }
        }
        mapping
    }

    /// Takes operations off one by one; whether it did.
    fn improve(&self, mapping: &mut Mapping, latest: u32) -> bool {
        let before = (mapping.operations, mapping.chosen.clone());
        self.mapper.exact_round(mapping);
        self.mapper.settle(mapping, Some(latest));
        if mapping.operations > before.0 {
            self.mapper.take(mapping, &before, latest);
        }
        mapping.operations < before.0
    }
}

/// Those who bear the operations of a class that is used so often.
fn share(uses: u32) -> f32 {
    uses.max(1) as f32
}
