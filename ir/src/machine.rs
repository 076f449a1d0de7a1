//! The target machine, as data.
//!
//! A machine is a set of *kinds* of processing elements (PEs), each fully
//! pipelined and able to start one operation per cycle, with a memory after
//! every element, a buffer for late transfers and a crossbar between them
//! (thesis 1.1 to 1.3). No property of a machine is a constant in code: all are
//! in a TOML file (`machines/`), described field by field below.

pub mod device;
pub mod fields;
pub mod identity;
pub mod interconnect;

pub use device::{ClockOrigin, Device, DeviceFamily};
pub use identity::MachineMismatch;
pub use interconnect::{Interconnect, LinkNetwork, Topology};

use crate::document;
use robovec_num::format::{Format, FormatError};
use robovec_num::operation::Operation;
use serde::{Deserialize, Serialize};

/// A target machine.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// Its name, used in text and reports.
    pub name: String,
    /// One line for users.
    #[serde(default)]
    pub description: String,
    /// Clock of the processing elements, in MHz, where it is known; absent
    /// means as the model of the device estimates it.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "fields::clock_mhz::deserialize"
    )]
    pub clock_mhz: Option<f64>,
    /// Origin of that clock. A published clock is that of other hardware, so
    /// only studies of published results use it.
    #[serde(default)]
    pub clock_origin: ClockOrigin,
    /// The family of devices it is built on.
    #[serde(default, skip_serializing_if = "DeviceFamily::is_default")]
    pub device: DeviceFamily,
    /// The number format of every word: a name as in
    /// [`Format::from_str`](Format), or a float's fields as a table; binary32
    /// when absent.
    #[serde(default)]
    pub number: Format,
    /// The kinds of processing elements.
    #[serde(rename = "element")]
    pub elements: Vec<ElementDescription>,
    /// The memory of each element.
    pub memory: MemoryDescription,
    /// The buffer of each element; without one every write is direct.
    #[serde(default)]
    pub buffer: Option<BufferDescription>,
    /// Interconnect that results travel on; a crossbar when absent.
    #[serde(default)]
    pub interconnect: Interconnect,
    /// The instruction memories, which only generated hardware bounds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instructions: Option<InstructionDescription>,
    /// The real device that the machine is built on, where there is one.
    #[serde(default)]
    pub resources: Option<DeviceResources>,
}

/// A kind of processing element.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElementDescription {
    /// Its name: lower-case letters only, since the text form appends a number,
    /// and not `host`, which represents the host in it.
    pub kind: String,
    /// The operations it performs: `add`, `sub`, `mul`, `div`, `sqrt`, and the
    /// fused `fma` (a*b + c), `fms` (a*b - c) and `fnma` (c - a*b).
    pub operations: Vec<String>,
    /// Their number, unless a pass gets another one.
    #[serde(deserialize_with = "fields::count::deserialize")]
    pub count: u32,
    /// Pipeline stages of the operator.
    #[serde(deserialize_with = "fields::stages::deserialize")]
    pub stages: u32,
    /// Cycles for operand fetch and write-back together; the sequencer that
    /// is generated allows no other number than 2 ([`fields::transfer`]).
    #[serde(deserialize_with = "fields::transfer::deserialize")]
    pub transfer: u32,
}

impl ElementDescription {
    /// Cycles from the issue of an operation to the first issue that can
    /// read its result.
    pub fn weight(&self) -> u32 {
        self.stages + self.transfer
    }

    /// True when elements of this kind perform a fused operation, and so
    /// read three operands.
    pub fn is_fused(&self) -> bool {
        Operation::ALL
            .into_iter()
            .any(|operation| operation.is_fused() && self.performs(operation))
    }

    /// True when elements of this kind perform the operation.
    pub fn performs(&self, operation: Operation) -> bool {
        self.operations.iter().any(|name| name == operation.name())
    }
}

robovec_num::named! {
    /// The construction of operand memories.
    #[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum MemoryStyle {
        /// One memory per element with two ports and twice the clock: both operands
        /// are read in the first half of a cycle, up to `writes` words are written
        /// in the second. An element that performs a fused operation reads three:
        /// it has two copies of its memory with the same content, and the second
        /// copy supplies the addend.
        Unified = "unified",
        /// One memory per operand side, each with one read and one write port, on
        /// one clock: an operand must lie in the memory of its side.
        SideSplit = "side-split",
        /// One memory per element with two read and two write ports on one clock,
        /// as larger devices have (thesis, conclusion): the schedule is that of
        /// [`MemoryStyle::Unified`], without the doubled clock. A third operand
        /// comes from a second copy, as there.
        FourPort = "four-port",
    }
}

