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
//! What is cheapest is then *challenged* ([`challenge`]): tried at many states
//! that nothing has seen, and at states bred from the worst of them. Where it
//! fails, these states join those it is measured at, formats are widened, and
//! the cheapest is taken anew, until one holds. Of small programs a bound over
//! the ranges may prove the rest ([`bound`]).
//!
//! Where the scene has a motion ([`motion`]), the choice has to stay within the
//! error that is allowed over time as well, else its mantissa is widened.
//!
//! **Invariants.** Two seeds draw the states that candidates are chosen by:
//! few for the *search*, which orders of series and mantissas are tried at;
//! four times as many for the *validation*, which mantissas must hold at too
//! and which gives the errors of candidates. Every challenge draws others. A
//! choice that did not hold is never taken again, so that the search ends.

pub mod bound;
pub mod challenge;
pub mod confirm;
mod format;
pub mod motion;
pub mod page;
mod ranges;
mod series;
mod size;
pub mod text;
mod tolerance;
mod variants;

pub use bound::FitBound;
pub use challenge::Challenge;
pub use motion::{MotionShare, MotionTolerance};
pub use series::{SinePlace, SineTreatment};

use crate::explore::ExplorationProgress;
use crate::explore::device::{self, DeviceShare};
use crate::explore::pareto::{self, EqualPoints};
use crate::explore::program::{ExplorationError, view};
use crate::generate::Formulation;
use crate::yardstick::{ErrorSpread, Yardstick};
use robovec_analysis::critical_path::critical_path;
use robovec_codegen::hardware::{self, MachineClock};
use robovec_framework::scene::{ArraySizes, Scene};
use robovec_ir::count::Counts;
use robovec_ir::{Format, Machine, Module};
use robovec_num::NumberFormat;
use robovec_schedule::PlaceError;
use serde::Serialize;
use std::sync::Arc;
use tolerance::FormatErrors;

/// How many times as many states as the search has the validation has: a
/// search measures often and can afford few.
const VALIDATION_FACTOR: u32 = 4;

/// By how many bits a mantissa is widened that errs too much over time.
const WIDER: u32 = 2;

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
    /// The usual sizes of the general function's arrays, by which errors are
    /// measured where the arrays vanish.
    pub sizes: ArraySizes,
    /// Random states of the search; the validation takes four times as many.
    pub states: u32,
    /// The seed of the states of the search; validation and challenges take
    /// the next ones.
    pub seed: u64,
    /// How many times the usual number of states a choice is challenged with.
    pub effort: u32,
    /// The motion whose error over time the scene limits.
    pub motion: Option<&'a MotionTolerance<'a>>,
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
    /// The clock of the machine with these elements, and its origin.
    pub clock: MachineClock,
    /// The time at that clock, µs.
    pub microseconds: f64,
    /// Errors at the states of the validation, approximations and rounding
    /// together, relative to each element.
    pub relative: ErrorSpread,
    /// The same errors, relative to the largest element of the array.
    pub normwise: ErrorSpread,
    /// The largest error over its tolerance: at most 1 when all are met; 0
    /// when the scene has no tolerances. States that broke another choice
    /// count as well.
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
    /// What the chosen one was tried with, and held.
    pub challenge: Option<Challenge>,
    /// Its error over time; `None` where the scene has no motion.
    pub motion: Option<MotionShare>,
    /// What is proved of the chosen one; `None` where it has no bound.
    pub bound: Option<FitBound>,
    /// Choices before it that did not hold when they were challenged.
    pub broken: u32,
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
    /// No program can be placed on the machine.
    #[error("no program can be placed on the machine: {0}")]
    Placement(PlaceError),
}

