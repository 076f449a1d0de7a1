//! The bodies of the fuzz targets: plain functions of bytes, which the ordinary
//! tests run briefly and cargo-fuzz runs at length.

pub mod images;
pub mod mutants;

pub use images::simulate_garbage;
pub use mutants::check_catches_mutants;
