//! The framework that every pass uses, and nothing of any pass.
//!
//! [`pass`] defines a pass and a registry of passes, [`options`] its options,
//! [`pipeline`] reads the user's list of passes, [`manager`] runs it with its
//! instruments, [`check`] compares functions, [`trail`] shows the origin of
//! values, [`reduce`] finds the failing pass and rewrite, [`template`] fills
//! generated files. This crate reads and writes no files.

pub mod check;
pub mod differentiation;
pub mod fingerprint;
pub mod instances;
pub mod manager;
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