/// Searches programs, formats and numbers of elements for a scene, and measures
/// each; `progress` is told what is tried.
///
/// # Errors
///
/// See [`FitError`]. That nothing meets the scene is no error: the outcome
/// then has no chosen candidate, and its front shows what is possible.
pub fn fit(task: &FitTask<'_>, progress: ExplorationProgress<'_>) -> Result<FitOutcome, FitError> {
    let mut search = FitSearch::new(task, progress)?;
    let mut broken = 0;
    loop {
        let candidates = search.candidates();
        let Some(chosen) = cheapest(&candidates) else {
            return Ok(search.outcome(candidates, None, broken));
        };
        let program = candidates[chosen].program;
        let format = search.format_of(&candidates[chosen]);
        // A motion costs less than a challenge and is tried before it.
        let name = &search.programs[program].name;
        progress(&format!("{name} in {format}: the error over time"));
        let motion = task.motion.map(|motion| {
            let module = &search.programs[program].module;
            motion.of(module, format)
        });
        if motion.as_ref().is_some_and(|motion| !motion.holds()) {
            search.widen(program, format)?;
            broken += 1;
            continue;
        }
        progress(&format!(
            "{name} in {format}: searching for the worst state"
        ));
        let attempt = (&search.programs[program], format);
        let challenge = challenge::challenge(task, attempt, broken)?;
        if challenge.holds() {
            let mut outcome = search.outcome(candidates, Some((chosen, challenge)), broken);
            outcome.motion = motion;
            return Ok(outcome);
        }
        broken += 1;
        search.learn(program, challenge.worst)?;
    }
}

/// The cheapest of the candidates that meet the scene.
fn cheapest(candidates: &[FitCandidate]) -> Option<usize> {
    let eligible = candidates.iter().enumerate();
    let eligible = eligible.filter(|(_, candidate)| candidate.meets);
    let cheapest = eligible.min_by(|(_, a), (_, b)| {
        let tables = |candidate: &FitCandidate| candidate.resources.look_up_tables;
        a.share
            .total_cmp(&b.share)
            .then(tables(a).total_cmp(&tables(b)))
            .then(a.cycles.cmp(&b.cycles))
    });
    cheapest.map(|(index, _)| index)
}

/// Programs with the formats and sizes they are tried in, and the states they
/// are measured at.
struct FitSearch<'t, 'a> {
    task: &'t FitTask<'a>,
    search: Yardstick,
    validation: Yardstick,
    programs: Vec<FitProgram>,
    /// For every program the machines it is placed on.
    sizes: Vec<Vec<size::SizedMachine>>,
    /// For every program its formats with the errors at the validation.
    formats: Vec<Vec<(Format, FormatErrors)>>,
}

impl<'t, 'a> FitSearch<'t, 'a> {
    fn new(
        task: &'t FitTask<'a>,
        progress: ExplorationProgress<'_>,
    ) -> Result<FitSearch<'t, 'a>, FitError> {
        let search = yardstick(task, task.states, task.seed);
        let validation = yardstick(
            task,
            task.states * VALIDATION_FACTOR,
            task.seed.wrapping_add(1),
        );
        let mut made = variants::programs(task, &search, progress)?;
        series::write(task, &search, &mut made, progress)?;
        let (mut programs, mut sizes, mut formats) = (Vec::new(), Vec::new(), Vec::new());
        let mut refused: Option<PlaceError> = None;
        for program in made {
            let (name, treatment) = (&program.name, program.treatment);
            progress(&format!("{name}, {treatment}: formats and elements"));
            match size::sizes(task, &program) {
                Err(error) => refused = Some(error),
                Ok(placed) => {
                    formats.push(format::formats(task, &program, &search, &validation)?);
                    sizes.push(placed);
                    programs.push(program);
                }
            }
        }
        if let (true, Some(error)) = (programs.is_empty(), refused) {
            return Err(FitError::Placement(error));
        }
        Ok(FitSearch {
            task,
            search,
            validation,
            programs,
            sizes,
            formats,
        })
    }

