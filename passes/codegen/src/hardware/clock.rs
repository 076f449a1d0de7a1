//! The clock of a machine: an estimate without any tool.
//!
//! The delays of the operators are those of the mapped cores, tabulated by
//! latency; what stands between them is short and known: operands come from
//! a block memory, results cross the crossbar into one. Delays of cells are
//! published, those of nets are not, so every estimate is a range.
//!
//! **Invariant.** The tables are what `robovec synthesise --delays` prints
//! (yosys 0.70, binary32 with subnormal numbers); a test compares them when
//! yosys is installed. They were never calibrated against Quartus.

use super::shape::MachineShape;
use crate::rtl::cores::{self, OperatorCore};
use robovec_ir::machine::ElementDescription;
use robovec_ir::{Format, Machine, Operation};
use robovec_num::NumberFormat;
use serde::Serialize;

/// The delay of a net, ps: the lower and the upper guess.
const NETS: [u32; 2] = [500, 900];

/// Clock to output of a register and of a block memory, and the set-up time
/// of a block memory's data and address, ps (yosys' `intel_alm` cells).
const REGISTER: u32 = 731;
const MEMORY: u32 = 1004;
const MEMORY_DATA: u32 = 97;
const MEMORY_ADDRESS: u32 = 125;

/// A look-up table through its slowest input, and a memory in logic.
const TABLE: u32 = 605;
const LOGIC_MEMORY: u32 = 487;

/// The highest clock of a block memory, MHz (thesis 1.3).
const MEMORY_MHZ: f64 = 240.0;

/// Adders of 1 stage and more: from an operand to a register and from register
/// to register with quick nets, then both with slow ones, ps.
const ADDER: [[u32; 4]; 16] = [
    [25266, 0, 33986, 0],
    [13507, 13554, 18307, 18661],
    [9184, 11128, 13460, 14728],
    [7515, 8991, 10706, 11791],
    [5410, 8015, 7410, 10415],
    [5410, 6865, 7410, 9665],
    [5410, 7039, 7410, 8639],
    [4703, 6139, 6303, 7339],
    [4703, 6139, 6303, 7339],
    [3803, 6139, 5003, 7339],
    [3803, 6063, 5303, 7263],
    [3803, 4226, 5003, 6225],
    [3803, 4225, 5003, 6225],
    [3803, 4225, 5003, 6225],
    [3803, 4225, 5003, 6225],
    [3803, 4225, 5003, 6225],
];

/// The same for multipliers.
const MULTIPLIER: [[u32; 4]; 13] = [
    [19091, 0, 26849, 0],
    [9865, 11227, 14529, 15227],
    [6895, 9530, 10774, 11930],
    [4800, 9530, 7600, 11930],
    [4506, 7244, 6906, 8844],
    [4506, 6786, 6906, 9511],
    [4506, 6777, 6906, 9577],
    [4506, 6127, 6906, 9025],
    [4506, 6432, 6906, 9511],
    [4506, 6361, 6906, 9399],
    [3909, 5876, 6300, 8585],
    [4506, 6432, 6906, 9232],
    [4506, 6432, 7297, 9440],
];

/// A clock, MHz.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Estimate {
    /// With 900 ps per net.
    pub low: f64,
    /// Between the two.
    pub mid: f64,
    /// With 500 ps per net.
    pub high: f64,
}

/// The clock of a machine's elements: of a cycle, which has several clocks
/// where memories are shared in time. An estimate from published delays of
/// cells for a Cyclone V of speed grade 7, neither placed nor routed nor
/// calibrated.
pub fn estimated_clock_mhz(machine: &Machine) -> Estimate {
    let shape = MachineShape::of(machine, 1024, 1024);
    let [quick, slow] = [0, 1].map(|guess| period(&shape, guess));
    Estimate {
        low: 1e6 / slow,
        mid: 2e6 / (quick + slow),
        high: 1e6 / quick,
    }
}

/// The delays of an operator of binary32 by latency: from an operand to a
/// register, and from register to register, ps; `guess` 0 for quick nets, 1
/// for slow ones. Latencies beyond the table are no quicker. None for the
/// operators that are not tabulated.
pub fn tabulated(core: OperatorCore, stages: u32, guess: usize) -> Option<[u32; 2]> {
    let table: &[[u32; 4]] = match core {
        OperatorCore::Add => &ADDER,
        OperatorCore::Multiply => &MULTIPLIER,
        OperatorCore::Divide | OperatorCore::Root | OperatorCore::Fused => return None,
    };
    let place = (stages.max(1) as usize).min(table.len()) - 1;
    let row = table[place];
    Some([row[2 * guess], row[2 * guess + 1]])
}

