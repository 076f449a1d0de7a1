//! Reduction of a failing pipeline to the smallest program and the single
//! rewrite that still fail.
//!
//! Three steps, each of which narrows the result of the one before: the first
//! pass that fails (with its own error, a panic, a refusal by the verifier or
//! by the semantic check); the smallest program on which that pass fails in the
//! same way; in it, the one rewrite without which it does not fail.
//!
//! Invariants: every step is run again on its result, to confirm it; the work
//! is bounded by a number of values run through passes, so that the same input
//! gives the same bytes on a slow machine and on a fast one.

mod edit;
mod locate;
mod shrink;
mod trial;
mod witness;

pub use locate::Rewrite;
pub use shrink::ReductionEffort;
pub use trial::{PassProblem, ProblemKind, TrialSetting};
pub use witness::Witness;

use crate::manager::difference;
use crate::pipeline::Pipeline;
use robovec_ir::{Module, print};
use std::fmt;
use trial::Case;

/// The work allowed by default: values run through passes.
pub const WORK: u64 = 4_000_000;

/// The smallest program found, and its failure.
#[derive(Clone, Debug)]
pub struct Reduction {
    /// The function that goes wrong.
    pub function: String,
    /// The number of the pass in the whole run, counted over all functions from
    /// 1.
    pub ordinal: u64,
    /// The problem on the original program.
    pub problem: PassProblem,
    /// The rewrite that breaks the original program.
    pub rewrite: Option<Rewrite>,
    /// Values of the function before the pass.
    pub size_before: usize,
    /// The small program.
    pub program: Module,
    /// The passes that show the problem on it; the last one goes wrong.
    pub pipeline: Pipeline,
    /// The problem on the small program.
    pub small_problem: PassProblem,
    /// The rewrite that breaks the small program.
    pub small_rewrite: Option<Rewrite>,
    /// The effect of that rewrite (or, when the pass does not count them, of
    /// the whole pass) on the text of the small program.
    pub difference: Option<String>,
    /// Whole numbers that show the difference, where there are such.
    pub witness: Option<Witness>,
    /// The effort spent.
    pub effort: ReductionEffort,
}

/// The first failing pass, with the function before it.
#[derive(Clone, Debug)]
pub struct Broken {
    /// The problem.
    pub problem: PassProblem,
    /// The failing function, alone.
    pub program: Module,
    /// The passes that show the problem on it; the last one goes wrong.
    pub pipeline: Pipeline,
}

/// Finds the first pass that fails when a pipeline runs on a module; `None`
/// when every pass keeps the promise of its numeric class.
pub fn broken_pass(
    module: &Module,
    pipeline: &Pipeline,
    setting: TrialSetting<'_>,
) -> Option<Broken> {
    let located = locate::first_broken_pass(module, pipeline, setting)?;
    Some(Broken {
        problem: located.problem,
        program: located.case.module(),
        pipeline: located.case.pipeline(),
    })
}

/// Reduces the first failure of a pipeline on a module; `None` when every pass
/// keeps the promise of its numeric class.
///
/// `work` bounds the effort; see [`WORK`].
pub fn reduce(
    module: &Module,
    pipeline: &Pipeline,
    setting: TrialSetting<'_>,
    work: u64,
) -> Option<Reduction> {
    let located = locate::first_broken_pass(module, pipeline, setting)?;
    let problem = located.problem;
    let mut case = located.case;
    let rewrite = locate::single_rewrite(&case, &problem, setting);
    let size_before = case.function.nodes().len();
    let effort = shrink::shrink(&mut case, &problem, setting, work);
    assert!(
        case.function.nodes().len() <= size_before,
        "a reduction makes no program larger"
    );
    // The small program shows a like problem, by construction; a pass that
    // is not deterministic may not.
    let small_problem = case.run(setting, None, true).problem?;
    let small_rewrite = locate::single_rewrite(&case, &problem, setting);
    let (difference, witness) = effect(&case, &small_problem, small_rewrite.as_ref(), setting);
    Some(Reduction {
        function: case.function.name.clone(),
        ordinal: located.ordinal,
        rewrite,
        size_before,
        program: case.module(),
        pipeline: case.pipeline(),
        small_problem,
        small_rewrite,
        difference,
        witness,
        effort,
        problem,
    })
}

/// The effect of the broken rewrite on the text, and numbers that show it; only
/// when the result is well formed.
fn effect(
    case: &Case,
    problem: &PassProblem,
    rewrite: Option<&Rewrite>,
    setting: TrialSetting<'_>,
) -> (Option<String>, Option<Witness>) {
    if problem.kind != ProblemKind::Changed {
        return (None, None);
    }
    let after = |rewrites: Option<u64>| case.run(setting, rewrites, false).module;
    let new = after(rewrite.map(|rewrite| rewrite.number));
    let old = match rewrite {
        Some(rewrite) => after(Some(rewrite.number - 1)),
        None => case.module(),
    };
    let (Some(function), Some(before)) = (new.functions.first(), old.functions.first()) else {
        return (None, None);
    };
    let text = |module: &Module, function| print::print_function(module.tables.view(function));
    let lines = difference(&text(&old, before), &text(&new, function));
    let witness = witness::find(&new.tables, &case.function, function);
    (Some(lines), witness)
}

impl fmt::Display for Rewrite {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "rewrite {} of {}", self.number, self.of)?;
        if !self.name.is_empty() {
            write!(formatter, ", of {}", self.name)?;
        }
        write!(formatter, ", by: {}", self.rule)
    }
}

impl fmt::Display for Reduction {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pass = self.pipeline.passes().last();
        let pass = pass.expect("the pipeline ends with the pass that fails");
        writeln!(
            formatter,
            "pass {} of the run, {pass}, fails on function '{}' with {} values",
            self.ordinal, self.function, self.size_before
        )?;
        match &self.rewrite {
            Some(rewrite) => writeln!(formatter, "  {rewrite}")?,
            None => writeln!(
                formatter,
                "  no single rewrite: the pass fails before its first rewrite, or does not report rewrites"
            )?,
        }
        let values: usize = self.program.functions.iter().map(|f| f.nodes().len()).sum();
        let exhausted = if self.effort.exhausted {
            "; the limit of work was reached, and a smaller one may exist"
        } else {
            ""
        };
        writeln!(
            formatter,
            "smallest program found: {values} values, after {} trials{exhausted}",
            self.effort.trials
        )?;
        formatter.write_str(&self.small_summary())
    }
}

impl Reduction {
    /// A summary of the small program, line by line: the problem, numbers that
    /// show it, the rewrite and its effect.
    pub fn small_summary(&self) -> String {
        let mut lines = vec![self.small_problem.message.clone()];
        lines.extend(self.witness.as_ref().map(ToString::to_string));
        lines.extend(self.small_rewrite.as_ref().map(ToString::to_string));
        if let Some(difference) = &self.difference {
            lines.push("which does this:".to_owned());
            lines.push(difference.trim_end().to_owned());
        }
        lines.push(String::new());
        lines.join("\n")
    }
}
