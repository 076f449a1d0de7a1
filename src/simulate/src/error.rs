//! Errors of images, and hazards of a run.

use super::mif::MifError;
use robovec_ir::Format;
use robovec_num::format::FormatError;

/// Reason why images cannot be loaded into a machine.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum LoadError {
    /// No manifest among the files.
    #[error(
        "there is no manifest.json among the files; it is written last, so without it the images \
         are not complete"
    )]
    NoManifest,
    /// Manifests of several functions.
    #[error("there are several manifests: '{0}' and '{1}'; load one function at a time")]
    SeveralManifests(String, String),
    /// The manifest is not JSON of the documented schema.
    #[error("'{file}' is not a manifest: {message}")]
    Manifest {
        /// The file.
        file: String,
        /// Message of the JSON reader, with line and column.
        message: String,
    },
    /// A manifest of another version.
    #[error("the manifest has format {found}, this robovec reads format {expected}")]
    Format {
        /// Of the manifest.
        found: u32,
        /// The one that can be read.
        expected: u32,
    },
    /// A file named in the manifest is missing.
    #[error("the manifest names '{0}', which is not among the files")]
    NoFile(String),
    /// A memory image that cannot be read.
    #[error("'{file}', {error}")]
    Image {
        /// The file.
        file: String,
        /// Fault and its place.
        error: MifError,
    },
    /// An image of another depth or width than the manifest states.
    #[error("'{file}' has {found} as its {what}, the manifest has {expected}")]
    ImageSize {
        /// The file.
        file: String,
        /// `depth` or `width`.
        what: &'static str,
        /// Of the file.
        found: u32,
        /// Of the manifest.
        expected: u32,
    },
    /// A size beyond the limits of this simulator.
    #[error("the images describe {0}, more than the simulator holds")]
    TooLarge(String),
    /// A number format without an arithmetic.
    #[error("the number format {0}: {width}", width = FormatError::Width)]
    UnsupportedNumber(Format),
    /// The images use a feature that the machine does not have.
    #[error("the machine does not fit the images: {0}")]
    Machine(String),
    /// More write ports than a memory of the machine has.
    #[error("memory {memory} has {ports} write ports in the images, {allowed} in the machine")]
    WritePorts {
        /// The memory.
        memory: String,
        /// In the images.
        ports: u32,
        /// In the machine.
        allowed: u32,
    },
    /// More read ports than a buffer of the machine has.
    #[error(
        "the buffer of {element} has {ports} read ports in the images, {allowed} in the machine"
    )]
    BufferPorts {
        /// The element.
        element: String,
        /// In the images.
        ports: u32,
        /// In the machine.
        allowed: u32,
    },
    /// A memory or buffer with more words than the machine has.
    #[error("{memory} has {words} words in the images, {allowed} in the machine")]
    Words {
        /// The memory or buffer.
        memory: String,
        /// In the images.
        words: u32,
        /// In the machine.
        allowed: u32,
    },
    /// The fields of an instruction word make no sense.
    #[error("the layout of the instruction word of {element} is wrong: {problem}")]
    Layout {
        /// The element.
        element: String,
        /// Fault in words.
        problem: String,
    },
    /// Two elements or memories of one name.
    #[error("the name '{0}' occurs in the manifest twice")]
    NameTwice(String),
    /// A list of select codes other than all results, then all buffer ports.
    #[error("the crossbar's sources are not all results and then all buffer read ports")]
    Sources,
    /// The manifest refers to an item that it does not describe.
    #[error("{user} refers to {what}, which the manifest does not have")]
    Dangling {
        /// Who refers.
        user: String,
        /// The missing target.
        what: String,
    },
    /// The manifest gives a word two initial values.
    #[error("word {address} of {memory} has two initial values")]
    InitialTwice {
        /// The memory.
        memory: String,
        /// The address.
        address: u32,
    },
    /// A word of an instruction image that the file leaves open.
    #[error("the instruction of {element} in cycle {cycle} is not defined")]
    UndefinedInstruction {
        /// The element.
        element: String,
        /// The cycle.
        cycle: u32,
    },
    /// Bits set outside all fields.
    #[error("the instruction of {element} in cycle {cycle} has bits set that no field covers")]
    UndefinedBits {
        /// The element.
        element: String,
        /// The cycle.
        cycle: u32,
    },
    /// The images were generated for another machine.
    #[error("the images were generated for a machine with hash {images}, this one has {machine}")]
    OtherMachine {
        /// Of the manifest.
        images: String,
        /// Of the machine given.
        machine: String,
    },
    /// A file is not the one the manifest was written with.
    #[error("'{file}' was changed: it has the hash {found}, the manifest has {expected}")]
    OtherFile {
        /// The file.
        file: String,
        /// Of its content.
        found: String,
        /// Of the manifest.
        expected: String,
    },
    /// The instruction images are not those the manifest was written with.
    #[error("the instruction images have the hash {found}, the manifest has {expected}")]
    OtherSchedule {
        /// Of the files.
        found: String,
        /// Of the manifest.
        expected: String,
    },
}

