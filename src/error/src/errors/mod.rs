//! Origin and size of rounding errors.
//!
//! [`crate::accuracy`] measures how large errors are; this crate finds their
//! causes: the [`Heat`] of source equations, and for every output at one state
//! its error, the error predicted from the loss of every operation, a bound,
//! the standard deviation under random rounding, and the greatest loss, over
//! all states, in a window of operations before it ([`ErrorTable`]). The
//! methods are in [`robovec_analysis`].

mod heat;
mod proof;
mod table;
mod view;

pub use heat::{Heat, HotEquation, HotInput, MAX_EQUATIONS, blame};
pub use proof::ProofRow;
pub use table::{ErrorMethod, ErrorSettings, ErrorTable, IntervalRow, OutputRow, explain};
pub use view::{csv, json, text};
pub use view::{heat_text, heat_title};

#[cfg(test)]
mod tests;
