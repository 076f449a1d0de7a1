//! Finding the first pass that goes wrong, and in it the one rewrite.

use super::trial::{self, Case, PassProblem, TrialSetting};
use crate::manager::{Executed, Limit};
use crate::pipeline::{PassStep, Pipeline};
use robovec_ir::{Level, Module};

/// The first pass that goes wrong.
pub(super) struct Located {
    pub(super) problem: PassProblem,
    /// The number of passes that ran up to it, itself included, over all
    /// functions.
    pub(super) ordinal: u64,
    /// The function and the passes that show the problem; usually only one
    /// pass.
    pub(super) case: Case,
}

/// Runs a pipeline with every pass checked, up to the first that goes wrong.
///
/// As every pass is checked against its own input, the first failure names the
/// pass; only the shortest failing tail of the pipeline is searched for.
pub(super) fn first_broken_pass(
    module: &Module,
    pipeline: &Pipeline,
    setting: TrialSetting<'_>,
) -> Option<Located> {
    let trial = trial::run(module, pipeline, setting, None, true);
    let problem = trial.problem?;
    let index = trial.executed.last()?.function;
    Some(Located {
        ordinal: trial.executed.len() as u64,
        case: shortest_tail(module, pipeline, setting, &trial.executed, index, &problem),
        problem,
    })
}

/// The failing pass on the state before it, or with the minimum number of
/// passes before it: a reduction needs equations or single operations, and
/// times and schedules are not kept.
fn shortest_tail(
    module: &Module,
    pipeline: &Pipeline,
    setting: TrialSetting<'_>,
    executed: &[Executed],
    index: usize,
    problem: &PassProblem,
) -> Case {
    let mut steps: Vec<PassStep> = Vec::new();
    for (done, pass) in executed.iter().enumerate().rev() {
        if pass.function != index {
            break;
        }
        steps.insert(0, pass.step.clone());
        let limit = Limit {
            passes: done as u64,
            rewrites: None,
        };
        let before = trial::run(module, pipeline, setting, Some(limit), false).module;
        let mut function = before.functions[index].clone();
        if !matches!(function.level, Level::Equations | Level::Atomic) {
            continue;
        }
        function.timing = None;
        let case = Case {
            tables: before.tables,
            function,
            steps: steps.clone(),
            registry: pipeline.registry,
        };
        if case.shows(problem, setting, None) {
            return case;
        }
    }
    Case {
        tables: module.tables.clone(),
        function: module.functions[index].clone(),
        steps,
        registry: pipeline.registry,
    }
}

/// The rewrite that breaks a function.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Rewrite {
    /// Its number in the pass, from 1.
    pub number: u64,
    /// The total number of rewrites of the pass.
    pub of: u64,
    /// The value rewritten, as in the text; empty for an inner node.
    pub name: String,
    /// Way of the change: the name of a rule, or a few words.
    pub rule: String,
}

/// The rewrite of the last pass without which the problem does not show: found
/// by halving, as the first rewrites of a pass are the same for any
/// continuation. `None` when the pass does not count its rewrites, or when it
/// goes wrong without any.
pub(super) fn single_rewrite(
    case: &Case,
    problem: &PassProblem,
    setting: TrialSetting<'_>,
) -> Option<Rewrite> {
    let total = case.run(setting, None, true).executed.last()?.rewrites;
    let shows = |rewrites| case.shows(problem, setting, Some(rewrites));
    if total == 0 || shows(0) || !shows(total) {
        return None;
    }
    // Not with the first, but with the second.
    let (mut good, mut bad) = (0, total);
    while bad - good > 1 {
        let middle = good + (bad - good) / 2;
        if shows(middle) {
            bad = middle;
        } else {
            good = middle;
        }
    }
    let trial = case.run(setting, Some(bad), true);
    let (name, rule) = trial.executed.last()?.last.clone()?;
    Some(Rewrite {
        number: bad,
        of: total,
        name: if name.is_none() {
            String::new()
        } else {
            format!("%{}", name.display(&trial.module.tables.symbols))
        },
        rule,
    })
}
