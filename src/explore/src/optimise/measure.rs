//! Programs measured where they will run, and which of them is taken.

use super::maker::MadeProgram;
use super::processor;
use super::start::PreparedStarts;
use super::{OptimisationError, OptimisationQuestion, OptimisationTarget};
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
    /// Of every array its largest error over its largest element: median and
    /// worst.
    pub(super) errors: Option<[f64; 2]>,
    /// Reason why there is no time.
    pub(super) remark: String,
}

pub(super) struct MeasuredPrograms {
    pub(super) figures: Vec<ProgramFigures>,
    /// Index of the one that is taken.
    pub(super) best: usize,
    /// Its errors in detail.
    pub(super) errors: MeasuredErrors,
}

/// The number format of a target: that of the machine, binary64 in C.
pub(super) fn format(question: &OptimisationQuestion<'_>) -> Format {
    match question.target {
        OptimisationTarget::Fpga => question.machine.number,
        OptimisationTarget::Cpu | OptimisationTarget::Batch => Format::BINARY64,
    }
}

/// Measures what can be the best.
pub(super) fn measure(
    prepared: &PreparedStarts,
    outcome: &SearchOutcome<MadeProgram>,
    question: &OptimisationQuestion<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<MeasuredPrograms, OptimisationError> {
    let mut figures = vec![ProgramFigures::default(); outcome.trials.len()];
    let best = match question.target {
        OptimisationTarget::Fpga => outcome.best.ok_or_else(|| {
            let reasons = outcome.trials.iter().filter_map(|t| t.bound.as_ref().err());
            let reason = reasons.map(ToString::to_string).next();
            OptimisationError::Placement(reason.unwrap_or_default())
        })?,
        OptimisationTarget::Cpu | OptimisationTarget::Batch => {
            processor::choose(prepared, outcome, question, &mut figures, progress)
                .map_err(OptimisationError::Timing)?
        }
    };
    progress("measuring errors");
    let measured = |index: &usize| {
        let is_candidate = match question.target {
            OptimisationTarget::Fpga => outcome.trials[*index].cycles.is_some(),
            OptimisationTarget::Cpu | OptimisationTarget::Batch => {
                figures[*index].nanoseconds.is_some()
            }
        };
        is_candidate || *index == best
    };
    let candidates: Vec<usize> = (0..figures.len()).filter(measured).collect();
    let yardstick = Yardstick::new(view(&prepared.starts[0]), question.states, question.count);
    let errors: Result<Vec<(usize, MeasuredErrors)>, Unmeasurable> = candidates
        .into_par_iter()
        .map(|index| {
            let program = &outcome.trials[index].program.module;
            let errors = yardstick.errors(view(program), format(question))?;
            Ok((index, errors))
        })
        .collect();
    let errors = errors.map_err(ExplorationError::from)?;
    let mut of_best = MeasuredErrors::default();
    for (index, errors) in errors {
        figures[index].errors = Some([errors.normwise.median, errors.normwise.worst]);
        if index == best {
            of_best = errors;
        }
    }
    Ok(MeasuredPrograms {
        figures,
        best,
        errors: of_best,
    })
}
