//! Update of the histories over a pass.
//!
//! A value whose definition the pass left alone keeps its history. Any other
//! gets the history of its source and one more step: that of the same name
//! before the pass; else that of the value the pass noted; else that of the
//! value, or output, after which it is named.

use super::Notes;
use super::state::{DefinitionState, DefinitionSubject, OutputSymbols, assignment_of};
use hashbrown::HashMap;
use robovec_ir::{Function, Histories, History, HistoryStep, Name, Tables};
use rustc_hash::FxBuildHasher;

/// A function before a pass, as far as histories need it.
pub(crate) struct Follower {
    /// Without its history; the pass may write the function in place.
    before: Function,
    state: DefinitionState,
    histories: Histories,
}

impl Follower {
    /// Takes the histories out of a function that a pass is about to change;
    /// `None` when it has none.
    pub(crate) fn start(function: &mut Function) -> Option<Follower> {
        let histories = function.histories.take()?;
        Some(Follower {
            before: function.clone(),
            state: DefinitionState::of(function),
            histories,
        })
    }

    /// Gives the function, as the pass left it, its histories.
    pub(crate) fn finish(
        self,
        tables: &Tables,
        function: &mut Function,
        pass: &str,
        notes: &Notes,
    ) {
        let after = DefinitionState::of(function);
        let mut steps = HistoryExtension {
            histories: self.histories,
            pass,
            plain: HashMap::default(),
        };
        let owners = OutputSymbols::of(tables, &self.before);
        let mut values = Vec::with_capacity(function.nodes().len());
        for (value, node) in function.values() {
            if node.name.is_none() {
                values.push(History::NONE);
                continue;
            }
            let origin = origin(&self.state, &owners, node.name);
            let history = origin.map_or(History::NONE, |origin| steps.history_of(origin));
            let same = self.state.value(node.name).is_some_and(|old| {
                let old = self
                    .state
                    .definition(&self.before, DefinitionSubject::Value(old));
                old == after.definition(function, DefinitionSubject::Value(value))
            });
            values.push(if same {
                history
            } else {
                steps.add(history, notes.rules(node.name))
            });
        }
        let mut outputs = Vec::with_capacity(function.assignments.len());
        for (index, assignment) in function.assignments.iter().enumerate() {
            let Some(old) = assignment_of(&self.before, assignment.output) else {
                outputs.push(steps.add(History::NONE, std::iter::empty()));
                continue;
            };
            let old = DefinitionSubject::Output(old);
            let history = steps.history_of(old);
            let same = self.state.definition(&self.before, old)
                == after.definition(function, DefinitionSubject::Output(index));
            outputs.push(if same {
                history
            } else {
                steps.add(history, std::iter::empty())
            });
        }
        function.histories = Some(steps.histories.with_subjects(values, outputs));
    }
}

/// The origin of the value that has a name after a pass: the value of that name
/// before it, or else its namesake, so that `OM16.2` comes from `OM16`.
pub(super) fn origin(
    before: &DefinitionState,
    owners: &OutputSymbols,
    name: Name,
) -> Option<DefinitionSubject> {
    let own = before.value(name).map(DefinitionSubject::Value);
    own.or_else(|| before.namesake(name, owners))
}

/// The table of steps being extended by one pass.
struct HistoryExtension<'a> {
    histories: Histories,
    pass: &'a str,
    /// The step of this pass without rules, by the history before it: the
    /// frequent case, without making texts.
    plain: HashMap<History, History, FxBuildHasher>,
}

impl HistoryExtension<'_> {
    fn history_of(&self, subject: DefinitionSubject) -> History {
        let found = match subject {
            DefinitionSubject::Value(value) => self.histories.values.get(value.index()),
            DefinitionSubject::Output(index) => self.histories.outputs.get(index),
        };
        found.copied().unwrap_or(History::NONE)
    }

    fn add<'r>(&mut self, before: History, rules: impl Iterator<Item = &'r str>) -> History {
        let rules: Vec<String> = rules.map(str::to_owned).collect();
        if rules.is_empty()
            && let Some(&known) = self.plain.get(&before)
        {
            return known;
        }
        let plain = rules.is_empty();
        let history = self.histories.add(HistoryStep {
            before,
            pass: self.pass.to_owned(),
            rules,
        });
        if plain {
            self.plain.insert(before, history);
        }
        history
    }
}

/// Gives a function that has no histories empty ones.
pub(crate) fn begin(function: &mut Function) {
    if function.histories.is_none() {
        let (values, outputs) = (function.nodes().len(), function.assignments.len());
        function.histories = Some(Histories::new(values, outputs));
    }
}
