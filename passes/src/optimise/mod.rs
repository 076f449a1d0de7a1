//! The variant that suits the machine.
//!
//! - [`steps`]: the possible steps, as data;
//! - [`search`](mod@search): the next step to try, and the best program;
//! - [`trial`]: programs with their figures;
//! - `table`: the trials, for users.
//!
//! The search is open to others: `robovec optimise` runs it over several
//! formulations and on all cores.

mod question;
pub mod search;
pub mod steps;
mod table;
pub mod trial;

use robovec_analysis::class::NumericClass;
use robovec_framework::manager::apply;
use robovec_framework::pass::{Context, Gives, NestedReport, Pass, PassError};
use robovec_framework::trail::Notes;
use robovec_framework::{declare_pass, option_words};
use robovec_ir::machine::fields;
use robovec_ir::{Function, Level, Machine};
use robovec_num::limits::NumberLimit;
use robovec_schedule::{PlaceError, element_counts, explain, with_counts};
use search::{
    ProgramMaker, ScheduleSize, SearchJob, SearchQuestion, SearchStart, schedule_size, search,
    usual_unit,
};
use steps::StartForm;

option_words! {
    /// Goal of the choice of a variant.
    #[derive(Default)]
    pub enum Goal {
        /// The shortest schedule on the machine; of equally short ones that
        /// with the fewest operations.
        #[default]
        Cycles = "cycles",
        /// The fewest operations, then the shortest path.
        Operations = "operations",
        /// The shortest path, then the fewest operations.
        Path = "path",
    }
}

option_words! {
    /// Numeric class of the variants.
    #[derive(Default)]
    pub enum VariantClass {
        /// Equality over the reals alone.
        Real = "real",
        /// And sin^2 + cos^2 = 1, on which Robotran's equations rest as well.
        #[default]
        RealTrig = "real-trig",
    }
}

declare_pass! {
    /// Tries the other passes and takes the variant that suits the machine.
    ///
    /// With few elements the operations decide how long a schedule is, with
    /// many the longest path does; `optimise` makes variants of both kinds,
    /// places them on the machine with the numbers of elements given, and
    /// takes the one of the shortest schedule (`for=cycles`), or the one with
    /// the fewest operations or the shortest path. What was tried is listed in
    /// a table:
    ///
    /// ```text
    /// variant       operations  path  bound  cycles
    /// reassociated        4907   350    622     622  taken
    /// as printed          5379   758    758       -  cannot be better
    /// ```
    ///
    /// `bound` is a proved lower bound of the schedule: a variant whose bound
    /// is no shorter than a schedule that is known is not placed. The best
    /// variants are taken further, the more the greater the `effort`. Variants
    /// from composite bodies rest on sin^2 + cos^2 = 1 (`class=real` leaves
    /// them out). Variants with fused multiply-adds are tried where the machine
    /// has elements for them.
    ///
    /// The function comes out at the level atomic; `place` with the same
    /// numbers of elements gives the schedule of the table.
    pub struct Optimise("optimise") {
        /// Goal of the choice of the variant.
        pub r#for: Goal = Goal::default(),
        /// Numeric class of the variants.
        pub class: VariantClass = VariantClass::default(),
        /// Adders; by default those of the machine file.
        pub n_add: Option<u32> = None => fields::count::LIMIT,
        /// Multipliers; by default those of the machine file.
        pub n_multi: Option<u32> = None => fields::count::LIMIT,
        /// Dividers, on machines that have them.
        pub n_div: Option<u32> = None => fields::count::LIMIT,
        /// Square-root extractors, on machines that have them.
        pub n_sqrt: Option<u32> = None => fields::count::LIMIT,
        /// Elements that multiply and add in one operation, on machines that
        /// have them.
        pub n_fma: Option<u32> = None => fields::count::LIMIT,
        /// Effort of the search: more is never worse, and takes as many times
        /// longer.
        pub effort: u32 = 1 => EFFORT,
        /// The work of one effort, in operations that are reassociated once;
        /// for 0 forty times the operations, at least 1,500,000 and at
        /// most 8,000,000.
        pub budget: u32 = 0 => NumberLimit::whole(
            0, 1_000_000_000, "variants are made until this number of operations were reassociated"),
    }
    takes: [Equations, Atomic],
    gives: Gives::Level(robovec_ir::Level::Atomic),
    class: RealTrig,
    destroys: [Timed],
}

