//! The form of a function with the least rounding error within a time limit.

mod compensate;
mod fuse;
pub(crate) mod measure;
pub(crate) mod profile;
mod regroup;
mod terms;
#[cfg(test)]
mod tests;

use compensate::CompensationBudget;
use measure::{Errors, ReferenceOutputs};
use profile::{LANES, SensitivityProfile};
use robovec_analysis::critical_path::critical_path;
use robovec_analysis::rounding::usual_states;
use robovec_framework::declare_pass;
use robovec_framework::options::OptionValue;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::without_dead;
use robovec_ir::states::States;
use robovec_ir::{Format, Function, View};
use robovec_num::limits::{Amount, NumberLimit};

/// Limit of the longest path.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum CycleLimit {
    /// At most the present length.
    Same,
    /// At most this number of cycles of the machine, and never fewer than the
    /// length of the longest path.
    AtMost(u32),
}

impl OptionValue for CycleLimit {
    const IS_NUMBER: bool = true;
    fn type_name() -> String {
        "integer | same".to_owned()
    }
    fn parse(text: &str) -> Result<CycleLimit, String> {
        match text {
            "same" => Ok(CycleLimit::Same),
            other => u32::parse(other).map(CycleLimit::AtMost),
        }
    }
    fn print(&self) -> String {
        match self {
            CycleLimit::Same => "same".to_owned(),
            CycleLimit::AtMost(cycles) => cycles.to_string(),
        }
    }
    fn amount(&self) -> Option<Amount> {
        match self {
            CycleLimit::Same => None,
            CycleLimit::AtMost(cycles) => cycles.amount(),
        }
    }
}

declare_pass! {
    /// Writes sums and products in the form that rounds least.
    ///
    /// The pass measures at a few random states (the ranges of the scene, when
    /// there is one) the size of every value and the effect of its rounding on
    /// the outputs, and rewrites where that makes the predicted error of all
    /// outputs smaller:
    ///
    /// - terms of a sum are added in the order with the smallest partial sums:
    ///   small ones first, and what cancels before the rest;
    /// - products that cancel are factored: `a*b - a*c` becomes `a*(b - c)`,
    ///   and `a*a - b*b` becomes `(a - b)*(a + b)`;
    /// - where operations may be added (`growth`), the rounding errors of the
    ///   values that harm most are computed and taken off further on:
    ///   compensated sums and products (Ogita, Rump and Oishi, SIAM J. Sci.
    ///   Comput. 26, 2005), across equations;
    /// - where the machine has fused elements, products are contracted into
    ///   the sums that read them, which saves a rounding.
    ///
    /// The longest path does not exceed `cycles`, or what it was when that is
    /// more; operations do not grow beyond `growth`. At the end both versions
    /// are measured at fresh states in `format`: the function stays as it was
    /// unless neither the median of the relative error nor that of the
    /// normwise one is worse.
    ///
    /// Belongs after every pass that regroups or merges (`balance`, `eqsat`,
    /// `cse`): a compensated sum is equal over the reals to the plain one, so
    /// such a pass may undo it. `asap-alap` and `place` may follow.
    pub struct Accurate("accurate") {
        /// The longest path allowed, in cycles of the machine; `same` for its
        /// length before the pass.
        pub cycles: CycleLimit = CycleLimit::Same => NumberLimit::whole(
            0, 1_000_000_000, "no function takes more cycles"),
        /// Cycles allowed beyond that, in per cent of it.
        pub slack: u32 = 0 => NumberLimit::whole(
            0, 10_000, "no longer path rounds less"),
        /// Operations allowed beyond those there are, in per cent.
        pub growth: u32 = 0 => NumberLimit::whole(
            0, 10_000, "the number of operations grows up to a hundred times"),
        /// Random states at which the result is measured; 0 for as many as
        /// the size of the function suggests.
        pub states: u32 = 0 => NumberLimit::whole(
            0, 10_000, "the function is measured at every state, and all results are kept"),
        /// The number format whose rounding counts.
        pub format: Format = Format::BINARY32,
    }
    takes: [Atomic],
    gives: Gives::Same,
    class: Real,
    destroys: [Timed, Shared, ZeroFree],
}

/// The seed of all states that the pass measures.
pub(crate) const SEED: u64 = 0x5eed_acc0;

/// The number of the first state at which the result is measured; earlier
/// states are for the search.
const FIRST_MEASURED: u32 = 1000;

/// The number of the first state at which the version that was chosen is
/// measured once more: the best of several is partly the luckiest.
const FIRST_CHECKED: u32 = 1_000_000;

/// Number of profiles by which sums are ordered; each result is measured.
const PROFILES: u32 = 3;

/// The number of compensated versions that are measured.
const MEASURED: usize = 3;

