//! Generated equations against an independent account of the dynamics, on
//! random trees of all six kinds of joints.
//!
//! `ROBOVEC_TREES=2000 cargo test --test generate` tries more trees.

mod agreement;
mod reference;