/// Fault of the machine, and its cycle. Cycles count from 0.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Hazard {
    /// The number of inputs differs from the manifest.
    #[error("the program takes {expected} inputs, {given} are given")]
    InputCount {
        /// In the manifest.
        expected: usize,
        /// Given.
        given: usize,
    },
    /// An operand is read from a word neither loaded nor written yet.
    #[error("cycle {cycle}: {element} reads {memory}[{address}], which holds no value yet")]
    UninitialisedRead {
        /// Cycle.
        cycle: u32,
        /// Who.
        element: String,
        /// The memory.
        memory: String,
        /// The address.
        address: u32,
    },
    /// A buffer word is put on the crossbar before anything was written.
    #[error(
        "cycle {cycle}: word {word} of the buffer of {element} is read, but holds no value yet"
    )]
    UninitialisedBufferRead {
        /// Cycle.
        cycle: u32,
        /// Whose buffer.
        element: String,
        /// Its word.
        word: u32,
    },
    /// A write port selects an element whose pipeline gives no result.
    #[error("cycle {cycle}: {memory} takes the result of {element}, which has none in this cycle")]
    NoResult {
        /// Cycle.
        cycle: u32,
        /// Into which memory.
        memory: String,
        /// The selected element.
        element: String,
    },
    /// A buffer write without a result.
    #[error("cycle {cycle}: {element} has no result to put into its buffer")]
    NoResultToBuffer {
        /// Cycle.
        cycle: u32,
        /// The element.
        element: String,
    },
    /// A select code beyond the crossbar's inputs.
    #[error(
        "cycle {cycle}: a write port of {memory} selects input {select} of the crossbar, which has {inputs}"
    )]
    UnknownSource {
        /// Cycle.
        cycle: u32,
        /// The memory.
        memory: String,
        /// The select code.
        select: u32,
        /// Inputs of the crossbar.
        inputs: u32,
    },
    /// An operation code the element does not have.
    #[error("cycle {cycle}: {element} has no operation of code {code}")]
    UnknownOperation {
        /// Cycle.
        cycle: u32,
        /// Who.
        element: String,
        /// The code.
        code: u32,
    },
    /// Two ports of a memory write the same word.
    #[error("cycle {cycle}: {memory}[{address}] is written through two ports")]
    WrittenTwice {
        /// Cycle.
        cycle: u32,
        /// The memory.
        memory: String,
        /// The address.
        address: u32,
    },
    /// An address beyond a memory.
    #[error("cycle {cycle}: address {address} is beyond the {words} words of {memory}")]
    AddressRange {
        /// Cycle.
        cycle: u32,
        /// The memory.
        memory: String,
        /// The address.
        address: u32,
        /// Its words.
        words: u32,
    },
    /// A word beyond a buffer.
    #[error("cycle {cycle}: word {word} is beyond the {words} words of the buffer of {element}")]
    BufferOverflow {
        /// Cycle.
        cycle: u32,
        /// Whose buffer.
        element: String,
        /// The word.
        word: u32,
        /// Its words.
        words: u32,
    },
    /// A value is replaced that nothing has read.
    #[error("cycle {cycle}: {memory}[{address}] is overwritten; its value was never read")]
    Lost {
        /// Cycle.
        cycle: u32,
        /// The memory.
        memory: String,
        /// The address.
        address: u32,
    },
    /// A buffered value is replaced that was never put on the crossbar.
    #[error(
        "cycle {cycle}: word {word} of the buffer of {element} is overwritten before it was read"
    )]
    LostInBuffer {
        /// Cycle.
        cycle: u32,
        /// Whose buffer.
        element: String,
        /// The word.
        word: u32,
    },
    /// The program ends while an operation is in a pipeline.
    #[error(
        "the program ends after {cycles} cycles with a result of {element} still in its pipeline"
    )]
    StillRunning {
        /// The length of the program.
        cycles: u32,
        /// The element.
        element: String,
    },
    /// An output's word was not written in the cycle given in the manifest.
    #[error("output {output}: {memory}[{address}] is not written in cycle {expected}")]
    OutputNotWritten {
        /// The output element.
        output: String,
        /// The memory.
        memory: String,
        /// The address.
        address: u32,
        /// The cycle in the manifest.
        expected: u32,
    },
    /// An output's word was written again before the end.
    #[error("output {output}: {memory}[{address}] is overwritten in cycle {cycle}")]
    OutputOverwritten {
        /// The output element.
        output: String,
        /// The memory.
        memory: String,
        /// The address.
        address: u32,
        /// Cycle.
        cycle: u32,
    },
}
