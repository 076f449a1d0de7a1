//! Choice of forms by curves: the best known method, except for large networks.
//!
//! Every class has a [curve](super::curves) of its arrivals and operations.
//! From the outputs back each class in use gets the form in time of least
//! additional cost, and sets the required times of its operands; then
//! operations are counted exactly.

use super::curves::Curves;
use super::map::{Mapper, Mapping};
use super::timing::NEVER;
use super::trial::FormTrial;

/// Rounds stop when one saves less than this part of the operations that the
/// first one left.
const MOST_SAVED: u64 = 12;

/// Chooses forms by curves.
pub(crate) struct CurveMapper<'a, 'n> {
    mapper: &'a Mapper<'n>,
    state: CurveState,
    /// The state before the last mapping.
    before: CurveState,
}

/// State that one mapping leaves for the next.
#[derive(Clone)]
struct CurveState {
    curves: Curves,
    /// Number of users of each class that share its operations: of the mappings
    /// made so far, the last ones with the most weight.
    shares: Vec<f32>,
}

impl<'a, 'n> CurveMapper<'a, 'n> {
    /// Users are at first those of the forms in the original function.
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
        let state = CurveState { curves, shares };
        CurveMapper {
            mapper,
            before: state.clone(),
            state,
        }
    }

    /// The shortest possible path.
    pub(crate) fn shortest(&self) -> u32 {
        let outputs = self.mapper.outputs.iter();
        let earliest = outputs.filter_map(|&output| self.state.curves.of(output).first());
        earliest.map(|point| point.arrival).fold(0, u32::max)
    }

    /// A mapping with few operations and no output later than `latest`. Rounds
    /// end before their time when one has `enough` operations or that is out of
    /// reach.
    pub(crate) fn map(&mut self, latest: u32, rounds: u32, enough: Option<u64>) -> Mapping {
        let rounds = rounds.max(1);
        let forms = &self.mapper.forms;
        let CurveState { curves, shares } = &mut self.state;
        // Nothing is made anew where nothing changed, as behind `go_back`.
        curves.update(forms, shares, &self.mapper.outputs);
        self.before.clone_from(&self.state);
        let mut best: Option<Mapping> = None;
        for round in 0..rounds {
            if round > 0 {
                let CurveState { curves, shares } = &mut self.state;
                curves.update_live(forms, shares);
            }
            let mut mapping = self.mapper.unmapped();
            let chosen = self.select(latest);
            self.mapper.take(&mut mapping, &chosen, latest);
            let mut rounds = 0..rounds;
            while rounds.next().is_some() && self.improve(&mut mapping, latest) {}
            for (known, &uses) in self.state.shares.iter_mut().zip(&mapping.uses) {
                *known = (*known + 2.0 * share(uses)) / 3.0;
            }
            let made = mapping.operations;
            if best.as_ref().is_none_or(|best| made < best.operations) {
                best = Some(mapping);
            }
            let is_over = |enough| made <= enough || made - made / MOST_SAVED > enough;
            if enough.is_some_and(is_over) {
                break;
            }
        }
        best.expect("there is a round")
    }

    /// Forgets the mapping made last.
    pub(crate) fn go_back(&mut self) {
        self.state.clone_from(&self.before);
    }

    /// Chooses a form for every class, starting from the outputs: for a class
    /// in use the one of the least additional cost in the time required, for
    /// the others the cheapest.
    fn select(&self, latest: u32) -> Vec<u32> {
        let (forms, curves) = (&self.mapper.forms, &self.state.curves);
        let mut chosen = vec![u32::MAX; forms.len()];
        // By class when it is required, if it is used.
        let mut required: Vec<Option<u32>> = vec![None; forms.len()];
        for &output in &self.mapper.outputs {
            required[output] = Some(latest);
        }
        let (mut trial, mut best) = (FormTrial::default(), FormTrial::default());
        for at in (0..forms.len()).rev() {
            if curves.of(at).is_empty() {
                continue;
            }
            let in_time = curves.in_time(at, required[at].unwrap_or(NEVER));
            let first = curves.point(at, in_time).form;
            chosen[at] = first;
            let Some(time) = required[at] else {
                continue;
            };
            best.read(forms, curves, first);
            best.meet(curves, time);
            let mut least = best.marginal(curves, &required);
            for form in forms.of(at).filter(|&form| form != first) {
                if trial.read(forms, curves, form) && trial.meet(curves, time) {
                    let flow = trial.marginal(curves, &required);
                    if flow < least {
                        least = flow;
                        chosen[at] = form;
                        std::mem::swap(&mut trial, &mut best);
                    }
                }
            }
            best.require(time, |class, time| {
                let known = &mut required[class];
                *known = Some(known.unwrap_or(NEVER).min(time));
            });
        }
        chosen
    }

    /// Removes operations one by one; true on success.
    fn improve(&self, mapping: &mut Mapping, latest: u32) -> bool {
        let (operations, chosen) = (mapping.operations, mapping.chosen.clone());
        self.mapper.exact_round(mapping);
        self.mapper.settle(mapping, Some(latest));
        if mapping.operations > operations {
            self.mapper.take(mapping, &chosen, latest);
        }
        mapping.operations < operations
    }
}

/// Those who have the operations of a class that is used so often.
fn share(uses: u32) -> f32 {
    uses.max(1) as f32
}
