//! The story of one value, from its equation to the last state.

use super::expression::{WrittenExpression, of_output, of_value};
use super::find::TrackedItem;
use super::follow::origin;
use super::state::{
    Definition, DefinitionState, DefinitionSubject, OutputSymbols, assignment_of, name_of,
};
use super::{Notes, Stage, Trail};
use robovec_analysis::critical_path::{Weights, arrivals, longest, tails};
use robovec_ir::{Function, HistoryStep, Machine, SourceSet, Tables, View};

/// The account of a value or an output.
#[derive(Clone, PartialEq, Debug)]
pub struct Account {
    /// Its name in the text.
    pub name: String,
    /// The equations it comes from; of an output, also those of the value it
    /// is set to.
    pub sources: Vec<SourceSet>,
    /// The histories from before this run, of the item and of its sources: name
    /// and steps, those without a step left out.
    pub earlier: Vec<(String, Vec<HistoryStep>)>,
    /// The states of it, and of its sources, before the first pass.
    pub read: Vec<Moment>,
    /// The passes that changed it, in order.
    pub entries: Vec<PassEntry>,
    /// Its present state; `None` when a pass removed it.
    pub now: Option<Moment>,
    /// Removal, where it was removed.
    pub gone: Option<Gone>,
}

/// The pass that removed a value.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Gone {
    /// The pass with its options.
    pub pass: String,
    /// The value that took its place, when the pass reported it.
    pub into: Option<String>,
}

/// A pass that had a part in a value.
#[derive(Clone, PartialEq, Debug)]
pub struct PassEntry {
    /// The pass with its options, as in the pipeline.
    pub pass: String,
    /// The changes it made.
    pub changes: Vec<DefinitionChange>,
}

/// One definition that a pass changed.
#[derive(Clone, PartialEq, Debug)]
pub struct DefinitionChange {
    /// The state of its source; `None` without a known source.
    pub before: Option<Moment>,
    /// The state it became.
    pub after: Moment,
    /// The rules the pass applied to it.
    pub rules: Vec<String>,
    /// The definition is unchanged, but represents these equations from here
    /// on.
    pub merged: Option<SourceSet>,
}

/// A definition in one state of its function.
#[derive(Clone, PartialEq, Debug)]
pub struct Moment {
    /// The definition, with the intermediate values of the same equation
    /// expanded.
    pub text: String,
    /// Time at which its result is available at the earliest, in cycles.
    pub arrival: u32,
    /// The number of cycles it could be later without lengthening the longest
    /// path.
    pub slack: u32,
    /// The longest path of the function, in cycles.
    pub path: u32,
}

/// Number of values that are followed at most: where an output was set to
/// another value, both stories are reported.
const MAX_FOLLOWED: usize = 8;

/// Reports the origin of an item that was [found](super::find), through all
/// states, in the function at the end of the run.
///
/// The time is linear in the function for every pass that changed it.
pub fn explain(
    tables: &Tables,
    function: &Function,
    trail: &Trail,
    machine: &Machine,
    item: TrackedItem,
) -> Account {
    let stages = trail.of(&function.name);
    let weights = Weights::cycles(machine);
    // The last state that has the item, counted in stages.
    let states: Vec<&Function> = stages.iter().map(|stage| &stage.before).collect();
    let state = |index: usize| states.get(index).copied().unwrap_or(function);
    let mut last = stages.len();
    while last > 0 && !has(state(last), item) {
        last -= 1;
    }
    let mut after = Snapshot::new(tables, state(last), &weights);
    let mut walk = BackwardWalk {
        tracked: vec![item],
        entries: Vec::new(),
    };
    let subject = after.subject(item);
    let now = subject.map(|subject| after.moment(subject));
    let name = subject.map_or_else(String::new, |subject| name_of(after.view, subject));
    if let Some(DefinitionSubject::Output(index)) = subject {
        walk.follow_operand(after.view.function, index);
    }
    let followed = walk.tracked.iter();
    let sources = followed.filter_map(|&item| Some(after.sources(after.subject(item)?)));
    let sources = sources.collect();
    for stage in stages[..last].iter().rev() {
        let before = Snapshot::new(tables, &stage.before, &weights);
        walk.step(stage, &before, &after);
        after = before;
    }
    walk.entries.reverse();
    let read: Vec<DefinitionSubject> = walk
        .tracked
        .iter()
        .filter_map(|&item| after.subject(item))
        .collect();
    let gone = (last < stages.len()).then(|| Gone {
        pass: stages[last].pass.clone(),
        into: replacement(tables, &stages[last].notes, &name),
    });
    let earlier = read.iter().map(|&subject| after.earlier(subject));
    let earlier: Vec<_> = earlier.filter(|(_, steps)| !steps.is_empty()).collect();
    Account {
        name,
        sources,
        earlier,
        read: read
            .into_iter()
            .map(|subject| after.moment(subject))
            .collect(),
        entries: walk.entries,
        now: now.filter(|_| gone.is_none()),
        gone,
    }
}

