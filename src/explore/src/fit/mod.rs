//! The cheapest program and machine that meet a scene.
//!
//! A scene states which outputs are needed, how exact (tolerances) and how soon
//! (a deadline). The choices are the formulation of the equations, the passes,
//! the method for sines and cosines, the number format, and the number of
//! elements. They are chosen in this order, each against the scene's own
//! tolerances and deadline, by measurement:
//!
//! 1. programs ([`variants`]): every formulation specialised to the scene,
//!    with the equations as short or as few as the passes make them;
//! 2. series ([`series`]): of each method the smallest order whose error leaves
//!    room for rounding;
//! 3. format ([`format`]): the narrowest exponent that holds what occurs, the
//!    narrowest mantissa that meets the tolerances, found by halving; of the
//!    shortest programs fixed point as well, and a format for every value
//!    ([`mixture`]);
//! 4. units for sines and cosines before the run ([`units`]);
//! 5. elements ([`size`]): the fewest that meet the deadline, and more of
//!    them for the front.
//!
//! The result is candidates with time, error and cost, the cheapest of them
//! ([`CostMeasure`]) that meets all, and the Pareto front.
//!
//! The cheapest is then *challenged* ([`challenge`]): tried at many new states,
//! and at states found by a search from the worst of them. Where it fails,
//! these states are added to those of the measurement, formats are widened, and
//! the cheapest is chosen again, until one holds. For small programs a bound
//! over the ranges may prove the rest ([`bound`]).
//!
//! Where the scene has a motion ([`motion`]), the choice has to stay within the
//! error that is allowed over time as well, else its mantissa is widened.
//!
//! **Invariants.** Two seeds draw the states that candidates are chosen by:
//! few for the *search*, which orders of series and mantissas are tried at;
//! four times as many for the *validation*, which mantissas must hold at too
//! and which gives the errors of candidates. Every challenge draws others. A
//! choice that did not hold is never taken again, so that the search ends.

mod answer;
mod bound;
mod challenge;
pub mod confirm;
mod format;
mod mixture;
mod motion;
mod search;
mod series;
mod size;
pub mod text;
mod units;
mod variants;

pub use bound::{FitBound, FitSources};
pub use challenge::Challenge;
pub use mixture::ValueMixture;
pub use motion::{EnergyDrift, MotionShare, MotionTolerance};
pub use series::{SinePlace, SineTreatment};

use crate::ExplorationProgress;
use crate::device::DeviceShare;
use crate::pareto::{self, EqualPoints};
use crate::program::ExplorationError;
use robovec_dynamics::generate::Formulation;
use robovec_error::yardstick::{ErrorSpread, Unmeasurable};
use robovec_fpga::hardware::MachineClock;
use robovec_framework::scene::{ArraySizes, Measure, Scene};
use robovec_ir::{Machine, Module};
use robovec_schedule::PlaceError;
use search::{FitSearch, VALIDATION_FACTOR};
use serde::Serialize;
use std::cmp::Ordering;
use std::sync::Arc;

/// Maximum number of steps of motions, all choices together.
const MOTION_STEPS: u64 = 2_000_000;

/// Part of a tolerance that found errors may use, a margin for other states.
const ACCEPTED: f64 = 0.8;

/// The same where errors are relative to the output itself: they are largest
/// where it vanishes, in so thin a set of states that searches meet its worst
/// by chance (1.8 times as much as another one in the tests' random scenes).
const ACCEPTED_RELATIVE: f64 = 0.5;

/// Share of what is accepted that errors at the states of the search and of the
/// validation may use: others are worse, and a failed challenge costs more.
const SAMPLED: f64 = 0.875;

/// Share of what is accepted that a series may use, before rounding.
const SERIES: f64 = 0.625;

/// Relative uncertainty of estimated costs; smaller differences are ties.
const UNCERTAINTY: f64 = 0.05;

/// Measure of the cheapest.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum CostMeasure {
    /// The share of the device that the machine takes, with one floating-point
    /// format.
    #[default]
    Device,
    /// The cells of the arithmetic, for custom hardware: fixed point, or a
    /// format for each value, may be chosen.
    Cells,
}

