//! The framework that every pass uses, and nothing of any pass.
//!
//! [`pass`] defines a pass and a registry of passes, [`options`] what it
//! can be given, [`pipeline`] reads what the user wants to run, [`manager`]
//! runs it with its instruments, [`check`] compares functions, [`trail`] shows
//! where values come from, [`reduce`] finds what a pass breaks, [`template`]
//! fills generated files. This crate reads and writes no files.

pub mod check;
pub mod differentiation;
pub mod fingerprint;
pub mod instances;
pub mod manager;
pub mod manual;
pub mod options;
pub mod pass;
pub mod pipeline;
pub mod reduce;
pub mod rewrite;
pub mod rewrite_limit;
pub mod scene;
pub mod template;
pub mod trail;

/// Declaration of a pass about its numbers; [`declare_pass!`] names it.
pub use robovec_analysis::class::NumericClass;
