//! The trail: the history of every value.
//!
//! A value of the last state of a compilation has little to do with the text of
//! its equation. Its origin is recorded twice:
//!
//! - its *history* ([`robovec_ir::History`]), the passes that made or changed
//!   it and the rules these applied, which is stored with the function and in
//!   its text;
//! - the [`Trail`], every state before a pass with the notes of the pass, from
//!   which [`explain`] shows the history of one value with its expressions.
//!
//! Most of both is found by comparing definitions before and after a pass;
//! facts known only to the pass (the rule, the source value) are noted while it
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

/// The states before the passes of a run that changed them.
#[derive(Default, Debug)]
pub struct Trail {
    stages: Vec<Stage>,
}

/// A pass that changed a function.
#[derive(Debug)]
struct Stage {
    /// The function before the pass.
    before: Function,
    /// The pass with its options, as in the pipeline.
    pass: String,
    notes: Notes,
}

impl Trail {
    /// An empty trail, before any pass has run.
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
