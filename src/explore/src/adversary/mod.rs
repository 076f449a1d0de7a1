//! Adversary of programs: the search for the states at which errors are
//! largest.

mod breed;
mod climb;

pub(crate) use breed::StateBreeder;
pub(crate) use climb::{Climbs, ROUND};
