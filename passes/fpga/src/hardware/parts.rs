//! The parts of a machine and the resources of each.
//!
//! The formulas follow the Verilog under `hdl/` and the generated Verilog
//! around it, part by part, so that a change there has one place here. They
//! hold for any number of elements, format, latency, memory style and size;
//! they are compared with yosys' mapping (`robovec rtl --synthesise`).

use super::ResourceUse;
use super::interconnect::{Terminals, interconnect};
use super::memory::{blocks, four_port_blocks, lab_memories, true_dual_port_blocks};
use super::operator::operator;
use super::shape::{ElementsOfKind, MachineShape};
use crate::layout::bits;
use crate::rtl::cores_of;
use robovec_ir::machine::{Interconnect, MemoryStyle};
use serde::Serialize;

robovec_num::named! {
    /// The kind of a part.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum PartKind {
        /// The operators of an element.
        Operators = "operators",
        /// The instruction memory of an element, with its word register.
        Instructions = "instruction memory",
        /// The operand memories of an element.
        Operands = "operand memories",
        /// The buffer of an element.
        Buffer = "buffer",
        /// The crossbar.
        Crossbar = "crossbar",
        /// The counter of cycles.
        Sequencer = "sequencer",
        /// The host's window, with its way to the memories.
        Window = "host window",
    }
}

/// A part of a machine.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct MachinePart {
    /// The kind of the part.
    pub part: PartKind,
    /// The kind of its element; none for a part that exists once.
    pub kind: Option<String>,
    /// Their number.
    pub count: u32,
    /// The resources of one.
    pub each: ResourceUse,
}

/// The parts of a machine.
pub fn parts(shape: &MachineShape) -> Vec<MachinePart> {
    let mut parts = Vec::new();
    for kind in shape.kinds.iter().filter(|kind| kind.count > 0) {
        let mut part = |part: PartKind, each: ResourceUse| {
            parts.push(MachinePart {
                part,
                kind: Some(kind.element.kind.clone()),
                count: kind.count,
                each,
            });
        };
        part(PartKind::Operators, operators(shape, kind));
        part(PartKind::Instructions, instructions(shape, kind));
        part(PartKind::Operands, operands(shape, kind));
        if let Some((words, reads)) = shape.buffer {
            part(PartKind::Buffer, buffer(shape, words, reads));
        }
    }
    let once = [
        (PartKind::Crossbar, crossbar(shape)),
        (PartKind::Sequencer, sequencer(shape)),
        (PartKind::Window, window(shape)),
    ];
    parts.extend(once.map(|(part, each)| MachinePart {
        part,
        kind: None,
        count: 1,
        each,
    }));
    parts
}

/// The resources of a whole machine.
pub fn resources(shape: &MachineShape) -> ResourceUse {
    let all = parts(shape).into_iter();
    all.map(|part| part.each * f64::from(part.count)).sum()
}

fn operators(shape: &MachineShape, kind: &ElementsOfKind) -> ResourceUse {
    let mut cores = cores_of(&kind.element);
    cores.sort_unstable();
    let stages = kind.element.stages;
    let mut taken: ResourceUse = cores
        .iter()
        .map(|core| operator(*core, shape.number, stages, shape.device))
        .sum();
    let operations = kind.element.operations.len() as u32;
    if operations > 1 {
        // The code of the operation that enters; with several operators also
        // of those under way, and a choice among their results.
        let code = bits(operations);
        taken.registers += f64::from(code);
        taken.aluts += f64::from(code);
        if cores.len() > 1 {
            taken.registers += f64::from(code * stages);
            let choice = shape.number.width() * (cores.len() as u32 - 1) + 2 * cores.len() as u32;
            taken.aluts += f64::from(choice);
        }
    }
    taken
}

fn instructions(shape: &MachineShape, kind: &ElementsOfKind) -> ResourceUse {
    let width = shape.instruction_width(kind);
    let words = 1 << shape.instruction_address();
    ResourceUse {
        // Enables that are inverted.
        aluts: 2.0,
        registers: f64::from(width),
        memory_blocks: f64::from(blocks(words, width, shape.device)),
        ..ResourceUse::default()
    }
}

