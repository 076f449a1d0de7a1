//! The bodies of the fuzz targets: plain functions of bytes, which the ordinary
//! tests run briefly and cargo-fuzz runs at length.

pub mod adjoints;
pub mod boxes;
#[cfg(test)]
mod cases;
pub mod derivatives;
pub mod domains;
pub mod equations;
pub mod errors;
pub mod formats;
pub mod fpcore;
pub mod generate;
pub mod generated;
mod hostile;
pub mod images;
pub mod inlined;
pub mod loops;
pub mod models;
pub mod mutants;
mod mutations;
pub mod norms;
pub mod passes;
pub mod pipelines;
pub mod precision;
mod referee;
pub mod results;
pub mod rewriting;
pub mod robotran;
pub mod robots;
pub mod rules;
pub mod series;
pub mod statistics;
mod term;
pub mod text;
pub mod verdicts;
pub mod written;

pub use adjoints::errors_are_predicted;
pub use boxes::bounds_hold_over_boxes;
pub use derivatives::derivatives_hold;
pub use domains::domains_are_compared;
pub use errors::errors_stay_within_bounds;
pub use formats::formats_agree;
pub use fpcore::read_fpcore;
pub use images::simulate_garbage;
pub use inlined::inline_undoes_atomise;
pub use models::{model_round_trip, read_model};
pub use mutants::check_catches_mutants;
pub use norms::norms_hold;
pub use results::results_stay_in_class;
pub use robotran::read_robotran;
pub use robots::read_robot;
pub use rules::false_rules_are_caught;
pub use series::series_keep_their_errors;
pub use text::{parse_text, round_trip};
pub use verdicts::rules_are_judged;
pub use written::written_reads_back;
