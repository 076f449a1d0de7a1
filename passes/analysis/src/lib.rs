//! Analyses: properties of functions for passes and reports; functions are not
//! changed. This crate depends on numbers and functions, and on no pass.

pub mod accuracy;
pub mod adjoint;
pub mod class;
pub mod condition;
pub mod critical_path;
pub mod error_bound;
pub mod interval;
pub mod norms;
pub mod processor;
pub mod range;
pub mod reference;
pub mod rounding;
pub mod slice;
pub mod stochastic;