impl MemoryStyle {
    /// Memories of one element: one, or one per operand side.
    pub fn banks(self) -> usize {
        match self {
            MemoryStyle::Unified | MemoryStyle::FourPort => 1,
            MemoryStyle::SideSplit => 2,
        }
    }
}

/// The operand memory of one processing element.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MemoryDescription {
    /// Its construction.
    pub style: MemoryStyle,
    /// Words per memory (per side, when split); absent means unlimited.
    #[serde(default, deserialize_with = "fields::memory_words::deserialize")]
    pub words: Option<u32>,
    /// Words that can be written per cycle into one memory (per side, when
    /// split); absent means unlimited.
    #[serde(default, deserialize_with = "fields::writes::deserialize")]
    pub writes: Option<u32>,
}

impl MemoryDescription {
    /// Maximum number of words written per cycle into one memory.
    pub fn write_limit(&self) -> u32 {
        self.writes.unwrap_or(u32::MAX)
    }
}

/// The buffer of one processing element: it takes the element's own results
/// and hands them to the crossbar in a later cycle.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BufferDescription {
    /// Words; absent means unlimited.
    #[serde(default, deserialize_with = "fields::buffer_words::deserialize")]
    pub words: Option<u32>,
    /// Distinct words that can be read per cycle; absent means unlimited.
    #[serde(default, deserialize_with = "fields::reads::deserialize")]
    pub reads: Option<u32>,
}

impl BufferDescription {
    /// Maximum number of distinct words read per cycle.
    pub fn read_limit(&self) -> u32 {
        self.reads.unwrap_or(u32::MAX)
    }
}

/// The instruction memory of one processing element.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InstructionDescription {
    /// Words, and so cycles of the longest program; absent means as many as
    /// the program that hardware is generated for takes, rounded up to a
    /// power of two.
    #[serde(default, deserialize_with = "fields::instruction_words::deserialize")]
    pub words: Option<u32>,
}

/// Resources of a real device in all; 0 where a machine file has none.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DeviceResources {
    /// The device's name.
    pub device: String,
    /// Logic cells of the device (ALM).
    #[serde(deserialize_with = "fields::logic::deserialize")]
    pub logic: u32,
    /// Memory blocks of the device (M10K).
    #[serde(deserialize_with = "fields::memory_blocks::deserialize")]
    pub memory_blocks: u32,
    /// Multiplier blocks of the device.
    #[serde(deserialize_with = "fields::multipliers::deserialize")]
    pub multipliers: u32,
}

/// An error of a machine file.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum MachineError {
    /// Not TOML, or not these fields.
    #[error("{message}")]
    Syntax {
        /// The message of the TOML reader.
        message: String,
        /// Bytes of the offending text.
        span: Option<std::ops::Range<usize>>,
    },
    /// The file is well formed but describes no machine.
    #[error("{0}")]
    Meaning(String),
}

/// The machine files that ship with robovec, by name.
pub const BUILT_IN: &[(&str, &str)] = &[
    ("ideal", include_str!("../machines/ideal.toml")),
    ("thesis", include_str!("../machines/thesis.toml")),
    ("side-split", include_str!("../machines/side-split.toml")),
    (
        "pipeline-3-3",
        include_str!("../machines/pipeline-3-3.toml"),
    ),
    (
        "pipeline-6-4",
        include_str!("../machines/pipeline-6-4.toml"),
    ),
    (
        "pipeline-10-5",
        include_str!("../machines/pipeline-10-5.toml"),
    ),
    ("fused", include_str!("../machines/fused.toml")),
    ("solver", include_str!("../machines/solver.toml")),
    ("de10-nano", include_str!("../machines/de10-nano.toml")),
    ("bufferless", include_str!("../machines/bufferless.toml")),
    (
        "bufferless-split",
        include_str!("../machines/bufferless-split.toml"),
    ),
    ("four-port", include_str!("../machines/four-port.toml")),
    ("bus", include_str!("../machines/bus.toml")),
    ("mesh", include_str!("../machines/mesh.toml")),
    ("torus", include_str!("../machines/torus.toml")),
    ("omega", include_str!("../machines/omega.toml")),
    ("hypercube", include_str!("../machines/hypercube.toml")),
];

