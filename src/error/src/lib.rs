//! Rounding errors of programs: exact results, error attribution, effects of
//! passes, the search for the largest errors.

pub mod accuracy;
pub mod adversary;
pub mod errors;
pub mod yardstick;
