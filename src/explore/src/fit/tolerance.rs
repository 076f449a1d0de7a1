//! The errors of a program in a format, beside what the scene allows.

use super::{FitError, FitProgram, FitTask};
use crate::program::{ExplorationError, view};
use robovec_error::yardstick::{MeasuredErrors, Yardstick, results};
use robovec_framework::scene::Allowed;
use robovec_ir::Format;

/// The errors of a program in a format at the states of a yardstick.
#[derive(Clone, Debug)]
pub(super) struct FormatErrors {
    pub(super) errors: MeasuredErrors,
    /// For every state the largest error of an output over what is allowed of
    /// it; 0 where the scene allows every error, infinite for what is no
    /// number.
    pub(super) shares: Vec<f64>,
}

impl FormatErrors {
    /// The errors at the states of a yardstick.
    pub(super) fn at(
        task: &FitTask<'_>,
        program: &FitProgram,
        format: Format,
        yardstick: &Yardstick,
    ) -> Result<FormatErrors, FitError> {
        let view = view(&program.module);
        let inputs = yardstick.inputs(view).map_err(ExplorationError::from)?;
        let results = results(view, format, &inputs);
        let errors = yardstick.judge(view, &results);
        Ok(FormatErrors {
            errors: errors.map_err(ExplorationError::from)?,
            shares: shares(task, program, yardstick, &results)?,
        })
    }

    /// The largest error over what is allowed.
    pub(super) fn used(&self) -> f64 {
        self.shares.iter().copied().fold(0.0, f64::max)
    }
}

/// For every state of a yardstick the largest error over what is allowed, of
/// results in the order of the program's assignments.
pub(super) fn shares(
    task: &FitTask<'_>,
    program: &FitProgram,
    yardstick: &Yardstick,
    results: &[Vec<f64>],
) -> Result<Vec<f64>, FitError> {
    let view = view(&program.module);
    let allowed = Allowed::new(view, Some(task.scene), f64::INFINITY, &task.sizes);
    let shares = yardstick.shares(view, results, &allowed);
    Ok(shares.map_err(ExplorationError::from)?)
}
