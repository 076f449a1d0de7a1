//! The manifest that goes with the images: the schema of `manifest.json`.
//!
//! It names every image, describes the instruction words, and gives the address
//! of every input, constant, host value and output; a host program, the
//! simulator or a testbench needs no other file. `docs/images.md` explains the
//! fields in words; both must be changed together, with [`FORMAT`].

use serde::{Deserialize, Serialize};

/// The version of the schema, raised at every incompatible change.
pub const FORMAT: u32 = 2;

/// The manifest of one function's images.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The version of robovec that wrote it.
    pub robovec: String,
    /// The version of the schema, [`FORMAT`].
    pub format: u32,
    /// The function.
    pub function: String,
    /// The machine the images are for.
    pub machine: MachineIdentity,
    /// The number format of every data word.
    pub number: robovec_ir::Format,
    /// 64-bit FNV-1a hash, in hexadecimal, of the instruction images' bytes,
    /// one image after the other in order of the elements.
    pub schedule_hash: String,
    /// Length of the program: every instruction image has this many words.
    pub cycles: u32,
    /// Every image, in the order of writing: images with other hashes do not
    /// belong to the manifest.
    pub files: Vec<FileHash>,
    /// The elements, in the order of the crossbar.
    pub elements: Vec<ProcessingElement>,
    /// The sources that the crossbar's select codes represent: code `i` is
    /// `sources[i]`.
    pub sources: Vec<String>,
    /// Every input element, in order.
    pub inputs: Vec<InputElement>,
    /// The constants that are loaded or put out.
    pub constants: Vec<ConstantElement>,
    /// The values the host computes before the run, each after its operands.
    pub host: Vec<HostElement>,
    /// The implementation of the host's sines and cosines, as
    /// [`robovec_num::trigonometry::host::Implementation`] names it; absent
    /// when they are those of binary64, rounded once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trigonometry: Option<String>,
    /// Every output element that is set, in order.
    pub outputs: Vec<OutputElement>,
    /// The addresses of the memories for the host, in the hardware of the
    /// images; absent when they were made from the machine file alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<AddressMap>,
}

/// The host's window into the hardware: addresses count 32-bit words.
///
/// Word `i` of a unit has its limbs, the lowest first, at `address + i *
/// stride` and after it; writing the last one writes the word.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AddressMap {
    /// Version of the map, as the register `version` states it.
    pub version: u32,
    /// Bits of the host's address.
    pub address_bits: u32,
    /// The content of the register `machine hash`: the images fit hardware with
    /// this hash.
    pub machine_hash: String,
    /// Address of the control register: bit 0 starts, bit 1 clears `done`.
    pub control: u32,
    /// Address of the status: bit 0 running, bit 1 done.
    pub status: u32,
    /// Address of the length of the program, to be set to
    /// [`Manifest::cycles`].
    pub cycles: u32,
    /// Address of the low half of the schedule's hash; the high half follows.
    pub schedule: u32,
    /// Address of the low half of the machine's hash; the high half follows.
    pub machine: u32,
    /// Every memory: those of instructions and those of operands.
    pub units: Vec<MappedMemory>,
}

/// A memory in the host's window.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MappedMemory {
    /// `add0.instructions`, or the name of an operand memory.
    pub name: String,
    /// Address of its first limb.
    pub address: u32,
    /// Words it has in hardware.
    pub words: u32,
    /// 32-bit limbs of a word.
    pub limbs: u32,
    /// Addresses from one word to the next: the next power of two.
    pub stride: u32,
    /// True if the host can read it back.
    pub readable: bool,
}

/// A file and the hash of its content.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileHash {
    /// The file, relative to the folder of the manifest.
    pub file: String,
    /// 64-bit FNV-1a hash of its bytes, in hexadecimal.
    pub hash: String,
}

