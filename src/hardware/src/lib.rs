//! Simulators of hardware and yosys, run on what robovec generates.

pub mod rtl;
pub mod synthesis;
