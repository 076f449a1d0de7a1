//! Code generation for processors.
//!
//! [`c`] writes a C99 function, [`batch`] one that evaluates many states at
//! once, [`rolled`] one with loops; [`emit`] and [`sincos`] are shared by them.
//! [`superword`] finds operations of the first that one vector can compute.
//! [`fpcore`] writes for tools that bound rounding errors, and [`kind`] holds
//! the signatures of Robotran's functions.

pub mod batch;
pub mod c;
pub mod casadi;
mod emit;
pub mod fpcore;
pub mod kind;
pub mod rolled;
mod sincos;
pub mod superword;
pub mod template;
#[cfg(test)]
mod testing;
