//! The histories of values: the passes that made or changed them, and the rules
//! these applied.
//!
//! Kept only on request, beside the nodes and not in them: a table of steps
//! that all values share, and four bytes per value. A history is a chain, each
//! step naming the one before it, so that the thousands of values with the same
//! passes share one.

use hashbrown::HashMap;
use rustc_hash::FxBuildHasher;

/// The history of a value: its last step, in a table of [`Histories`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Debug)]
pub struct History(u32);

impl History {
    /// The history of a value that was read and not changed since.
    pub const NONE: History = History(0);

    /// The place of the last step in the table; `None` for a value that was
    /// read and not changed since.
    #[inline]
    pub fn index(self) -> Option<usize> {
        (self.0 as usize).checked_sub(1)
    }
}

/// A pass that made a value or changed its definition.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct HistoryStep {
    /// The history of its origin.
    pub before: History,
    /// The pass with its options, as in the pipeline.
    pub pass: String,
    /// The rules the pass applied, in order; empty for a pass that shows
    /// none.
    pub rules: Vec<String>,
}

/// The histories of a function's values.
#[derive(Clone, Default, Debug)]
pub struct Histories {
    steps: Vec<HistoryStep>,
    index: HashMap<HistoryStep, u32, FxBuildHasher>,
    /// One for every node; inner nodes of expressions have
    /// [`History::NONE`], since they belong to their definition or output.
    pub values: Vec<History>,
    /// One for every assignment.
    pub outputs: Vec<History>,
}

impl Histories {
    /// Histories of a function without changes since it was read.
    pub fn new(values: usize, outputs: usize) -> Histories {
        Histories {
            values: vec![History::NONE; values],
            outputs: vec![History::NONE; outputs],
            ..Histories::default()
        }
    }

    /// The history that ends with this step; equal steps give equal
    /// histories. The step's own past must be of this table.
    pub fn add(&mut self, step: HistoryStep) -> History {
        assert!(
            step.before.0 as usize <= self.steps.len(),
            "a step comes after those before it"
        );
        let next = self.steps.len() as u32 + 1;
        if let Some(&known) = self.index.get(&step) {
            return History(known);
        }
        self.steps.push(step.clone());
        self.index.insert(step, next);
        History(next)
    }

    /// All steps; each comes after its predecessors.
    pub fn steps(&self) -> &[HistoryStep] {
        &self.steps
    }

    /// The last step of a history.
    pub fn step(&self, history: History) -> Option<&HistoryStep> {
        self.steps.get(history.index()?)
    }

    /// The steps of a history, the first one first.
    pub fn chain(&self, history: History) -> Vec<&HistoryStep> {
        let mut chain = Vec::new();
        let mut next = history;
        while let Some(step) = self.step(next) {
            chain.push(step);
            next = step.before;
        }
        chain.reverse();
        chain
    }

    /// Returns the steps, for writing the histories of the next state after
    /// them.
    #[must_use]
    pub fn with_subjects(self, values: Vec<History>, outputs: Vec<History>) -> Histories {
        Histories {
            values,
            outputs,
            ..self
        }
    }

    /// For every step its printed number, counted from 1; 0 for those no value
    /// or output needs.
    pub(crate) fn numbers(&self) -> Vec<u32> {
        let mut needed = vec![0; self.steps.len()];
        for index in self.subjects().filter_map(|history| history.index()) {
            needed[index] = 1;
        }
        for (index, step) in self.steps.iter().enumerate().rev() {
            if needed[index] == 1
                && let Some(before) = step.before.index()
            {
                needed[before] = 1;
            }
        }
        let mut next = 0;
        for number in needed.iter_mut().filter(|number| **number == 1) {
            next += 1;
            *number = next;
        }
        needed
    }

    fn subjects(&self) -> impl Iterator<Item = History> + '_ {
        self.values.iter().chain(&self.outputs).copied()
    }
}

/// True when the values and outputs of two functions have the same histories;
/// the internal numbering of steps does not count, and no table equals an empty
/// one.
pub(crate) fn same_histories(left: Option<&Histories>, right: Option<&Histories>) -> bool {
    let mut common = Histories::default();
    let mut renumbered = |histories: Option<&Histories>| {
        let Some(histories) = histories else {
            return (Vec::new(), Vec::new());
        };
        let mut translation = vec![History::NONE];
        for step in &histories.steps {
            translation.push(common.add(HistoryStep {
                before: translation[step.before.0 as usize],
                ..step.clone()
            }));
        }
        let translate = |list: &[History]| -> Vec<History> {
            let new = list.iter().map(|history| translation[history.0 as usize]);
            let mut new: Vec<History> = new.collect();
            while new.pop_if(|last| *last == History::NONE).is_some() {}
            new
        };
        (translate(&histories.values), translate(&histories.outputs))
    };
    renumbered(left) == renumbered(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(before: History, pass: &str) -> HistoryStep {
        HistoryStep {
            before,
            pass: pass.to_owned(),
            rules: Vec::new(),
        }
    }

    #[test]
    fn histories_are_shared_and_compared_by_what_they_say() {
        let mut left = Histories::new(2, 1);
        let unused = left.add(step(History::NONE, "fold"));
        let first = left.add(step(History::NONE, "atomise"));
        let second = left.add(step(first, "balance"));
        assert_eq!(left.add(step(first, "balance")), second);
        assert_eq!(left.chain(second).len(), 2);
        assert_ne!(unused, first);
        left.values = vec![second, History::NONE];
        assert_eq!(left.numbers(), [0, 1, 2]);

        let mut right = Histories::new(2, 1);
        let first = right.add(step(History::NONE, "atomise"));
        let second = right.add(step(first, "balance"));
        right.values = vec![second, History::NONE];
        assert!(same_histories(Some(&left), Some(&right)));
        right.values[1] = first;
        assert!(!same_histories(Some(&left), Some(&right)));
        assert!(same_histories(None, Some(&Histories::new(5, 5))));
    }
}
