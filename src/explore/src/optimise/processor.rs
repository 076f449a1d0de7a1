//! Programs as C on this processor.
//!
//! Operations, loads and stores make most of the time of straight-line C
//! ([`processor_work`]), but not all. So the programs of the least work, and
//! one of every preparation, are compiled and timed.

use super::maker::MadeProgram;
use super::measure::ProgramFigures;
use super::start::PreparedStarts;
use super::{OptimisationQuestion, OptimisationTarget};
use crate::ExplorationProgress;
use crate::processor::{LARGEST, question};
use crate::program::view;
use rayon::prelude::*;
use robovec_analysis::processor::processor_work;
use robovec_bench::contestant::{Contestant, ContestantFamily};
use robovec_bench::{BenchOutcome, BenchQuestion, Compiler, bench, own, robotran};
use robovec_cgen::superword::SuperwordLanes;
use robovec_io::files::TemporaryFolder;
use robovec_passes::optimise::search::SearchOutcome;
use robovec_passes::optimise::steps::{FEWEST, PREPARATIONS, PRESET, SearchStep};
use std::path::Path;

/// Rounds, and the time of a program in a round, ms: of all, of the fastest.
const ROUNDS: [(u32, u32); 2] = [(2, 30), (8, 60)];
/// Candidates this much slower than the fastest are not timed a second time.
const NEAR: f64 = 1.06;
/// Other flags that programs are timed with, to be better with all.
const OTHER_FLAGS: &str = own::FLAGS;
/// Maximum number of programs whose errors are measured where none is timed.
const MEASURED: usize = 16;
/// Programs of the smallest estimated work that are timed, by effort.
const TIMED: usize = 2;
/// Operations of all programs that are compiled, beside two in any case.
const COMPILED: usize = 300_000;

/// Candidates, with times over the fastest one's, or why none was timed.
pub(super) fn contenders(
    prepared: &PreparedStarts,
    outcome: &SearchOutcome<MadeProgram>,
    question: &OptimisationQuestion<'_>,
    figures: &mut [ProgramFigures],
    progress: ExplorationProgress<'_>,
) -> Result<Vec<(f64, usize)>, String> {
    let fewest = outcome.best.expect("the first program is always made");
    let untimed = match question.compiler {
        None => "not timed, as asked",
        Some(_) if outcome.trials[fewest].operations > LARGEST => "too large to compile and time",
        Some(compiler) => {
            let candidates = candidates(outcome, question.effort);
            let timing = ProgramTiming {
                prepared,
                outcome,
                question,
                compiler,
                progress,
            };
            let mut slowness = timing.slowness(&candidates, figures)?;
            slowness.retain(|(time, _)| time.is_finite());
            if slowness.is_empty() {
                return Err(figures[candidates[0]].remark.clone());
            }
            return Ok(slowness);
        }
    };
    untimed.clone_into(&mut figures[fewest].remark);
    let operations = |index: usize| outcome.trials[index].operations as f64;
    let mut order: Vec<usize> = (0..outcome.trials.len()).collect();
    order.sort_by(|&a, &b| operations(a).total_cmp(&operations(b)).then(a.cmp(&b)));
    order.truncate(MEASURED);
    Ok(order
        .into_iter()
        .map(|index| (operations(index), index))
        .collect())
}

/// The programs to time: the preset, and those of the least work.
fn candidates(outcome: &SearchOutcome<MadeProgram>, effort: u32) -> Vec<usize> {
    let trials = &outcome.trials;
    let work: Vec<f64> = trials
        .par_iter()
        .map(|trial| processor_work(view(&trial.program.module).function))
        .collect();
    let mut order: Vec<usize> = (0..trials.len()).collect();
    order.sort_by(|&a, &b| work[a].total_cmp(&work[b]).then(a.cmp(&b)));
    let of = |step: &SearchStep| {
        let made = |&&index: &&usize| trials[index].preparation.is_some_and(|own| own == step);
        order.iter().find(made).copied()
    };
    let preset = FEWEST.iter().filter(|step| step.name == PRESET);
    let preset = preset.filter_map(of);
    let least = order
        .iter()
        .copied()
        .take(TIMED.saturating_add(effort as usize));
    let preparations = PREPARATIONS.iter().chain(FEWEST).filter_map(of);
    let mut taken: Vec<usize> = Vec::new();
    let mut operations = 0;
    for index in preset.chain(least).chain(preparations) {
        let figures = |index: usize| (work[index].to_bits(), trials[index].path);
        if taken.iter().any(|&known| figures(known) == figures(index)) {
            continue;
        }
        operations += trials[index].operations;
        if taken.len() < 2 || operations <= COMPILED {
            taken.push(index);
        }
    }
    taken
}

