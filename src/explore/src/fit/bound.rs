//! Proof about a choice for every state in the ranges, and its errors by source.
//!
//! Trials leave the states in between open. Bounds cover them, by norms over
//! the whole program ([`robovec_analysis::norms`]) and, where it is small, by
//! enclosures over boxes ([`robovec_analysis::interval`]): where the bound of
//! an output's rounding is within the smallest error allowed, no state exceeds
//! it. A bound that is too large neither proves nor refutes.

use super::format::shares;
use super::{FitError, FitProgram, FitTask, SineTreatment};
use crate::program::view;
use robovec_analysis::adjoint::Tape;
use robovec_analysis::interval::{
    ConeWindow, GivenData, Leaves, RangeBasis, WindowLeaves, input_ranges, subdivide,
};
use robovec_analysis::norms::norm_bounds;
use robovec_error::yardstick::{Yardstick, results};
use robovec_framework::scene::Allowed;
use robovec_ir::Format;
use robovec_num::arithmetic::Arithmetic;
use robovec_num::interval::Interval;
use robovec_num::soft_float::FormatArithmetic;
use serde::Serialize;

/// Maximum number of operations of a program that is bounded, some seconds.
const LARGEST: usize = 20_000;

/// Maximum number of operations of a program that is enclosed over boxes.
const BOXED: usize = 1000;

/// Enclosures of all outputs, times operations and leaves: some seconds.
const WORK: usize = 1 << 24;

/// Bounds of the rounding of a program.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct FitBound {
    /// Outputs with a tolerance.
    pub outputs: usize,
    /// Those of them whose bound is within the smallest error allowed.
    pub proved: usize,
    /// Largest bound over the smallest error allowed; infinite without a bound.
    pub used: f64,
}

impl FitBound {
    /// True when every output is proved.
    pub fn holds(&self) -> bool {
        self.proved == self.outputs
    }
}

/// Bounds a program in a format; `None` for one that is too large, does not
/// only round, has formats for values, or reads inputs without a range.
pub(super) fn bound(task: &FitTask<'_>, program: &FitProgram, format: Format) -> Option<FitBound> {
    let view = view(&program.module);
    let operations = view.function.nodes().len();
    if program.treatment != SineTreatment::True || program.mixture.is_some() || operations > LARGEST
    {
        return None;
    }
    let allowed = Allowed::new(view, Some(task.scene), f64::INFINITY, &task.sizes);
    // Where all outputs are zero the least is allowed.
    let least = allowed.of(&vec![0.0; view.function.assignments.len()]);
    let tape = Tape::new(view.function);
    let states = task.scene.states(task.seed);
    let inputs = input_ranges(view, &states);
    let ranges: Vec<Interval> = inputs.iter().map(|input| input.range).collect();
    let norms = norm_bounds(&tape, &ranges, format, GivenData::Real);
    let leaves = Leaves::new(view, &tape, &states, 0);
    let wanted: Vec<(usize, f64)> = (least.into_iter().enumerate())
        .filter(|(_, least)| least.is_finite())
        .collect();
    let mut result = FitBound {
        outputs: wanted.len(),
        proved: 0,
        used: 0.0,
    };
    for (output, least) in wanted {
        let slot = tape.output_slot(output);
        let window = ConeWindow::new(&tape, slot, LARGEST);
        let leaves = WindowLeaves::new(&tape, &window, format, GivenData::Real, &leaves);
        if leaves.knowledge != RangeBasis::Given {
            return None;
        }
        let mut error = norms.error[slot];
        if operations <= BOXED {
            let size = (window.nodes.len() + leaves.ranges.len() + 1) * result.outputs;
            let found = subdivide(&tape, &window, &leaves, (WORK / size).max(1));
            error = error.min(found.error);
        }
        let used = match error {
            0.0 => 0.0,
            error => error / least,
        };
        result.proved += usize::from(used <= 1.0);
        result.used = result.used.max(used);
    }
    (result.outputs > 0).then_some(result)
}

/// Largest ratio of an error to the allowed one by source, at worst states.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct FitSources {
    /// Of inputs rounded to the format, with exact operations.
    pub data: f64,
    /// Of series for sines and cosines, with exact data and binary64.
    pub series: f64,
    /// Of operations in the format, against exact ones, on rounded data.
    pub operations: f64,
}

impl FitSources {
    /// The sources at states; `None` for a program with formats for values.
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
