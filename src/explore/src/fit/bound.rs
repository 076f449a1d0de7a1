//! Proof about a choice for every state in the ranges.
//!
//! Trials leave the states in between open. Enclosures over boxes cover them
//! ([`robovec_analysis::interval`]): where the bound of an output's rounding
//! error is within the smallest error that the scene allows, no state exceeds
//! it. They are tight for small programs only; a bound that is too large
//! neither proves nor refutes.

use super::{FitProgram, FitTask, SineTreatment};
use crate::program::view;
use robovec_analysis::adjoint::Tape;
use robovec_analysis::interval::{
    ConeWindow, GivenData, Leaves, RangeBasis, WindowLeaves, subdivide,
};
use robovec_framework::scene::Allowed;
use robovec_ir::Format;
use serde::Serialize;

/// Maximum number of operations of a program that is bounded: enclosures of
/// larger ones take too long or are too wide.
const LARGEST: usize = 1000;

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
/// is not of rounding alone, or that reads inputs without a range.
pub(super) fn bound(task: &FitTask<'_>, program: &FitProgram, format: Format) -> Option<FitBound> {
    let view = view(&program.module);
    if program.treatment != SineTreatment::True || view.function.nodes().len() > LARGEST {
        return None;
    }
    let allowed = Allowed::new(view, Some(task.scene), f64::INFINITY, &task.sizes);
    // Where all outputs are zero the least is allowed.
    let least = allowed.of(&vec![0.0; view.function.assignments.len()]);
    let tape = Tape::new(view.function);
    let leaves = Leaves::new(view, &tape, &task.scene.states(task.seed), 0);
    let wanted: Vec<(usize, f64)> = (least.into_iter().enumerate())
        .filter(|(_, least)| least.is_finite())
        .collect();
    let mut result = FitBound {
        outputs: wanted.len(),
        proved: 0,
        used: 0.0,
    };
    for (output, least) in wanted {
        let window = ConeWindow::new(&tape, tape.output_slot(output), LARGEST);
        let leaves = WindowLeaves::new(&tape, &window, format, GivenData::Real, &leaves);
        if leaves.knowledge != RangeBasis::Given {
            return None;
        }
        let size = (window.nodes.len() + leaves.ranges.len() + 1) * result.outputs;
        let found = subdivide(&tape, &window, &leaves, (WORK / size).max(1));
        let used = match found.error {
            0.0 => 0.0,
            error => error / least,
        };
        result.proved += usize::from(used <= 1.0);
        result.used = result.used.max(used);
    }
    (result.outputs > 0).then_some(result)
}
