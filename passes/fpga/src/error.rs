//! The reasons why a function cannot be turned into memory images.

use robovec_ir::machine::MachineMismatch;
use robovec_ir::{Format, MAX_INPUT_ELEMENTS};
use std::io;

/// The reason why a function has no memory images on a machine.
///
/// Cycles, elements and addresses are those of the placed text.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The function lacks a schedule or a placement.
    #[error("function '{function}' is at level {level}; memory images need level placed")]
    NotPlaced {
        /// The function.
        function: String,
        /// Its level.
        level: &'static str,
    },
    /// The placement does not fit its function.
    #[error("the placement of function '{function}' is malformed: {what}")]
    Malformed {
        /// The function.
        function: String,
        /// The part that does not fit.
        what: String,
    },
    /// The function was scheduled for another machine.
    #[error(transparent)]
    OtherMachine(#[from] MachineMismatch),
    /// Instruction words select among the sources of a crossbar; the switches
    /// of a network have none.
    #[error(
        "memory images and hardware are for machines with a crossbar, and '{machine}' has a \
         {interconnect}"
    )]
    Interconnect {
        /// The machine.
        machine: String,
        /// Its interconnect.
        interconnect: &'static str,
    },
    /// The schedule names a kind of element the machine lacks.
    #[error("the machine has no processing elements of kind '{kind}'")]
    UnknownKind {
        /// The kind.
        kind: String,
    },
    /// An element is assigned an operation that its kind does not perform.
    #[error("element {element} cannot perform '{operation}', which '%{value}' needs")]
    CannotPerform {
        /// The element.
        element: String,
        /// The operation.
        operation: &'static str,
        /// The value.
        value: String,
    },
    /// Two operations start on one element in one cycle.
    #[error("element {element} starts two operations in cycle {cycle}")]
    IssueTwice {
        /// The element.
        element: String,
        /// The cycle.
        cycle: u32,
    },
    /// More writes into a memory in one cycle than it has ports.
    #[error("memory {memory} takes more than {ports} writes in cycle {cycle}")]
    WritePorts {
        /// The memory.
        memory: String,
        /// Its write ports.
        ports: u32,
        /// The cycle.
        cycle: u32,
    },
    /// More distinct buffer words read in one cycle than the buffer can.
    #[error("the buffer of {element} is read at more than {ports} words in cycle {cycle}")]
    BufferPorts {
        /// The element.
        element: String,
        /// Its buffer's read ports.
        ports: u32,
        /// The cycle.
        cycle: u32,
    },
    /// A write after the write-back cycle of a value without a buffer word.
    #[error("'%{value}' is written in cycle {cycle}, after it left element {element}, unbuffered")]
    NotBuffered {
        /// The value.
        value: String,
        /// The producing element.
        element: String,
        /// The cycle of the write.
        cycle: u32,
    },
    /// A write before the result exists.
    #[error("'%{value}' is written in cycle {cycle} but is on the bus in cycle {ready} only")]
    WriteTooEarly {
        /// The value.
        value: String,
        /// The cycle of the write.
        cycle: u32,
        /// The write-back cycle.
        ready: u64,
    },
    /// Something happens in or after the last cycle.
    #[error("'%{value}' needs cycle {cycle}, the schedule ends before cycle {cycles}")]
    AfterEnd {
        /// The value.
        value: String,
        /// The cycle of the issue or write.
        cycle: u64,
        /// The length of the schedule.
        cycles: u32,
    },
    /// An address beyond the words the machine declares.
    #[error("address {address} of {memory} is beyond its {words} words")]
    AddressRange {
        /// The memory or buffer.
        memory: String,
        /// The address.
        address: u32,
        /// Its words.
        words: u32,
    },
    /// Two initial values for one word.
    #[error("word {address} of {memory} has two initial values")]
    PreloadTwice {
        /// The memory.
        memory: String,
        /// The address.
        address: u32,
    },
    /// A number, or a number format, that no memory can hold.
    #[error("{0}")]
    Number(String),
    /// More inputs than a manifest, which names each of them, can list.
    #[error(
        "the function has {count} input elements; a manifest lists at most {MAX_INPUT_ELEMENTS}"
    )]
    TooManyInputs {
        /// Of the function.
        count: usize,
    },
    /// A value has its own number format, which the elements lack.
    #[error(
        "'%{value}' is computed as {format}, and the elements of the machine compute as {machine}"
    )]
    Format {
        /// The value.
        value: String,
        /// Its format.
        format: Format,
        /// The machine's.
        machine: Format,
    },
    /// As many inputs as the function has elements are needed.
    #[error("the data images need {expected} input values, {given} are given")]
    InputCount {
        /// The number the function needs.
        expected: usize,
        /// The actual number.
        given: usize,
    },
    /// The images could not be written.
    #[error("the images could not be written: {0}")]
    Write(#[from] io::Error),
}
