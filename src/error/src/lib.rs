//! Rounding errors of programs: exact results, error attribution, effects of
//! passes.

pub mod accuracy;
pub mod errors;
pub mod yardstick;
