//! Studies: many programs placed on many machines, and what follows for a
//! person who has to choose.
//!
//! `plan` says what is placed; `run` places it, in parallel, with finished
//! points kept by [`crate::store`]; `tables` and `figures` are views of the points,
//! each named by its number in the thesis; `verdict` says in words what they
//! mean; `page` puts everything into one HTML file. The figures of the thesis
//! itself are data (`printed`), shown beside ours and never mixed with them.
//!
//! **Invariant.** Everything but CPU times is a function of plan and programs
//! alone: no clock, no number of threads, no order of work enters a result.

mod captions;
pub mod couples;
pub mod cpu;
pub mod figures;
pub mod key;
pub mod knee;
pub mod occupation;
pub mod page;
pub mod plan;
pub mod point;
pub mod printed;
pub mod program;
pub mod results;
pub mod run;
mod step;
pub mod tables;
mod variants;
pub mod verdict;
pub mod zone;