fn has(function: &Function, item: TrackedItem) -> bool {
    match item {
        TrackedItem::Value(name) => function.nodes().iter().any(|node| node.name == name),
        TrackedItem::Output(output) => assignment_of(function, output).is_some(),
    }
}

/// The value that replaced a removed one, as the pass noted it.
fn replacement(tables: &Tables, notes: &Notes, name: &str) -> Option<String> {
    let into = notes.noted_with(&super::equal_to(name))?;
    Some(format!("%{}", into.display(&tables.symbols)))
}

/// A state with the tables for its queries.
struct Snapshot<'a> {
    view: View<'a>,
    state: DefinitionState,
    uses: Vec<u32>,
    arrivals: Vec<u32>,
    tails: Vec<u32>,
    path: u32,
}

impl<'a> Snapshot<'a> {
    fn new(tables: &'a Tables, function: &'a Function, weights: &Weights) -> Snapshot<'a> {
        let arrivals = arrivals(function, weights);
        Snapshot {
            view: View { tables, function },
            state: DefinitionState::of(function),
            uses: function.use_counts(),
            tails: tails(function, weights),
            path: longest(&arrivals),
            arrivals,
        }
    }

    fn subject(&self, item: TrackedItem) -> Option<DefinitionSubject> {
        match item {
            TrackedItem::Value(name) => self.state.value(name).map(DefinitionSubject::Value),
            TrackedItem::Output(output) => {
                assignment_of(self.view.function, output).map(DefinitionSubject::Output)
            }
        }
    }

    fn item(&self, subject: DefinitionSubject) -> TrackedItem {
        let function = self.view.function;
        match subject {
            DefinitionSubject::Value(value) => TrackedItem::Value(function.node(value).name),
            DefinitionSubject::Output(index) => {
                TrackedItem::Output(function.assignments[index].output)
            }
        }
    }

    fn sources(&self, subject: DefinitionSubject) -> SourceSet {
        match subject {
            DefinitionSubject::Value(value) => self.view.function.node(value).sources,
            DefinitionSubject::Output(index) => self.view.function.assignments[index].sources,
        }
    }

    /// A subject's name and the steps of its history.
    fn earlier(&self, subject: DefinitionSubject) -> (String, Vec<HistoryStep>) {
        let steps = self.view.function.histories.as_ref().map(|histories| {
            let history = match subject {
                DefinitionSubject::Value(value) => histories.values.get(value.index()),
                DefinitionSubject::Output(index) => histories.outputs.get(index),
            };
            let chain = histories.chain(history.copied().unwrap_or_default());
            chain.into_iter().cloned().collect()
        });
        (name_of(self.view, subject), steps.unwrap_or_default())
    }

    fn definition(&self, subject: DefinitionSubject) -> Definition {
        self.state.definition(self.view.function, subject)
    }

    fn expression(&self, subject: DefinitionSubject) -> WrittenExpression {
        match subject {
            DefinitionSubject::Value(value) => of_value(self.view, &self.uses, value),
            DefinitionSubject::Output(index) => of_output(self.view, &self.uses, index),
        }
    }

    fn moment(&self, subject: DefinitionSubject) -> Moment {
        self.timed(subject, self.expression(subject).text)
    }

    fn timed(&self, subject: DefinitionSubject, text: String) -> Moment {
        let operand = match subject {
            DefinitionSubject::Value(value) => value.into(),
            DefinitionSubject::Output(index) => self.view.function.assignments[index].operand,
        };
        let arrival = operand.entry_or_default(&self.arrivals);
        let tail = operand.entry_or_default(&self.tails);
        Moment {
            text,
            arrival,
            slack: self.path.saturating_sub(arrival.saturating_add(tail)),
            path: self.path,
        }
    }
}

