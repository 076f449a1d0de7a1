//! Origin and size of rounding errors.
//!
//! Measuring tells how large errors are ([`crate::accuracy`]); this tells
//! what they are made of: the [`Heat`] of source equations, and for every
//! output at one state the error it has, the error predicted from what every
//! operation lost, a bound, the standard deviation under random rounding, and
//! what a window of operations before it can lose in any state
//! ([`ErrorTable`]). The methods are in [`robovec_analysis`].

mod heat;
mod proof;
mod table;
mod value;
mod view;

pub use heat::{Heat, HotEquation, HotInput, MAX_EQUATIONS, blame};
pub use proof::ProofRow;
pub use table::{ErrorMethod, ErrorSettings, ErrorTable, IntervalRow, OutputRow};
pub use value::explain;
pub use view::{csv, json, text};
pub use view::{heat_text, heat_title};

#[cfg(test)]
mod tests;
