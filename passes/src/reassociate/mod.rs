//! The engine of `zero-removal`, `swap` and `balance`.
//!
//! All three read the function as *groups*, a group being a signed sum of terms
//! or a product of factors, and write each group again as a tree of operations.
//! They differ in the extent of a group ([`GroupReach`]) and in the shape of
//! the tree ([`TreeShape`]).
//!
//! Signs never cost an operation while they travel: a value may be stored
//! with the wrong sign and its users flip theirs (a sum subtracts instead of
//! adding, a product passes the sign on). Rounding to nearest is symmetric,
//! so a flipped sign changes no bit. Only an output that needs the true sign
//! of a value stored with the wrong one forces a `0 - x`; [`signs`] chooses
//! the stored signs so that this is rare.

mod build;
mod negations;
mod share;
mod signs;
mod tree;

pub(crate) use build::{TreeShape, reassociate};
