//! The top of the hardware, `robovec_machine`: elements, crossbar, sequencer
//! and the host's window, wired up.

use super::crossbar::host_sources;
use super::element::{self, phase_bits};
use super::hardware::{ElementGroup, Hardware};
use super::text::{VERSION, bits_of, equals, joined, range};
use super::window::{AddressBlocks, Block};
use crate::layout::bits;
use robovec_framework::template::fill;
use robovec_ir::machine::MemoryStyle;

/// The program that is loaded at configuration.
pub(super) struct ConfiguredProgram<'a> {
    /// The function's name, which its images' names begin with.
    pub(super) function: &'a str,
    pub(super) cycles: u32,
    /// The hash of its instruction images: sixteen hexadecimal digits.
    pub(super) schedule_hash: &'a str,
}

pub(super) fn text(hardware: &Hardware, program: &ConfiguredProgram<'_>) -> String {
    let window = hardware.window();
    let top = Top {
        hardware,
        width: hardware.width(),
        elements: hardware.element_count(),
        select: bits(hardware.sizes().sources()),
        limbs: window.instructions.limbs.max(window.operands.limbs),
        window,
    };
    top.text(program)
}

struct Top<'a> {
    hardware: &'a Hardware,
    window: AddressBlocks,
    /// Bits of a data word.
    width: u32,
    elements: u32,
    /// Bits of a select.
    select: u32,
    /// Limbs of the widest word that the host writes.
    limbs: u32,
}

