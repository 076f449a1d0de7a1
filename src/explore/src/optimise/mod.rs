//! Search for the best program of a target, for `robovec optimise`.
//!
//! A function starts from its equations as they came and, where there is a
//! model, from other formulations that compute the same ([`start`]). The search
//! of the pass `optimise` makes programs from them, here on all cores and with
//! a memory on disk ([`maker`]). They are measured on their target
//! ([`measure`]): the schedule on the machine, or their C; and for each the
//! error of its results in the target's format.
//!
//! The chosen program is proved once more, as a whole, against the equations
//! ([`proof`]): the user need not trust the passes.

pub mod answer;
pub mod found;
mod input;
mod maker;
mod measure;
mod processor;
mod proof;
pub mod start;
pub mod text;

use crate::device;
use crate::placing::words_of_a_side;
use crate::program::ExplorationError;
use crate::share::SharedWork;
use crate::worst::worst;
pub use maker::MakerTally;
use robovec_bench::Compiler;
use robovec_error::yardstick::account::{ErrorAccount, random_states};
use robovec_fpga::hardware;
use robovec_framework::scene::Scene;
use robovec_ir::states::States;
use robovec_ir::{Machine, Module};
use robovec_passes::optimise::search::ScheduleSize;
use robovec_passes::optimise::{Goal, VariantClass};
use serde::Serialize;
use start::OptimisationStart;
use std::path::Path;
use std::sync::Arc;

/// Target of a program.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum OptimisationTarget {
    /// The shortest schedule on the machine; memory images and HDL
    Fpga,
    /// The shortest time of one evaluation in C; the C file replaces Robotran's
    Cpu,
    /// The shortest time per state in C that evaluates several states at once
    Batch,
}

impl OptimisationTarget {
    /// Goal of the search: on processors programs of fewest operations.
    pub(crate) fn goal(self) -> Goal {
        match self {
            OptimisationTarget::Fpga => Goal::Cycles,
            OptimisationTarget::Cpu | OptimisationTarget::Batch => Goal::Operations,
        }
    }
}

/// Question.
pub struct OptimisationQuestion<'a> {
    /// Target of the program.
    pub target: OptimisationTarget,
    /// The machine: with the numbers of elements that are wanted.
    pub machine: &'a Machine,
    /// Scene that describes the use of the function.
    pub scene: Option<&'a Scene>,
    /// Numeric class of programs.
    pub class: VariantClass,
    /// Effort of the search, at least 1.
    pub effort: u32,
    /// Source of random states.
    pub states: &'a States,
    /// States that errors are measured at.
    pub count: u32,
    /// The C compiler with which programs are timed, if there is one.
    pub compiler: Option<&'a Compiler>,
    /// Its flags.
    pub flags: &'a str,
    /// The C file of the function.
    pub file: Option<&'a Path>,
    /// Place where made programs are kept, and which of them come first.
    pub work: SharedWork<'a>,
}

/// A program that was tried.
#[derive(Clone, PartialEq, Default, Debug, Serialize)]
pub struct OptimisationPoint {
    /// The steps it went through.
    pub name: String,
    /// Name of the start; empty for the equations as they came.
    pub start: String,
    /// The passes from that start.
    pub passes: String,
    /// Operations.
    pub operations: usize,
    /// The longest path, in cycles of the machine.
    pub path: u32,
    /// No schedule of these operations is shorter.
    pub bound: Option<u32>,
    /// The schedule.
    pub cycles: Option<u32>,
    /// The time of the schedule at the machine's clock, us.
    pub microseconds: Option<f64>,
    /// The time of one state in C, ns.
    pub nanoseconds: Option<f64>,
    /// The machine's share of the device with memories for it, if placed.
    pub share: Option<f64>,
    /// Size of the compiled C, bytes, where it was timed.
    pub code_bytes: Option<u64>,
    /// Errors of a candidate: of every array in every state the largest error
    /// over the largest element, the median and the worst.
    pub errors: Option<[f64; 2]>,
    /// The largest error of a directed search in the ranges and of the random
    /// states, of rows of the front: over the largest element of the array or,
    /// in the search, the usual size of the array if that is larger.
    pub found: Option<f64>,
    /// Bound of that error for every state in the ranges, where there is one.
    pub proved: Option<f64>,
    /// Reason why it was not measured.
    pub remark: String,
    /// True for the function as it came.
    #[serde(rename = "input")]
    pub is_input: bool,
    /// True for the one that was taken.
    pub taken: bool,
}

/// Result of a search.
pub struct Optimised {
    /// All that was tried, the input as it came first.
    pub points: Vec<OptimisationPoint>,
    /// Index of the point that was taken.
    pub best: usize,
    /// Programs that were not made, with the reasons.
    pub skipped: Vec<(String, String)>,
    /// Number of programs with the same figures.
    pub alike: usize,
    /// The number of programs that were made and not timed, since they promise less.
    pub untimed: usize,
    /// The program that was taken: at the level atomic, not placed.
    pub program: Arc<Module>,
    /// Index of its start.
    pub start: usize,
    /// Proof about it.
    pub proof: String,
    /// Its errors.
    pub errors: ErrorAccount,
}

