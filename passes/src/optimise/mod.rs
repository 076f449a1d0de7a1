//! The variant that suits the machine.
//!
//! With few elements operations decide, with many the longest path does, and
//! between the two neither: so variants are placed and the schedules compared
//! (facts that hold for every list scheduler: a schedule is at least as long
//! as the path and as the operations of a kind over its elements). The parts:
//!
//! - `variants`: what is tried;
//! - `trial`: variants made and measured, within a budget of operations;
//! - `choice`: the best of them; schedules are made only where the proved
//!   bound leaves a chance;
//! - `table`: what was tried, for people.

mod choice;
mod table;
mod trial;
mod variants;

use robovec_analysis::class::NumericClass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::{declare_pass, option_words};
use robovec_ir::Function;
use robovec_ir::machine::fields;
use robovec_num::limits::NumberLimit;
use robovec_schedule::{element_counts, explain, with_counts};

option_words! {
    /// What a variant is chosen for.
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
    /// What the variants may rest on.
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
    /// the fewest operations or the shortest path. What was tried is told in
    /// a table:
    ///
    /// ```text
    /// variant       operations  path  bound  cycles
    /// reassociated        4907   350    622     622  taken
    /// as printed          5379   758    758       -  cannot be better
    /// ```
    ///
    /// `bound` is a proved lower bound of the schedule: a variant whose bound
    /// is no shorter than a schedule that is known is not placed. Variants
    /// from composite bodies rest on sin^2 + cos^2 = 1 (`class=real` leaves them
    /// out). Variants with fused multiply-adds are tried where the machine has elements for
    /// them.
    ///
    /// The function comes out at the level atomic; `place` with the same
    /// numbers of elements gives the schedule of the table.
    pub struct Optimise("optimise") {
        /// What the variant is chosen for.
        pub r#for: Goal = Goal::default(),
        /// What the variants may rest on.
        pub class: VariantClass = VariantClass::default(),
        /// Adders; the machine file says how many otherwise.
        pub n_add: Option<u32> = None => fields::count::LIMIT,
        /// Multipliers; the machine file says how many otherwise.
        pub n_multi: Option<u32> = None => fields::count::LIMIT,
        /// Dividers, on machines that have them.
        pub n_div: Option<u32> = None => fields::count::LIMIT,
        /// Square-root extractors, on machines that have them.
        pub n_sqrt: Option<u32> = None => fields::count::LIMIT,
        /// Elements that multiply and add in one operation, on machines that
        /// have them.
        pub n_fma: Option<u32> = None => fields::count::LIMIT,
        /// The operations of all variants together after which no further one
        /// is made: all for a model of 100,000 operations, a few for a larger
        /// one.
        pub budget: u32 = 4_000_000 => NumberLimit::whole(
            0, 1_000_000_000, "variants are made until they have so many operations together"),
    }
    takes: [Equations, Atomic],
    gives: Gives::Level(robovec_ir::Level::Atomic),
    class: RealTrig,
    requires: [],
    sets: [],
    destroys: [Timed],
}

impl Pass for Optimise {
    fn class(&self, declared: NumericClass) -> NumericClass {
        match self.class {
            VariantClass::Real => NumericClass::Real,
            VariantClass::RealTrig => declared,
        }
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
        let class = self.class(Optimise::INFO.class);
        let mut trials = trial::make(function, &machine, (self.budget, class), context)?;
        let choice = choice::choose(&mut trials, &machine, self.r#for);
        let rows = table::rows(&trials, choice.as_ref().ok().copied());
        let taken = match choice {
            Ok(taken) => taken,
            Err((index, error)) => {
                return Err(explain(&error, &trials[index].function, context));
            }
        };
        context.remarks.extend(rows);
        let made = trials.iter().filter(|trial| trial.is_made()).count();
        let placed = trials.iter().filter(|trial| trial.cycles.is_some()).count();
        context.statistics.push(("variants made", made as u64));
        context.statistics.push(("variants placed", placed as u64));
        let taken = trials.swap_remove(taken);
        *context.notes = taken.notes;
        *function = taken.function;
        Ok(())
    }
}
