//! The description of the hardware: the machine file with every size settled.
//!
//! A machine file may leave sizes open; a schedule gives the number of
//! elements. Hardware is the result of both, and stays when the next program
//! comes: `machine.json` keeps it beside the generated text, and a program fits
//! when its traffic stays within.

use super::error::RtlError;
use super::window::{AddressBlocks, Block};
use super::{legs, unit};
use crate::layout::{Sizes, WordLayout, bits};
use crate::manifest::{AddressMap, Buffer, FileHash, MappedMemory};
use crate::traffic::Traffic;
use robovec_framework::option_words;
use robovec_ir::machine::{ElementDescription, Interconnect, MemoryStyle};
use robovec_ir::{Format, Machine};
use robovec_num::NumberFormat;
use robovec_num::fnv::Fnv;
use serde::{Deserialize, Serialize};

/// The version of the description, raised at every incompatible change.
const FORMAT: u32 = 2;
/// The version of the host's map, in register 7.
const MAP_VERSION: u32 = 1;
/// Bits of the host's address at most: 4 GiB of bytes.
const MAX_ADDRESS_BITS: u32 = 30;
/// Words of an instruction or operand memory at most.
const MAX_WORDS: u32 = 1 << 24;
/// Elements at most: a crossbar grows with their square.
const MAX_ELEMENTS: usize = 1024;

option_words! {
    /// The extent to which the crossbar is built.
    #[derive(Default)]
    pub enum CrossbarChoice {
        /// Every source reaches every write port: any program fits.
        #[default]
        Full = "full",
        /// Only the pairs of source and write port that the schedule uses.
        Pruned = "pruned",
    }
}

/// The crossbar as built.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Crossbar {
    /// Every source reaches every write port.
    Full,
    /// For every write port the codes of the sources that reach it, in
    /// ascending order. Ports are counted element by element, within an
    /// element memory by memory.
    Pruned(Vec<Vec<u32>>),
}

/// Equal elements.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElementGroup {
    /// Their kind in the machine file.
    pub kind: String,
    /// Their number.
    pub count: u32,
}

/// Hardware, with every size settled.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hardware {
    /// The version of robovec that built it.
    pub robovec: String,
    /// The version of this description.
    pub format: u32,
    /// The machine file.
    pub machine: Machine,
    /// The elements, in the order of the crossbar.
    pub elements: Vec<ElementGroup>,
    /// Words of an instruction memory: cycles of the longest program.
    pub instruction_words: u32,
    /// Words of an operand memory.
    pub words: u32,
    /// Write ports of an operand memory.
    pub write_ports: u32,
    /// The buffer of every element, if there are any.
    pub buffer: Option<Buffer>,
    /// The crossbar.
    pub crossbar: Crossbar,
    /// The generated files beside the description; empty before any are
    /// generated.
    pub files: Vec<FileHash>,
}

impl Hardware {
    /// The hardware for a program and all others that fit it: the machine's
    /// sizes, and for open sizes those of the program, rounded up to a power of
    /// two.
    pub(crate) fn new(traffic: &Traffic<'_>, choice: CrossbarChoice) -> Result<Hardware, RtlError> {
        let machine = traffic.machine;
        check_machine(machine)?;
        let usage = &traffic.usage;
        let room = |declared: Option<u32>, used: u32| {
            let rounded = used.max(1).checked_next_power_of_two();
            declared.unwrap_or_else(|| rounded.unwrap_or(u32::MAX))
        };
        let cycles = traffic.schedule.cycles.max(1);
        let declared = machine.instructions.and_then(|memory| memory.words);
        let instruction_words = room(declared, cycles);
        if instruction_words < cycles {
            let function = traffic.view.function.name.clone();
            let reasons = vec![format!(
                "it takes {cycles} cycles, and the machine file gives the instruction memories \
                 {instruction_words} words"
            )];
            return Err(RtlError::Misfit { function, reasons });
        }
        let groups = traffic.schedule.kinds.iter().map(|kind| ElementGroup {
            kind: kind.name.clone(),
            count: kind.count,
        });
        let mut hardware = Hardware {
            robovec: env!("CARGO_PKG_VERSION").to_owned(),
            format: FORMAT,
            machine: machine.clone(),
            elements: groups.filter(|group| group.count > 0).collect(),
            instruction_words,
            words: room(machine.memory.words, usage.words),
            write_ports: machine.memory.writes.unwrap_or(usage.write_ports).max(1),
            buffer: machine.buffer.map(|buffer| Buffer {
                words: room(buffer.words, usage.buffer_words),
                read_ports: buffer.reads.unwrap_or(usage.buffer_reads).max(1),
            }),
            crossbar: Crossbar::Full,
            files: Vec::new(),
        };
        // Before anything is counted with these sizes.
        hardware.validate()?;
        if choice == CrossbarChoice::Pruned {
            hardware.crossbar = Crossbar::Pruned(legs::used(traffic, &hardware.sizes()));
        }
        Ok(hardware)
    }