/// The longest of all paths of a cycle, ps.
fn period(shape: &MachineShape, guess: usize) -> f64 {
    let net = NETS[guess];
    let mut longest = f64::from(crossbar(shape, net));
    for kind in &shape.kinds {
        longest = longest.max(element(&kind.element, shape.number, guess));
    }
    let phases = f64::from(shape.phases());
    if shape.phases() > 1 {
        // In every clock a port takes another address.
        let address = f64::from(REGISTER + TABLE + MEMORY_ADDRESS + 2 * net);
        longest = longest.max(phases * address);
    }
    longest.max(phases * 1e6 / MEMORY_MHZ)
}

/// From a buffer's address through the buffer and the crossbar into a memory.
fn crossbar(shape: &MachineShape, net: u32) -> u32 {
    let mut levels = 0;
    let mut left = shape.sources();
    while left > 1 {
        left = left.div_ceil(4);
        levels += 1;
    }
    let buffer = if shape.buffer.is_some() {
        LOGIC_MEMORY + net
    } else {
        0
    };
    REGISTER + net + buffer + levels * (TABLE + net) + MEMORY_DATA
}

/// The longest path of the operators of an element, ps.
fn element(element: &ElementDescription, number: Format, guess: usize) -> f64 {
    let performed = Operation::ALL.into_iter();
    let performed = performed.filter(|operation| element.performs(*operation));
    let periods = performed
        .filter_map(OperatorCore::of)
        .map(|core| match number {
            Format::Float(format) => {
                let model = slowest(core, format, element.stages);
                match tabulated(core, element.stages, guess) {
                    Some([first, inner]) => {
                        let binary32 = slowest(core, NumberFormat::BINARY32, element.stages);
                        f64::from((MEMORY + first).max(inner)) * model / binary32
                    }
                    // The model has quick nets; slow ones make paths through
                    // logic three tenths longer, as in the tables.
                    None => f64::from(MEMORY) + model * [1.0, 1.3][guess],
                }
            }
            Format::Fixed(_) => f64::from(fixed(core, number.width(), NETS[guess])),
        });
    periods.fold(0.0, f64::max)
}

/// The slowest stage by the cores' own model, which carries the table over
/// to other formats.
fn slowest(core: OperatorCore, format: NumberFormat, stages: u32) -> f64 {
    let mask = cores::cuts(core, format, stages).mask;
    let (mut worst, mut stage) = (1, 0);
    for (place, step) in (0_u32..).zip(core.steps(format)) {
        stage += step.delay;
        worst = worst.max(stage);
        if mask >> place & 1 == 1 {
            stage = 0;
        }
    }
    f64::from(worst)
}

/// A carry chain, or a product and a carry chain, in one stage: there are no
/// cores of fixed point.
fn fixed(core: OperatorCore, width: u32, net: u32) -> u32 {
    let chain = 1342 + 36 * width + 368 + net;
    let product = match core {
        OperatorCore::Multiply => 3928 + net,
        _ => 0,
    };
    MEMORY + net + product + chain
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::machine::MemoryStyle;

    fn with_stages(add: u32, multiply: u32) -> Machine {
        let mut machine = Machine::built_in("side-split").expect("it ships");
        machine.elements[0].stages = add;
        machine.elements[1].stages = multiply;
        machine
    }

    #[test]
    fn more_stages_are_faster_within_the_range_of_the_thesis() {
        let clocks: Vec<Estimate> = [(1, 2), (3, 3), (5, 5), (10, 8)]
            .map(|(add, multiply)| estimated_clock_mhz(&with_stages(add, multiply)))
            .to_vec();
        for pair in clocks.windows(2) {
            assert!(pair[0].mid < pair[1].mid, "{pair:?}");
        }
        for clock in &clocks {
            assert!(clock.low < clock.mid && clock.mid < clock.high);
        }
        // Table 1.3 has 37 MHz for the first of these.
        assert!((25.0..45.0).contains(&clocks[0].mid), "{:?}", clocks[0]);
    }

    #[test]
    fn pumped_memories_and_wide_formats_are_slower() {
        let split = estimated_clock_mhz(&with_stages(14, 9));
        let mut pumped = with_stages(14, 9);
        pumped.memory.style = MemoryStyle::Unified;
        pumped.memory.writes = Some(2);
        // 240 MHz for two clocks of a cycle, as the thesis has it.
        let pumped = estimated_clock_mhz(&pumped);
        assert!(pumped.high <= 120.0 && split.high >= pumped.high);
        let mut wide = with_stages(14, 9);
        wide.number = "f64".parse().expect("it is a format");
        assert!(estimated_clock_mhz(&wide).mid < split.mid);
        wide.number = "fixed(12,19)".parse().expect("it is a format");
        assert!(estimated_clock_mhz(&wide).mid > 20.0);
    }
}