impl VariantClass {
    /// The class of a function that rests on it.
    pub fn numeric(self) -> NumericClass {
        match self {
            VariantClass::Real => NumericClass::Real,
            VariantClass::RealTrig => NumericClass::RealTrig,
        }
    }
}

impl Pass for Optimise {
    fn class(&self, _: NumericClass) -> NumericClass {
        self.class.numeric()
    }

    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let numbers = [
            self.n_add,
            self.n_multi,
            self.n_div,
            self.n_sqrt,
            self.n_fma,
        ];
        let machine = with_counts(context.machine, element_counts(numbers))?;
        let mut start = function.clone();
        if start.level == Level::Equations {
            let atomise = context.registry.pipeline("atomise");
            let atomise = atomise.map_err(|error| PassError::new(error.to_string()))?;
            let mut report = NestedReport::default();
            apply(
                &atomise,
                &mut start,
                &mut context.nested(&machine, &mut report),
            )?;
        }
        let question = SearchQuestion {
            machine: &machine,
            goal: self.r#for,
            class: self.class.numeric(),
            registry: context.registry,
            effort: self.effort,
            unit: match self.budget {
                0 => usual_unit(start.nodes().len()),
                budget => u64::from(budget),
            },
        };
        let start = SearchStart {
            name: String::new(),
            form: StartForm::Printed,
            program: (start, Notes::unwanted()),
        };
        let mut maker = NestedPasses {
            context,
            machine: &machine,
        };
        let mut outcome = search(&mut maker, vec![start], question)?;
        let rows = table::rows(&outcome);
        let Some(best) = outcome.best else {
            let mut trials = outcome.trials.iter();
            let failed = trials.find_map(|trial| Some((trial, trial.bound.as_ref().err()?)));
            let (trial, error) = failed.expect("what cannot be placed has a reason");
            return Err(explain(error, &trial.program.0, context));
        };
        context.remarks.extend(rows);
        let placed = outcome.trials.iter().filter(|trial| trial.cycles.is_some());
        let placed = placed.count() as u64;
        let made = (outcome.trials.len() + outcome.alike) as u64;
        context.count("variants made", made);
        context.count("variants placed", placed);
        let (taken, notes) = outcome.trials.swap_remove(best).program;
        *context.notes = notes;
        *function = taken;
        Ok(())
    }
}

/// Limit of the effort.
pub const EFFORT: NumberLimit =
    NumberLimit::whole(1, 10_000, "every unit of effort takes as long as the first");

/// Makes variants by running passes inside the pass: one after the other, since
/// they share the tables of the module.
struct NestedPasses<'a, 'b> {
    context: &'a mut Context<'b>,
    machine: &'a Machine,
}

impl ProgramMaker for NestedPasses<'_, '_> {
    type Program = (Function, Notes);

    fn make(
        &mut self,
        jobs: Vec<SearchJob<Self::Program>>,
    ) -> Vec<Result<Self::Program, PassError>> {
        let jobs = jobs.into_iter();
        let made = jobs.map(|job| {
            let (mut function, notes) = job.program;
            let mut report = NestedReport {
                notes,
                ..NestedReport::default()
            };
            let mut context = self.context.nested(self.machine, &mut report);
            apply(&job.pipeline, &mut function, &mut context)?;
            Ok((function, report.notes))
        });
        made.collect()
    }

    fn function(program: &Self::Program) -> &Function {
        &program.0
    }

    fn schedules(
        &mut self,
        programs: &[&Self::Program],
        machine: &Machine,
    ) -> Vec<Result<ScheduleSize, PlaceError>> {
        let functions = programs.iter().map(|(function, _)| function);
        functions
            .map(|function| schedule_size(function, machine))
            .collect()
    }
}
