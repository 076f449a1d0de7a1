//! The cheapest program and machine that a scene can do with.
//!
//! A scene says which outputs are needed, how exact (tolerances) and how soon
//! (a deadline). Many things can be chosen: the formulation of the equations,
//! the passes, how sines and cosines are computed, the number format, the
//! number of elements. They are chosen in this order, each against the
//! scene's own tolerances and deadline, by measurement:
//!
//! 1. programs ([`variants`]): every formulation specialised to the scene,
//!    with the equations as short or as few as the passes make them;
//! 2. series ([`series`]): of each method the least order whose error leaves
//!    room for rounding;
//! 3. format ([`format`]): the narrowest exponent that holds what occurs, the
//!    narrowest mantissa that meets the tolerances, found by halving;
//! 4. elements ([`size`]): the fewest that meet the deadline, and more of
//!    them for the front.
//!
//! What comes out is a list of candidates with time, error and cost, the
//! cheapest that meets everything, and the front: the candidates that no other
//! one beats in time, cost and error together.
//!
//! **Invariant.** The chosen candidate is confirmed at states it was not
//! chosen by. Three seeds draw three sets of states: few for the *search*,
//! which orders of series and mantissas are tried at; four times as many for
//! the *validation*, which mantissas must hold at too and which gives the
//! errors of candidates; as many again for the *confirmation*, which also runs
//! some of them cycle by cycle from the memory images ([`confirm`]).

pub mod confirm;
mod format;
pub mod page;
mod ranges;
mod series;
mod size;
pub mod text;
mod variants;

pub use series::{SinePlace, SineTreatment};

use crate::explore::ExplorationProgress;
use crate::explore::device::{self, DeviceShare};
use crate::explore::pareto::{self, EqualPoints};
use crate::explore::program::{ExplorationError, view};
use crate::explore::yardstick::{ErrorSpread, MeasuredErrors, Yardstick};
use crate::generate::Formulation;
use robovec_analysis::critical_path::critical_path;
use robovec_framework::scene::{Measure, Scene};
use robovec_ir::count::Counts;
use robovec_ir::{Format, Machine, Module};
use serde::Serialize;
use std::sync::Arc;

/// How many times as many states as the search has the validation has, and the
/// confirmation: a search measures often and can afford few.
const VALIDATION_FACTOR: u32 = 4;

/// What is searched for, and where.
pub struct FitTask<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The general function of the scene, alone in its module, by which
    /// everything is measured.
    pub general: &'a Module,
    /// The general function in every formulation that is to be tried, each
    /// alone in its module.
    pub formulations: Vec<(Formulation, Module)>,
    /// The machine whose elements, memories and clock are used.
    pub machine: &'a Machine,
    /// Where sines and cosines are computed.
    pub trigonometry: SinePlace,
    /// Random states of the search; the validation and the confirmation take
    /// four times as many each.
    pub states: u32,
    /// The seed of the states of the search; validation and confirmation take
    /// the next two.
    pub seed: u64,
}

/// A program made for the scene.
#[derive(Clone, Debug)]
pub struct FitProgram {
    /// Formulation and passes, in words.
    pub name: String,
    /// The pipeline that made it from the general equations.
    pub pipeline: String,
    /// The formulation it starts from.
    pub formulation: Formulation,
    /// How its sines and cosines are computed.
    pub treatment: SineTreatment,
    /// One function, at the atomic level.
    pub module: Arc<Module>,
    /// The largest error in binary64 over its tolerance, at the states of the
    /// search: that of series and other approximations, next to which
    /// binary64's own rounding is nothing.
    pub model_share: f64,
}

/// A program in a format on a number of elements.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct FitCandidate {
    /// Index of its program in [`FitOutcome::programs`], from 0.
    pub program: usize,
    /// Name of the number format, as [`Format`] prints it.
    pub format: String,
    /// Elements that add, and that multiply.
    pub elements: [u32; 2],
    /// Number of operations of the program.
    pub operations: usize,
    /// The longest chain, in cycles.
    pub path: u32,
    /// Length of the schedule, in cycles.
    pub cycles: u32,
    /// The same at the machine's clock, µs.
    pub microseconds: f64,
    /// Errors at the states of the validation, approximations and rounding
    /// together, relative to each element.
    pub relative: ErrorSpread,
    /// The same errors, relative to the largest element of the array.
    pub normwise: ErrorSpread,
    /// The largest error over its tolerance: at most 1 when all are met; 0
    /// when the scene has no tolerances.
    pub used: f64,
    /// What it takes of the device, estimated.
    pub resources: DeviceShare,
    /// The largest of its shares of the device, which counts as the cost
    /// ([`DeviceShare::share`]).
    pub share: f64,
    /// Tolerances and deadline are met, and the device has room.
    pub meets: bool,
}

/// What was found.
pub struct FitOutcome {
    /// The programs.
    pub programs: Vec<FitProgram>,
    /// Everything that was placed and measured.
    pub candidates: Vec<FitCandidate>,
    /// Index of the cheapest candidate that meets everything, by share of the
    /// device, then look-up tables, then cycles; `None` when none does.
    pub chosen: Option<usize>,
}