    /// Every program in its formats on its machines.
    fn candidates(&self) -> Vec<FitCandidate> {
        let mut candidates = Vec::new();
        for (index, program) in self.programs.iter().enumerate() {
            for size in &self.sizes[index] {
                for (format, errors) in &self.formats[index] {
                    let made = candidate(self.task, (index, program), *format, errors, size);
                    candidates.push(made);
                }
            }
        }
        candidates
    }

    /// The format of a candidate.
    fn format_of(&self, candidate: &FitCandidate) -> Format {
        let formats = self.formats[candidate.program].iter();
        let mut named = formats.filter(|(format, _)| format.to_string() == candidate.format);
        named.next().expect("a candidate has one of the formats").0
    }

    /// Adds states at which a program failed to those that programs are
    /// measured at, and widens the format of that program.
    fn learn(&mut self, failed: usize, states: Vec<Vec<f64>>) -> Result<(), FitError> {
        let news = Yardstick::at(view(self.task.general), states.clone());
        self.search.extend(view(self.task.general), states.clone());
        self.validation.extend(view(self.task.general), states);
        for (index, program) in self.programs.iter().enumerate() {
            if index == failed {
                self.formats[index] =
                    format::formats(self.task, program, &self.search, &self.validation)?;
                continue;
            }
            for (format, errors) in &mut self.formats[index] {
                let more = FormatErrors::at(self.task, program, *format, &news)?;
                errors.shares.extend(more.shares);
            }
        }
        Ok(())
    }

    /// Refuses a format of a program, and all that are no wider, for its error
    /// over time; the next wider mantissa is tried instead.
    fn widen(&mut self, program: usize, refused: Format) -> Result<(), FitError> {
        let bits = |format: Format| match format {
            Format::Float(float) => float.mantissa,
            Format::Fixed(fixed) => fixed.fraction,
        };
        for (format, errors) in &mut self.formats[program] {
            if bits(*format) <= bits(refused) {
                errors.shares.push(f64::INFINITY);
            }
        }
        let Format::Float(float) = refused else {
            return Ok(());
        };
        let wider = Format::Float(NumberFormat {
            mantissa: float.mantissa + WIDER,
            ..float
        });
        let known = |(format, _): &(Format, FormatErrors)| *format == wider;
        if float.mantissa + WIDER <= 52 && !self.formats[program].iter().any(known) {
            let one = &self.programs[program];
            let errors = FormatErrors::at(self.task, one, wider, &self.validation)?;
            self.formats[program].push((wider, errors));
        }
        Ok(())
    }

    fn outcome(
        self,
        candidates: Vec<FitCandidate>,
        held: Option<(usize, Challenge)>,
        broken: u32,
    ) -> FitOutcome {
        let (chosen, challenge) = held.unzip();
        let bound = chosen.and_then(|chosen| {
            let candidate = &candidates[chosen];
            let program = &self.programs[candidate.program];
            bound::bound(self.task, program, self.format_of(candidate))
        });
        FitOutcome {
            bound,
            motion: None,
            programs: self.programs,
            candidates,
            chosen,
            challenge,
            broken,
        }
    }
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
    measured: &FormatErrors,
    size: &size::SizedMachine,
) -> FitCandidate {
    let machine = size.machine(task.machine);
    let resources = device::taken(&machine, format, size.cycles, size.words);
    let function = &program.module.functions[0];
    let clock = hardware::clock(&Machine {
        number: format,
        ..machine.clone()
    });
    let microseconds = clock.microseconds(size.cycles);
    let (used, errors) = (measured.used(), &measured.errors);
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
        clock,
        microseconds,
        relative: errors.relative,
        normwise: errors.normwise,
        used,
        resources,
        share: resources.share(task.machine.device.device()),
        meets: in_time
            && used <= 1.0
            // Infinite when a result was not finite, which a scene without
            // tolerances would let pass.
            && errors.normwise.worst.is_finite()
            && resources.share(task.machine.device.device()) <= 1.0,
    }
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
