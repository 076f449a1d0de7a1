//! A model in motion: its equations evaluated, solved and integrated in time.
//!
//! This room checks from end to end that a model, its generated equations and
//! the passes over them agree: what moves is decided by the equations alone,
//! while energies and the work of forces are reckoned from the model. Where
//! one of them is wrong, energy is lost or a loop opens.

pub mod inputs;

pub use inputs::{Inputs, State};
