//! The shape of a machine: every size that decides its resources.
//!
//! Sizes are those of the hardware: memories have the number of words that
//! their address bits can address, and no fewer than 64, since a block memory
//! is larger anyway.

use crate::layout::bits;
use crate::rtl::{Crossbar, Hardware};
use robovec_ir::machine::{Device, ElementDescription, Interconnect, MemoryStyle};
use robovec_ir::{Format, Machine};

/// Address bits of instruction and operand memories at least.
const LEAST_ADDRESS: u32 = 6;

/// Elements of one kind.
#[derive(Clone, Debug)]
pub struct ElementsOfKind {
    /// Their description.
    pub element: ElementDescription,
    /// Their number.
    pub count: u32,
}

/// A machine with every size settled.
#[derive(Clone, Debug)]
pub struct MachineShape {
    /// Its device.
    pub device: &'static Device,
    /// The number format.
    pub number: Format,
    /// The kinds of elements.
    pub kinds: Vec<ElementsOfKind>,
    /// The construction of operand memories.
    pub style: MemoryStyle,
    /// Words of an operand memory (per side, when split).
    pub words: u32,
    /// Write ports of an operand memory (per side, when split).
    pub write_ports: u32,
    /// Words and read ports of a buffer.
    pub buffer: Option<(u32, u32)>,
    /// Words of an instruction memory.
    pub instruction_words: u32,
    /// The interconnect that results travel through.
    pub interconnect: Interconnect,
    /// For each write port of a crossbar the sources connected to it; `None`
    /// for all of them.
    pub legs: Option<Vec<u32>>,
}

impl MachineShape {
    /// The shape of a machine for programs of at most this number of cycles and
    /// of words per operand memory, with a full crossbar. Sizes that the
    /// machine file declares come first; open ones are two write ports and a
    /// buffer of 16 words with one output, as in the thesis.
    pub fn of(machine: &Machine, cycles: u32, words: u32) -> MachineShape {
        let kinds = machine.elements.iter().map(|element| ElementsOfKind {
            element: element.clone(),
            count: element.count,
        });
        MachineShape {
            device: machine.device.device(),
            number: machine.number,
            kinds: kinds.collect(),
            style: machine.memory.style,
            words: machine.memory.words.unwrap_or(words),
            write_ports: machine.memory.writes.unwrap_or(2),
            buffer: (machine.buffer)
                .map(|buffer| (buffer.words.unwrap_or(16), buffer.reads.unwrap_or(1))),
            instruction_words: cycles,
            interconnect: machine.interconnect,
            legs: None,
        }
    }

    /// The shape of hardware that is built.
    pub fn built(hardware: &Hardware) -> MachineShape {
        let kinds = hardware.elements.iter().map(|group| {
            let mut known = hardware.machine.elements.iter();
            let element = known.find(|element| element.kind == group.kind);
            let element = element.expect("the machine has the kind of every group");
            ElementsOfKind {
                element: element.clone(),
                count: group.count,
            }
        });
        MachineShape {
            device: hardware.machine.device.device(),
            number: hardware.machine.number,
            kinds: kinds.collect(),
            style: hardware.machine.memory.style,
            words: hardware.words,
            write_ports: hardware.write_ports,
            buffer: hardware
                .buffer
                .as_ref()
                .map(|buffer| (buffer.words, buffer.read_ports)),
            instruction_words: hardware.instruction_words,
            interconnect: hardware.machine.interconnect,
            legs: match &hardware.crossbar {
                Crossbar::Full => None,
                Crossbar::Pruned(legs) => {
                    Some(legs.iter().map(|codes| codes.len() as u32).collect())
                }
            },
        }
    }

    /// Elements of all kinds.
    pub fn elements(&self) -> u32 {
        self.kinds.iter().map(|kind| kind.count).sum()
    }

    /// Operand memories of an element.
    pub fn memories(&self) -> u32 {
        self.style.banks() as u32
    }

    /// Clocks of a cycle: a unified memory reads in the first and writes two
    /// words in each further one; a memory per side reads and writes in the
    /// first and writes in each further one; one with four ports does all in
    /// one.
    pub fn phases(&self) -> u32 {
        match self.style {
            MemoryStyle::Unified => 1 + self.write_ports.div_ceil(2),
            MemoryStyle::SideSplit => self.write_ports,
            MemoryStyle::FourPort => 1,
        }
    }

    /// The number of sources of one element: its result and the reads of its
    /// buffer.
    pub(super) fn own_sources(&self) -> u32 {
        1 + self.buffer.map_or(0, |(_, reads)| reads)
    }

    /// The number of sources that a write port can select from.
    pub fn sources(&self) -> u32 {
        self.elements() * self.own_sources()
    }

    /// Write ports of all elements.
    pub fn ports(&self) -> u32 {
        self.elements() * self.memories() * self.write_ports
    }

    /// Address bits of an operand memory as built.
    pub fn operand_address(&self) -> u32 {
        bits(self.words).max(LEAST_ADDRESS)
    }

    /// Address bits of an instruction memory as built.
    pub fn instruction_address(&self) -> u32 {
        bits(self.instruction_words).max(LEAST_ADDRESS)
    }

    /// Bits of an instruction word of a kind (`docs/images.md`).
    pub fn instruction_width(&self, kind: &ElementsOfKind) -> u32 {
        let operations = kind.element.operations.len() as u32;
        let code = if operations > 1 { bits(operations) } else { 0 };
        let reads = if kind.element.is_fused() { 3 } else { 2 };
        let address = bits(self.words);
        let write = 1 + address + bits(self.sources());
        let buffer = self
            .buffer
            .map_or(0, |(words, reads)| 1 + (1 + reads) * bits(words));
        1 + code + reads * address + self.memories() * self.write_ports * write + buffer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_of_the_thesis_has_its_sizes() {
        let machine = Machine::built_in("de10-nano").expect("it ships");
        let shape = MachineShape::of(&machine, 987, 900);
        assert_eq!(
            (shape.elements(), shape.sources(), shape.ports()),
            (8, 16, 16)
        );
        assert_eq!(
            (shape.operand_address(), shape.instruction_address()),
            (11, 10)
        );
        assert_eq!(shape.phases(), 2);
        // As the layout of the images has it: four addresses, two enables,
        // issue, operation, two selects, the buffer.
        assert_eq!(
            shape.instruction_width(&shape.kinds[0]),
            4 * 11 + 2 + 1 + 1 + 2 * 4 + 9
        );
        assert_eq!(
            shape.instruction_width(&shape.kinds[1]),
            4 * 11 + 2 + 1 + 2 * 4 + 9
        );
    }
}
