//! Rounding errors of programs in the words of robovec: exact results, what errors are made of, what passes change.

pub mod accuracy;
pub mod errors;
pub mod yardstick;
