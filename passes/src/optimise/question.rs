//! Questions that a search answers, and who makes the programs.

use super::Goal;
use super::steps::StartForm;
use super::trial::VariantTrial;
use robovec_analysis::class::NumericClass;
use robovec_framework::pass::{PassError, Registry};
use robovec_framework::pipeline::Pipeline;
use robovec_ir::{Function, Machine};
use robovec_schedule::{PlaceError, PlaceOptions, most_memory_words, place};

/// Subject and limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct SearchQuestion<'a> {
    /// The machine that programs are for.
    pub machine: &'a Machine,
    /// Measure of the best program.
    pub goal: Goal,
    /// Numeric class of programs.
    pub class: NumericClass,
    /// Registry of the passes.
    pub registry: &'static Registry,
    /// Number of [`unit`](SearchQuestion::unit)s that may be spent, at least 1.
    pub effort: u32,
    /// The work of one effort, in operations that are reassociated once.
    pub unit: u64,
}

/// A program that a search starts from, at the level atomic.
#[derive(Clone, Debug)]
pub struct SearchStart<P> {
    /// Its name, in front of those of the steps; may be empty.
    pub name: String,
    /// Form of the start.
    pub form: StartForm,
    /// The program.
    pub program: P,
}

/// A program to be made.
#[derive(Clone, Debug)]
pub struct SearchJob<P> {
    /// Index of its start.
    pub start: usize,
    /// The program before the step.
    pub program: P,
    /// The passes that make it.
    pub pipeline: Pipeline,
    /// All passes from the start on.
    pub passes: String,
    /// The work it is charged with.
    pub work: u64,
}

/// Makes and places programs for a search.
pub trait ProgramMaker {
    /// A program.
    type Program: Clone;

    /// Makes programs, in this order; none depends on another one.
    fn make(
        &mut self,
        jobs: Vec<SearchJob<Self::Program>>,
    ) -> Vec<Result<Self::Program, PassError>>;

    /// The function of a program.
    fn function(program: &Self::Program) -> &Function;

    /// The schedules of programs on a machine.
    fn schedules(
        &mut self,
        programs: &[&Self::Program],
        machine: &Machine,
    ) -> Vec<Result<ScheduleSize, PlaceError>>;
}

/// Size of a schedule.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ScheduleSize {
    /// Its length.
    pub cycles: u32,
    /// The maximum number of words of memory of an element, both sides of a
    /// split one together.
    pub words: u32,
}

/// A program that was not made.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SkippedVariant {
    /// The steps it would have gone through.
    pub name: String,
    /// Reason why it was not made.
    pub reason: String,
}

/// The reason for trials that wait for more effort.
pub(super) const BEYOND_EFFORT: &str = "beyond the effort";

impl SkippedVariant {
    /// True for trials that more effort would make.
    pub(super) fn is_beyond_effort(&self) -> bool {
        self.reason == BEYOND_EFFORT
    }
}

/// Result of a search.
#[derive(Clone, Debug)]
pub struct SearchOutcome<P> {
    /// All programs that were made, in that order.
    pub trials: Vec<VariantTrial<P>>,
    /// Index of the best; `None` when the machine can place none.
    pub best: Option<usize>,
    /// Variants that were not made.
    pub skipped: Vec<SkippedVariant>,
    /// Number of programs with the same figures.
    pub alike: usize,
}

/// The work of one effort where the smallest start has this number of
/// operations: some seconds on one core for models of any usual size.
pub fn usual_unit(operations: usize) -> u64 {
    const LEAST: u64 = 1_500_000;
    const MOST: u64 = 8_000_000;
    /// Enough for all preparations and one move.
    const PER_OPERATION: u64 = 40;
    (operations as u64 * PER_OPERATION).clamp(LEAST, MOST)
}

/// Size of the schedule that `place` makes of a function.
///
/// # Errors
///
/// Those of [`place`].
pub fn schedule_size(function: &Function, machine: &Machine) -> Result<ScheduleSize, PlaceError> {
    let mut function = function.clone();
    let summary = place(&mut function, machine, PlaceOptions::default())?;
    Ok(ScheduleSize {
        cycles: summary.cycles,
        words: most_memory_words(&function).expect("what is placed has a placement"),
    })
}