/// Reason of a search without result.
#[derive(Debug, thiserror::Error)]
pub enum OptimisationError {
    /// A pass failed on equations, or a program does not match the function.
    #[error(transparent)]
    Program(#[from] ExplorationError),
    /// No program fits the machine.
    #[error("the machine can place no program: {0}")]
    Placement(String),
    /// No program was timed.
    #[error("no program could be timed: {0}")]
    Timing(String),
    /// The chosen program computes another function: a mistake in a pass.
    #[error(
        "the best program does not compute the function of the input; this is a mistake in a pass\n{0}"
    )]
    Proof(String),
}

/// Searches as one of several workers, so that their programs are kept: those
/// of its share first, then those that no other worker has made by then.
/// Measurement and proof follow in [`optimise`] with the same question.
pub fn search_share(
    starts: &[OptimisationStart],
    question: &OptimisationQuestion<'_>,
    progress: crate::ExplorationProgress<'_>,
) -> Result<MakerTally, OptimisationError> {
    let prepared = start::prepared(starts, question)?;
    let (mut outcome, tally) = maker::programs(starts, &prepared, question, progress)?;
    maker::place_nearby(&mut outcome, &prepared, question, progress);
    Ok(tally)
}

/// Searches, measures, proves.
pub fn optimise(
    starts: &[OptimisationStart],
    question: &OptimisationQuestion<'_>,
    progress: crate::ExplorationProgress<'_>,
) -> Result<Optimised, OptimisationError> {
    let prepared = start::prepared(starts, question)?;
    let (mut outcome, _) = maker::programs(starts, &prepared, question, progress)?;
    maker::place_nearby(&mut outcome, &prepared, question, progress);
    let measured = measure::measure(&prepared, &outcome, question, progress)?;
    let best = measured.best;
    outcome.trials[best].program.module =
        maker::as_made(&outcome.trials[best], &prepared, question)?;
    let trial = &outcome.trials[best];
    progress("proving the best");
    let proof = proof::prove(&prepared, trial, question).map_err(OptimisationError::Proof)?;
    let mut points = vec![measured.input];
    let mut modules = vec![prepared.starts[0].clone()];
    let is_timed = measured
        .figures
        .iter()
        .any(|figures| figures.nanoseconds.is_some());
    for (index, (trial, figures)) in outcome.trials.iter().zip(&measured.figures).enumerate() {
        // What was not timed is no rival of what was.
        if is_timed && figures.nanoseconds.is_none() && figures.remark.is_empty() {
            continue;
        }
        modules.push(trial.program.module.clone());
        points.push(OptimisationPoint {
            name: trial.name.clone(),
            start: starts[trial.start].name.clone(),
            passes: prepared.passes(&trial.pipeline),
            operations: trial.operations,
            path: trial.path,
            bound: trial.bound.as_ref().ok().copied(),
            cycles: trial.cycles,
            microseconds: (trial.cycles)
                .map(|cycles| hardware::clock(question.machine).microseconds(cycles)),
            nanoseconds: figures.nanoseconds,
            share: (trial.cycles.zip(trial.words))
                .map(|(cycles, words)| share(ScheduleSize { cycles, words }, question.machine)),
            code_bytes: figures.code_bytes,
            errors: figures.errors,
            found: None,
            proved: None,
            remark: if figures.remark.is_empty() {
                trial.remark.to_owned()
            } else {
                figures.remark.clone()
            },
            is_input: false,
            taken: index == best,
        });
    }
    let skipped = outcome.skipped.iter();
    let taken = points.iter().position(|point| point.taken);
    let mut optimised = Optimised {
        untimed: outcome.trials.len() + 1 - points.len(),
        points,
        best: taken.expect("the best was timed, where any was"),
        alike: outcome.alike,
        skipped: skipped
            .map(|skipped| (skipped.name.clone(), skipped.reason.clone()))
            .collect(),
        program: trial.program.module.clone(),
        start: trial.start,
        proof,
        errors: ErrorAccount {
            format: measure::format(question),
            normwise: measured.errors.normwise,
            states: random_states(
                question.count as usize,
                question.states.seed(),
                question.scene.is_some(),
            ),
        },
    };
    progress("searching for the largest errors");
    let front = optimised.shown(optimised.measure(question), text::SHOWN);
    let exact = &prepared.starts[0];
    for index in front {
        let program = (&*modules[index], measure::format(question));
        let worst = worst(exact, program, question.states, question.scene);
        let worst = worst.map_err(ExplorationError::from)?;
        let point = &mut optimised.points[index];
        point.found = Some(worst.with_sampled(point.errors.map_or(0.0, |[_, worst]| worst)));
        point.proved = worst.proved;
    }
    Ok(optimised)
}

/// The share of the device that a machine takes for a program that was placed.
fn share(size: ScheduleSize, machine: &Machine) -> f64 {
    let words = words_of_a_side(size.words, machine);
    device::figures(machine, machine.number, size.cycles, words).share
}
