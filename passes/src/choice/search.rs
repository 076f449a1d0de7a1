//! The shortest path that a network allows within a budget of operations, and
//! the fewest operations within a path.

use super::chooser::{ChoiceMethod, FormChooser};
use super::emit::emit;
use super::import::Import;
use super::map::{Mapper, Mapping};
use crate::balance::balanced;
use robovec_analysis::critical_path::{Weights, arrivals, longest};
use robovec_ir::{Function, Tables};
use robovec_num::limits::NumberLimit;

/// Operations allowed, in percent of the present number.
pub(crate) const GROWTH: NumberLimit = NumberLimit::whole(
    0,
    10_000,
    "the number of operations grows up to a hundred times",
);

/// Operations allowed, as a number.
pub(crate) const OPERATIONS: NumberLimit =
    NumberLimit::whole(0, 100_000_000, "no function has more operations");

/// A path, in cycles.
pub(crate) const PATH: NumberLimit =
    NumberLimit::whole(0, 1_000_000_000, "no function takes more cycles");

/// Rounds in which operations are saved again.
pub(crate) const ROUNDS: NumberLimit = NumberLimit::whole(
    0,
    64,
    "in every round the operations of every value are counted and chosen again",
);

/// The operations allowed: this number, or for 0 a part of the present number,
/// in percent.
pub(crate) fn allowed(operations: u32, growth: u32, before: u64) -> u64 {
    match operations {
        0 => before * u64::from(growth) / 100,
        operations => u64::from(operations),
    }
}

/// The step to try after one was too dear, from the operations before it, those
/// allowed and those it took: where the budget should end, half way at most.
fn smaller_step(step: u32, (before, allowed, dear): (u64, u64, u64)) -> u32 {
    let (left, taken) = (allowed.saturating_sub(before), dear.saturating_sub(before));
    let share = u64::from(step) * left / taken.max(1);
    u32::try_from(share).map_or(step / 2, |share| share.clamp(step / 8, step / 2))
}

/// The search for the shortest path within a budget of operations, or for the
/// fewest operations within a path.
pub(crate) struct PathSearch<'a> {
    /// The function that was read: its signature and its names.
    pub(crate) function: &'a Function,
    pub(crate) import: &'a Import,
    pub(crate) timing: Weights,
    pub(crate) weights: Weights,
    /// The path, in cycles, below which nothing is spent.
    pub(crate) shortest: u32,
    /// Rounds in which operations are saved again.
    pub(crate) rounds: u32,
    /// Way in which forms are chosen.
    pub(crate) method: ChoiceMethod,
}

impl PathSearch<'_> {
    /// Longest path in cycles, and operations.
    pub(crate) fn size(&self, function: &Function) -> (u32, u64) {
        let path = longest(&arrivals(function, &self.weights));
        let free = function.nodes().iter();
        let free = free
            .filter(|node| node.operation.is_trigonometric())
            .count();
        (path, (function.nodes().len() - free) as u64)
    }

    /// The function with the shortest path, and its size, if it is better than
    /// the best so far.
    pub(crate) fn run(
        &self,
        tables: &mut Tables,
        before: (u32, u64),
        allowed: u64,
    ) -> Option<(Function, (u32, u64))> {
        let mapper = Mapper::new(&self.import.network, self.timing, &self.import.outputs);
        let mut chooser = FormChooser::new(&mapper, self.method, self.rounds);
        let fastest = chooser.shortest().max(self.shortest);
        let (steps, finest) = chooser.steps();
        let mut best: Option<(Function, (u32, u64))> = None;
        // A mapping is best modelled on one that is little later, so the path
        // is shortened step by step, and when a step is too dear by less.
        let mut reached = before;
        let mut step = (before.0.saturating_sub(fastest) / steps).max(1);
        // What is made of a mapping has fewer operations.
        let mut enough = allowed;
        while reached.0 > fastest && u64::from(step) * finest >= u64::from(reached.0) {
            let target = reached.0.saturating_sub(step).max(fastest);
            let mapping = chooser.map(target, enough);
            let (made, size) = self.realise(tables, &mapper, &mapping);
            enough = allowed * mapping.operations / size.1.max(1);
            if size.1 > allowed {
                step = smaller_step(step, (reached.1, allowed, size.1));
                chooser.go_back();
                continue;
            }
            reached = (target.min(size.0), size.1);
            chooser.keep(mapping);
            if best.as_ref().is_none_or(|(_, known)| size < *known) {
                best = Some((made, size));
            }
        }
        // Where the budget is no limit, operations are saved all the same.
        if let Some((_, known)) = best
            && reached.0 <= fastest
            && let Some(mapping) = chooser.map_again(fastest)
        {
            let (made, size) = self.realise(tables, &mapper, &mapping);
            if size < known && size.1 <= allowed {
                best = Some((made, size));
            }
        }
        best.filter(|(_, size)| *size < before)
    }

    /// The function with few operations that is no later than `shortest`, or
    /// any when that is 0, and its size.
    pub(crate) fn cheapest(&self, tables: &mut Tables) -> (Function, (u32, u64)) {
        let mapper = Mapper::new(&self.import.network, self.timing, &self.import.outputs);
        let chooser = FormChooser::new(&mapper, self.method, self.rounds);
        let latest = match self.shortest {
            0 => u32::MAX,
            path => path.max(chooser.shortest()),
        };
        self.realise(tables, &mapper, &chooser.map_once(latest))
    }

    /// The function of a mapping, balanced, and its size.
    fn realise(
        &self,
        tables: &mut Tables,
        mapper: &Mapper<'_>,
        mapping: &Mapping,
    ) -> (Function, (u32, u64)) {
        let import = self.import;
        let raw = emit(self.function, import, mapper, mapping, self.timing, tables);
        let made = balanced(&raw, tables, &self.weights);
        let size = self.size(&made);
        (made, size)
    }
}
