//! The trail: the history of every value.
//!
//! A value of the last state of a compilation has little to do with the text
//! of its equation. Two things show how it came about:
//!
//! - its *history* ([`robovec_ir::History`]), the passes that made or changed
//!   it and the rules these applied, which goes with the function and into
//!   its text;
//! - the [`Trail`], every state a pass found with what the pass noted, from
//!   which [`explain`] shows the story of one value with its expressions.
//!
//! Most of both is found by comparing definitions before and after a pass; what
//! only the pass itself knows (which rule, from which value), it notes while it
//! runs: [`Context::note`](crate::pass::Context::note). Neither is kept unless
//! requested, and neither has an influence on any pass.

mod account;
mod expression;
mod find;
mod follow;
mod names;
mod notes;
mod state;
mod states;

pub use account::{Account, DefinitionChange, Gone, Moment, PassEntry, explain};
pub use find::{NotFound, TrackedItem, find};
pub use notes::{Notes, equal_to};
pub use state::DefinitionSubject;
pub use states::{TrailState, states};

pub(crate) use follow::{Follower, begin};

use robovec_ir::Function;

/// The states that the passes of a run found, where they changed them.
#[derive(Default, Debug)]
pub struct Trail {
    stages: Vec<Stage>,
}

/// A pass that changed a function.
#[derive(Debug)]
struct Stage {
    /// The function as the pass found it.
    before: Function,
    /// The pass with its options, as in the pipeline.
    pass: String,
    notes: Notes,
}

impl Trail {
    /// Nothing has run yet.
    pub fn new() -> Trail {
        Trail::default()
    }

    pub(crate) fn add(&mut self, before: Function, pass: &str, notes: Notes) {
        self.stages.push(Stage {
            before,
            pass: pass.to_owned(),
            notes,
        });
    }

    /// The stages of one function, in order.
    fn of(&self, function: &str) -> Vec<&Stage> {
        let stages = self.stages.iter();
        stages
            .filter(|stage| stage.before.name == function)
            .collect()
    }
}
