//! The statements of a state: its text by lines, with known facts about each.

use super::data::{StateData, TextTable};
use robovec_analysis::adjoint::{AdjointRun, Tape};
use robovec_analysis::critical_path::{Weights, arrivals, longest, tails};
use robovec_framework::rewrite::owners;
use robovec_framework::trail::{DefinitionSubject, TrailState};
use robovec_ir::print::{self, print_function};
use robovec_ir::states::States;
use robovec_ir::{Format, Function, Machine, Module, SourcePlace, SourceSet, Tables, Value, View};
use std::collections::BTreeMap;

/// Sets of source places by number, in order of their first use.
#[derive(Default)]
pub(super) struct SourceTable {
    numbers: BTreeMap<SourceSet, u32>,
}

impl SourceTable {
    fn number(&mut self, set: SourceSet) -> u32 {
        let next = self.numbers.len() as u32;
        *self.numbers.entry(set).or_insert(next)
    }

    /// The places of every set: file, line, column.
    pub(super) fn places(self, tables: &Tables) -> Vec<Vec<[u32; 3]>> {
        let mut all = vec![Vec::new(); self.numbers.len()];
        for (set, number) in self.numbers {
            let places = tables.sources.places(set);
            let places = places.map(|place| [place.file, place.line, place.column]);
            all[number as usize] = places.collect();
        }
        all
    }
}

fn named(function: &Function) -> Vec<Value> {
    let values = function.values();
    let named = values.filter(|(_, node)| !node.name.is_none());
    named.map(|(value, _)| value).collect()
}

/// The statements of a state; `before` is the function in the state before.
pub(super) fn collect(
    tables: &Tables,
    state: &TrailState<'_>,
    before: Option<&Function>,
    (machine, states): (&Machine, &States),
    (texts, sources): (&mut TextTable, &mut SourceTable),
) -> StateData {
    let function = state.function;
    let view = View { tables, function };
    let values = named(function);
    let weights = Weights::cycles(machine);
    let (arrivals, tails) = (arrivals(function, &weights), tails(function, &weights));
    let path = longest(&arrivals);
    let count = values.len() + function.assignments.len();
    let errors = relative_errors(view, machine.number, states);
    let numbers = before.map(statement_numbers);
    let mut data = StateData {
        pass: state.pass.map(str::to_owned),
        level: function.level.name(),
        path,
        values: values.len(),
        names: Vec::with_capacity(count),
        texts: Vec::with_capacity(count),
        sources: Vec::with_capacity(count),
        arrivals: Vec::with_capacity(count),
        slacks: Vec::with_capacity(count),
        origins: Vec::with_capacity(count),
        rules: BTreeMap::new(),
        errors: Vec::with_capacity(count),
    };
    for line in statement_lines(&print_function(view), count) {
        let (name, right) = split(line);
        data.names.push(texts.number(name));
        data.texts.push(texts.number(right));
    }
    let origin = |subject: Option<DefinitionSubject>| match (subject, &numbers) {
        (Some(DefinitionSubject::Value(value)), Some(numbers)) => numbers.of_value(value),
        (Some(DefinitionSubject::Output(index)), Some(numbers)) => numbers.of_output(index),
        (_, None) | (None, _) => -1,
    };
    let time = |data: &mut StateData, value: Option<Value>| {
        let (arrival, tail) = value.map_or((0, 0), |value| {
            (arrivals[value.index()], tails[value.index()])
        });
        data.arrivals.push(arrival);
        data.slacks
            .push(path.saturating_sub(arrival.saturating_add(tail)));
    };
    for (number, &value) in values.iter().enumerate() {
        data.sources
            .push(sources.number(function.node(value).sources));
        time(&mut data, Some(value));
        data.origins
            .push(origin(state.value_origins[value.index()]));
        data.errors.push(errors.0[value.index()]);
        let rules = &state.rules[value.index()];
        if !rules.is_empty() {
            let rules = rules.iter().map(|rule| texts.number(rule)).collect();
            data.rules.insert(number as u32, rules);
        }
    }
    for (index, assignment) in function.assignments.iter().enumerate() {
        data.sources.push(sources.number(assignment.sources));
        time(&mut data, assignment.operand.value());
        data.origins.push(origin(state.output_origins[index]));
        data.errors.push(errors.1[index]);
    }
    let columns = [
        data.names.len(),
        data.texts.len(),
        data.sources.len(),
        data.arrivals.len(),
        data.slacks.len(),
        data.origins.len(),
        data.errors.len(),
    ];
    assert_eq!(columns, [count; 7], "every statement is in every column");
    data
}

struct StatementNumbers {
    values: Vec<i64>,
    first_output: usize,
}

fn statement_numbers(function: &Function) -> StatementNumbers {
    let named = named(function);
    let mut values = vec![-1; function.nodes().len()];
    for (number, value) in named.iter().enumerate() {
        values[value.index()] = number as i64;
    }
    StatementNumbers {
        values,
        first_output: named.len(),
    }
}

