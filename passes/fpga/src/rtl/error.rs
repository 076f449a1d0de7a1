//! The reasons why there is no hardware for a machine or a program.

use crate::ImageError;
use robovec_ir::Format;
use std::io;

/// The reason why hardware cannot be generated.
#[derive(Debug, thiserror::Error)]
pub enum RtlError {
    /// The program has no images, which the hardware would run.
    #[error(transparent)]
    Images(#[from] ImageError),
    /// The cores are floating-point cores.
    #[error("hardware is built for floating-point numbers only, and the machine computes in {0}")]
    Number(Format),
    /// Only the crossbar is built.
    #[error("hardware is built with a crossbar only, and the machine has the interconnect '{0}'")]
    Interconnect(&'static str),
    /// The devices that hardware is built for have no such memory.
    #[error("hardware is built with memories of two ports, and the machine's have four")]
    FourPort,
    /// There is no core for an operation.
    #[error("there is no core for '{operation}', which elements of kind '{kind}' perform")]
    NoCore {
        /// The operation.
        operation: String,
        /// The kind.
        kind: String,
    },
    /// A memory without write ports, or a buffer without read ports.
    #[error("the machine file declares no {ports} ports for {what}")]
    NoPorts {
        /// Memory or buffer.
        what: &'static str,
        /// Write or read.
        ports: &'static str,
    },
    /// More than the addresses of the host or the tools can bear.
    #[error("{0}")]
    TooLarge(String),
    /// The program has no place on the hardware.
    #[error("'{function}' does not fit the hardware: {}", .reasons.join("; "))]
    Misfit {
        /// The function.
        function: String,
        /// The shortages, one sentence each.
        reasons: Vec<String>,
    },
    /// A description of hardware that cannot be read.
    #[error("this is not a description of hardware: {0}")]
    Description(String),
    /// The files could not be written.
    #[error("the hardware could not be written: {0}")]
    Write(#[from] io::Error),
}
