//! robovec: a compiler for the equations of multibody systems.

pub mod command;
pub mod evaluate_command;

pub use robovec_bench as bench;
pub use robovec_dynamics::{generate, kinematics, motion, stale, whole_step};
pub use robovec_error::{accuracy, errors, yardstick};
pub use robovec_explore as explore;
pub use robovec_explore::{fit, front, neglect, optimise, scene, study, sweep, trigonometry};
pub use robovec_fpcore as fpcore;
pub use robovec_hardware::{rtl, synthesis};
pub use robovec_io::{files, process, sources};
pub use robovec_model as model;
pub use robovec_present as present;
pub use robovec_robotran as robotran;
pub use robovec_robotran::align;
pub use robovec_simulate as simulate;
pub use robovec_stress as stress;
pub use robovec_view as view;
pub use robovec_view::report;

/// The page on the library, whose examples `cargo test` compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../docs/library.md")]
struct LibraryPage;
