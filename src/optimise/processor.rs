//! Programs as C on this processor.
//!
//! Operations tell most of the time of straight-line C, but not all of it:
//! what fits into registers, and what can be done side by side, the compiler
//! and the processor know alone. So the programs with the fewest operations
//! are compiled and timed.

use super::maker::MadeProgram;
use super::measure::ProgramFigures;
use super::start::PreparedStarts;
use super::{OptimisationQuestion, OptimisationTarget};
use crate::bench::contestant::{Contestant, ContestantFamily};
use crate::bench::{BenchOutcome, BenchQuestion, Compiler, bench, own, robotran};
use crate::explore::ExplorationProgress;
use crate::explore::processor::LARGEST;
use crate::explore::program::view;
use crate::files::TemporaryFolder;
use robovec_passes::optimise::search::SearchOutcome;

/// States that programs are timed at.
const STATES: u32 = 16;
/// Rounds, and the time of everybody in a round, ms.
const ROUNDS: (u32, u32) = (5, 60);
/// Times that differ by less than this part are the same: measurements vary
/// by as much.
const SAME: f64 = 0.02;
/// Programs that are timed, and more for every effort.
const TIMED: usize = 2;

/// The program to take, and times of those that might have been.
///
/// # Errors
///
/// The reason why no program was timed, though it could be compiled here.
pub(super) fn choose(
    prepared: &PreparedStarts,
    outcome: &SearchOutcome<MadeProgram>,
    question: &OptimisationQuestion<'_>,
    figures: &mut [ProgramFigures],
    progress: ExplorationProgress<'_>,
) -> Result<usize, String> {
    let fewest = outcome.best.expect("the first program is always made");
    let Some(compiler) = question.compiler else {
        "not timed, as asked".clone_into(&mut figures[fewest].remark);
        return Ok(fewest);
    };
    if outcome.trials[fewest].operations > LARGEST {
        "too large to compile and time".clone_into(&mut figures[fewest].remark);
        return Ok(fewest);
    }
    let candidates = candidates(outcome, question.effort);
    let times = timed(prepared, outcome, question, compiler, &candidates, progress)?;
    let mut best: Option<(f64, usize)> = None;
    for (&index, outcome) in candidates.iter().zip(times) {
        figures[index].nanoseconds = outcome.nanoseconds;
        figures[index].code_bytes = outcome.code_bytes;
        figures[index].remark = outcome.failure.unwrap_or_default();
        let Some(time) = outcome.nanoseconds else {
            continue;
        };
        if best.is_none_or(|(known, _)| time < known * (1.0 - SAME)) {
            best = Some((time, index));
        }
    }
    best.map(|(_, index)| index)
        .ok_or_else(|| figures[candidates[0]].remark.clone())
}

/// The programs with the fewest operations, the best first, each once.
fn candidates(outcome: &SearchOutcome<MadeProgram>, effort: u32) -> Vec<usize> {
    let trials = &outcome.trials;
    let mut order: Vec<usize> = (0..trials.len()).collect();
    order.sort_by_key(|&index| (trials[index].operations, trials[index].path, index));
    order.dedup_by_key(|index| (trials[*index].operations, trials[*index].path));
    order.truncate(TIMED.saturating_add(effort as usize));
    order
}

/// Times of programs, in their order.
fn timed(
    prepared: &PreparedStarts,
    outcome: &SearchOutcome<MadeProgram>,
    question: &OptimisationQuestion<'_>,
    compiler: &Compiler,
    candidates: &[usize],
    progress: ExplorationProgress<'_>,
) -> Result<Vec<BenchOutcome>, String> {
    let folder = TemporaryFolder::new().map_err(|error| format!("no temporary folder: {error}"))?;
    let bench_question = BenchQuestion {
        name: "function".to_owned(),
        view: view(&prepared.modules[0]),
        model: None,
        has_loads: false,
        states: question.states,
        count: STATES,
        flags: Some(question.flags),
    };
    let contestants = candidates.iter().map(|&index| {
        let trial = &outcome.trials[index];
        contestant(&bench_question, question, compiler, trial)
    });
    let contestants: Vec<Contestant> = contestants.collect();
    let (rounds, milliseconds) = ROUNDS;
    bench(
        &bench_question,
        &contestants,
        folder.path(),
        rounds,
        milliseconds,
        &mut |what| progress(what),
    )
    .map_err(|error| error.to_string())
}

fn contestant(
    bench_question: &BenchQuestion<'_>,
    question: &OptimisationQuestion<'_>,
    compiler: &Compiler,
    trial: &robovec_passes::optimise::trial::VariantTrial<MadeProgram>,
) -> Contestant {
    let plan = own::ContestantPlan {
        question: bench_question,
        compiler,
        family: ContestantFamily::Equations,
        name: &trial.name,
        view: view(&trial.program.module),
    };
    let make = |way: own::ContestantMaker| way(&plan);
    if question.target == OptimisationTarget::Batch {
        return make(own::batch);
    }
    let in_place = make(robotran::drop_in);
    match in_place.missing {
        // A function that is none of Robotran's has arrays of its own.
        Some(_) => make(own::straight),
        None => in_place,
    }
}
