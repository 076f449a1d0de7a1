//! The cycle-accurate simulator.
//!
//! It is the judge of code generation and placement, so it reads only the
//! inputs of the hardware: the text of the memory images and the manifest
//! (`docs/images.md`), and the machine. It steps through pipelines, crossbar,
//! buffers and memories cycle by cycle, computes in the machine's number
//! format, and refuses every hazard by name and cycle ([`Hazard`]). Invariants:
//!
//! - it shares no code with placement or image generation but the manifest's
//!   schema: what it knows of an instruction word it reads from the manifest,
//!   what it knows of timing from the machine;
//! - a word holds a value or nothing (a shadow bit); reading nothing is a
//!   hazard, so results never depend on what a memory held before;
//! - any text is either loaded or refused with a [`LoadError`], and any loaded
//!   program either runs or stops at a hazard, within bounded time and memory.

mod decode;
mod error;
mod fit;
mod load;
pub mod mif;
mod program;
mod run;
mod trace;

pub use error::{Hazard, LoadError};
pub use program::{LoadedProgram, SimulatedOutputs};
pub use trace::{LoadedWord, Trace, TracedResult};
