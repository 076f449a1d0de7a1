//! Look-ahead within a budget of operations.

use crate::choice::chooser::ChoiceMethod;
use crate::choice::compose::{CompositionLimits, look_ahead};
use crate::choice::search::{self, PathSearch};
use robovec_analysis::critical_path::Weights;
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_ir::{Function, Level};
use robovec_num::limits::NumberLimit;

declare_pass! {
    /// Shortens the longest path by looking back across several equations.
    ///
    /// The late value of a recursion enters its equations linearly: `x = c*u + e`
    /// with `c` and `e` known early. Substituting `u = d*v + f` gives `x` from
    /// `v`, one step earlier, with the coefficient `c*d` and the rest `c*f + e`
    /// computed beside the recursion. Such forms are made for all sums and
    /// products at many frontiers back in time, each in several variants, and
    /// the cheapest combination is chosen that makes the longest path as short
    /// as the budget of operations allows: a parallel prefix network where it
    /// shortens the path, shared by all columns of a mass matrix, and unchanged
    /// code elsewhere.
    ///
    /// Values are identified by their residues at two points of the prime
    /// field, so equal values written differently are merged, and the function
    /// can end up with fewer operations than before.
    ///
    /// If no path can be shortened within the budget, the function is
    /// unchanged. `sin` and `cos` are taken as independent: no identity between
    /// them is used. `balance,cse,dce` belong after this pass.
    pub struct Lookahead("lookahead") {
        /// Operations allowed, in percent of those the function has.
        pub growth: u32 = 100 => search::GROWTH,
        /// Operations allowed, as a number; 0 leaves it to `growth`.
        pub operations: u32 = 0 => search::OPERATIONS,
        /// Longest path wanted, in cycles: nothing is spent on a shorter one.
        pub path: u32 = 0 => search::PATH,
        /// Cycles from one frontier to the next.
        pub grid: u32 = 10 => NumberLimit::whole(
            1, 1_000_000, "there are no frontiers further back"),
        /// Frontiers looked back.
        pub frontiers: u32 = 24 => NumberLimit::whole(
            0, 256, "every value gets up to two forms for every frontier"),
        /// Number of times the distance between frontiers is doubled, to look
        /// further back.
        pub doublings: u32 = 0 => NumberLimit::whole(
            0, 20, "every value gets forms at all frontiers of every distance"),
        /// Late terms a form may have.
        pub width: u32 = 24 => NumberLimit::whole(
            0, 64, "a form is composed of the forms of its terms, width times width products each"),
        /// Late terms up to which a form is made nevertheless: of more than
        /// `width` the earliest are summed up with what is known early. With
        /// many operations to spend, `reach=96 window=300` finds shorter paths.
        pub reach: u32 = 0 => NumberLimit::whole(
            0, 256, "every form is composed of this number of terms"),
        /// A value ready this number of cycles before a frontier counts as
        /// early.
        pub window: u32 = 100 => NumberLimit::whole(
            0, 1_000_000, "no value is ready earlier"),
        /// Way in which forms are chosen; by curves up to 200,000 values
        /// considered.
        pub choice: ChoiceMethod = ChoiceMethod::default(),
        /// Rounds in which operations are saved again.
        pub rounds: u32 = 3 => search::ROUNDS,
    }
    takes: [Atomic],
    gives: Gives::Level(Level::Atomic),
    class: Real,
    destroys: [Timed],
}

impl Pass for Lookahead {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let weights = Weights::cycles(context.machine);
        let timing = weights.with_equal_sums();
        let limits = CompositionLimits {
            grid: self.grid.max(1),
            frontiers: self.frontiers,
            doublings: self.doublings,
            width: self.width as usize,
            reach: self.reach as usize,
            window: self.window,
        };
        let Some((import, _)) = look_ahead(function, context, timing, limits) else {
            return Ok(());
        };
        let search = PathSearch {
            function,
            import: &import,
            timing,
            weights,
            shortest: self.path,
            rounds: self.rounds,
            method: self.choice,
        };
        let before = search.size(function);
        let allowed = search::allowed(self.operations, self.growth, before.1);
        context.statistics.extend(import.counts());
        let mut cycles = 0;
        if let Some((new, (path, _))) = search.run(context.tables, before, allowed) {
            cycles = u64::from(before.0 - path);
            *function = new;
        }
        context.count("cycles taken off the longest path", cycles);
        Ok(())
    }
}