    /// Reads a description.
    ///
    /// # Errors
    ///
    /// Fails when it is none, or one that no robovec of this version wrote.
    pub fn parse(text: &str) -> Result<Hardware, RtlError> {
        let fail = |message: String| RtlError::Description(message);
        let hardware: Hardware =
            serde_json::from_str(text).map_err(|error| fail(error.to_string()))?;
        if hardware.format != FORMAT {
            return Err(fail(format!(
                "its format is {}, and this robovec knows {FORMAT}",
                hardware.format
            )));
        }
        let sound = hardware.machine.validate();
        sound.map_err(|error| fail(error.to_string()))?;
        hardware.validate()?;
        Ok(hardware)
    }

    /// The description as text, one line per part.
    ///
    /// # Errors
    ///
    /// There is no known omission: every description has a text.
    pub fn text(&self) -> Result<String, RtlError> {
        let text = serde_json::to_string_pretty(self).map_err(std::io::Error::from)?;
        Ok(text + "\n")
    }

    fn validate(&self) -> Result<(), RtlError> {
        check_machine(&self.machine)?;
        let unknown =
            |group: &&ElementGroup| self.machine.elements.iter().all(|e| e.kind != group.kind);
        if let Some(group) = self.elements.iter().find(unknown) {
            return Err(RtlError::Description(format!(
                "the machine has no elements of kind '{}'",
                group.kind
            )));
        }
        for group in &self.elements {
            unit::check(self.kind(group))?;
        }
        let elements: u64 = self
            .elements
            .iter()
            .map(|group| u64::from(group.count))
            .sum();
        if elements == 0 || elements > MAX_ELEMENTS as u64 {
            return Err(RtlError::TooLarge(format!(
                "the machine has {elements} elements; hardware is built for 1 to {MAX_ELEMENTS}"
            )));
        }
        let sizes = [self.instruction_words, self.words]
            .into_iter()
            .chain(self.buffer.iter().map(|buffer| buffer.words));
        for words in sizes {
            if words == 0 || words > MAX_WORDS {
                return Err(RtlError::TooLarge(format!(
                    "a memory of {words} words; hardware is built for 1 to {MAX_WORDS}"
                )));
            }
        }
        let ports = [
            Some(self.write_ports),
            self.buffer.as_ref().map(|b| b.read_ports),
        ];
        if ports
            .into_iter()
            .flatten()
            .any(|ports| ports == 0 || ports > 64)
        {
            return Err(RtlError::TooLarge(
                "a memory has more than 64 ports or none".to_owned(),
            ));
        }
        if self.window().address_bits > MAX_ADDRESS_BITS {
            return Err(RtlError::TooLarge(format!(
                "the memories take {} bits of the host's address, more than {MAX_ADDRESS_BITS}",
                self.window().address_bits
            )));
        }
        match &self.crossbar {
            Crossbar::Full => Ok(()),
            Crossbar::Pruned(legs) => legs::validate(legs, &self.sizes()),
        }
    }

    pub(super) fn number(&self) -> NumberFormat {
        match self.machine.number {
            Format::Float(float) => float,
            Format::Fixed(_) => unreachable!("validation refuses fixed-point machines"),
        }
    }

    /// Bits of a data word.
    pub fn width(&self) -> u32 {
        self.machine.number.width()
    }

    /// The number of elements.
    pub fn element_count(&self) -> u32 {
        self.elements.iter().map(|group| group.count).sum()
    }

    /// Memories per element.
    pub fn memories(&self) -> u32 {
        self.machine.memory.style.banks() as u32
    }