impl Machine {
    /// The shipped machine of a name; `None` when no machine of this name
    /// ships.
    pub fn built_in(name: &str) -> Option<Machine> {
        let (_, text) = BUILT_IN.iter().find(|(known, _)| *known == name)?;
        Some(Machine::parse(text).expect("shipped machines are valid"))
    }

    /// Reads a machine file.
    ///
    /// # Errors
    ///
    /// Fails when the text is not TOML with the fields of [`Machine`], or
    /// describes something that cannot be built: no elements, an unknown
    /// operation, an operation two kinds perform, a kind whose name is not
    /// letters, a number beyond its limit ([`fields`]).
    pub fn parse(text: &str) -> Result<Machine, MachineError> {
        let machine: Machine = document::read(text).map_err(|error| MachineError::Syntax {
            message: error.message,
            span: error.span,
        })?;
        machine.validate()?;
        Ok(machine)
    }

    /// Checks the rules for a machine file beyond its syntax.
    /// [`Machine::parse`] has done so; machines made or changed in code need
    /// it.
    ///
    /// # Errors
    ///
    /// As [`Machine::parse`], except for the syntax.
    pub fn validate(&self) -> Result<(), MachineError> {
        let fail = |message: String| Err(MachineError::Meaning(message));
        if self.elements.is_empty() {
            return fail("a machine needs at least one kind of processing element".to_owned());
        }
        self.check_fields().map_err(MachineError::Meaning)?;
        if !self.number.is_possible() {
            return fail(format!(
                "the number format {}: {}",
                self.number,
                FormatError::Width
            ));
        }
        if let Interconnect::Network(network) = &self.interconnect
            && let Some(fault) = network.fault(self.elements.iter().map(|kind| kind.count).sum())
        {
            return fail(fault);
        }
        if self.memory.style == MemoryStyle::FourPort
            && self.memory.writes.is_none_or(|writes| writes > 2)
        {
            return fail(
                "a memory of four ports takes at most 2 words in a cycle; set 'writes = 2'"
                    .to_owned(),
            );
        }
        self.check_kinds().map_err(MachineError::Meaning)
    }

    /// Checks the names and operations of the kinds, against each other too.
    fn check_kinds(&self) -> Result<(), String> {
        for (index, element) in self.elements.iter().enumerate() {
            let kind = &element.kind;
            if element.is_fused() && self.memory.style == MemoryStyle::SideSplit {
                return Err(format!(
                    "the kind '{kind}' performs a fused operation, whose three operands a memory \
                     per side cannot hand out; let the memory have the style 'unified'"
                ));
            }
            if kind.is_empty()
                || !kind.bytes().all(|byte| byte.is_ascii_lowercase())
                || kind == "host"
            {
                return Err(format!(
                    "the kind '{kind}' must be a word of lower-case letters other than 'host'"
                ));
            }
            for name in &element.operations {
                let known = Operation::ALL
                    .iter()
                    .any(|operation| operation.name() == name);
                // Copies cost nothing, a minus is `0 - x`, and sine and cosine
                // are the host's.
                if !known || matches!(name.as_str(), "copy" | "neg" | "sin" | "cos") {
                    return Err(format!(
                        "the kind '{kind}' performs '{name}'; a processing element performs \
                         add, sub, mul, div, sqrt, fma, fms or fnma"
                    ));
                }
                // Every operation has one kind at most ([`Machine::kind_of`]).
                let earlier = &self.elements[..index];
                if earlier
                    .iter()
                    .any(|other| other.kind == *kind || other.operations.contains(name))
                {
                    return Err(format!(
                        "the kind '{kind}' or its operation '{name}' is listed twice"
                    ));
                }
            }
        }
        Ok(())
    }