fn operands(shape: &MachineShape, kind: &ElementsOfKind) -> ResourceUse {
    let address = shape.operand_address();
    let width = shape.number.width();
    let words = 1 << address;
    let ports = shape.write_ports;
    match shape.style {
        MemoryStyle::SideSplit => {
            // Two addresses joined with the host's; with several writes a
            // choice of address and word, and a register for the operand.
            let choice = if ports > 1 {
                multiplexer(ports) * (address + width)
            } else {
                0
            };
            let held = if ports > 1 { width } else { 0 };
            let side = ResourceUse {
                aluts: f64::from(2 * address + 2 + choice),
                registers: f64::from(held),
                memory_blocks: f64::from(blocks(words, width, shape.device)),
                ..ResourceUse::default()
            };
            side * 2.0
        }
        MemoryStyle::Unified => {
            // Each port reads or writes, so its address is a choice of two,
            // and of more with more writes; an operand waits in a register
            // for the end of the cycle.
            let each = ports.div_ceil(2);
            let choice = if each > 1 {
                multiplexer(each) * width
            } else {
                0
            };
            let held = if shape.phases() > 2 { 2 } else { 1 };
            let copies = copies_of(kind);
            ResourceUse {
                aluts: f64::from((1 + copies) * (address + 1) + 2 * choice),
                registers: f64::from((1 + copies) * held * width),
                memory_blocks: f64::from(
                    copies * true_dual_port_blocks(words, width, shape.device),
                ),
                ..ResourceUse::default()
            }
        }
        MemoryStyle::FourPort => {
            let copies = copies_of(kind);
            ResourceUse {
                aluts: f64::from(copies * (2 * address + 2)),
                memory_blocks: f64::from(copies * four_port_blocks(words, width)),
                ..ResourceUse::default()
            }
        }
    }
}

/// The number of copies of an operand memory: an element of fused operations
/// reads a third operand from a second one.
fn copies_of(kind: &ElementsOfKind) -> u32 {
    if kind.element.is_fused() { 2 } else { 1 }
}

fn buffer(shape: &MachineShape, words: u32, reads: u32) -> ResourceUse {
    let width = shape.number.width();
    let words = 1_u32 << bits(words).max(2);
    let columns = words.div_ceil(32);
    let choice = if columns > 1 {
        multiplexer(columns) * width + columns
    } else {
        0
    };
    ResourceUse {
        aluts: f64::from(reads * (1 + choice)),
        lab_memories: f64::from(reads * lab_memories(words, width)),
        ..ResourceUse::default()
    }
}

/// Six-input tables per bit of a choice of `count`, as a tree of choices of
/// four (thesis 1.3.1).
pub(super) fn multiplexer(count: u32) -> u32 {
    let mut tables = 0;
    let mut left = count;
    while left > 1 {
        // A single word at the end of a level passes as it is.
        tables += left.div_ceil(4) - u32::from(left % 4 == 1);
        left = left.div_ceil(4);
    }
    tables
}

fn crossbar(shape: &MachineShape) -> ResourceUse {
    let width = shape.number.width();
    if let Interconnect::Network(_) = shape.interconnect {
        let terminals = Terminals {
            elements: shape.elements(),
            sources: shape.own_sources(),
            ports: shape.memories() * shape.write_ports,
            width,
        };
        return interconnect(shape.interconnect, terminals);
    }
    let select = bits(shape.sources());
    let aluts: u32 = match &shape.legs {
        None => shape.ports() * multiplexer(shape.sources()) * width,
        // A select is first turned into the number of a leg, two tables per
        // bit of it.
        Some(legs) => legs
            .iter()
            .map(|&count| match count {
                0 | 1 => 0,
                _ if count == shape.sources() => multiplexer(count) * width,
                _ => multiplexer(count) * width + 2 * bits(count).min(select),
            })
            .sum(),
    };
    ResourceUse {
        aluts: f64::from(aluts),
        ..ResourceUse::default()
    }
}

fn sequencer(shape: &MachineShape) -> ResourceUse {
    let address = shape.instruction_address();
    let phases = shape.phases();
    let counter = if phases > 1 { bits(phases) + 1 } else { 0 };
    ResourceUse {
        // Three counters with their loads, and a comparison with zero.
        aluts: f64::from(5 * address + 16 + 2 * counter),
        registers: f64::from(4 * address + 6 + counter),
        ..ResourceUse::default()
    }
}

