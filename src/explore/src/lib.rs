//! Common parts of explorations: programs made by pipelines, machines with
//! other numbers of elements, placements, errors against exact results, shares
//! of a device, times on a processor, and the points that no other one beats.
//!
//! An exploration makes programs, varies axes ([`axes`]), measures a point for
//! every combination and keeps what no other point beats ([`pareto`]). Its
//! clients are the rooms `optimise`, `front`, `fit`, `sweep`, `study` and
//! `trigonometry`; none of them uses another one.
//!
//! What stays with the clients, since its meaning differs:
//!
//! - points: `front` has one for a program in a format with times for every
//!   size, `fit` one for a program in a format and a size, `sweep` one for a
//!   design, `study` one for a request;
//! - the order of work: `front` shares the beginnings of pipelines, `fit` stops
//!   an axis where it is exact or quick enough, `sweep` and `study` place on
//!   all cores; all but `fit` keep their points, so that shares of the work can
//!   be done by several workers ([`share`]);
//! - `accuracy` is no client: the pass manager measures for it, at every pass.

pub mod axes;
mod captions;
pub mod device;
pub mod exploration;
pub mod fit;
pub mod front;
pub mod neglect;
pub mod operators;
pub mod optimise;
pub mod pareto;
pub mod placing;
pub mod processor;
pub mod program;
pub mod scene;
pub mod share;
pub mod store;
pub mod study;
pub mod sweep;
pub mod trigonometry;

/// Told of what is measured next, or of what was measured.
pub type ExplorationProgress<'a> = &'a (dyn Fn(&str) + Sync);
