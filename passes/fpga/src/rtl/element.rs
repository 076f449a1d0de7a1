//! A processing element: instruction memory, operand memories, operators and
//! buffer, one module per kind.

use super::hardware::{ElementGroup, Hardware};
use super::text::{VERSION, bits_of, extended, joined, range, slice};
use super::unit;
use crate::layout::{OPERATION, READ, WordLayout, bits};
use crate::manifest::InstructionField;
use robovec_framework::template::fill;
use robovec_ir::machine::MemoryStyle;
use std::fmt::{Display, Write};

/// The name of a kind's module.
pub(super) fn module_name(group: &ElementGroup) -> String {
    format!("robovec_element_{}", group.kind)
}

/// Address bits of a buffer as built. A buffer of one word has two, since
/// synthesis would take registers for less.
pub(super) fn buffer_address(words: u32) -> u32 {
    bits(words).max(2)
}

/// Bits that count the clocks of a cycle.
pub(super) fn phase_bits(phases: u32) -> u32 {
    bits(phases)
}

/// The text of the module of a kind.
pub(super) fn text(hardware: &Hardware, group: &ElementGroup) -> String {
    let layout = hardware.layout(group);
    let select = bits(hardware.sizes().sources());
    let element = ElementModule {
        hardware,
        group,
        layout,
    };
    let kind = hardware.kind(group);
    let (width, instruction) = (hardware.width(), element.layout.width());
    let (memories, fetch) = (hardware.memories(), hardware.instruction_address());
    let ports = memories * hardware.write_ports;
    let code_bits = element.layout.fields()[OPERATION as usize].width;
    let operation = match code_bits {
        0 => String::new(),
        _ => {
            let code = element.field(OPERATION);
            format!("    wire {} operation = {code};\n\n", range(code_bits))
        }
    };
    let buffered = hardware.buffer.as_ref().map(|buffer| {
        let words = range(buffer.read_ports * width);
        format!("    output {words} buffered,\n")
    });
    let (images, operands): (&[&str], _) = match hardware.machine.memory.style {
        MemoryStyle::Unified | MemoryStyle::FourPort => (&["DATA"], element.pumped()),
        MemoryStyle::SideSplit => (&["LEFT", "RIGHT"], element.split()),
    };
    let image = |name: &&str| format!(",\n    parameter {name} = \"data\"");
    let fields = element
        .layout
        .fields()
        .iter()
        .filter(|field| field.width > 0);
    let field = |field: &InstructionField| {
        format!("    //   {:<22} {}\n", field.name, slice("word", field))
    };
    let selects: Vec<String> = (0..memories)
        .flat_map(|memory| element.writes(memory)[2].clone())
        .collect();
    let device = hardware.machine.device.device();
    let unit = unit::text(kind, hardware.number(), code_bits, device);
    fill(
        include_str!("element.v"),
        &[
            ("version", &VERSION),
            ("kind", &kind.kind),
            ("operations", &kind.operations.join(", ")),
            ("latency", &(kind.stages + 1)),
            ("images", &images.iter().map(image).collect::<String>()),
            ("phase_range", &range(phase_bits(hardware.phases()))),
            ("fetch_bits", &fetch),
            ("fetch_range", &range(fetch)),
            ("selects_range", &range(ports * select)),
            ("arriving_range", &range(ports * width)),
            ("buffered", &buffered.unwrap_or_default()),
            ("instruction_width", &instruction),
            ("instruction_range", &range(instruction)),
            ("host_write_range", &range(memories)),
            ("address_range", &range(hardware.operand_address())),
            ("host_words_range", &range(memories * width)),
            ("word_range", &range(width)),
            ("fields", &fields.map(field).collect::<String>()),
            ("selects", &joined(&selects)),
            ("operands", &operands),
            ("operation", &operation),
            ("unit", &unit),
            ("buffer", &element.buffer()),
        ],
    )
}