    /// The names of an element's memories, after the element's own.
    pub(super) fn memory_suffixes(&self) -> &'static [&'static str] {
        match self.machine.memory.style {
            MemoryStyle::Unified | MemoryStyle::FourPort => &[""],
            MemoryStyle::SideSplit => &[".left", ".right"],
        }
    }

    /// Clocks of a cycle.
    ///
    /// A unified memory reads in the first and writes two words in each
    /// further one; a memory per side reads and writes in the first and
    /// writes in each further one.
    pub fn phases(&self) -> u32 {
        match self.machine.memory.style {
            MemoryStyle::Unified | MemoryStyle::FourPort => 1 + self.write_ports.div_ceil(2),
            MemoryStyle::SideSplit => self.write_ports,
        }
    }

    /// The sizes that lay out the instruction words.
    pub(crate) fn sizes(&self) -> Sizes {
        Sizes {
            words: self.words,
            write_ports: self.write_ports,
            memories: self.memories(),
            buffer: self.buffer.as_ref().map(|b| (b.words, b.read_ports)),
            elements: self.element_count(),
        }
    }

    pub(super) fn kind(&self, group: &ElementGroup) -> &ElementDescription {
        let mut kinds = self.machine.elements.iter();
        let found = kinds.find(|kind| kind.kind == group.kind);
        found.expect("validation has found the kind of every group")
    }

    /// The names and kinds of all elements, in order.
    pub(super) fn names(&self) -> impl Iterator<Item = (String, &ElementGroup)> {
        self.elements.iter().flat_map(|group| {
            (0..group.count).map(move |number| (format!("{}{number}", group.kind), group))
        })
    }

    /// The layout of the instruction words of a group.
    pub(super) fn layout(&self, group: &ElementGroup) -> WordLayout {
        let kind = self.kind(group);
        WordLayout::new(&self.sizes(), kind.operations.len(), kind.is_fused())
    }

    /// Bits of the widest instruction word.
    pub(super) fn instruction_width(&self) -> u32 {
        let widths = self.elements.iter().map(|group| self.layout(group).width());
        widths.max().expect("hardware has an element")
    }

    /// Address bits of the instruction memories. Smaller memories than 64
    /// words are not built: block memories are larger, and synthesis would
    /// take registers for less.
    pub(super) fn instruction_address(&self) -> u32 {
        bits(self.instruction_words).max(6)
    }

    /// Words of the instruction memories as built.
    pub(crate) fn instruction_depth(&self) -> u32 {
        1 << self.instruction_address()
    }

    /// Address bits of the operand memories as built; see
    /// [`Hardware::instruction_address`].
    pub(super) fn operand_address(&self) -> u32 {
        bits(self.words).max(6)
    }

    /// The addresses at which the host finds everything.
    pub(crate) fn window(&self) -> AddressBlocks {
        let elements = self.element_count();
        AddressBlocks::new(
            Block::new(
                self.instruction_width(),
                self.instruction_address(),
                elements,
            ),
            Block::new(
                self.width(),
                self.operand_address(),
                elements * self.memories(),
            ),
        )
    }

    /// The description of the window in the manifest.
    pub(super) fn address_map(&self) -> AddressMap {
        let window = self.window();
        let mut units = Vec::new();
        for (index, (name, group)) in (0u32..).zip(self.names()) {
            units.push(MappedMemory {
                name: format!("{name}.instructions"),
                address: window.instructions.address(index),
                words: self.instruction_depth(),
                limbs: self.layout(group).width().div_ceil(32),
                stride: 1 << window.instructions.limb_bits,
                readable: false,
            });
        }
        for (index, (name, _)) in (0u32..).zip(self.names()) {
            for (memory, suffix) in (0u32..).zip(self.memory_suffixes()) {
                units.push(MappedMemory {
                    name: format!("{name}{suffix}"),
                    address: window.operands.address(index * self.memories() + memory),
                    words: 1 << self.operand_address(),
                    limbs: window.operands.limbs,
                    stride: 1 << window.operands.limb_bits,
                    readable: true,
                });
            }
        }
        AddressMap {
            version: MAP_VERSION,
            address_bits: window.address_bits,
            machine_hash: self.hash(),
            control: 0,
            status: 1,
            cycles: 2,
            schedule: 3,
            machine: 5,
            units,
        }
    }

    /// Number of pairs of source and write port in the crossbar, and in a full
    /// one.
    pub fn crossbar_pairs(&self) -> (u64, u64) {
        let sizes = self.sizes();
        let ports = sizes.elements * sizes.memories * sizes.write_ports;
        let all = u64::from(ports) * u64::from(sizes.sources());
        let built = match &self.crossbar {
            Crossbar::Full => all,
            Crossbar::Pruned(legs) => legs.iter().map(|codes| codes.len() as u64).sum(),
        };
        (built, all)
    }

    /// The content of the machine's hash register: 64-bit FNV-1a, as sixteen
    /// hexadecimal digits, of everything that decides which images run.
    pub fn hash(&self) -> String {
        let kinds: Vec<_> = (self.elements.iter())
            .map(|group| {
                let kind = self.kind(group);
                (&group.kind, group.count, &kind.operations, kind.stages)
            })
            .collect();
        let essence = (
            self.machine.number,
            kinds,
            self.machine.memory.style,
            &self.machine.interconnect,
            (self.instruction_words, self.words, self.write_ports),
            &self.buffer,
            &self.crossbar,
        );
        let text = serde_json::to_vec(&essence).expect("hardware is numbers, texts and lists");
        Fnv::of(&text).text()
    }
}

/// Refuses machines that hardware cannot be built for.
fn check_machine(machine: &Machine) -> Result<(), RtlError> {
    if let Format::Fixed(_) = machine.number {
        return Err(RtlError::Number(machine.number));
    }
    if machine.interconnect != Interconnect::Crossbar {
        return Err(RtlError::Interconnect(machine.interconnect.name()));
    }
    if machine.memory.style == MemoryStyle::FourPort {
        return Err(RtlError::FourPort);
    }
    if machine.memory.writes == Some(0) {
        let (what, ports) = ("its memories", "write");
        return Err(RtlError::NoPorts { what, ports });
    }
    if machine.buffer.is_some_and(|buffer| buffer.reads == Some(0)) {
        let (what, ports) = ("its buffers", "read");
        return Err(RtlError::NoPorts { what, ports });
    }
    Ok(())
}
