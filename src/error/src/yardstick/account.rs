//! Error and cost in the form that every command prints.
//!
//! An error beside a speed is always printed in the same way: the median and
//! the worst over all arrays and states, relative to the largest element of the
//! array, with the number format, the states and the reference named. Relative
//! errors of elements, which cancelled ones dominate, are for error reports.

use super::{ErrorSpread, Unmeasurable, Yardstick};
use robovec_ir::diagnostic::counted;
use robovec_ir::{Format, View};
use robovec_present::number::{exponential, or_dash, share_percent};

/// Heads of the two columns of errors.
pub const ERROR_HEADS: [&str; 2] = ["median error", "worst error"];

/// The errors of a program, with all that they depend on.
#[derive(Clone, PartialEq, Debug)]
pub struct ErrorAccount {
    /// The format it was computed in.
    pub format: Format,
    /// Of every array and state, the largest error over the largest element.
    pub normwise: ErrorSpread,
    /// The states, in words: see [`random_states`].
    pub states: String,
}

/// States in words: number and source; `has_ranges` of a scene or file.
pub fn random_states(count: usize, seed: u64, has_ranges: bool) -> String {
    let ranges = if has_ranges {
        " in the given ranges"
    } else {
        ""
    };
    format!("{}{ranges}, seed {seed}", counted(count, "random state"))
}

/// Unit and reference of errors.
pub fn measure_text(states: &str) -> String {
    format!("of the largest element of an array ({states}, against double-double)")
}

impl ErrorAccount {
    /// Measures a program in a format; `states` names the yardstick's states.
    pub fn measured(
        program: View<'_>,
        yardstick: &Yardstick,
        format: Format,
        states: String,
    ) -> Result<ErrorAccount, Unmeasurable> {
        Ok(ErrorAccount {
            format,
            normwise: yardstick.errors(program, format)?.normwise,
            states,
        })
    }

    /// One line without an end.
    pub fn text(&self) -> String {
        format!(
            "error in {}: median {}, worst {} {}",
            self.format,
            exponential(self.normwise.median),
            exponential(self.normwise.worst),
            measure_text(&self.states)
        )
    }
}

/// A share of a device in percent, `-` where nothing was placed.
pub fn share_cell(share: Option<f64>) -> String {
    or_dash(share, share_percent)
}
