//! The passes of robovec.
//!
//! Each is one file or folder of this crate, except the one that places, which
//! has its own crate; [`registry::REGISTRY`] lists all of them. `sums` has the
//! parts that the passes on sums and products share, `choice` and `reassociate`
//! those that some of them share. This crate reads and writes no files.

pub mod accurate;
pub mod asap_alap;
pub mod atomise;
pub mod balance;
pub mod cancellation;
mod choice;
pub mod codegen;
pub mod composite;
pub mod cse;
pub mod dce;
pub mod differentiate;
pub mod eqsat;
pub mod factor;
pub mod fma;
pub mod fold;
mod hash;
pub mod inline;
pub mod interleave;
pub mod lookahead;
pub mod meet;
pub mod mixed;
pub mod optimise;
mod reassociate;
pub mod recurrence;
pub mod registry;
pub mod specialise;
mod sums;
pub mod swap;
pub mod trigonometry;
pub mod zero_removal;
