//! Hardware on disk: benches with what the simulator expects, and the tools
//! that run them.
//!
//! `passes/fpga/src/rtl` writes text and knows no numbers; here the
//! cycle-accurate simulator gives the benches what every operation must
//! result in, and the simulators of hardware are called. **Invariant.** What
//! a bench expects comes from the images alone, through the simulator, which
//! shares no code with the generator of the hardware.

mod bench;
mod tools;

pub use bench::{BenchFailure, bench_files};
pub use tools::{CheckFailure, Checked, Door, HardwareSimulator, check};