/// Task of a search.
pub struct FitTask<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The general function of the scene, alone in its module, the reference.
    pub general: &'a Module,
    /// The general function in every formulation to try, each in its module.
    pub formulations: Vec<(Formulation, Module)>,
    /// The machine whose elements, memories and clock are used.
    pub machine: &'a Machine,
    /// Place where sines and cosines are computed.
    pub trigonometry: SinePlace,
    /// Measure of the cheapest.
    pub cost: CostMeasure,
    /// The usual sizes of arrays, by which errors are measured at zeros.
    pub sizes: ArraySizes,
    /// Random states of the search; the validation takes four times as many.
    pub states: u32,
    /// Seed of the states of the search; validation and challenges take others.
    pub seed: u64,
    /// Number of times the usual number of states a choice is challenged with.
    pub effort: u32,
    /// The motion whose error over time the scene limits.
    pub motion: Option<&'a MotionTolerance<'a>>,
}

impl FitTask<'_> {
    /// The part of a tolerance that the largest error found may use.
    pub fn accepted(&self) -> f64 {
        let tolerances = self.scene.outputs.iter().filter_map(|need| need.tolerance);
        let mut measures = tolerances.map(|tolerance| tolerance.measure);
        if measures.any(|measure| measure == Measure::Relative) {
            ACCEPTED_RELATIVE
        } else {
            ACCEPTED
        }
    }

    fn cost_of(&self, candidate: &FitCandidate) -> f64 {
        match self.cost {
            CostMeasure::Device => candidate.share,
            CostMeasure::Cells => candidate.cells,
        }
    }

    /// The part of a tolerance that errors at sampled states may use.
    fn sampled(&self) -> f64 {
        SAMPLED * self.accepted()
    }

    /// The part of a tolerance that a series may use.
    fn of_series(&self) -> f64 {
        SERIES * self.accepted()
    }
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
    /// Way in which its sines and cosines are computed.
    pub treatment: SineTreatment,
    /// One function, at the atomic level.
    pub module: Arc<Module>,
    /// The largest error in binary64 over its tolerance, at the states of the
    /// search: that of approximations, beside which its rounding is nothing.
    pub model_share: f64,
    /// The formats of its values, where each has its own.
    pub mixture: Option<ValueMixture>,
    /// Reason why the scene rules it out: it is measured nevertheless.
    pub excluded: Option<String>,
}

/// A program in a format on a number of elements.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct FitCandidate {
    /// Index of its program in [`FitOutcome::programs`], from 0.
    pub program: usize,
    /// Name of the number format, as [`Format`](robovec_ir::Format) prints it.
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
    /// Errors at the states of the validation, relative to each element.
    pub relative: ErrorSpread,
    /// The same errors, relative to the largest element of the array.
    pub normwise: ErrorSpread,
    /// The largest error over its tolerance: at most 1 when all are met; 0
    /// without tolerances. States that broke another choice count as well.
    pub used: f64,
    /// Resources of the device that it takes, estimated.
    pub resources: DeviceShare,
    /// The largest of its shares of the device ([`DeviceShare::share`]).
    pub share: f64,
    /// Cells of its arithmetic ([`robovec_ir::cost::function_cost`]).
    pub cells: f64,
    /// Reason why it cannot be chosen at any error and cost; else empty.
    pub remark: String,
    /// It can be chosen, meets tolerances and deadline, and fits the device.
    pub meets: bool,
}

/// Result of a search.
pub struct FitOutcome {
    /// The programs.
    pub programs: Vec<FitProgram>,
    /// Everything that was placed and measured.
    pub candidates: Vec<FitCandidate>,
    /// Index of the candidate chosen of those that meet all conditions: of the
    /// cheapest ones, whose costs differ by less than their uncertainty, the
    /// fastest, then the most exact; `None` when there is none.
    pub chosen: Option<usize>,
    /// Challenge that the chosen one held.
    pub challenge: Option<Challenge>,
    /// Its error over time; `None` where the scene has no motion.
    pub motion: Option<MotionShare>,
    /// Bound of the chosen one; `None` where it has none.
    pub bound: Option<FitBound>,
    /// Its errors by their source, at the worst states of the challenge;
    /// `None` where values have their own formats.
    pub sources: Option<FitSources>,
    /// Choices before it that did not hold when they were challenged.
    pub broken: u32,
    /// Choices before it that erred too much over time.
    pub drifted: u32,
    /// Candidates that could not be tried, with the reasons.
    pub untried: Vec<String>,
}