    /// Compares every number with its limit. The numbers of a machine that is
    /// read from text are checked by the reader, so that an error shows its
    /// place; this function is for machines made or changed in code.
    fn check_fields(&self) -> Result<(), String> {
        fields::clock_mhz::check(&self.clock_mhz)?;
        if let Format::Float(float) = &self.number {
            robovec_num::format::fields::exponent::check(&float.exponent)?;
            robovec_num::format::fields::mantissa::check(&float.mantissa)?;
        }
        for element in &self.elements {
            let about = |reason| format!("the kind '{}': {reason}", element.kind);
            fields::count::check(&element.count).map_err(about)?;
            fields::stages::check(&element.stages).map_err(about)?;
            fields::transfer::check(&element.transfer).map_err(about)?;
        }
        fields::memory_words::check(&self.memory.words)?;
        fields::writes::check(&self.memory.writes)?;
        if let Some(buffer) = &self.buffer {
            fields::buffer_words::check(&buffer.words)?;
            fields::reads::check(&buffer.reads)?;
        }
        if let Some(instructions) = &self.instructions {
            fields::instruction_words::check(&instructions.words)?;
        }
        if let Interconnect::Network(network) = &self.interconnect {
            fields::hop::check(&network.hop)?;
            fields::link_words::check(&network.words)?;
            fields::columns::check(&network.columns)?;
        }
        if let Some(resources) = &self.resources {
            fields::logic::check(&resources.logic)?;
            fields::memory_blocks::check(&resources.memory_blocks)?;
            fields::multipliers::check(&resources.multipliers)?;
        }
        Ok(())
    }

    /// Index into [`Machine::elements`] of the kind that performs an operation:
    /// at most one kind does. `None` when no kind does.
    pub fn kind_of(&self, operation: Operation) -> Option<usize> {
        self.elements
            .iter()
            .position(|element| element.performs(operation))
    }

    /// Cycles from the issue of an operation to the first issue that can read
    /// its result ([`ElementDescription::weight`] of its kind); 0 for
    /// operations that take no time on the machine (copies, and sine and
    /// cosine, which the host evaluates); a minus counts as a subtraction. An
    /// operation that the machine cannot perform counts as its slowest one, so
    /// that paths through it can still be compared; the placer refuses it.
    pub fn weight(&self, operation: Operation) -> u32 {
        let performed = match operation {
            Operation::Copy | Operation::Sin | Operation::Cos => return 0,
            Operation::Neg => Operation::Sub,
            other => other,
        };
        match self.kind_of(performed) {
            Some(kind) => self.elements[kind].weight(),
            None => self
                .elements
                .iter()
                .map(ElementDescription::weight)
                .max()
                .expect("a machine has a kind of processing elements"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shipped_machines_are_valid_and_bear_their_names() {
        for (name, text) in BUILT_IN {
            match Machine::parse(text) {
                Ok(machine) => assert_eq!(machine.name, *name),
                Err(error) => panic!("{name}: {error}"),
            }
        }
    }

    #[test]
    fn the_thesis_weighs_additions_12_and_multiplications_7() {
        let machine = Machine::built_in("thesis").expect("it ships");
        assert_eq!(machine.weight(Operation::Neg), 12);
        assert_eq!(machine.weight(Operation::Mul), 7);
        assert_eq!(machine.weight(Operation::Sin), 0);
    }

    #[test]
    fn number_formats_are_tables_or_names() {
        let text = include_str!("../machines/thesis.toml");
        let start = text.find("[number]").expect("it has a format");
        let (before, table) = text.split_at(start);
        let end = table.find("\n\n").expect("more follows");
        let named =
            |name: &str| Machine::parse(&format!("number = {name}\n{before}{}", &table[end..]));
        let machine = named("\"float(8,17,flush)\"").expect("it is a format");
        assert_eq!(machine.number.to_string(), "float(8,17,flush)");
        assert_eq!(
            named("\"f32\""),
            Ok(Machine::built_in("thesis").expect("it ships"))
        );
        let fixed = named("\"fixed(12,19)\"").expect("it is a format");
        assert_eq!(fixed.number.width(), 32);
        let written = toml::to_string(&fixed).expect("it can be written");
        assert_eq!(Machine::parse(&written), Ok(fixed));
        for wrong in [
            "\"f31\"",
            "\"fixed(40,40)\"",
            "32",
            "{exponent = 8}",
            "{exponent = 15, mantissa = 63, subnormals = true}",
        ] {
            assert!(named(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn three_operands_need_a_memory_for_both_sides() {
        let fused = Machine::built_in("fused").expect("it ships");
        let kind = fused
            .kind_of(Operation::Fnma)
            .expect("it has such elements");
        assert!(fused.elements[kind].is_fused());
        assert!(!fused.elements[0].is_fused());
        let split = include_str!("../machines/fused.toml").replace("unified", "side-split");
        let error = Machine::parse(&split).expect_err("it cannot be built");
        assert!(error.to_string().contains("three operands"), "{error}");
    }
}
