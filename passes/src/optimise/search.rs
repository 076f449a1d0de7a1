//! The search: programs from starts by preparations, and from the best of
//! them by moves.
//!
//! With few elements operations decide, with many the longest path does, and
//! between the two neither; so programs are placed and the schedules compared.
//! Facts that hold for every list scheduler (a schedule is at least as long as
//! the path, and as the operations of a kind over its elements) show which
//! programs need not be placed or tried.
//!
//! Invariants:
//!
//! - work is counted in operations, never in time, and the next trial depends
//!   on figures alone: the same question gives the same programs on any number
//!   of threads;
//! - a search of more effort begins with the search of less: trials beyond the
//!   work allowed so far wait, and come first when there is more. More effort
//!   is therefore never worse.

use super::Goal;
use super::question::BEYOND_EFFORT;
pub use super::question::{
    ProgramMaker, ScheduleSize, SearchJob, SearchOutcome, SearchQuestion, SearchStart,
    SkippedVariant, schedule_size, usual_unit,
};
use super::steps::{
    FEWEST, FEWEST_MOVES, FUSED, MOVES, PREPARATIONS, SATURATED, SearchStep, StartForm, class,
};
use super::trial::VariantTrial;
use robovec_framework::pass::PassError;
use robovec_ir::Operation;

/// Searches. The first preparation of the first start is always made.
///
/// # Errors
///
/// Fails when not a single program can be made: the error of the first pass.
pub fn search<M: ProgramMaker>(
    maker: &mut M,
    starts: Vec<SearchStart<M::Program>>,
    question: SearchQuestion<'_>,
) -> Result<SearchOutcome<M::Program>, PassError> {
    let mut search = ProgramSearch {
        maker,
        question,
        starts,
        trials: Vec::new(),
        skipped: Vec::new(),
        failure: None,
        waiting: Vec::new(),
        budget: question.unit,
        expansions: 0,
        expanded: Vec::new(),
        alike: 0,
    };
    for is_first in [true, false] {
        let planned = search.preparations(is_first);
        search.carry_out(planned);
    }
    search.expand(1);
    let operations = search.starts.iter();
    let operations = operations.map(|start| M::function(&start.program).nodes().len());
    let is_small = operations
        .min()
        .is_some_and(|operations| operations <= SMALL);
    let unit = question.unit * if is_small { 2 } else { 1 };
    for effort in 2..=question.effort {
        search.budget += unit;
        let waiting = std::mem::take(&mut search.waiting);
        search.carry_out(waiting);
        search.expand(effort);
    }
    search.finish()
}

/// Origin of a program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Origin {
    /// A start, by its index.
    Start(usize),
    /// A program that was made, by its index.
    Trial(usize),
}

/// Origin of a program: its start, a flag for a preparation that searches for
/// composite bodies, and one for a preparation that reorders sums.
type Lineage = (usize, bool, bool);

/// A step on a program.
#[derive(Clone, Copy, Debug)]
struct PlannedStep {
    origin: Origin,
    step: &'static SearchStep,
}

impl PlannedStep {
    /// A step on a program that was made.
    fn of(index: usize, step: &'static SearchStep) -> PlannedStep {
        let origin = Origin::Trial(index);
        PlannedStep { origin, step }
    }
}

struct ProgramSearch<'a, M: ProgramMaker> {
    maker: &'a mut M,
    question: SearchQuestion<'a>,
    starts: Vec<SearchStart<M::Program>>,
    trials: Vec<VariantTrial<M::Program>>,
    skipped: Vec<SkippedVariant>,
    /// Error of the first pass that gave up.
    failure: Option<PassError>,
    /// Steps that do not fit into the work allowed so far.
    waiting: Vec<PlannedStep>,
    /// The work that is left.
    budget: u64,
    /// Programs that moves were tried on.
    expansions: u32,
    /// Of those that only a preparation made, their origins.
    expanded: Vec<Lineage>,
    /// Programs that looked like others and were not kept.
    alike: usize,
}

/// Programs that moves are tried on by the first effort, and by each of the
/// others: a bound for small functions, of which this number of take little of
/// the work allowed. The first is short, since whole explorations run it.
const EXPANSIONS: [u32; 2] = [9, 24];

/// Operations up to which a function is small: each effort but the first has
/// twice the work for it, since it gains by longer chains of moves.
const SMALL: usize = 2_500;

/// In one turn of this number of moves are tried on the best of all programs.
const TURNS: u32 = 3;

