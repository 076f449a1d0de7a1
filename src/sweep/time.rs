//! Cycles and time of one function on one machine, for reports.

use robovec_ir::{Machine, Module};
use robovec_passes::place::{PlaceError, PlaceOptions, place};
use serde::Serialize;

/// The clock at which the thesis' design ran (thesis 1.3), MHz.
pub const AS_BUILT_MHZ: f64 = 25.0;

/// What one evaluation takes on a machine.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct FpgaTime {
    /// Length of the schedule, cycles.
    pub cycles: u32,
    /// No schedule is shorter.
    pub lower_bound: u32,
    /// At the clock at which the thesis' design ran, µs.
    pub as_built_us: f64,
    /// The clock hoped for, MHz.
    pub clock_mhz: f64,
    /// At that clock, µs.
    pub at_clock_us: f64,
}

/// Places the function of a module that holds it alone, at level atomic, and
/// tells its time at the thesis' clock and at `clock_mhz` (the machine's own
/// where there is none, or an estimate).
///
/// # Errors
///
/// When the machine cannot perform it.
pub fn fpga_time(
    module: &Module,
    machine: &Machine,
    clock_mhz: Option<f64>,
) -> Result<FpgaTime, PlaceError> {
    let mut function = module.functions[0].clone();
    let summary = place(&mut function, machine, PlaceOptions::default())?;
    let clock_mhz = clock_mhz.unwrap_or(machine.clock_mhz);
    let cycles = f64::from(summary.cycles);
    Ok(FpgaTime {
        cycles: summary.cycles,
        lower_bound: summary.lower_bound,
        as_built_us: cycles / AS_BUILT_MHZ,
        clock_mhz,
        at_clock_us: cycles / clock_mhz,
    })
}