/// Going backwards through the stages.
struct BackwardWalk {
    /// The items that are followed, by their names in the state reached.
    tracked: Vec<TrackedItem>,
    entries: Vec<PassEntry>,
}

impl BackwardWalk {
    fn follow(&mut self, item: TrackedItem) {
        if self.tracked.len() < MAX_FOLLOWED && !self.tracked.contains(&item) {
            self.tracked.push(item);
        }
    }

    /// Follows the value an output is set to.
    fn follow_operand(&mut self, function: &Function, index: usize) {
        if let Some(value) = function.assignments[index].operand.value()
            && let name = function.node(value).name
            && !name.is_none()
        {
            self.follow(TrackedItem::Value(name));
        }
    }

    fn step(&mut self, stage: &Stage, before: &Snapshot<'_>, after: &Snapshot<'_>) {
        let owners = OutputSymbols::of(before.view.tables, before.view.function);
        let mut changes = Vec::new();
        for item in std::mem::take(&mut self.tracked) {
            let Some(new) = after.subject(item) else {
                continue;
            };
            let old = match item {
                TrackedItem::Value(name) => origin(&before.state, &owners, name),
                TrackedItem::Output(_) => before.subject(item),
            };
            if let Some(old) = old {
                self.follow(before.item(old));
            }
            if let Some(DefinitionSubject::Output(index)) = old {
                self.follow_operand(before.view.function, index);
            }
            changes.extend(change(&stage.notes, (before, old), (after, new)));
        }
        if !changes.is_empty() {
            self.entries.push(PassEntry {
                pass: stage.pass.clone(),
                changes,
            });
        }
    }
}

/// The change of one subject by a pass; `None` when there is none.
fn change(
    notes: &Notes,
    (before, old): (&Snapshot<'_>, Option<DefinitionSubject>),
    (after, new): (&Snapshot<'_>, DefinitionSubject),
) -> Option<DefinitionChange> {
    let expression = after.expression(new);
    let earlier = old.map(|old| before.moment(old));
    let same_definition = old.is_some_and(|old| before.definition(old) == after.definition(new));
    let same_text = earlier
        .as_ref()
        .is_some_and(|earlier| earlier.text == expression.text);
    if same_definition && same_text {
        return None;
    }
    let merged = old
        .filter(|&old| same_text && before.definition(old).is_merged(after.definition(new)))
        .map(|_| after.sources(new));
    let own = match after.item(new) {
        TrackedItem::Value(name) => Some(name),
        TrackedItem::Output(_) => None,
    };
    let mut rules: Vec<String> = Vec::new();
    for name in own.into_iter().chain(expression.inside) {
        for rule in notes.rules(name) {
            if !rules.iter().any(|known| known == rule) {
                rules.push(rule.to_owned());
            }
        }
    }
    Some(DefinitionChange {
        before: earlier,
        after: after.timed(new, expression.text),
        rules,
        merged,
    })
}