fn window(shape: &MachineShape) -> ResourceUse {
    let elements = shape.elements();
    let width = shape.number.width();
    let memories = elements * shape.memories();
    let widths = shape.kinds.iter().map(|kind| shape.instruction_width(kind));
    let instruction = widths.fold(1, u32::max);
    let limbs = instruction.max(width).div_ceil(32);
    let cycle = shape.instruction_address();
    let block = |word: u32, address: u32, units: u32| {
        let limb = word.div_ceil(32).next_power_of_two().ilog2();
        limb + address + units.next_power_of_two().ilog2()
    };
    let address = 1 + block(instruction, cycle, elements).max(block(
        width,
        shape.operand_address(),
        memories,
    ));
    let unit = memories.next_power_of_two().ilog2();
    ResourceUse {
        // What the host reads is a choice among all memories and registers;
        // every memory compares the address with its own.
        aluts: f64::from(
            multiplexer(memories) * width + 4 * 32 + address + 2 * (elements + memories) + 20,
        ),
        registers: f64::from(
            32 * limbs + address + cycle + 1 + 64 + 4 * 32 + 14 + 2 * unit + memories * width,
        ),
        ..ResourceUse::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::Machine;

    #[test]
    fn a_choice_of_sixteen_takes_five_tables() {
        // Thesis 1.3.1: 160 tables for 32 bits from 16 sources.
        assert_eq!(32 * multiplexer(16), 160);
        assert_eq!(
            [1, 2, 4, 5, 8, 17, 32, 64].map(multiplexer),
            [0, 1, 1, 2, 3, 6, 11, 21]
        );
    }

    /// Elements of each kind, stages of adder and multiplier, words of an
    /// instruction memory, and the counts of yosys 0.70 for the whole machine:
    /// tables, registers, memory blocks, multiplier blocks.
    const MAPPED: [([u32; 4], [f64; 4]); 3] = [
        ([2, 5, 3, 2048], [2792.0, 1592.0, 80.0, 2.0]),
        ([4, 10, 5, 1024], [6614.0, 4468.0, 116.0, 4.0]),
        ([8, 10, 5, 1024], [19307.0, 8623.0, 240.0, 8.0]),
    ];

    #[test]
    fn whole_machines_are_within_a_twelfth_of_the_mapping() {
        for ([count, add, multiply, words], mapped) in MAPPED {
            let mut machine = Machine::built_in("side-split").expect("it ships");
            for (element, stages) in machine.elements.iter_mut().zip([add, multiply]) {
                (element.count, element.stages) = (count, stages);
            }
            let taken = resources(&MachineShape::of(&machine, words, 1024));
            let found = [
                taken.aluts,
                taken.registers,
                taken.memory_blocks,
                taken.multiplier_blocks,
            ];
            for (found, mapped) in found.into_iter().zip(mapped) {
                let error = (found - mapped).abs() / mapped;
                assert!(error < 1.0 / 12.0, "{count}: {found} for {mapped}");
            }
        }
    }

    #[test]
    fn more_of_anything_takes_more() {
        let machine = Machine::built_in("side-split").expect("it ships");
        let base = resources(&MachineShape::of(&machine, 1024, 1024));
        let grown = |change: &dyn Fn(&mut MachineShape)| {
            let mut shape = MachineShape::of(&machine, 1024, 1024);
            change(&mut shape);
            resources(&shape)
        };
        assert!(grown(&|shape| shape.kinds[0].count = 8).aluts > base.aluts);
        assert!(grown(&|shape| shape.kinds[1].element.stages = 9).registers > base.registers);
        assert!(grown(&|shape| shape.words = 4096).memory_blocks > base.memory_blocks);
        assert!(grown(&|shape| shape.write_ports = 2).aluts > base.aluts);
        assert!(grown(&|shape| shape.buffer = None).lab_memories < base.lab_memories);
        assert!(grown(&|shape| shape.legs = Some(vec![5; 16])).aluts < base.aluts);
        assert_eq!(base.multiplier_blocks, 4.0);
    }
}
