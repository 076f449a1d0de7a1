//! Measuring the programs of the choices.

use super::choice::FrontChoice;
use crate::device::{self, MachineFigures};
use crate::placing::{placed, with_fused};
use crate::processor;
use crate::program::{ExplorationError, view};
use robovec_analysis::critical_path::critical_path;
use robovec_cgen::c::Real;
use robovec_error::yardstick::{ErrorSpread, LargestErrors, MeasuredErrors, Yardstick};
use robovec_ir::count::Counts;
use robovec_ir::{Format, Machine, Module};
use robovec_schedule::PlaceOptions;
use serde::{Deserialize, Serialize};

/// A choice, measured in a format.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct FrontPoint {
    /// The choice's name.
    pub choice: String,
    /// True for a choice of the thesis.
    pub thesis: bool,
    /// The number format.
    pub format: String,
    /// Passes.
    pub pipeline: String,
    /// Operations; sines and cosines separate.
    pub operations: usize,
    /// The longest chain, in cycles of the machine.
    pub path: u32,
    /// Length of the schedule for each number of elements per kind, in
    /// cycles; `None` where the machine cannot hold the program.
    pub cycles: Vec<Option<u32>>,
    /// The same in microseconds at the machine's clock.
    pub microseconds: Vec<Option<f64>>,
    /// Share of the thesis' device that the machine takes for each number of
    /// elements, with memories for this program: the largest of its shares,
    /// estimated ([`device::DeviceShare::share`]).
    pub shares: Vec<Option<f64>>,
    /// Time of a call on one core of this computer, ns; `None` if not measured.
    pub cpu_ns: Option<f64>,
    /// Errors relative to the element, of series and rounding.
    pub relative: ErrorSpread,
    /// Errors over the largest element of the array.
    pub normwise: ErrorSpread,
    /// The output with the largest normwise error, and the state.
    pub worst: (String, usize),
    /// Largest normwise error that a directed search finds, with real-valued
    /// inputs rounded; `None` for points that others beat in cycles and error.
    #[serde(default)]
    pub found: Option<f64>,
}

/// Measures a program in all of the choice's formats, if it fits the yardstick.
pub(super) fn measure(
    choice: &FrontChoice,
    module: &Module,
    machine: &Machine,
    elements: &[u32],
    yardstick: &Yardstick,
) -> Result<Vec<FrontPoint>, ExplorationError> {
    let view = view(module);
    let counts = Counts::of(view.function);
    let path = critical_path(view.function, machine).asap_cycle;
    let place = |&count: &u32| {
        let machine = with_fused(machine, [count; 2]);
        let placed = placed(module, &machine, PlaceOptions::default()).ok()?;
        let words = placed.most_words(&machine);
        Some((machine, placed.summary.cycles, words))
    };
    let places: Vec<Option<(Machine, u32, u32)>> = elements.iter().map(place).collect();
    let point = |format: &Format| {
        let errors = yardstick.errors(view, *format)?;
        let figures = places.iter().map(|place| {
            let (machine, cycles, words) = place.as_ref()?;
            Some(device::figures(machine, *format, *cycles, *words))
        });
        let figures: Vec<Option<MachineFigures>> = figures.collect();
        Ok(FrontPoint {
            choice: choice.name.clone(),
            thesis: choice.thesis,
            format: format.to_string(),
            pipeline: choice.stages.join(","),
            operations: counts.operations,
            path,
            cycles: places.iter().map(|place| Some(place.as_ref()?.1)).collect(),
            microseconds: figures
                .iter()
                .map(|one| Some(one.as_ref()?.microseconds))
                .collect(),
            shares: figures
                .iter()
                .map(|one| Some(one.as_ref()?.share))
                .collect(),
            cpu_ns: None,
            relative: errors.relative,
            normwise: errors.normwise,
            worst: worst(&errors),
            found: None,
        })
    };
    choice.formats.iter().map(point).collect()
}

/// Times a program on this computer, in the formats of C, if it can.
pub(super) fn time(module: &Module, points: &mut [FrontPoint]) {
    for point in points {
        let real = match point.format.as_str() {
            "f32" => Real::Float,
            "f64" => Real::Double,
            _ => continue,
        };
        point.cpu_ns = processor::compile_and_run(view(module), real).ok();
    }
}

fn worst(errors: &MeasuredErrors) -> (String, usize) {
    let mut worst: Option<&LargestErrors> = None;
    for output in &errors.outputs {
        if worst.is_none_or(|worst| output.normwise > worst.normwise) {
            worst = Some(output);
        }
    }
    worst.map_or((String::new(), 0), |output| {
        (output.name.clone(), output.worst_state)
    })
}
