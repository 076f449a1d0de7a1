//! Errors of a choice by their source: the rounding of the data, the series
//! for sines and cosines, the operations.

use super::format::shares;
use super::{FitError, FitProgram, FitTask};
use crate::program::view;
use robovec_error::yardstick::{Yardstick, results};
use robovec_ir::Format;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::soft_float::FormatArithmetic;
use serde::Serialize;

/// The largest ratio of an error to the allowed one for each source alone, at
/// the worst states of a challenge.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct FitSources {
    /// Of inputs rounded to the format, with exact operations.
    pub data: f64,
    /// Of series for sines and cosines, with exact data and operations of
    /// binary64.
    pub series: f64,
    /// Of operations in the format, against the same program with exact ones,
    /// with data rounded to the format.
    pub operations: f64,
}

impl FitSources {
    /// The sources at states of the general function; `None` for a program
    /// whose values, inputs too, have their own formats.
    pub(super) fn at(
        task: &FitTask<'_>,
        program: &FitProgram,
        format: Format,
        states: &[Vec<f64>],
    ) -> Result<Option<FitSources>, FitError> {
        if program.mixture.is_some() || states.is_empty() {
            return Ok(None);
        }
        let arithmetic = FormatArithmetic::new(format);
        let rounded = |state: &Vec<f64>| -> Vec<f64> {
            state
                .iter()
                .map(|&number| arithmetic.literal(number))
                .collect()
        };
        let held: Vec<Vec<f64>> = states.iter().map(rounded).collect();
        let [real, held] =
            [states.to_vec(), held].map(|states| Yardstick::at(view(task.general), states));
        let view = view(&program.module);
        let largest = |reference: &Yardstick, inputs: &[Vec<f64>], format| {
            let results = results(view, format, inputs);
            let shares = shares(task, program, reference, &results)?;
            Ok::<f64, FitError>(shares.into_iter().fold(0.0, f64::max))
        };
        let [all_digits, rounded] = [real.inputs(view)?, held.inputs(view)?];
        let same = Yardstick::at(view, rounded.clone());
        Ok(Some(FitSources {
            data: largest(&real, &rounded, Format::BINARY64)?,
            series: largest(&real, &all_digits, Format::BINARY64)?,
            operations: largest(&same, &rounded, format)?,
        }))
    }
}
