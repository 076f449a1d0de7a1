//! The top of the hardware, `robovec_machine`: elements, crossbar, sequencer
//! and the host's window, wired up.

use super::crossbar::host_sources;
use super::element::{self, phase_bits};
use super::hardware::Hardware;
use super::text::{bits_of, equals, heading, range};
use super::window::{AddressBlocks, Block};
use crate::layout::bits;
use robovec_ir::machine::MemoryStyle;
use std::fmt::Write;

/// The program that is loaded at configuration.
pub(super) struct ConfiguredProgram<'a> {
    /// The function's name, which its images' names begin with.
    pub(super) function: &'a str,
    /// Its cycles.
    pub(super) cycles: u32,
    /// The hash of its instruction images: sixteen hexadecimal digits.
    pub(super) schedule_hash: &'a str,
}

/// The text of the top.
pub(super) fn text(hardware: &Hardware, program: &ConfiguredProgram<'_>) -> String {
    let top = Top {
        hardware,
        window: hardware.window(),
        width: hardware.width(),
        elements: hardware.element_count(),
        select: bits(hardware.sizes().sources()),
    };
    let mut text = top.head(program);
    text += &top.control();
    text += &top.decoding();
    text += &top.crossbar();
    for (index, (name, _)) in (0u32..).zip(hardware.names()) {
        text += &top.element(index, &name);
    }
    text += "endmodule\n";
    text
}

struct Top<'a> {
    hardware: &'a Hardware,
    window: AddressBlocks,
    /// Bits of a data word.
    width: u32,
    elements: u32,
    /// Bits of a select.
    select: u32,
}