impl StatementNumbers {
    fn of_value(&self, value: Value) -> i64 {
        self.values[value.index()]
    }

    fn of_output(&self, index: usize) -> i64 {
        (self.first_output + index) as i64
    }
}

/// The lines of a printed function that define something.
fn statement_lines(text: &str, count: usize) -> Vec<&str> {
    let lines = text.lines().map(str::trim);
    let lines: Vec<&str> = lines
        .filter(|line| !line.is_empty() && *line != "}")
        .collect();
    let first = lines.len().checked_sub(count);
    let first = first.expect("every definition has its own line");
    lines[first..].to_vec()
}

/// A definition without slot, words and places, which are shown elsewhere.
fn split(line: &str) -> (&str, &str) {
    let (name, right) = line.split_once(" = ").expect("a line defines one name");
    let ends = [" on ", " @", " in ", " by ", " {"].map(|mark| right.find(mark));
    let end = ends.into_iter().flatten().min().unwrap_or(right.len());
    (name, right[..end].trim_end())
}

/// Relative error of every node and assignment in a format, at the first random
/// state: absent for an exact zero, or where something is not finite.
fn relative_errors(
    view: View<'_>,
    format: Format,
    states: &States,
) -> (Vec<Option<f32>>, Vec<Option<f32>>) {
    let function = view.function;
    let tape = Tape::new(function);
    let run = AdjointRun::of(function, &tape, format, &states.draw(view, 0));
    let relative = |slot: usize| {
        let share = (run.errors()[slot] / run.exact()[slot]).abs();
        share.is_finite().then(|| two_digits(share))
    };
    let nodes = (0..function.nodes().len()).map(relative).collect();
    let outputs = 0..function.assignments.len();
    let outputs = outputs.map(|index| relative(tape.output_slot(index)));
    (nodes, outputs.collect())
}

/// Two digits are enough on a page and keep it small.
fn two_digits(number: f64) -> f32 {
    let text = format!("{number:.1e}");
    text.parse().expect("a number that was just printed")
}

/// The shares of source lines in the errors of all outputs.
pub(super) fn heat(view: View<'_>, format: Format, states: &States) -> Vec<(u32, u32, f64)> {
    let tape = Tape::new(view.function);
    let (found, ..) = robovec_error::errors::blame(view, &tape, format, states);
    let mut lines: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    for equation in found.equations(view, usize::MAX) {
        if let Some(place) = equation.place {
            *lines.entry((place.file, place.line)).or_insert(0.0) += equation.share;
        }
    }
    lines
        .into_iter()
        .map(|((file, line), share)| (file, line, (share * 1e6).round() / 1e6))
        .collect()
}

/// Gives a module's equations, without places, those of its printed text, under
/// this name; returns the text, or `None` when a place is known already.
pub fn place_lines(module: &mut Module, name: &str) -> Option<String> {
    if !module.tables.sources.files.is_empty() {
        return None;
    }
    let text = print::print_module(module);
    let file = module.tables.sources.add_file(name);
    let mut lines = text.lines().zip(1..);
    for index in 0..module.functions.len() {
        let mut places = BTreeMap::new();
        for (line, number) in lines.by_ref() {
            if line == "}" {
                break;
            }
            if let Some((left, _)) = line.trim_start().split_once(" = ") {
                let column = line.len() - line.trim_start().len() + 1;
                let place = SourcePlace {
                    file,
                    line: number,
                    column: column as u32,
                    end_line: number,
                    end_column: line.chars().count() as u32,
                };
                places.insert(left.to_owned(), place);
            }
        }
        assign(module, index, &places);
    }
    Some(text)
}

/// Gives values and outputs the places of their names or equations.
fn assign(module: &mut Module, index: usize, places: &BTreeMap<String, SourcePlace>) {
    let tables = &mut module.tables;
    let function = &mut module.functions[index];
    let names: Vec<String> = function
        .assignments
        .iter()
        .map(|assignment| {
            let view = robovec_ir::View { tables, function };
            print::print_output(view, assignment.output)
        })
        .collect();
    let owners = owners(tables, function);
    let mut by_owner = BTreeMap::new();
    for (assignment, name) in function.assignments.iter_mut().zip(&names) {
        if let Some(&place) = places.get(name) {
            assignment.sources = tables.sources.single(place);
            if let Some(value) = assignment.operand.value() {
                by_owner.insert(owners[value.index()], assignment.sources);
            }
        }
    }
    let values: Vec<_> = function.values().map(|(value, _)| value).collect();
    for &value in &values {
        let name = function.node(value).name;
        if name.is_none() {
            continue;
        }
        let text = format!("%{}", name.display(&tables.symbols));
        if let Some(&place) = places.get(&text) {
            let sources = tables.sources.single(place);
            function.node_mut(value).sources = sources;
            by_owner.insert(name.base, sources);
        }
    }
    for value in values {
        if function.node(value).name.is_none()
            && let Some(&sources) = by_owner.get(&owners[value.index()])
        {
            function.node_mut(value).sources = sources;
        }
    }
}
