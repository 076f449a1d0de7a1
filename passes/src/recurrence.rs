//! Linear recurrences solved by parallel prefix.

use crate::balance::balanced;
use crate::choice::chooser::{ChoiceMethod, FormChooser};
use crate::choice::compose::{CompositionLimits, look_ahead};
use crate::choice::emit::emit;
use crate::choice::import::Import;
use crate::choice::map::Mapper;
use crate::choice::search;
use robovec_analysis::critical_path::{Weights, arrivals, longest};
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_ir::{Function, Level, Tables};
use robovec_num::limits::NumberLimit;

declare_pass! {
    /// Finds linear recurrences and solves them by parallel prefix.
    ///
    /// Along a chain of bodies velocities, accelerations, forces and torques
    /// follow recurrences `x = A*x' + b` whose matrices are known early. They
    /// are found in the plain equations, for any formulation: every sum and
    /// product is treated as linear in its latest operands, and written in the
    /// values available at the last multiple of 1, 2, 4, 8 ... `grid` cycles,
    /// each of these forms being composed of two of the one before. That is
    /// Sklansky's network (1960) on products of matrices that all right-hand
    /// sides of a recurrence share; the longest path grows with the logarithm
    /// of the length of the chain.
    ///
    /// The path comes first; operations are then taken off again where there is
    /// time. Where `lookahead` shortens a path within a budget of operations,
    /// this pass uses as many operations as the path requires. The function is
    /// unchanged if its path does not become shorter. `balance,cse,dce` belong
    /// after it.
    pub struct Recurrence("recurrence") {
        /// Longest path wanted, in cycles: nothing is spent on a shorter one.
        pub path: u32 = 0 => search::PATH,
        /// Smallest distance between points to look back to, in cycles.
        pub grid: u32 = 40 => NumberLimit::whole(
            1, 1_000_000, "there are no points further back"),
        /// Points looked back to, of every distance.
        pub frontiers: u32 = 3 => NumberLimit::whole(
            0, 256, "every value gets up to two forms for every point"),
        /// Late terms a form may have.
        pub width: u32 = 12 => NumberLimit::whole(
            0, 64, "a form is composed of the forms of its terms, width times width products each"),
        /// A value ready this number of cycles before such a point counts as
        /// early.
        pub window: u32 = 250 => NumberLimit::whole(
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

impl Pass for Recurrence {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let weights = Weights::cycles(context.machine);
        let timing = weights.with_equal_sums();
        let path = |function: &Function| longest(&arrivals(function, &weights));
        let before = path(function);
        let grid = self.grid.max(1);
        let limits = CompositionLimits {
            grid,
            frontiers: self.frontiers,
            doublings: (before / grid).checked_ilog2().map_or(0, |power| power + 1),
            width: self.width as usize,
            reach: 0,
            window: self.window,
        };
        let Some((import, chain)) = look_ahead(function, context, timing, limits) else {
            return Ok(());
        };
        let chain = ("equations in the longest recurrence", u64::from(chain));
        context.statistics.push(chain);
        context.statistics.extend(import.counts());
        let mut cycles = 0;
        let tables = &mut *context.tables;
        if let Some(raw) = self.shortest(function, import, timing, before, tables) {
            let new = balanced(&raw, tables, &weights);
            let after = path(&new);
            if after < before {
                cycles = before - after;
                *function = new;
            }
        }
        let statistic = ("cycles taken off the longest path", u64::from(cycles));
        context.statistics.push(statistic);
        Ok(())
    }
}

impl Recurrence {
    /// The function with the shortest path, if that is shorter than before. It
    /// consumes the network, which is several times the size of the function.
    fn shortest(
        &self,
        function: &Function,
        import: Import,
        timing: Weights,
        before: u32,
        tables: &mut Tables,
    ) -> Option<Function> {
        let mapper = Mapper::new(&import.network, timing, &import.outputs);
        let chooser = FormChooser::new(&mapper, self.choice, self.rounds);
        let target = chooser.shortest().max(self.path);
        if target >= before {
            return None;
        }
        let mapping = chooser.map_once(target);
        Some(emit(function, &import, &mapper, &mapping, timing, tables))
    }
}