impl Top<'_> {
    /// Write ports of an element, over all its memories.
    fn ports(&self) -> u32 {
        self.hardware.memories() * self.hardware.write_ports
    }

    fn cycle_bits(&self) -> u32 {
        self.hardware.instruction_address()
    }

    /// Limbs of the widest word that the host writes.
    fn limbs(&self) -> u32 {
        self.window
            .instructions
            .limbs
            .max(self.window.operands.limbs)
    }

    fn head(&self, program: &ConfiguredProgram<'_>) -> String {
        let hardware = self.hardware;
        let groups: Vec<String> = (hardware.elements.iter())
            .map(|group| format!("{} {}", group.count, group.kind))
            .collect();
        let clocks = match hardware.phases() {
            1 => "one clock".to_owned(),
            count => format!("{count} clocks"),
        };
        let mut text = heading(&[
            format!(
                "The machine '{}': {}; {} words, {clocks} per cycle.",
                hardware.machine.name,
                groups.join(", "),
                hardware.machine.number,
            ),
            format!(
                "Programs whose manifest has the machine hash {} fit.",
                hardware.hash()
            ),
            String::new(),
            "Parameters".to_owned(),
            "  INITIAL   1: the memories and the program's length hold the images from".to_owned(),
            "            configuration on; 0: everything comes through the host's bus".to_owned(),
            "  IMAGES    how the path of every image begins".to_owned(),
            "  CYCLES, SCHEDULE_HASH   of the program in these images".to_owned(),
            String::new(),
            "Ports".to_owned(),
            "  reset       synchronous; memories keep their content".to_owned(),
            "  host_...    the host's bus: host_window tells its addresses".to_owned(),
            "  results     what is on the elements' buses, element 0 lowest, in the".to_owned(),
            "              cycle `results_cycle` of the program; for benches".to_owned(),
            "  results_running   both mean something: one clock in every cycle".to_owned(),
        ]);
        let _ = write!(
            text,
            "module robovec_machine #(\n    parameter INITIAL = 1,\n    \
             parameter IMAGES = \"../img/{}.\",\n    parameter CYCLES = {},\n    \
             parameter [63:0] SCHEDULE_HASH = 64'h{}\n) (\n",
            program.function, program.cycles, program.schedule_hash,
        );
        for (direction, width, name) in [
            ("input ", 0, "clock"),
            ("input ", 0, "reset"),
            ("input ", 0, "host_write"),
            ("input ", 0, "host_read"),
            ("input ", self.window.address_bits, "host_address"),
            ("input ", 32, "host_writedata"),
            ("output", 32, "host_readdata"),
            ("output", 0, "host_readvalid"),
            ("output", 0, "running"),
            ("output", self.elements * self.width, "results"),
            ("output", self.cycle_bits(), "results_cycle"),
        ] {
            let range = if width == 0 {
                String::new()
            } else {
                range(width) + " "
            };
            let _ = writeln!(text, "    {direction} {range}{name},");
        }
        text + "    output results_running\n);\n\n"
    }

    fn control(&self) -> String {
        let hardware = self.hardware;
        let phases = hardware.phases();
        let cycle = self.cycle_bits();
        format!(
            "    wire start;\n    wire finished;\n    wire {length} cycles;\n    \
             wire {phase} phase;\n    wire advance;\n    wire {address} fetch_address;\n    \
             wire fetched;\n    wire active;\n\n    \
             sequencer #(\n        .ADDRESS({cycle}), .PHASES({phases}), .PHASE_BITS({phase_bits})\n    \
             ) counter (\n        .clock(clock), .reset(reset),\n        \
             .start(start), .cycles(cycles),\n        .phase(phase), .advance(advance),\n        \
             .fetch_address(fetch_address), .fetched(fetched),\n        \
             .active(active), .cycle(results_cycle),\n        \
             .running(running), .finished(finished)\n    );\n\n    \
             assign results_running = active & advance;\n\n    \
             wire unit_access;\n    wire unit_write;\n    wire {host} unit_address;\n    \
             wire {limbs} unit_data;\n    wire {word} unit_word;\n    \
             wire unused_limbs = &{{1'b0, unit_data}};\n\n    \
             host_window #(\n        .ADDRESS({host_bits}), .LIMBS({limb_count}), \
             .WIDTH({width}), .CYCLE({cycle}),\n        \
             .CYCLES(INITIAL != 0 ? CYCLES : 0),\n        \
             .SCHEDULE_HASH(INITIAL != 0 ? SCHEDULE_HASH : 64'd0),\n        \
             .MACHINE_HASH(64'h{hash})\n    ) window (\n        \
             .clock(clock), .reset(reset),\n        \
             .host_write(host_write), .host_read(host_read), .host_address(host_address),\n        \
             .host_writedata(host_writedata), .host_readdata(host_readdata),\n        \
             .host_readvalid(host_readvalid),\n        \
             .start(start), .cycles(cycles), .running(running), .finished(finished),\n        \
             .unit_access(unit_access), .unit_write(unit_write), \
             .unit_address(unit_address),\n        \
             .unit_data(unit_data), .unit_word(unit_word)\n    );\n\n",
            length = range(cycle + 1),
            phase = range(phase_bits(phases)),
            address = range(cycle),
            phase_bits = phase_bits(phases),
            host = range(self.window.address_bits),
            host_bits = self.window.address_bits,
            limbs = range(32 * self.limbs()),
            limb_count = self.limbs(),
            word = range(self.width),
            width = self.width,
            hash = hardware.hash(),
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
        bits_of("unit_data", 32 * (self.limbs() - limbs), width)
    }

    fn decoding(&self) -> String {
        let (window, hardware) = (&self.window, self.hardware);
        let block = &window.operands;
        let units = self.elements * hardware.memories();
        let padded = 1u32 << block.unit_bits;
        let mut text = format!(
            "    // The host's accesses to operand memories.\n    \
             wire operand_write = {};\n    \
             wire {} operand_address = {};\n    \
             wire {} host_words;\n    wire {} host_word = {};\n",
            self.commit(block, block.limbs),
            range(block.word_bits),
            bits_of("unit_address", block.limb_bits, block.word_bits),
            range(padded * self.width),
            range(self.width),
            self.host_word(block.limbs, self.width),
        );
        if padded > units {
            let missing = (padded - units) * self.width;
            let _ = writeln!(
                text,
                "    assign {} = {missing}'d0;",
                bits_of("host_words", units * self.width, missing)
            );
        }
        // Words leave the block memories late in a clock, so they are held
        // before one of them is chosen.
        let _ = write!(
            text,
            "    reg {words} host_held;\n    \
             always @(posedge clock) host_held <= host_words;\n",
            words = range(padded * self.width),
        );
        if block.unit_bits > 0 {
            let _ = write!(
                text,
                "    reg {unit} unit_read;\n    reg {unit} unit_held;\n    \
                 always @(posedge clock) begin\n        \
                 unit_read <= {};\n        unit_held <= unit_read;\n    end\n    \
                 assign unit_word = host_held[unit_held*{width} +: {width}];\n",
                bits_of("unit_address", block.unit_low(), block.unit_bits),
                unit = range(block.unit_bits),
                width = self.width,
            );
        } else {
            text += "    assign unit_word = host_held;\n";
        }
        let block = &window.instructions;
        let _ = writeln!(
            text,
            "    wire {} instruction_address = {};\n",
            range(block.word_bits),
            bits_of("unit_address", block.limb_bits, block.word_bits),
        );
        text
    }

    fn crossbar(&self) -> String {
        let hardware = self.hardware;
        let sources = hardware.sizes().sources();
        let width = self.width;
        let mut text = format!(
            "    // What the crossbar chooses from. While the host writes an operand, every\n    \
             // select is 0, and these sources carry its word to the memories.\n    \
             wire {all} on_buses;\n    wire {all} sources;\n",
            all = range(sources * width),
        );
        let carried = host_sources(hardware);
        for source in 0..sources {
            let place = bits_of("on_buses", source * width, width);
            let value = if carried.binary_search(&source).is_ok() {
                format!("unit_access ? host_word : {place}")
            } else {
                place
            };
            let _ = writeln!(
                text,
                "    assign {} = {value};",
                bits_of("sources", source * width, width)
            );
        }
        let _ = writeln!(
            text,
            "    assign results = {};\n\n    wire {} selects;\n    wire {} arriving;\n    \
             robovec_crossbar crossbar (\n        .sources(sources), .selects(selects), \
             .host(host_word),\n        .words(arriving)\n    );\n",
            bits_of("on_buses", 0, self.elements * width),
            range(self.elements * self.ports() * self.select),
            range(self.elements * self.ports() * width),
        );
        text
    }

    fn element(&self, index: u32, name: &str) -> String {
        let hardware = self.hardware;
        let Some((_, group)) = hardware.names().nth(index as usize) else {
            return String::new();
        };
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
            format!("        .buffered({}),\n", super::text::joined(&reads))
        });
        format!(
            "    {module} #(\n        .INITIAL(INITIAL), .INSTRUCTIONS({{IMAGES, \
             \"{name}.instructions\"}}),\n        {images}\n    ) {name} (\n        \
             .clock(clock), .advance(advance), .phase(phase),\n        \
             .fetch_address(fetch_address), .fetched(fetched),\n        \
             .selects({selects}),\n        .arriving({arriving}),\n{buffered}        \
             .host_instruction_write({commit} & {own}),\n        \
             .host_instruction_address(instruction_address),\n        \
             .host_instruction({instruction}),\n        \
             .host_access(unit_access), .host_write({writes}),\n        \
             .host_address(operand_address), .host_words({words}),\n        \
             .result({result})\n    );\n\n",
            module = element::module_name(group),
            selects = bits_of("selects", index * ports * self.select, ports * self.select),
            arriving = bits_of("arriving", index * ports * width, ports * width),
            buffered = buffered.unwrap_or_default(),
            commit = self.commit(block, limbs),
            own = equals("unit_address", block.unit_low(), block.unit_bits, index),
            instruction = self.host_word(limbs, layout.width()),
            writes = super::text::joined(&writes),
            words = bits_of("host_words", index * memories * width, memories * width),
            result = bits_of("on_buses", index * width, width),
        )
    }
}
