//! Resources of a device that a machine takes, by number format: an estimate.
//!
//! The formulas are those of [`robovec_fpga::hardware`], for the hardware that
//! `robovec rtl` writes. There is no synthesis.

use super::placing::{placed, words_of_a_side};
use robovec_fpga::hardware::{self, MachineClock, MachineShape, ResourceUse};
use robovec_ir::machine::Device;
use robovec_ir::{Format, Function, Machine, Module};
use robovec_schedule::{PlaceOptions, most_memory_words};
use serde::Serialize;

/// Resources of a machine.
#[derive(Clone, Copy, PartialEq, Default, Debug, Serialize)]
pub struct DeviceShare {
    /// Look-up tables.
    pub look_up_tables: f64,
    /// Memory blocks.
    pub memory_blocks: f64,
    /// Multiplier blocks.
    pub multiplier_blocks: f64,
}

impl DeviceShare {
    /// Largest of the three shares of a device; above 1 it does not fit.
    pub fn share(&self, device: &Device) -> f64 {
        let capacity = &device.capacity;
        let shares = [
            self.look_up_tables / capacity.look_up_tables,
            self.memory_blocks / capacity.memory_blocks,
            self.multiplier_blocks / capacity.multiplier_blocks,
        ];
        shares.into_iter().fold(0.0, f64::max)
    }
}

/// Speed and cost of a machine for a schedule.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MachineFigures {
    /// The clock, with its origin.
    pub clock: MachineClock,
    /// Time of the schedule at that clock, µs.
    pub microseconds: f64,
    /// Resources of the device that the machine uses.
    pub resources: DeviceShare,
    /// The largest of its shares of the device ([`DeviceShare::share`]).
    pub share: f64,
}

/// Figures of a machine in a format, for a program of some cycles and at most
/// some words per element. A memory in logic counts as tables.
pub fn figures(machine: &Machine, format: Format, cycles: u32, words: u32) -> MachineFigures {
    let machine = Machine {
        number: format,
        ..machine.clone()
    };
    let device = machine.device.device();
    let resources = taken_by(&MachineShape::of(&machine, cycles, words), device);
    let clock = hardware::clock(&machine);
    MachineFigures {
        clock,
        microseconds: clock.microseconds(cycles),
        resources,
        share: resources.share(device),
    }
}

/// Resources of a device that hardware takes, counted as [`figures`] does.
pub fn taken_by(shape: &MachineShape, device: &Device) -> DeviceShare {
    taken_in_all(&hardware::resources(shape), device)
}

/// Resources of a machine, counted as [`figures`] does.
pub fn taken_in_all(taken: &ResourceUse, device: &Device) -> DeviceShare {
    let capacity = &device.capacity;
    DeviceShare {
        look_up_tables: capacity.tables_per_adaptive * taken.aluts
            + capacity.tables_per_memory * taken.lab_memories,
        memory_blocks: taken.memory_blocks,
        multiplier_blocks: taken.multiplier_blocks,
    }
}

/// The schedule of a module's first function, cycles, and the machine's share
/// of the device with memories for it; `None` where it cannot hold it.
pub fn placed_share(module: &Module, machine: &Machine) -> Option<(u32, f64)> {
    let placed = placed(module, machine, PlaceOptions::default()).ok()?;
    let cycles = placed.summary.cycles;
    let figures = figures(machine, machine.number, cycles, placed.most_words(machine));
    Some((cycles, figures.share))
}

/// The share of the device that a machine takes with memories for a function
/// that is placed on it; `None` for one that is not.
pub fn share_of_placed(function: &Function, machine: &Machine) -> Option<f64> {
    let cycles = function.schedule.as_ref()?.cycles;
    let words = words_of_a_side(most_memory_words(function)?, machine);
    Some(figures(machine, machine.number, cycles, words).share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrower_formats_and_fewer_elements_take_less() {
        let machine = Machine::built_in("thesis").expect("it ships");
        let of = |format: &str| {
            let format = format.parse().expect("it is a format");
            figures(&machine, format, 1024, 2048).resources
        };
        let (half, single, double) = (of("f16"), of("f32"), of("f64"));
        let device = machine.device.device();
        let shares = [half, single, double].map(|taken| taken.share(device));
        assert!(shares.is_sorted_by(|a, b| a < b), "{shares:?}");
        assert_eq!(
            [half, single, double].map(|taken| taken.multiplier_blocks),
            [2.0, 4.0, 16.0]
        );
        // The thesis prints 120 blocks of memory for this machine.
        assert!((90.0..130.0).contains(&single.memory_blocks));
    }
}
