//! The passes of robovec.

pub mod analysis;
pub mod class;

pub use class::NumericClass;
