//! Common parts of explorations: programs made by pipelines, machines with
//! other numbers of elements, placements, errors against exact results, shares
//! of a device, times on a processor, and the points that no other one beats.
//!
//! An exploration makes programs, varies axes ([`axes`]), measures a point for
//! every combination and keeps the points that no other dominates ([`pareto`]).
//! Its clients are the rooms `optimise`, `front`, `fit`, `sweep`, `study` and
//! `trigonometry`; none of them uses another one, except for `optimise::found`.
//!
//! Of a function ([`exploration`]) `front` compares programs and `sweep` designs: both
//! take an [`exploration::ExploredFunction`] and a share of the work ([`share`]), and
//! present themselves as an [`exploration::Exploration`]. Clock, time, resources and
//! share of a machine come from [`device::figures`], titles and captions from
//! `captions.toml`.
//!
//! These stay with the clients, since their meaning differs:
//!
//! - points: `front` has one for a program in a format with times for every
//!   size, `fit` one for a program in a format and a size, `sweep` one for a
//!   design, `study` one for a request;
//! - the order of work: `front` shares the beginnings of pipelines, `fit` stops
//!   an axis where it is exact or fast enough, `sweep` and `study` place on all
//!   cores; all but `fit` keep their points.

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
mod worst;

/// Listener to the start and end of measurements.
pub type ExplorationProgress<'a> = &'a (dyn Fn(&str) + Sync);