/// Programs placed at a time. A constant, so that the placed programs do not
/// depend on the number of threads.
const PLACED_AT_ONCE: usize = 4;

impl<M: ProgramMaker> ProgramSearch<'_, M> {
    /// The preparations of all starts that come first, or all others.
    fn preparations(&self, is_first: bool) -> Vec<PlannedStep> {
        let mut planned = Vec::new();
        for (index, start) in self.starts.iter().enumerate() {
            let steps = PREPARATIONS.iter().chain(self.if_fewest(FEWEST));
            let steps = steps.filter(|step| {
                step.is_first == is_first
                    && (!step.printed_only || start.form == StartForm::Printed)
            });
            planned.extend(steps.map(|step| PlannedStep {
                origin: Origin::Start(index),
                step,
            }));
        }
        planned
    }

    /// These steps where only operations count, none elsewhere.
    fn if_fewest(&self, steps: &'static [SearchStep]) -> &'static [SearchStep] {
        match self.question.goal {
            Goal::Operations => steps,
            Goal::Cycles | Goal::Path => &[],
        }
    }

    /// Carries out the steps within the budget; the rest waits.
    fn carry_out(&mut self, planned: Vec<PlannedStep>) {
        let before = self.trials.len();
        self.make(planned);
        if self.question.machine.kind_of(Operation::Fma).is_some() {
            let fresh = before..self.trials.len();
            let fused =
                fresh.flat_map(|index| FUSED.iter().map(move |step| PlannedStep::of(index, step)));
            let plain = self.trials.len();
            self.make(fused.collect());
            // Moves are for products and sums apart.
            for trial in &mut self.trials[plain..] {
                trial.is_expanded = true;
            }
        }
        if self.question.goal == Goal::Cycles {
            self.place();
        }
    }

    /// Makes the programs of steps that fit into the budget.
    fn make(&mut self, planned: Vec<PlannedStep>) {
        let mut jobs = Vec::new();
        let mut names = Vec::new();
        for plan in planned {
            let Some(pipeline) = plan.step.pipeline(self.question.registry) else {
                continue;
            };
            if class(&pipeline) > self.question.class || self.is_hopeless(plan) {
                continue;
            }
            let (program, start, name, passes) = self.description(plan);
            let operations = M::function(&program).nodes().len() as u64;
            let work = operations.saturating_mul(plan.step.weight);
            let is_first = self.trials.is_empty() && jobs.is_empty();
            if work > self.budget && !is_first {
                self.waiting.push(plan);
                continue;
            }
            self.budget = self.budget.saturating_sub(work);
            let preparation = match plan.origin {
                Origin::Start(_) => Some(plan.step),
                Origin::Trial(_) => None,
            };
            names.push((name, start, passes.clone(), preparation));
            jobs.push(SearchJob {
                start,
                program,
                pipeline,
                passes,
                work,
            });
        }
        let made = self.maker.make(jobs);
        for ((name, start, passes, preparation), made) in names.into_iter().zip(made) {
            match made {
                Ok(program) => self.keep((name, start, passes), program, preparation),
                Err(error) => {
                    self.skipped.push(SkippedVariant {
                        name,
                        reason: error.message.clone(),
                    });
                    self.failure.get_or_insert(error);
                }
            }
        }
    }

    fn keep(
        &mut self,
        name: (String, usize, String),
        program: M::Program,
        preparation: Option<&'static SearchStep>,
    ) {
        let mut trial = VariantTrial::new(name, program, M::function, self.question.machine);
        trial.preparation = preparation;
        if self.trials.iter().any(|known| known.looks_like(&trial)) {
            if preparation.is_none() {
                self.alike += 1;
                return;
            }
            // Whatever would be made of it is made of the other one.
            trial.is_expanded = true;
        }
        self.trials.push(trial);
    }

    /// Start of a step: the program, its start, and the name and passes of the
    /// result.
    fn description(&self, plan: PlannedStep) -> (M::Program, usize, String, String) {
        let (program, start, name, passes) = match plan.origin {
            Origin::Start(index) => {
                let start = &self.starts[index];
                (&start.program, index, start.name.as_str(), "")
            }
            Origin::Trial(index) => {
                let trial = &self.trials[index];
                (
                    &trial.program,
                    trial.start,
                    trial.name.as_str(),
                    trial.pipeline.as_str(),
                )
            }
        };
        let passes = match passes {
            "" => plan.step.pipeline.to_owned(),
            passes => format!("{passes},{}", plan.step.pipeline),
        };
        (program.clone(), start, plan.step.after(name), passes)
    }

    /// True when a preparation will not save enough to come near the best
    /// program: the result of the first of its kind from this start is more
    /// than twice as far.
    fn is_far_off(&self, start: usize, step: &SearchStep) -> bool {
        let scarce = |trial: &VariantTrial<M::Program>| match self.question.goal {
            Goal::Cycles => trial.shared as usize,
            Goal::Operations => trial.operations,
            Goal::Path => 0,
        };
        let own = self.trials.iter().filter(|trial| {
            let preparation = trial.preparation;
            trial.start == start
                && preparation.is_some_and(|own| own.finds_bodies == step.finds_bodies)
        });
        let (Some(own), Some(best)) = (own.map(scarce).min(), self.best()) else {
            return false;
        };
        own > 2 * self.rank(best).0
    }

    /// True when the elements cannot perform this number of operations in the
    /// time of the best schedule, or when nothing but operations is scarce.
    fn is_hopeless(&self, plan: PlannedStep) -> bool {
        let index = match plan.origin {
            Origin::Start(start) => {
                return !plan.step.is_first && self.is_far_off(start, plan.step);
            }
            Origin::Trial(index) => index,
        };
        if self.question.goal == Goal::Operations {
            return plan.step.growth > 100;
        }
        let trial = &self.trials[index];
        let (Goal::Cycles, true, Some(best)) = (
            self.question.goal,
            plan.step.growth > 100,
            self.best_cycles(),
        ) else {
            return false;
        };
        let shared = u64::from(trial.shared);
        let is_saturated = trial
            .cycles
            .is_some_and(|cycles| u64::from(cycles) * 50 <= shared * 51);
        shared * plan.step.growth / 100 >= u64::from(best) || is_saturated
    }

    /// Places the programs that may be better than the best, in order of the
    /// bounds.
    fn place(&mut self) {
        let mut order: Vec<(u32, usize, usize)> = Vec::new();
        for (index, trial) in self.trials.iter().enumerate() {
            if let (Ok(bound), None, "") = (&trial.bound, trial.cycles, trial.remark) {
                order.push((*bound, trial.operations, index));
            }
        }
        order.sort_unstable();
        for batch in order.chunks(PLACED_AT_ONCE) {
            let best = self.best();
            let best = best.map(|best| (self.rank(best).0, self.trials[best].operations));
            let (hopeful, hopeless): (Vec<_>, Vec<_>) = batch
                .iter()
                .partition(|entry| best.is_none_or(|best| (entry.0 as usize, entry.1) < best));
            for &(_, _, index) in hopeless {
                self.trials[index].remark = "cannot be better";
            }
            let programs: Vec<&M::Program> = (hopeful.iter())
                .map(|entry| &self.trials[entry.2].program)
                .collect();
            let sizes = self.maker.schedules(&programs, self.question.machine);
            for (&(_, _, index), size) in hopeful.into_iter().zip(sizes) {
                let trial = &mut self.trials[index];
                match size {
                    Ok(ScheduleSize { cycles, words }) => {
                        (trial.cycles, trial.words) = (Some(cycles), Some(words));
                    }
                    Err(error) => {
                        trial.remark = "cannot be placed";
                        trial.bound = Err(error);
                    }
                }
            }
        }
    }

    /// Measures in order: the goal, then those that decide among equals.
    fn rank(&self, index: usize) -> (usize, usize, usize) {
        let trial = &self.trials[index];
        let cycles = trial.cycles.or(trial.bound.as_ref().ok().copied());
        match self.question.goal {
            Goal::Cycles => {
                let cycles = cycles.map_or(usize::MAX, |cycles| cycles as usize);
                (cycles, trial.operations, index)
            }
            Goal::Operations => (trial.operations, trial.path as usize, index),
            Goal::Path => (trial.path as usize, trial.operations, index),
        }
    }

    /// The best program so far.
    fn best(&self) -> Option<usize> {
        let trials = (0..self.trials.len()).filter(|&index| match self.question.goal {
            Goal::Cycles => self.trials[index].cycles.is_some(),
            Goal::Operations | Goal::Path => true,
        });
        trials.min_by_key(|&index| self.rank(index))
    }

    fn best_cycles(&self) -> Option<u32> {
        self.best().and_then(|best| self.trials[best].cycles)
    }

    /// Tries all moves on one program after the other, while a promising one is
    /// left and its moves fit into the budget.
    fn expand(&mut self, effort: u32) {
        let [first, others] = EXPANSIONS;
        let most = first.saturating_add((effort - 1).saturating_mul(others));
        while self.waiting.is_empty() && self.expansions < most {
            let Some((index, is_best)) = self.next(effort) else {
                return;
            };
            self.trials[index].is_expanded = true;
            self.expansions += 1;
            self.expanded.extend(self.lineage(index));
            let moves = self.if_fewest(FEWEST_MOVES).iter().chain(MOVES);
            self.carry_out(moves.map(|step| PlannedStep::of(index, step)).collect());
            // Saturation takes longer than all moves: it is for what is small,
            // and for what no move makes better.
            if is_best && (self.is_small(index) || self.best() == Some(index)) {
                let steps = SATURATED.iter();
                self.carry_out(steps.map(|step| PlannedStep::of(index, step)).collect());
            }
        }
    }

    /// True where saturation takes little of the work allowed.
    fn is_small(&self, index: usize) -> bool {
        let operations = self.trials[index].operations as u64;
        let work = SATURATED
            .iter()
            .map(|step| operations * step.weight)
            .sum::<u64>();
        work * 4 <= self.question.unit
    }

    /// The lineage of a program that only a preparation made.
    fn lineage(&self, index: usize) -> Option<Lineage> {
        let trial = &self.trials[index];
        let preparation = trial.preparation?;
        Some((
            trial.start,
            preparation.finds_bodies,
            preparation.balances(),
        ))
    }

    /// The program to try the moves on: in all turns but the last of
    /// [`TURNS`] one that only a preparation made, of every lineage in turn, so
    /// that none is forgotten; then the best of all, for which the second part
    /// is true.
    fn next(&self, effort: u32) -> Option<(usize, bool)> {
        let best = self.best_cycles();
        let fewest = self.trials.iter().map(|trial| trial.operations);
        let fewest = fewest.min().expect("the program given is a trial");
        let promising = |&index: &usize| {
            let trial = &self.trials[index];
            // Moves save few operations, so that what elements need for them
            // is at least nearly what a schedule will take.
            let fits = match self.question.goal {
                Goal::Cycles => {
                    best.is_none_or(|best| u64::from(trial.shared) * 19 < u64::from(best) * 20)
                }
                Goal::Operations => trial.operations * 19 < fewest * 20,
                Goal::Path => true,
            };
            !trial.is_expanded && trial.bound.is_ok() && fits
        };
        let promising = (0..self.trials.len()).filter(promising);
        // While work is left, what promises less has its turn as well.
        if effort > 1 && promising.clone().next().is_none() {
            let left = (0..self.trials.len()).filter(|&index| {
                let trial = &self.trials[index];
                !trial.is_expanded && trial.bound.is_ok()
            });
            return left
                .min_by_key(|&index| self.rank(index))
                .map(|index| (index, false));
        }
        if self.expansions % TURNS != TURNS - 1 {
            let prepared = promising
                .clone()
                .filter_map(|index| Some((self.lineage(index)?, index)));
            // A schedule takes the time that elements need for the operations,
            // and some of the path, of which look-ahead leaves half or less.
            let potential = |&(lineage, index): &(Lineage, usize)| {
                let known = self.expanded.iter().filter(|&&known| known == lineage);
                let trial = &self.trials[index];
                let reach = match self.question.goal {
                    Goal::Cycles => trial.shared.saturating_add(trial.path / 3),
                    Goal::Operations => 0,
                    Goal::Path => trial.path,
                };
                (known.count(), reach, trial.operations, index)
            };
            if let Some((_, index)) = prepared.min_by_key(potential) {
                return Some((index, false));
            }
        }
        let best = promising.min_by_key(|&index| self.rank(index))?;
        Some((best, true))
    }

    /// Ends the search.
    fn finish(mut self) -> Result<SearchOutcome<M::Program>, PassError> {
        if let (true, Some(error)) = (self.trials.is_empty(), self.failure.take()) {
            return Err(error);
        }
        for plan in std::mem::take(&mut self.waiting) {
            let (_, _, name, _) = self.description(plan);
            let reason = BEYOND_EFFORT.to_owned();
            self.skipped.push(SkippedVariant { name, reason });
        }
        Ok(SearchOutcome {
            best: self.best(),
            trials: self.trials,
            alike: self.alike,
            skipped: self.skipped,
        })
    }
}