/// Why nothing could be searched.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum FitError {
    /// A program could not be made or measured.
    #[error(transparent)]
    Measure(#[from] ExplorationError),
    /// No program could be made at all.
    #[error("no formulation gives a program for this scene: {0}")]
    NoProgram(String),
}

/// Searches programs, formats and numbers of elements for a scene, and measures
/// each; `progress` is told what is tried.
///
/// # Errors
///
/// See [`FitError`]. That nothing meets the scene is no error: the outcome
/// then has no chosen candidate, and its front shows what is possible.
pub fn fit(task: &FitTask<'_>, progress: ExplorationProgress<'_>) -> Result<FitOutcome, FitError> {
    let search = yardstick(task, task.states, task.seed);
    let validation = yardstick(
        task,
        task.states * VALIDATION_FACTOR,
        task.seed.wrapping_add(1),
    );
    let mut programs = variants::programs(task, &search, progress)?;
    series::write(task, &search, &mut programs, progress)?;
    let mut candidates = Vec::new();
    for (index, program) in programs.iter().enumerate() {
        progress(&format!(
            "{}, {}: formats and elements",
            program.name, program.treatment
        ));
        let formats = format::formats(task, program, &search, &validation)?;
        for size in size::sizes(task, program) {
            for (format, errors) in &formats {
                let found = candidate(task, (index, program), *format, errors, &size);
                candidates.push(found);
            }
        }
    }
    let cheapest = candidates
        .iter()
        .enumerate()
        .filter(|(_, candidate)| candidate.meets)
        .min_by(|(_, a), (_, b)| {
            let tables = |candidate: &FitCandidate| candidate.resources.look_up_tables;
            a.share
                .total_cmp(&b.share)
                .then(tables(a).total_cmp(&tables(b)))
                .then(a.cycles.cmp(&b.cycles))
        });
    Ok(FitOutcome {
        chosen: cheapest.map(|(index, _)| index),
        programs,
        candidates,
    })
}

/// The general function's exact results at random states of the scene, which
/// errors are measured against.
fn yardstick(task: &FitTask<'_>, states: u32, seed: u64) -> Yardstick {
    let source = task.scene.states(seed);
    Yardstick::new(view(task.general), &source, states)
}

/// What a program in a format costs and reaches on a machine it is placed on.
fn candidate(
    task: &FitTask<'_>,
    (index, program): (usize, &FitProgram),
    format: Format,
    errors: &MeasuredErrors,
    size: &size::SizedMachine,
) -> FitCandidate {
    let machine = size.machine(task.machine);
    let resources = device::taken(&machine, format, size.cycles, size.words);
    let function = &program.module.functions[0];
    let microseconds = f64::from(size.cycles) / task.machine.clock_mhz;
    let used = largest_tolerance_share(task.scene, program, errors);
    let in_time = task
        .scene
        .deadline
        .is_none_or(|deadline| microseconds <= deadline);
    FitCandidate {
        program: index,
        format: format.to_string(),
        elements: size.elements,
        operations: Counts::of(function).operations,
        path: critical_path(function, task.machine).asap_cycle,
        cycles: size.cycles,
        microseconds,
        relative: errors.relative,
        normwise: errors.normwise,
        used,
        resources,
        share: resources.share(),
        meets: in_time
            && used <= 1.0
            // Infinite when a result was not finite, which a scene without
            // tolerances would let pass.
            && errors.normwise.worst.is_finite()
            && resources.share() <= 1.0,
    }
}

/// The largest error of any output over its tolerance, in the measure the
/// tolerance is of; 0 when no output has a tolerance.
fn largest_tolerance_share(scene: &Scene, program: &FitProgram, errors: &MeasuredErrors) -> f64 {
    let view = view(&program.module);
    let mut largest = 0.0f64;
    for (assignment, output) in view.function.assignments.iter().zip(&errors.outputs) {
        for tolerance in scene.tolerances(view, assignment.output) {
            let error = match tolerance.measure {
                Measure::Norm => output.normwise,
                Measure::Relative => output.relative,
                Measure::Absolute => output.absolute,
            };
            largest = largest.max(error / tolerance.bound);
        }
    }
    largest
}

impl FitOutcome {
    /// Indices of the candidates that no other one dominates in time, share of
    /// the device and worst normwise error, in order of time: of those that
    /// meet the scene, or of all when none does.
    pub fn front(&self) -> Vec<usize> {
        let any_meets = self.candidates.iter().any(|candidate| candidate.meets);
        let is_eligible = |&index: &usize| self.candidates[index].meets || !any_meets;
        let eligible: Vec<usize> = (0..self.candidates.len()).filter(is_eligible).collect();
        let measures = |&index: &usize| {
            let candidate = &self.candidates[index];
            [
                candidate.microseconds,
                candidate.share,
                candidate.normwise.worst,
            ]
        };
        let points: Vec<[f64; 3]> = eligible.iter().map(measures).collect();
        let front = pareto::front(&points, EqualPoints::All).into_iter();
        let mut front: Vec<usize> = front.map(|position| eligible[position]).collect();
        let time = |index: usize| self.candidates[index].microseconds;
        front.sort_by(|&a, &b| time(a).total_cmp(&time(b)).then(a.cmp(&b)));
        front
    }
}
