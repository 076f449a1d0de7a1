//! robovec: a compiler for the equations of multibody systems.

pub mod accuracy;
pub mod align;
pub mod bench;
pub mod command;
pub mod errors;
pub mod evaluate_command;
pub mod explore;
pub mod files;
pub mod fit;
pub mod fpcore;
pub mod front;
pub mod generate;
pub mod hexadecimal;
pub mod kinematics;
pub mod model;
pub mod motion;
pub mod neglect;
pub mod optimise;
pub mod present;
pub mod process;
pub mod report;
pub mod robotran;
pub mod rtl;
pub mod scene;
pub mod simulate;
pub mod sources;
pub mod stale;
pub mod stress;
pub mod study;
pub mod sweep;
pub mod synthesis;
pub mod trigonometry;
pub mod view;
pub mod whole_step;
pub mod yardstick;

pub use command::{grammar, limits};

/// The page on the library, whose examples `cargo test` compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../docs/library.md")]
struct LibraryPage;
