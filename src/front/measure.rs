//! Making the programs of the choices, and measuring them.
//!
//! Choices that start with the same stages share their work: programs are
//! kept by the stages that made them.

use super::choice::Choice;
use super::yardstick::{Errors, Unmeasurable, Yardstick};
use crate::generate::Formulation;
use crate::study::cpu;
use robovec_analysis::critical_path::critical_path;
use robovec_ir::count::Counts;
use robovec_ir::{Format, Machine, Module, Operation, View};
use robovec_passes::codegen::c::Real;
use robovec_passes::manager::{self, Config};
use robovec_passes::pipeline;
use robovec_passes::place::{PlaceOptions, place};
use robovec_passes::scene::Scene;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;

/// A choice, measured in a format.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Point {
    /// The choice's name.
    pub choice: String,
    /// True for what the thesis could choose.
    pub thesis: bool,
    /// The number format.
    pub format: String,
    /// Passes.
    pub pipeline: String,
    /// Operations; sines and cosines apart.
    pub operations: usize,
    /// The longest chain, in cycles of the machine.
    pub path: u32,
    /// Length of the schedule for each number of elements per kind, in
    /// cycles; `None` where the machine cannot hold the program.
    pub cycles: Vec<Option<u32>>,
    /// The same in microseconds at the machine's clock.
    pub microseconds: Vec<Option<f64>>,
    /// Time of one call on one core of this computer, ns; `None` when it was
    /// not measured.
    pub cpu_ns: Option<f64>,
    /// Errors relative to the element, everything included: series and
    /// rounding.
    pub relative: super::yardstick::Spread,
    /// Errors over the largest element of the array.
    pub normwise: super::yardstick::Spread,
    /// The output with the largest normwise error, and the state.
    pub worst: (String, usize),
}

/// Why a choice could not be measured.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum MeasureError {
    /// A pipeline that is none.
    #[error("'{0}' is no pipeline")]
    Pipeline(String),
    /// A pass gave up.
    #[error("{0}")]
    Pass(String),
    /// The program is about something else.
    #[error(transparent)]
    Unmeasurable(#[from] Unmeasurable),
}

/// Programs by formulation and stages.
pub struct Workshop<'a> {
    machine: &'a Machine,
    start: BTreeMap<&'static str, Arc<Module>>,
    made: BTreeMap<(&'static str, Vec<String>), Arc<Module>>,
}

/// The name under which equations as they came are kept.
const AS_THEY_CAME: &str = "";

impl<'a> Workshop<'a> {
    /// A workshop for a module of one function.
    pub fn new(machine: &'a Machine, module: Module) -> Workshop<'a> {
        Workshop {
            machine,
            start: BTreeMap::from([(AS_THEY_CAME, Arc::new(module))]),
            made: BTreeMap::new(),
        }
    }

    /// Adds the same function in another formulation.
    pub fn add(&mut self, formulation: Formulation, module: Module) {
        self.start.insert(formulation.name(), Arc::new(module));
    }

    /// The program of a choice.
    ///
    /// # Errors
    ///
    /// When a stage is no pipeline or a pass gives up. A formulation that was
    /// not added is an error of the caller and gives [`MeasureError::Pass`].
    pub fn program(&mut self, choice: &Choice) -> Result<Arc<Module>, MeasureError> {
        let start = choice.formulation.map_or(AS_THEY_CAME, Formulation::name);
        let missing = || MeasureError::Pass(format!("there are no equations '{start}'"));
        let mut module = self.start.get(start).cloned().ok_or_else(missing)?;
        for count in 1..=choice.stages.len() {
            let key = (start, choice.stages[..count].to_vec());
            if let Some(known) = self.made.get(&key) {
                module = known.clone();
                continue;
            }
            let next = run(&module, &choice.stages[count - 1], self.machine)?;
            module = Arc::new(next);
            self.made.insert(key, module.clone());
        }
        Ok(module)
    }
}

/// What a pipeline makes of a module.
pub(crate) fn run(module: &Module, stage: &str, machine: &Machine) -> Result<Module, MeasureError> {
    run_scene(module, stage, machine, None)
}

/// What a pipeline makes of a module for a scene.
pub(crate) fn run_scene(
    module: &Module,
    stage: &str,
    machine: &Machine,
    scene: Option<&Scene>,
) -> Result<Module, MeasureError> {
    let passes = pipeline::parse(stage).map_err(|_| MeasureError::Pipeline(stage.to_owned()))?;
    let mut module = module.clone();
    let mut log = io::sink();
    let config = Config {
        scene,
        ..Config::new(machine, &mut log)
    };
    manager::run(&mut module, &passes, config)
        .map_err(|error| MeasureError::Pass(error.to_string()))?;
    Ok(module)
}

/// The first function of a module, with its tables.
pub(crate) fn view(module: &Module) -> View<'_> {
    View {
        tables: &module.tables,
        function: &module.functions[0],
    }
}

/// A machine with so many adders and multipliers (or fused elements) each.
pub fn with_elements(machine: &Machine, count: u32) -> Machine {
    let mut machine = machine.clone();
    for operation in [Operation::Add, Operation::Mul, Operation::Fma] {
        if let Some(kind) = machine.kind_of(operation) {
            machine.elements[kind].count = count;
        }
    }
    machine
}

/// The length of a program's schedule with so many elements per kind; `None`
/// where it cannot be placed.
pub fn cycles(module: &Module, machine: &Machine, elements: u32) -> Option<u32> {
    let machine = with_elements(machine, elements);
    let mut function = module.functions[0].clone();
    let placed = place(&mut function, &machine, PlaceOptions::default()).ok()?;
    Some(placed.cycles)
}

/// Measures a program in each of the choice's formats.
///
/// # Errors
///
/// When program and yardstick do not fit.
pub fn measure(
    choice: &Choice,
    module: &Module,
    machine: &Machine,
    elements: &[u32],
    yardstick: &Yardstick,
) -> Result<Vec<Point>, MeasureError> {
    let view = view(module);
    let counts = Counts::of(view.function);
    let path = critical_path(view.function, machine).asap_cycle;
    let cycles: Vec<Option<u32>> = elements
        .iter()
        .map(|&count| cycles(module, machine, count))
        .collect();
    let time = |cycles: &Option<u32>| Some(f64::from((*cycles)?) / machine.clock_mhz);
    let point = |format: &Format| {
        let errors = yardstick.errors(view, *format)?;
        Ok(Point {
            choice: choice.name.clone(),
            thesis: choice.thesis,
            format: format.to_string(),
            pipeline: choice.stages.join(","),
            operations: counts.operations,
            path,
            cycles: cycles.clone(),
            microseconds: cycles.iter().map(time).collect(),
            cpu_ns: None,
            relative: errors.relative,
            normwise: errors.normwise,
            worst: worst(&errors),
        })
    };
    choice.formats.iter().map(point).collect()
}

/// Times a program on this computer, in the formats that C has. Where there is
/// no compiler, times stay away.
pub(super) fn time(module: &Module, points: &mut [Point]) {
    for point in points {
        let real = match point.format.as_str() {
            "f32" => Real::Float,
            "f64" => Real::Double,
            _ => continue,
        };
        point.cpu_ns = cpu::compile_and_run(view(module), real).ok();
    }
}

fn worst(errors: &Errors) -> (String, usize) {
    let mut worst: Option<&super::yardstick::OutputError> = None;
    for output in &errors.outputs {
        if worst.is_none_or(|worst| output.normwise > worst.normwise) {
            worst = Some(output);
        }
    }
    worst.map_or((String::new(), 0), |output| {
        (output.name.clone(), output.worst_state)
    })
}
