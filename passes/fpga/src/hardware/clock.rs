//! The clock of a machine: one model for every command.
//!
//! The delay of a stage of an operator is that of its steps
//! ([`CoreStep`](crate::rtl::cores::CoreStep)), from the figures of the device
//! ([`Device`]). The path between the operators is short and known: operands
//! come from a block memory, results cross the crossbar into one. Delays of
//! nets lie between two bounds, so every estimate is a range.
//!
//! **Invariant.** A machine on a device has one clock: reports, searches,
//! studies of robovec's own hardware and projects take it from [`clock`], and
//! published clocks are distinguished by their origin.

use super::shape::MachineShape;
use crate::rtl::cores::{self, OperatorCore, stage_delay};
use crate::rtl::cores_of;
use robovec_ir::machine::{ClockOrigin, Device, ElementDescription};
use robovec_ir::{Format, Machine};
use robovec_num::NumberFormat;
use serde::Serialize;

/// A clock, MHz.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Estimate {
    /// With slow nets.
    pub low: f64,
    /// Between the two.
    pub mid: f64,
    /// With fast nets.
    pub high: f64,
}

/// The clock of a machine, with its origin.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct MachineClock {
    /// Of a cycle, MHz.
    pub mhz: f64,
    /// Origin of the clock.
    pub origin: ClockOrigin,
}

impl MachineClock {
    /// The time of this number of cycles, in microseconds.
    pub fn microseconds(&self, cycles: u32) -> f64 {
        f64::from(cycles) / self.mhz
    }

    /// The clock and its origin, for users.
    pub fn text(&self) -> String {
        let megahertz = (self.mhz * 10.0).round() / 10.0;
        format!("{megahertz} MHz ({})", self.origin.name())
    }
}

/// The clock of a machine's elements: the declared or measured one of the
/// machine file, else the middle of the estimate. Figures published for other
/// hardware do not count.
pub fn clock(machine: &Machine) -> MachineClock {
    match (machine.clock_mhz, machine.clock_origin) {
        (Some(mhz), origin @ (ClockOrigin::Declared | ClockOrigin::Measured)) => {
            MachineClock { mhz, origin }
        }
        _ => MachineClock {
            mhz: estimated_clock_mhz(machine).mid,
            origin: ClockOrigin::Estimated,
        },
    }
}

/// The clock of a machine with other numbers of elements: kinds and counts.
pub fn clock_with_elements<'a>(
    machine: &Machine,
    counts: impl Iterator<Item = (&'a str, u32)> + Clone,
) -> MachineClock {
    let mut machine = machine.clone();
    for element in &mut machine.elements {
        let mut counts = counts.clone();
        if let Some((_, count)) = counts.find(|(kind, _)| *kind == element.kind) {
            element.count = count;
        }
    }
    clock(&machine)
}

/// The clock for studies of published tables: the published one, where there is
/// one, else that of [`clock`].
pub fn published_clock(machine: &Machine) -> MachineClock {
    match (machine.clock_mhz, machine.clock_origin) {
        (Some(mhz), origin @ ClockOrigin::Published) => MachineClock { mhz, origin },
        _ => clock(machine),
    }
}

/// The estimate for a machine's elements: of a cycle, which has several clocks
/// where memories are shared in time. Its quality is described in the device's
/// `origin`.
pub fn estimated_clock_mhz(machine: &Machine) -> Estimate {
    // Neither the length of programs nor their words matter.
    estimate_of(&MachineShape::of(machine, 1024, 1024))
}

/// The estimate for hardware of a shape.
pub fn estimate_of(shape: &MachineShape) -> Estimate {
    let nets = shape.device.nets;
    let [quick, slow] = [nets.quick, nets.slow].map(|net| period(shape, net));
    Estimate {
        low: 1e6 / slow,
        mid: 2e6 / (quick + slow),
        high: 1e6 / quick,
    }
}

/// The longest of all paths of a cycle, ps.
fn period(shape: &MachineShape, net: u32) -> f64 {
    let cells = &shape.device.cells;
    let mut longest = f64::from(crossbar(shape, net));
    for kind in &shape.kinds {
        let element = element(&kind.element, shape.number, shape.device, net);
        longest = longest.max(f64::from(element));
    }
    let phases = f64::from(shape.phases());
    if shape.phases() > 1 {
        // In every clock a port takes another address.
        let address = cells.register + cells.table_slowest + cells.memory_address + 2 * net;
        longest = longest.max(phases * f64::from(address));
    }
    longest.max(phases * 1e6 / shape.device.blocks.memory_mhz)
}

/// From a buffer's address through the buffer and the crossbar into a memory.
fn crossbar(shape: &MachineShape, net: u32) -> u32 {
    let cells = &shape.device.cells;
    let mut levels = 0;
    let mut left = shape.sources();
    while left > 1 {
        left = left.div_ceil(4);
        levels += 1;
    }
    let buffer = if shape.buffer.is_some() {
        cells.logic_memory + net
    } else {
        0
    };
    cells.register + net + buffer + levels * (cells.table_slowest + net) + cells.memory_data
}

/// The longest path of the operators of an element, ps.
fn element(element: &ElementDescription, number: Format, device: &Device, net: u32) -> u32 {
    let periods = cores_of(element).into_iter().map(|core| match number {
        Format::Float(format) => operator_period(core, format, element.stages, device, net),
        Format::Fixed(_) => fixed(core, number.width(), device, net),
    });
    periods.fold(0, u32::max)
}

/// The longest path of an operator whose operands come from a block memory,
/// ps: where nets take so long.
pub fn operator_period(
    core: OperatorCore,
    format: NumberFormat,
    stages: u32,
    device: &Device,
    net: u32,
) -> u32 {
    let mask = cores::cuts(core, format, stages, device).mask;
    let steps = core.steps_with_nets(format, device, net);
    let (mut worst, mut first) = (0, 0);
    for last in (0..steps.len()).filter(|last| mask >> last & 1 == 1) {
        let from = match first {
            0 => device.cells.memory,
            _ => device.cells.register,
        };
        worst = worst.max(from + stage_delay(&steps[first..=last]));
        first = last + 1;
    }
    worst
}

/// A carry chain, or a product and a carry chain, in one stage: there are no
/// cores of fixed point.
fn fixed(core: OperatorCore, width: u32, device: &Device, net: u32) -> u32 {
    let cells = &device.cells;
    let chain = cells.chain + cells.carry * width + net;
    let product = match core {
        OperatorCore::Multiply => cells.multiplier + net,
        _ => 0,
    };
    cells.memory + net + product + chain
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::machine::{DeviceFamily, MemoryStyle};

    fn with_stages(add: u32, multiply: u32) -> Machine {
        let mut machine = Machine::built_in("side-split").expect("it ships");
        machine.elements[0].stages = add;
        machine.elements[1].stages = multiply;
        machine
    }

    #[test]
    #[ignore = "prints the stages of the operators"]
    fn stages_of_operators() {
        for family in DeviceFamily::ALL {
            let device = family.device();
            for (core, stages) in [(OperatorCore::Add, 10), (OperatorCore::Multiply, 5)] {
                let binary32 = NumberFormat::BINARY32;
                let cuts = cores::cuts(core, binary32, stages, device);
                let steps = core.steps(binary32, device);
                let mut first = 0;
                println!("{} {core:?} {stages} {:x}", device.name, cuts.mask);
                for last in (0..steps.len()).filter(|last| cuts.mask >> last & 1 == 1) {
                    println!("  {first}..{last} {}", stage_delay(&steps[first..=last]));
                    first = last + 1;
                }
            }
        }
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
