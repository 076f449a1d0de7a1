//! Look-ahead within a budget of operations.

use crate::balance::balanced;
use crate::choice::compose::{CompositionLimits, look_ahead};
use crate::choice::emit::emit;
use crate::choice::import::Import;
use crate::choice::map::{Mapper, Mapping};
use robovec_analysis::critical_path::{Weights, arrivals};
use robovec_framework::declare_pass;
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_ir::{Function, Level, Tables};
use robovec_num::limits::NumberLimit;

declare_pass! {
    /// Shortens the longest path by looking back across several equations.
    ///
    /// What is late in a recursion enters its equations linearly: `x = c*u + e`
    /// with `c` and `e` known early. Substituting `u = d*v + f` gives `x` from
    /// `v`, one step earlier, with the coefficient `c*d` and the rest `c*f + e`
    /// computed beside the recursion. Such forms are made for all sums and
    /// products at many frontiers back in time, each in several ways, and the
    /// cheapest combination is chosen that makes the longest path as short as
    /// the budget of operations allows: a parallel prefix network where it
    /// pays, shared by all columns of a mass matrix, and nothing elsewhere.
    ///
    /// Values are identified by what they are at two points of the prime field,
    /// so equal values written differently become one on the way, and the
    /// function can end up with fewer operations than it had.
    ///
    /// A path that cannot be shortened within the budget leaves the function as
    /// it is. `sin` and `cos` are taken as independent: no identity between them
    /// is used. `balance,cse,dce` belong behind this pass.
    pub struct Lookahead("lookahead") {
        /// Operations allowed, in percent of those the function has.
        pub growth: u32 = 100 => NumberLimit::whole(
            0, 10_000, "operations become up to a hundred times those there are"),
        /// Operations allowed, as a number; 0 leaves it to `growth`.
        pub operations: u32 = 0 => NumberLimit::whole(
            0, 100_000_000, "no function has more operations"),
        /// Longest path wanted, in cycles: nothing is spent on a shorter one.
        pub path: u32 = 0 => NumberLimit::whole(
            0, 1_000_000_000, "no function takes more cycles"),
        /// Cycles from one frontier to the next.
        pub grid: u32 = 10 => NumberLimit::whole(
            1, 1_000_000, "no frontier is left to look back to"),
        /// Frontiers looked back.
        pub frontiers: u32 = 24 => NumberLimit::whole(
            0, 256, "every value gets up to two forms for every frontier"),
        /// How often the distance between frontiers is doubled, to look further
        /// back.
        pub doublings: u32 = 0 => NumberLimit::whole(
            0, 20, "every value gets forms at all frontiers of every distance"),
        /// Late terms a form may have.
        pub width: u32 = 12 => NumberLimit::whole(
            0, 64, "a form is composed of the forms of its terms, width times width products each"),
        /// A value ready so many cycles before a frontier counts as early.
        pub window: u32 = 60 => NumberLimit::whole(
            0, 1_000_000, "no value is ready earlier"),
        /// Rounds in which operations are saved again.
        pub rounds: u32 = 6 => NumberLimit::whole(
            0, 64, "operations are counted and chosen again for every value in every round"),
    }
    takes: [Atomic],
    gives: Gives::Level(Level::Atomic),
    class: Real,
    requires: [],
    sets: [],
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
            window: self.window,
        };
        let Some((import, _)) = look_ahead(function, context, timing, limits) else {
            return Ok(());
        };
        let search = LookaheadSearch {
            pass: self,
            function,
            import: &import,
            timing,
            weights,
        };
        let before = search.size(function);
        let (forms, classes) = (import.network.form_count(), import.network.len());
        context
            .statistics
            .push(("values considered", classes as u64));
        context.statistics.push(("forms considered", forms as u64));
        let mut cycles = 0;
        if let Some((new, path)) = search.run(context.tables, before) {
            cycles = u64::from(before.0 - path);
            *function = new;
        }
        context
            .statistics
            .push(("cycles taken off the longest path", cycles));
        Ok(())
    }
}

/// In how many steps the path is shortened at least.
const STEPS: u32 = 10;

/// The part of the path below which a step is not worth its time.
const FINEST: u64 = 400;

/// The step to try after one was too dear, from the operations before it, those
/// allowed and those it took: where the budget should end, half way at most.
fn smaller_step(step: u32, (before, allowed, dear): (u64, u64, u64)) -> u32 {
    let (left, taken) = (allowed.saturating_sub(before), dear.saturating_sub(before));
    let share = u64::from(step) * left / taken.max(1);
    u32::try_from(share).map_or(step / 2, |share| share.clamp(step / 8, step / 2))
}

/// The search for the shortest path within the budget.
struct LookaheadSearch<'a> {
    pass: &'a Lookahead,
    function: &'a Function,
    import: &'a Import,
    timing: Weights,
    weights: Weights,
}

impl LookaheadSearch<'_> {
    /// Longest path in cycles, and operations.
    fn size(&self, function: &Function) -> (u32, u64) {
        let path = arrivals(function, &self.weights).into_iter().max();
        let free = function.nodes().iter();
        let free = free
            .filter(|node| node.operation.is_trigonometric())
            .count();
        (path.unwrap_or(0), (function.nodes().len() - free) as u64)
    }

    /// The best function and its path, if it is better than what there was.
    fn run(&self, tables: &mut Tables, before: (u32, u64)) -> Option<(Function, u32)> {
        let allowed = match self.pass.operations {
            0 => before.1 * u64::from(self.pass.growth) / 100,
            operations => u64::from(operations),
        };
        let mapper = Mapper::new(&self.import.network, self.timing, &self.import.outputs);
        let earliest = mapper.earliest();
        let fastest = mapper.path(&earliest).max(self.pass.path);
        let mut best: Option<(Function, (u32, u64))> = None;
        // A mapping is best modelled on one that is little later, so the path
        // is shortened step by step, and when a step is too dear by less.
        let mut model = mapper.cheapest(self.pass.rounds);
        let mut reached = before;
        let mut step = (before.0.saturating_sub(fastest) / STEPS).max(1);
        while reached.0 > fastest && u64::from(step) * FINEST >= u64::from(reached.0) {
            let target = reached.0.saturating_sub(step).max(fastest);
            let mut mapping = earliest.clone();
            mapper.recover(&mut mapping, target, self.pass.rounds, Some(model.clone()));
            let made = self.realise(tables, &mapper, &mapping);
            let size = self.size(&made);
            if size.1 > allowed {
                step = smaller_step(step, (reached.1, allowed, size.1));
                continue;
            }
            reached = (target.min(size.0), size.1);
            model = mapping.into_uses();
            if best.as_ref().is_none_or(|(_, known)| size < *known) {
                best = Some((made, size));
            }
        }
        best.filter(|(_, size)| *size < before)
            .map(|(function, size)| (function, size.0))
    }

    /// The function of a mapping, balanced.
    fn realise(&self, tables: &mut Tables, mapper: &Mapper<'_>, mapping: &Mapping) -> Function {
        let import = self.import;
        let raw = emit(self.function, import, mapper, mapping, self.timing, tables);
        balanced(&raw, tables, &self.weights)
    }
}
