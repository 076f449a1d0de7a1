//! Hardware on disk: benches with the simulator's outputs, and their tools.
//!
//! `passes/fpga/src/rtl` writes text and computes no numbers; here the
//! cycle-accurate simulator gives the benches the expected result of every
//! operation, and the simulators of hardware are called. **Invariant.** The
//! results that a bench expects come from the images alone, through the
//! simulator, which shares no code with the generator of the hardware.

mod bench;
mod tools;

pub use bench::{BenchFailure, bench_files};
pub use tools::{CheckFailure, Checked, Door, HardwareSimulator, check};
