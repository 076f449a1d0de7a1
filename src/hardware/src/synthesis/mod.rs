//! Mapping of hardware to cells of a Cyclone V by yosys, and its clock.
//!
//! The vendor's tools are not needed: yosys' `synth_intel_alm` maps Verilog
//! to look-up tables, registers, memory blocks and multipliers
//! ([`tool`]), the netlist is counted module by module
//! ([`count`]), and its longest path found with published delays
//! ([`timing`]). Formulas for the same figures without any tool are in
//! [`robovec_fpga::hardware`], to be compared with the
//! mapping. On an ECP5 open tools also place and route ([`place`]).

pub mod cores;
pub mod count;
mod delays;
mod flat;
pub mod machine;
pub mod netlist;
pub mod page;
pub mod place;
pub mod timing;
pub mod tool;

pub use tool::{SynthesisDesign, SynthesisError, Yosys};