/// The machine the images are for.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineIdentity {
    /// Its name.
    pub name: String,
    /// 64-bit FNV-1a hash, in hexadecimal, of the properties on which a program
    /// depends: the compact JSON of `[number, elements, memory, buffer,
    /// interconnect]` of the machine file with every element's `count` set to 1
    /// (the counts used are in [`Manifest::elements`]).
    pub hash: String,
}

/// One processing element.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProcessingElement {
    /// Kind and number: `add0`.
    pub name: String,
    /// The kind in the machine file.
    pub kind: String,
    /// The operations, in order of their code in the field `operation`.
    pub operations: Vec<String>,
    /// Its instruction image.
    pub instructions: Instructions,
    /// Its memories: one, or left and right.
    pub memories: Vec<OperandMemory>,
    /// Its buffer, on machines that have one.
    pub buffer: Option<Buffer>,
}

impl ProcessingElement {
    /// Read ports of its buffer.
    pub fn buffer_reads(&self) -> u32 {
        self.buffer.as_ref().map_or(0, |buffer| buffer.read_ports)
    }
}

/// An instruction image.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Instructions {
    /// The file, beside the manifest.
    pub file: String,
    /// Bits of a word.
    pub width: u32,
    /// The fields, from bit 0 up.
    pub fields: Vec<InstructionField>,
}

/// A field of an instruction word. A field of the layout that would have no
/// bit is left out and counts as 0.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InstructionField {
    /// Its name, as in `docs/images.md`.
    pub name: String,
    /// Its lowest bit.
    pub low: u32,
    /// Its bits.
    pub width: u32,
}

/// An operand memory.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperandMemory {
    /// Its name in this manifest: `add0`, `add0.left`, `add0.right`.
    pub name: String,
    /// The data image, beside the manifest.
    pub file: String,
    /// Its words.
    pub words: u32,
    /// Its write ports.
    pub write_ports: u32,
}

/// The buffer of an element.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Buffer {
    /// Its words.
    pub words: u32,
    /// Its read ports.
    pub read_ports: u32,
}

/// A word of an operand memory.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WordAddress {
    /// The memory's name.
    pub memory: String,
    /// The address, from 0.
    pub address: u32,
}

/// A value that is known before the run, by its place in the manifest's
/// lists, from 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ValueReference {
    /// An input element.
    Input(u32),
    /// A constant.
    Constant(u32),
    /// A value of the host.
    Host(u32),
}

/// An input element and the words it must be loaded into.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputElement {
    /// Array and indices, counted from 1: `q[3]`.
    pub name: String,
    /// The words that must contain it at the start; none for an unread input.
    pub words: Vec<WordAddress>,
}

/// A constant and the words that hold it in the data images.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConstantElement {
    /// The shortest decimal number that reads back as the binary64 literal.
    pub value: String,
    /// The words it is in, in the data images.
    pub words: Vec<WordAddress>,
}

/// A value that the host computes in the machine's number format; sine and
/// cosine are those of binary64, rounded once.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HostElement {
    /// The value's name.
    pub name: String,
    /// The operation: `sin`, `cos` ….
    pub operation: String,
    /// Operands: inputs, constants and earlier values of the host.
    pub operands: Vec<ValueReference>,
    /// The words it must be in at the start.
    pub words: Vec<WordAddress>,
}

/// An output element and its place after the run.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputElement {
    /// Array and indices, counted from 1: `M[1,2]`.
    pub name: String,
    /// Its place among the flattened output elements, from 0.
    pub index: u32,
    /// The value.
    #[serde(flatten)]
    pub value: OutputValue,
}

/// The value of an output element.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputValue {
    /// In a memory after the last cycle.
    Home(Home),
    /// Known before the run.
    Known(ValueReference),
}

/// The word that holds an output at the end.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Home {
    /// The memory's name.
    pub memory: String,
    /// The address, from 0.
    pub address: u32,
    /// The cycle at whose end the word takes the output's value, and after
    /// which the word must not be written.
    pub written: u32,
}