/// Reason why nothing could be searched.
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

impl From<Unmeasurable> for FitError {
    fn from(error: Unmeasurable) -> FitError {
        FitError::Measure(error.into())
    }
}

/// Searches programs, formats and elements for a scene; reports `progress`.
///
/// # Errors
///
/// See [`FitError`]. A scene that no program meets is no error: the outcome
/// then has no chosen candidate, and its front shows the possible ones.
pub fn fit(task: &FitTask<'_>, progress: ExplorationProgress<'_>) -> Result<FitOutcome, FitError> {
    let mut search = FitSearch::new(task, progress)?;
    loop {
        let candidates = search.candidates();
        let Some(chosen) = cheapest(task, &candidates) else {
            return search.outcome(candidates, None);
        };
        let program = candidates[chosen].program;
        let format = search.format_of(&candidates[chosen]);
        // A motion costs less than a challenge, so it is tried first.
        let name = search.programs[program].name.clone();
        progress(&format!("{name} in {format}: the error over time"));
        let motion = match task.motion {
            // Without steps to spend nothing is established over time.
            Some(motion) if search.steps_left < motion.steps() => {
                search.untried.push(format!(
                    "{name} in {format} over time: all choices together may take {MOTION_STEPS} \
                     steps"
                ));
                return search.outcome(candidates, None);
            }
            Some(motion) => {
                search.steps_left -= motion.steps();
                Some(motion.of(&search.programs[program].module, format))
            }
            None => None,
        };
        if let Some(motion) = motion.as_ref().filter(|motion| !motion.holds()) {
            search.drifted += 1;
            search.widen(program, format, motion.used())?;
            continue;
        }
        progress(&format!(
            "{name} in {format}: searching for the worst state"
        ));
        let attempt = (&search.programs[program], format);
        let challenge = challenge::challenge(task, attempt, search.broken)?;
        if challenge.holds() {
            let mut outcome = search.outcome(candidates, Some((chosen, challenge)))?;
            outcome.motion = motion;
            return Ok(outcome);
        }
        search.broken += 1;
        search.learn(program, challenge.worst)?;
    }
}

/// Of the candidates that meet the scene, and among the cheapest within the
/// uncertainty of costs, the fastest, then the most exact, then the cheapest.
fn cheapest(task: &FitTask<'_>, candidates: &[FitCandidate]) -> Option<usize> {
    let cost = |candidate: &FitCandidate| task.cost_of(candidate);
    let eligible = || {
        let all = candidates.iter().enumerate();
        all.filter(|(_, candidate)| candidate.meets)
    };
    let least = eligible().map(|(_, candidate)| cost(candidate));
    let limit = (1.0 + UNCERTAINTY) * least.fold(f64::INFINITY, f64::min);
    let ties = eligible().filter(|(_, candidate)| cost(candidate) <= limit);
    let measures = |candidate: &FitCandidate| {
        let tables = candidate.resources.look_up_tables;
        [
            candidate.microseconds,
            candidate.used,
            cost(candidate),
            tables,
        ]
    };
    let order = |(_, a): &(usize, &FitCandidate), (_, b): &(usize, &FitCandidate)| {
        let pairs = measures(a).into_iter().zip(measures(b));
        pairs.fold(Ordering::Equal, |order, (a, b)| order.then(a.total_cmp(&b)))
    };
    ties.min_by(order).map(|(index, _)| index)
}

impl FitProgram {
    /// True when it has sines or cosines that are computed before the run.
    fn has_sines(&self) -> bool {
        let nodes = self.module.functions[0].nodes();
        nodes.iter().any(|node| node.operation.is_trigonometric())
    }
}

impl FitOutcome {
    /// Indices of the candidates that no other one dominates in time, share of
    /// the device and worst normwise error, in order of time: of those that
    /// meet the scene, or of all when there are none.
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
