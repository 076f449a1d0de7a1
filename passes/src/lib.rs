//! The passes of robovec.
//!
//! [`registry::REGISTRY`] lists them; [`pipeline`] reads what the user wants to
//! run; each pass is one file. This crate reads and writes no files.

pub mod accurate;
pub mod asap_alap;
pub mod atomise;
pub mod balance;
pub mod check;
mod choice;
pub mod class;
pub mod codegen;
pub mod composite;
pub mod cse;
pub mod dce;
pub mod eqsat;
pub mod factor;
mod fingerprint;
pub mod fma;
pub mod fold;
pub mod framework_registry;
pub mod inline;
pub mod instances;
pub mod interleave;
pub mod lookahead;
pub mod manager;
pub mod manual;
pub mod mixed;
pub mod optimise;
pub mod options;
pub mod pass;
pub mod pipeline;
pub mod place;
mod reassociate;
pub mod recurrence;
pub mod reduce;
pub mod registry;
pub mod rewrite;
pub mod rewrites;
pub mod rules;
pub mod scene;
pub mod specialise;
pub mod swap;
pub mod trail;
pub mod trigonometry;
pub mod zero_removal;

pub use class::NumericClass;
