//! All states of a function at once, each with the origins of its definitions,
//! as a page shows them side by side.

use super::follow::origin;
use super::state::{DefinitionState, DefinitionSubject, OutputSymbols, assignment_of};
use super::{Notes, Stage, Trail};
use robovec_ir::{Function, Tables};

/// A state of a function in the course of a run.
#[derive(Debug)]
pub struct TrailState<'a> {
    /// The pass that left the function so, with its options; `None` for the
    /// state that was read.
    pub pass: Option<&'a str>,
    /// The function in this state.
    pub function: &'a Function,
    /// For every node, in order, its origin in the state before; `None` for
    /// inner nodes of expressions, for values of unknown origin, and in the
    /// state that was read.
    pub value_origins: Vec<Option<DefinitionSubject>>,
    /// The same for every assignment.
    pub output_origins: Vec<Option<DefinitionSubject>>,
    /// For every node, in order, the rules that the pass noted for it.
    pub rules: Vec<Vec<&'a str>>,
}

/// The states of a run, from the one that was read to the current function;
/// passes that changed nothing have none.
///
/// Takes time linear in the function for every state.
pub fn states<'a>(
    tables: &Tables,
    function: &'a Function,
    trail: &'a Trail,
) -> Vec<TrailState<'a>> {
    let stages = trail.of(&function.name);
    let first = stages.first().map_or(function, |stage| &stage.before);
    let mut states = vec![TrailState {
        pass: None,
        function: first,
        value_origins: vec![None; first.nodes().len()],
        output_origins: vec![None; first.assignments.len()],
        rules: vec![Vec::new(); first.nodes().len()],
    }];
    let after = stages.iter().skip(1).map(|stage| &stage.before);
    let after = after.chain(std::iter::once(function));
    states.extend(
        stages
            .iter()
            .zip(after)
            .map(|(stage, after)| state_after(tables, stage, after)),
    );
    states
}

fn state_after<'a>(tables: &Tables, stage: &'a Stage, after: &'a Function) -> TrailState<'a> {
    let before = DefinitionState::of(&stage.before);
    let owners = OutputSymbols::of(tables, &stage.before);
    let notes: &'a Notes = &stage.notes;
    let nodes = after.nodes().iter();
    let value_origins = nodes.map(|node| {
        if node.name.is_none() {
            None
        } else {
            origin(&before, &owners, node.name)
        }
    });
    let assignments = after.assignments.iter();
    let output_origins = assignments.map(|assignment| {
        assignment_of(&stage.before, assignment.output).map(DefinitionSubject::Output)
    });
    let rules = after.nodes().iter();
    TrailState {
        pass: Some(&stage.pass),
        function: after,
        value_origins: value_origins.collect(),
        output_origins: output_origins.collect(),
        rules: rules.map(|node| notes.rules(node.name).collect()).collect(),
    }
}