struct ProgramTiming<'a> {
    prepared: &'a PreparedStarts,
    outcome: &'a SearchOutcome<MadeProgram>,
    question: &'a OptimisationQuestion<'a>,
    compiler: &'a Compiler,
    progress: ExplorationProgress<'a>,
}

impl ProgramTiming<'_> {
    /// Of every candidate the largest time over the fastest one's, by flags.
    fn slowness(
        &self,
        candidates: &[usize],
        figures: &mut [ProgramFigures],
    ) -> Result<Vec<(f64, usize)>, String> {
        let folder =
            TemporaryFolder::new().map_err(|error| format!("no temporary folder: {error}"))?;
        let mut flags = vec![self.question.flags];
        if flags[0] != OTHER_FLAGS {
            flags.push(OTHER_FLAGS);
        }
        let mut left = candidates.to_vec();
        for (rounds, milliseconds) in ROUNDS {
            let mut slowness: Vec<(f64, usize)> = left.iter().map(|&index| (1.0, index)).collect();
            for (number, flags) in flags.iter().enumerate() {
                let place = folder.path().join(number.to_string());
                let outcomes = self.timed(&left, &place, flags, rounds, milliseconds)?;
                let times = outcomes.iter().filter_map(|outcome| outcome.nanoseconds);
                let fastest = times.fold(f64::INFINITY, f64::min);
                for ((slowness, index), outcome) in slowness.iter_mut().zip(outcomes) {
                    // Where no program has a time, none is as fast as the fastest.
                    *slowness = match outcome.nanoseconds {
                        Some(time) => slowness.max(time / fastest),
                        None => f64::INFINITY,
                    };
                    if number == 0 {
                        figures[*index].nanoseconds = outcome.nanoseconds;
                        figures[*index].code_bytes = outcome.code_bytes;
                    }
                    if let Some(failure) = outcome.failure {
                        figures[*index].remark = failure;
                    }
                }
            }
            left = slowness
                .iter()
                .filter(|(time, _)| *time <= NEAR)
                .map(|(_, index)| *index)
                .collect();
            // The fastest is timed twice: its time is compared with the input.
            if left.is_empty() || rounds == ROUNDS[1].0 {
                return Ok(slowness);
            }
        }
        unreachable!("the last rounds end the timing")
    }

    /// The measurements of programs, in their order.
    fn timed(
        &self,
        candidates: &[usize],
        folder: &Path,
        flags: &str,
        rounds: u32,
        milliseconds: u32,
    ) -> Result<Vec<BenchOutcome>, String> {
        let function = view(&self.prepared.modules[0]);
        let question = BenchQuestion {
            flags: Some(flags),
            ..question(function, self.question.states)
        };
        let contestants = candidates.iter().map(|&index| {
            let trial = &self.outcome.trials[index];
            contestant(&question, self.question, self.compiler, trial)
        });
        let contestants: Vec<Contestant> = contestants.collect();
        bench(
            &question,
            &contestants,
            folder,
            rounds,
            milliseconds,
            &mut |what| (self.progress)(what),
        )
        .map_err(|error| error.to_string())
    }
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
        superwords: SuperwordLanes::Auto,
    };
    if question.target == OptimisationTarget::Batch {
        return own::batch(&plan);
    }
    single(&plan)
}

/// C that replaces Robotran's file; of other functions, with their arrays.
pub(super) fn single(plan: &own::ContestantPlan<'_>) -> Contestant {
    let in_place = robotran::drop_in(plan);
    match in_place.missing {
        Some(_) => own::straight(plan),
        None => in_place,
    }
}
