//! A processing element: instruction memory, operand memories, operators and
//! buffer, one module per kind.

use super::hardware::{ElementGroup, Hardware};
use super::text::{bits_of, extended, heading, joined, range, slice};
use super::unit;
use crate::layout::{OPERATION, READ, WordLayout, bits};
use robovec_ir::machine::MemoryStyle;
use std::fmt::Write;

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
    let element = ElementModule {
        hardware,
        group,
        layout: hardware.layout(group),
        select: bits(hardware.sizes().sources()),
    };
    let mut text = element.head();
    text += &element.instructions();
    text += &element.memories();
    text += "\n";
    let number = hardware.number();
    let code_bits = element.layout.fields()[OPERATION as usize].width;
    if code_bits > 0 {
        let code = element.field(OPERATION);
        let _ = writeln!(text, "    wire {} operation = {code};\n", range(code_bits));
    }
    text += &unit::text(
        hardware.kind(group),
        number,
        code_bits,
        hardware.machine.device.device(),
    );
    text += &element.buffer();
    text += "\nendmodule\n";
    text
}

struct ElementModule<'a> {
    hardware: &'a Hardware,
    group: &'a ElementGroup,
    layout: WordLayout,
    /// Bits of a select field.
    select: u32,
}

impl ElementModule<'_> {
    fn field(&self, place: u32) -> String {
        slice("word", &self.layout.fields()[place as usize])
    }

    /// An address field, as wide as the memory's address.
    fn address(&self, place: u32) -> String {
        let width = self.layout.fields()[place as usize].width;
        extended(&self.field(place), width, self.hardware.operand_address())
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

    fn head(&self) -> String {
        let hardware = self.hardware;
        let kind = hardware.kind(self.group);
        let images: &[&str] = match hardware.machine.memory.style {
            MemoryStyle::Unified | MemoryStyle::FourPort => &["DATA"],
            MemoryStyle::SideSplit => &["LEFT", "RIGHT"],
        };
        let mut text = heading(&[
            format!(
                "A processing element of kind '{}': {}.",
                kind.kind,
                kind.operations.join(", ")
            ),
            String::new(),
            format!(
                "An operation issued in cycle t is on `result` in cycle t + {}.",
                kind.stages + 1
            ),
        ]);
        let _ = write!(
            text,
            "module {} #(\n    parameter INITIAL = 0,\n",
            module_name(self.group)
        );
        let _ = write!(text, "    parameter INSTRUCTIONS = \"instructions\"");
        for image in images {
            let _ = write!(text, ",\n    parameter {image} = \"data\"");
        }
        let ports = hardware.memories() * hardware.write_ports;
        let phase = phase_bits(hardware.phases());
        let port = |direction: &str, width: u32, name: &str| {
            let range = if width == 1 {
                String::new()
            } else {
                range(width) + " "
            };
            format!("    {direction} {range}{name},\n")
        };
        text += "\n) (\n";
        text += &port("input ", 1, "clock");
        text += &port("input ", 1, "advance");
        let _ = writeln!(text, "    input  {} phase,", range(phase));
        text += &port("input ", hardware.instruction_address(), "fetch_address");
        text += &port("input ", 1, "fetched");
        let _ = writeln!(text, "    output {} selects,", range(ports * self.select));
        text += &port("input ", ports * hardware.width(), "arriving");
        if let Some(buffer) = &hardware.buffer {
            text += &port("output", buffer.read_ports * hardware.width(), "buffered");
        }
        text += &port("input ", 1, "host_instruction_write");
        text += &port(
            "input ",
            hardware.instruction_address(),
            "host_instruction_address",
        );
        text += &port("input ", self.layout.width(), "host_instruction");
        text += &port("input ", 1, "host_access");
        let _ = writeln!(
            text,
            "    input  {} host_write,",
            range(hardware.memories())
        );
        text += &port("input ", hardware.operand_address(), "host_address");
        text += &port(
            "output",
            hardware.memories() * hardware.width(),
            "host_words",
        );
        let _ = write!(
            text,
            "    output {} result\n);\n\n",
            range(hardware.width())
        );
        text
    }

    fn instructions(&self) -> String {
        let hardware = self.hardware;
        let width = self.layout.width();
        let mut text = format!(
            "    wire {} word;\n    \
             instruction_memory #(\n        .WIDTH({width}), .ADDRESS({}),\n        \
             .INITIAL(INITIAL), .IMAGE(INSTRUCTIONS)\n    ) instructions (\n        \
             .clock(clock), .advance(advance),\n        \
             .fetch_address(fetch_address), .fetched(fetched), .word(word),\n        \
             .host_write(host_instruction_write), .host_address(host_instruction_address),\n        \
             .host_data(host_instruction)\n    );\n\n    \
             // Fields of the instruction word, from bit 0 up:\n",
            range(width),
            hardware.instruction_address(),
        );
        for field in self.layout.fields().iter().filter(|field| field.width > 0) {
            let _ = writeln!(text, "    //   {:<22} {}", field.name, slice("word", field));
        }
        let selects: Vec<String> = (0..hardware.memories())
            .flat_map(|memory| self.writes(memory)[2].clone())
            .collect();
        let _ = writeln!(
            text,
            "    assign selects = {};\n    wire unused_fields = &{{1'b0, word}};\n",
            joined(&selects)
        );
        text
    }

    fn memories(&self) -> String {
        match self.hardware.machine.memory.style {
            MemoryStyle::Unified | MemoryStyle::FourPort => self.pumped(),
            MemoryStyle::SideSplit => self.split(),
        }
    }

    fn split(&self) -> String {
        let hardware = self.hardware;
        let (width, ports) = (hardware.width(), hardware.write_ports);
        let mut sides = String::new();
        for (memory, side) in ["left", "right"].into_iter().enumerate() {
            let [enables, addresses, _] = self.writes(memory as u32);
            let arriving = bits_of("arriving", memory as u32 * ports * width, ports * width);
            let _ = write!(
                sides,
                "        .{side}_address({}),\n        .{side}_write({}),\n        \
                 .{side}_write_address({}),\n        .{side}_write_data({arriving}),\n        \
                 .host_{side}_write(host_write[{memory}]),\n        \
                 .host_{side}_word({}),\n",
                self.address(READ + memory as u32),
                joined(&enables),
                joined(&addresses),
                bits_of("host_words", memory as u32 * width, width),
            );
        }
        format!(
            "    wire {word} left;\n    wire {word} right;\n    \
             wire unused_operands = &{{1'b0, right}};\n    \
             pe_split #(\n        .WIDTH({width}), .ADDRESS({}), .WRITES({ports}), \
             .PHASE_BITS({}),\n        .INITIAL(INITIAL), .LEFT_IMAGE(LEFT), \
             .RIGHT_IMAGE(RIGHT)\n    ) operands (\n        \
             .clock(clock), .advance(advance), .phase(phase),\n        \
             .host_access(host_access), .host_address(host_address),\n\
             {sides}        .left(left), .right(right)\n    );\n",
            hardware.operand_address(),
            phase_bits(hardware.phases()),
            word = range(width),
        )
    }

    fn pumped(&self) -> String {
        let hardware = self.hardware;
        let (width, ports) = (hardware.width(), hardware.write_ports);
        let fused = hardware.kind(self.group).is_fused();
        let [enables, addresses, _] = self.writes(0);
        let addend = if fused {
            self.address(READ + 2)
        } else {
            format!("{}'d0", hardware.operand_address())
        };
        format!(
            "    wire {word} left;\n    wire {word} right;\n    wire {word} addend;\n    \
             wire unused_operands = &{{1'b0, right, addend, host_access}};\n    \
             pe_pumped #(\n        .WIDTH({width}), .ADDRESS({address}), .WRITES({ports}), \
             .PHASES({phases}), .PHASE_BITS({phase_bits}),\n        \
             .FUSED({fused}), .INITIAL(INITIAL), .IMAGE(DATA)\n    ) operands (\n        \
             .clock(clock), .advance(advance), .phase(phase),\n        \
             .left_address({left}),\n        .right_address({right}),\n        \
             .addend_address({addend}),\n        .write({enables}),\n        \
             .write_address({addresses}),\n        .write_data(arriving),\n        \
             .host_write(host_write[0]), .host_address(host_address), .host_word(host_words),\n        \
             .left(left), .right(right), .addend(addend)\n    );\n",
            word = range(width),
            address = hardware.operand_address(),
            phases = hardware.phases(),
            phase_bits = phase_bits(hardware.phases()),
            fused = u32::from(fused),
            left = self.address(READ),
            right = self.address(READ + 1),
            enables = joined(&enables),
            addresses = joined(&addresses),
        )
    }

    fn buffer(&self) -> String {
        let Some(buffer) = &self.hardware.buffer else {
            return String::new();
        };
        let wanted = buffer_address(buffer.words);
        let address = |place: u32| {
            let width = self.layout.fields()[place as usize].width;
            extended(&self.field(place), width, wanted)
        };
        let write = self.layout.buffer_write();
        let reads: Vec<String> = (0..buffer.read_ports)
            .map(|port| address(self.layout.buffer_read(port)))
            .collect();
        format!(
            "\n    result_buffer #(\n        .WIDTH({}), .ADDRESS({wanted}), .READS({})\n    ) \
             buffer (\n        .clock(clock), .advance(advance),\n        .write({}), \
             .write_address({}), .result(result),\n        .read_address({}), \
             .words(buffered)\n    );\n",
            self.hardware.width(),
            buffer.read_ports,
            self.field(write),
            address(write + 1),
            joined(&reads),
        )
    }
}
