//! Proof about a choice for every state in the ranges.
//!
//! Trials leave the states in between open. Bounds cover them, by norms over
//! the whole program ([`robovec_analysis::norms`]) and, where it is small, by
//! enclosures over boxes ([`robovec_analysis::interval`]): where the bound of
//! an output's rounding error is within the smallest error that the scene
//! allows, no state exceeds it. A bound that is too large neither proves nor
//! refutes.

use super::{FitProgram, FitTask, SineTreatment};
use crate::program::view;
use robovec_analysis::adjoint::Tape;
use robovec_analysis::interval::{
    ConeWindow, GivenData, Leaves, RangeBasis, WindowLeaves, input_ranges, subdivide,
};
use robovec_analysis::norms::norm_bounds;
use robovec_framework::scene::Allowed;
use robovec_ir::Format;
use robovec_num::interval::Interval;
use serde::Serialize;

/// Maximum number of operations of a program that is bounded, some seconds.
const LARGEST: usize = 20_000;

/// Maximum number of operations of a program that is enclosed over boxes:
/// those of larger ones take too long or are too wide.
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
    /// The largest bound over the smallest error allowed; infinite where there
    /// is no bound.
    pub used: f64,
}

impl FitBound {
    /// True when every output is proved.
    pub fn holds(&self) -> bool {
        self.proved == self.outputs
    }
}

/// Bounds a program in a format; `None` for one that is too large, whose error
/// is not of rounding alone, whose values have their own formats, or that
/// reads inputs without a range.
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
