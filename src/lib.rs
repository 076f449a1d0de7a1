//! robovec: a compiler for the equations of multibody systems.

pub mod report;
pub mod robotran;
pub mod simulate;
