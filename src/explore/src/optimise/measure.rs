//! Programs measured where they will run, and which of them is taken.

use super::maker::MadeProgram;
use super::start::PreparedStarts;
use super::{
    OptimisationError, OptimisationPoint, OptimisationQuestion, OptimisationTarget, input,
    processor,
};
use crate::ExplorationProgress;
use crate::program::{ExplorationError, view};
use rayon::prelude::*;
use robovec_error::yardstick::{MeasuredErrors, Unmeasurable, Yardstick};
use robovec_ir::Format;
use robovec_passes::optimise::search::SearchOutcome;

#[derive(Clone, PartialEq, Default, Debug)]
pub(super) struct ProgramFigures {
    /// The time of one state in C, ns.
    pub(super) nanoseconds: Option<f64>,
    /// Size of the compiled C, bytes.
    pub(super) code_bytes: Option<u64>,
    /// Of every array the error over the largest element: median and worst.
    pub(super) errors: Option<[f64; 2]>,
    /// Reason why there is no time.
    pub(super) remark: String,
}

pub(super) struct MeasuredPrograms {
    /// The function as it came.
    pub(super) input: OptimisationPoint,
    pub(super) figures: Vec<ProgramFigures>,
    /// Index of the one that is taken.
    pub(super) best: usize,
    pub(super) errors: MeasuredErrors,
}

/// Times up to this multiple of the smallest are as short: errors decide then.
const AS_FAST: f64 = 1.01;

/// The number format of a target: that of the machine, binary64 in C.
pub(super) fn format(question: &OptimisationQuestion<'_>) -> Format {
    match question.target {
        OptimisationTarget::Fpga => question.machine.number,
        OptimisationTarget::Cpu | OptimisationTarget::Batch => Format::BINARY64,
    }
}

/// Measures input and candidates, and takes the most exact of the fastest.
pub(super) fn measure(
    prepared: &PreparedStarts,
    outcome: &SearchOutcome<MadeProgram>,
    question: &OptimisationQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<MeasuredPrograms, OptimisationError> {
    let mut figures = vec![ProgramFigures::default(); outcome.trials.len()];
    let contenders = match question.target {
        OptimisationTarget::Fpga => placed(outcome)?,
        OptimisationTarget::Cpu | OptimisationTarget::Batch => {
            processor::contenders(prepared, outcome, question, &mut figures, progress)
                .map_err(OptimisationError::Timing)?
        }
    };
    progress("measuring errors");
    let is_measured = |index: &usize| {
        figures[*index].nanoseconds.is_some()
            || contenders.iter().any(|(_, contender)| contender == index)
    };
    let measured: Vec<usize> = (0..figures.len()).filter(is_measured).collect();
    let yardstick = Yardstick::new(view(&prepared.starts[0]), question.states, question.count);
    let errors: Result<Vec<(usize, MeasuredErrors)>, Unmeasurable> = measured
        .into_par_iter()
        .map(|index| {
            let program = &outcome.trials[index].program.module;
            let errors = yardstick.errors(view(program), format(question))?;
            Ok((index, errors))
        })
        .collect();
    let errors = errors.map_err(ExplorationError::from)?;
    let input = input::point(prepared, question, &yardstick, progress)?;
    for (index, errors) in &errors {
        figures[*index].errors = Some([errors.normwise.median, errors.normwise.worst]);
    }
    let best = most_exact_of_the_fastest(&contenders, &figures);
    let of_best = errors.into_iter().find(|(index, _)| *index == best);
    let (_, errors) = of_best.expect("all that may be taken was measured");
    Ok(MeasuredPrograms {
        input,
        figures,
        best,
        errors,
    })
}

/// Programs with a schedule, and its cycles.
fn placed(outcome: &SearchOutcome<MadeProgram>) -> Result<Vec<(f64, usize)>, OptimisationError> {
    let trials = outcome.trials.iter().enumerate();
    let placed: Vec<(f64, usize)> = trials
        .filter_map(|(index, trial)| Some((f64::from(trial.cycles?), index)))
        .collect();
    if placed.is_empty() {
        let reasons = outcome.trials.iter().filter_map(|t| t.bound.as_ref().err());
        let reason = reasons.map(ToString::to_string).next();
        return Err(OptimisationError::Placement(reason.unwrap_or_default()));
    }
    Ok(placed)
}

/// Of the programs within [`AS_FAST`] of the smallest time the one of the
/// smallest worst error; of equally exact ones the fastest, then the first.
fn most_exact_of_the_fastest(contenders: &[(f64, usize)], figures: &[ProgramFigures]) -> usize {
    let times = contenders.iter().map(|(time, _)| *time);
    let limit = AS_FAST * times.fold(f64::INFINITY, f64::min);
    let worst = |index: usize| figures[index].errors.expect("contenders are measured")[1];
    let fast = contenders.iter().filter(|(time, _)| *time <= limit);
    let taken = fast.min_by(|(time, index), (other_time, other)| {
        let exact = worst(*index).total_cmp(&worst(*other));
        exact
            .then(time.total_cmp(other_time))
            .then(index.cmp(other))
    });
    taken.expect("the fastest is one of them").1
}