impl Pass for Accurate {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let states = match context.scene {
            Some(scene) => scene.states(SEED),
            None => States::new(SEED),
        };
        let before = critical_path(function, context.machine).asap_cycle;
        let allowed = match self.cycles {
            CycleLimit::Same => before,
            CycleLimit::AtMost(cycles) => cycles,
        };
        let slack = u64::from(allowed) * u64::from(self.slack) / 100;
        let limit = allowed
            .saturating_add(u32::try_from(slack).unwrap_or(u32::MAX))
            .max(before);
        let count = match self.states {
            0 => usual_states(function.nodes().len()),
            states => states,
        };
        let reference = {
            let tables = &*context.tables;
            ReferenceOutputs::new(View { tables, function }, &states, FIRST_MEASURED, count)
        };
        let mut search = AccuracySearch {
            reference,
            states,
            limit,
            format: self.format,
            size: function.nodes().len(),
            growth: self.growth,
            old: Errors::default(),
            best: function.clone(),
            errors: Errors::default(),
            statistics: Vec::new(),
        };
        search.old = search.reference.errors(function, self.format);
        search.errors = search.old;
        search.run(context);
        let fresh = {
            let tables = &*context.tables;
            ReferenceOutputs::new(
                View { tables, function },
                &search.states,
                FIRST_CHECKED,
                count,
            )
        };
        let old = fresh.errors(function, self.format);
        let new = fresh.errors(&search.best, self.format);
        let refused = context.rewrites.has_refused();
        if refused || search.errors != search.old && new.no_worse_than(&old) {
            context.statistics.append(&mut search.statistics);
            context.remark(told(&old, &new));
            *function = search.best;
        } else {
            context.remark("no form was found that rounds less".to_owned());
        }
        Ok(())
    }
}

/// The best version so far, and the measures of versions.
struct AccuracySearch {
    reference: ReferenceOutputs,
    states: States,
    /// The longest path allowed, in cycles.
    limit: u32,
    format: Format,
    /// Operations of the original function, and per cent allowed beyond.
    size: usize,
    growth: u32,
    old: Errors,
    best: Function,
    errors: Errors,
    statistics: Vec<(&'static str, u64)>,
}

impl AccuracySearch {
    fn run(&mut self, context: &mut Context<'_>) {
        let original = self.best.clone();
        let mut base = original.clone();
        let mut statistics = regroup::Regrouped::default();
        for part in 0..PROFILES {
            let profile = self.profile(&original, part, context);
            let (regrouped, done) = regroup::regroup(&original, &profile, self.limit, context);
            if done.reordered + done.factored == 0 {
                continue;
            }
            let regrouped = without_dead(regrouped);
            if self.offer(&regrouped, context) {
                base = regrouped;
                statistics = done;
            }
            if context.rewrites.has_refused() {
                break;
            }
        }
        let profile = self.profile(&base, 0, context);
        let mut contracted = 0;
        if let Some((fused, count)) = fuse::fuse(&base, &profile, self.limit, context)
            && self.offer(&fused, context)
        {
            contracted = count;
        }
        let mut compensated = 0;
        if self.growth > 0 {
            let budget = CompensationBudget {
                limit: self.limit,
                operations: self.size + self.size * self.growth as usize / 100,
                format: self.format,
            };
            let versions = compensate::compensated(&base, &profile, &budget, context);
            for version in versions.into_iter().take(MEASURED) {
                let function = version.function;
                let profile = self.profile(&function, 0, context);
                let fused = fuse::fuse(&function, &profile, self.limit, context);
                let (function, count) = fused.unwrap_or((function, 0));
                if self.offer(&function, context) {
                    (compensated, contracted) = (version.tracked as u64, count);
                }
            }
        }
        self.statistics.extend([
            ("sums reordered", statistics.reordered),
            ("sums factored", statistics.factored),
            ("products contracted", contracted),
            ("values compensated", compensated),
        ]);
    }

    /// Measures a version and keeps it when it is the best so far; one with
    /// refused rewrites always, since then it is needed for the reduction.
    fn offer(&mut self, function: &Function, context: &Context<'_>) -> bool {
        let errors = self.reference.errors(function, self.format);
        let better = errors.score() < self.errors.score() && errors.no_worse_than(&self.old);
        if better || context.rewrites.has_refused() {
            self.best = function.clone();
            self.errors = errors;
            return true;
        }
        false
    }

    fn profile(&self, function: &Function, part: u32, context: &Context<'_>) -> SensitivityProfile {
        let tables = &*context.tables;
        let first = part * LANES as u32;
        SensitivityProfile::new(View { tables, function }, &self.states, first)
    }
}

/// One line on the change of the errors.
fn told(old: &Errors, new: &Errors) -> String {
    let [old_median, .., old_worst] = old.normwise;
    let [median, .., worst] = new.normwise;
    format!(
        "median of the relative error {:.3e} to {:.3e}, of the normwise one {old_median:.3e} to \
         {median:.3e}, largest normwise {old_worst:.3e} to {worst:.3e}",
        old.relative, new.relative
    )
}