struct ElementModule<'a> {
    hardware: &'a Hardware,
    group: &'a ElementGroup,
    layout: WordLayout,
}

impl ElementModule<'_> {
    fn field(&self, place: u32) -> String {
        slice("word", &self.layout.fields()[place as usize])
    }

    /// An address field, as wide as the memory's address.
    fn address(&self, place: u32) -> String {
        self.extended_field(place, self.hardware.operand_address())
    }

    fn extended_field(&self, place: u32, wanted: u32) -> String {
        let width = self.layout.fields()[place as usize].width;
        extended(&self.field(place), width, wanted)
    }

    /// The write ports of a memory: enables, addresses and selects.
    fn writes(&self, memory: u32) -> [Vec<String>; 3] {
        let ports = 0..self.hardware.write_ports;
        let first = ports.map(|port| self.layout.write(memory, port));
        let first: Vec<u32> = first.collect();
        [
            first.iter().map(|&place| self.field(place)).collect(),
            first.iter().map(|&place| self.address(place + 1)).collect(),
            first.iter().map(|&place| self.field(place + 2)).collect(),
        ]
    }

    /// A template of operand memories, with the words of both.
    fn operands(&self, template: &str, own: &[(&str, &dyn Display)]) -> String {
        let hardware = self.hardware;
        let words: [(&str, &dyn Display); 4] = [
            ("width", &hardware.width()),
            ("address_bits", &hardware.operand_address()),
            ("ports", &hardware.write_ports),
            ("phase_bits", &phase_bits(hardware.phases())),
        ];
        fill(template, &[&words, own].concat())
    }

    fn split(&self) -> String {
        let (width, ports) = (self.hardware.width(), self.hardware.write_ports);
        let mut sides = String::new();
        for (memory, side) in (0u32..).zip(["left", "right"]) {
            let [enables, addresses, _] = self.writes(memory);
            let arriving = bits_of("arriving", memory * ports * width, ports * width);
            let _ = write!(
                sides,
                "        .{side}_address({}),\n        .{side}_write({}),\n        \
                 .{side}_write_address({}),\n        .{side}_write_data({arriving}),\n        \
                 .host_{side}_write(host_write[{memory}]),\n        \
                 .host_{side}_word({}),\n",
                self.address(READ + memory),
                joined(&enables),
                joined(&addresses),
                bits_of("host_words", memory * width, width),
            );
        }
        self.operands(include_str!("split.v"), &[("sides", &sides)])
    }

    fn pumped(&self) -> String {
        let hardware = self.hardware;
        let fused = hardware.kind(self.group).is_fused();
        let [enables, addresses, _] = self.writes(0);
        let addend = if fused {
            self.address(READ + 2)
        } else {
            format!("{}'d0", hardware.operand_address())
        };
        self.operands(
            include_str!("pumped.v"),
            &[
                ("word_range", &range(hardware.width())),
                ("phases", &hardware.phases()),
                ("fused", &u32::from(fused)),
                ("left", &self.address(READ)),
                ("right", &self.address(READ + 1)),
                ("addend", &addend),
                ("enables", &joined(&enables)),
                ("addresses", &joined(&addresses)),
            ],
        )
    }

    fn buffer(&self) -> String {
        let Some(buffer) = &self.hardware.buffer else {
            return String::new();
        };
        let wanted = buffer_address(buffer.words);
        let write = self.layout.buffer_write();
        let reads: Vec<String> = (0..buffer.read_ports)
            .map(|port| self.extended_field(self.layout.buffer_read(port), wanted))
            .collect();
        fill(
            include_str!("buffer.v"),
            &[
                ("width", &self.hardware.width()),
                ("buffer_bits", &wanted),
                ("reads", &buffer.read_ports),
                ("write", &self.field(write)),
                ("write_address", &self.extended_field(write + 1, wanted)),
                ("read_address", &joined(&reads)),
            ],
        )
    }
}
