//! Adversary of programs: the search for states at which errors are largest.
//!
//! The result is a lower bound of the largest error, no more.

mod breed;
mod climb;
mod guide;
mod rounding;
#[cfg(test)]
mod sound_tests;

pub use breed::StateBreeder;
pub use climb::{Climbs, ErrorRecord, ROUND};
pub use guide::RoundingGuide;
pub use rounding::{FoundErrors, SearchSubject, largest_errors};