impl Top<'_> {
    /// Write ports of an element, over all its memories.
    fn ports(&self) -> u32 {
        self.hardware.memories() * self.hardware.write_ports
    }

    fn text(&self, program: &ConfiguredProgram<'_>) -> String {
        let (hardware, width, limbs) = (self.hardware, self.width, self.limbs);
        let groups = hardware.elements.iter();
        let groups: Vec<String> = groups.map(|g| format!("{} {}", g.count, g.kind)).collect();
        let phases = hardware.phases();
        let clocks = match phases {
            1 => "one clock".to_owned(),
            count => format!("{count} clocks"),
        };
        let (cycle, host) = (hardware.instruction_address(), self.window.address_bits);
        let (operands, instructions) = (&self.window.operands, &self.window.instructions);
        let address = |block: &Block| bits_of("unit_address", block.limb_bits, block.word_bits);
        let ports = self.elements * self.ports();
        let names = (0u32..).zip(hardware.names());
        let element =
            |(index, (name, group)): (u32, (String, _))| self.element(index, &name, group);
        fill(
            include_str!("top.v"),
            &[
                ("version", &VERSION),
                // A name may hold anything but must stay in the comment.
                ("machine", &hardware.machine.name.replace(['\n', '\r'], " ")),
                ("groups", &groups.join(", ")),
                ("number", &hardware.machine.number),
                ("clocks", &clocks),
                ("hash", &hardware.hash()),
                ("function", &program.function),
                ("cycles", &program.cycles),
                ("schedule_hash", &program.schedule_hash),
                ("host_bits", &host),
                ("host_range", &range(host)),
                ("results_range", &range(self.elements * width)),
                ("cycle_bits", &cycle),
                ("cycle_range", &range(cycle)),
                ("length_range", &range(cycle + 1)),
                ("phases", &phases),
                ("phase_bits", &phase_bits(phases)),
                ("phase_range", &range(phase_bits(phases))),
                ("limbs", &limbs),
                ("limbs_range", &range(32 * limbs)),
                ("width", &width),
                ("word_range", &range(width)),
                ("operand_commit", &self.commit(operands, operands.limbs)),
                ("operand_range", &range(operands.word_bits)),
                ("operand_address", &address(operands)),
                ("host_words_range", &range(width << operands.unit_bits)),
                ("host_word", &self.host_word(operands.limbs, width)),
                ("missing", &self.missing()),
                ("unit_word", &self.unit_word()),
                ("instruction_range", &range(instructions.word_bits)),
                ("instruction_address", &address(instructions)),
                ("sources_range", &range(hardware.sizes().sources() * width)),
                ("sources", &self.sources()),
                ("results", &bits_of("on_buses", 0, self.elements * width)),
                ("selects_range", &range(ports * self.select)),
                ("arriving_range", &range(ports * width)),
                ("elements", &names.map(element).collect::<String>()),
            ],
        )
    }

    /// True in a clock in which the host writes the highest limb of a word
    /// of `limbs` limbs in a block.
    fn commit(&self, block: &Block, limbs: u32) -> String {
        let low = block.bits();
        let high = self.window.address_bits - low;
        format!(
            "unit_write & {} & {}",
            equals("unit_address", low, high, block.base >> low),
            equals("unit_address", 0, block.limb_bits, limbs - 1),
        )
    }

    /// The word of `limbs` limbs that the host has written.
    fn host_word(&self, limbs: u32, width: u32) -> String {
        bits_of("unit_data", 32 * (self.limbs - limbs), width)
    }

    /// Zeros for the words of memories that an address has and the machine
    /// lacks.
    fn missing(&self) -> String {
        let units = self.elements * self.hardware.memories();
        match (1 << self.window.operands.unit_bits) - units {
            0 => String::new(),
            more => {
                let missing = more * self.width;
                let words = bits_of("host_words", units * self.width, missing);
                format!("    assign {words} = {missing}'d0;\n")
            }
        }
    }

    /// The word that the host reads. Words leave the block memories late in a
    /// clock, so they are held before one of them is chosen.
    fn unit_word(&self) -> String {
        let block = &self.window.operands;
        if block.unit_bits == 0 {
            return "    assign unit_word = host_held;\n".to_owned();
        }
        format!(
            "    reg {unit} unit_read;\n    reg {unit} unit_held;\n    \
             always @(posedge clock) begin\n        \
             unit_read <= {};\n        unit_held <= unit_read;\n    end\n    \
             assign unit_word = host_held[unit_held*{width} +: {width}];\n",
            bits_of("unit_address", block.unit_low(), block.unit_bits),
            unit = range(block.unit_bits),
            width = self.width,
        )
    }

    /// Sources that the crossbar chooses from.
    fn sources(&self) -> String {
        let carried = host_sources(self.hardware);
        let line = |source: u32| {
            let [bus, place] = ["on_buses", "sources"]
                .map(|vector| bits_of(vector, source * self.width, self.width));
            match carried.binary_search(&source) {
                Ok(_) => format!("    assign {place} = unit_access ? host_word : {bus};\n"),
                Err(_) => format!("    assign {place} = {bus};\n"),
            }
        };
        (0..self.hardware.sizes().sources()).map(line).collect()
    }

    fn element(&self, index: u32, name: &str, group: &ElementGroup) -> String {
        let hardware = self.hardware;
        let images = match hardware.machine.memory.style {
            MemoryStyle::Unified | MemoryStyle::FourPort => {
                format!(".DATA({{IMAGES, \"{name}.data\"}})")
            }
            MemoryStyle::SideSplit => format!(
                ".LEFT({{IMAGES, \"{name}.left.data\"}}),\n        \
                 .RIGHT({{IMAGES, \"{name}.right.data\"}})"
            ),
        };
        let width = self.width;
        let (ports, memories) = (self.ports(), hardware.memories());
        let layout = hardware.layout(group);
        let block = &self.window.instructions;
        let limbs = layout.width().div_ceil(32);
        let operands = &self.window.operands;
        let writes: Vec<String> = (0..memories)
            .map(|memory| {
                let unit = index * memories + memory;
                let own = equals(
                    "unit_address",
                    operands.unit_low(),
                    operands.unit_bits,
                    unit,
                );
                format!("operand_write & {own}")
            })
            .collect();
        let buffered = hardware.buffer.as_ref().map(|buffer| {
            let reads: Vec<String> = (0..buffer.read_ports)
                .map(|port| {
                    let source = self.elements * (1 + port) + index;
                    bits_of("on_buses", source * width, width)
                })
                .collect();
            format!("        .buffered({}),\n", joined(&reads))
        });
        fill(
            include_str!("instance.v"),
            &[
                ("module", &element::module_name(group)),
                ("name", &name),
                ("images", &images),
                (
                    "selects",
                    &bits_of("selects", index * ports * self.select, ports * self.select),
                ),
                (
                    "arriving",
                    &bits_of("arriving", index * ports * width, ports * width),
                ),
                ("buffered", &buffered.unwrap_or_default()),
                ("commit", &self.commit(block, limbs)),
                (
                    "own",
                    &equals("unit_address", block.unit_low(), block.unit_bits, index),
                ),
                ("instruction", &self.host_word(limbs, layout.width())),
                ("writes", &joined(&writes)),
                (
                    "words",
                    &bits_of("host_words", index * memories * width, memories * width),
                ),
                ("result", &bits_of("on_buses", index * width, width)),
            ],
        )
    }
}
