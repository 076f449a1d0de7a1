//! `robovec-opt --explain`: the story of one value.

use super::CommandFailure;
use robovec_error::errors;
use robovec_framework::trail::{self, Account, DefinitionChange, Moment, PassEntry, Trail};
use robovec_io::sources::ReadEquations;
use robovec_ir::diagnostic::{Diagnostic, Label, Report};
use robovec_ir::states::States;
use robovec_ir::{Function, HistoryStep, Machine, SourcePlace, SourceSet, View, print};
use std::fmt::Write;

/// Number of source places shown with their lines; the others are named.
const MAX_EXCERPTS: usize = 6;

/// Prints how the requested value or output came to be, if there is one.
pub(crate) fn explain(
    asked: &str,
    input: &ReadEquations,
    trail: &Trail,
    machine: &Machine,
    states: &States,
) -> Result<String, CommandFailure> {
    let module = &input.module;
    let (index, item) = trail::find(module, trail, asked)
        .map_err(|error| CommandFailure::advised(error.to_string(), vec![error.help]))?;
    let function = &module.functions[index];
    let account = trail::explain(&module.tables, function, trail, machine, item);
    let mut text = origin(&account, function, input);
    for (name, steps) in &account.earlier {
        let steps: Vec<String> = steps.iter().map(describe_step).collect();
        let _ = writeln!(text, "before this run\n  {name}: {}", steps.join(", "));
    }
    if !account.read.is_empty() {
        text.push_str("as read\n");
        for moment in &account.read {
            print_moment(moment, &mut text);
        }
    }
    for entry in &account.entries {
        print_entry(entry, input, &mut text);
    }
    match (&account.now, &account.gone) {
        (_, Some(gone)) => {
            let into = match &gone.into {
                Some(into) => format!("it is now computed as {into}"),
                None => "no value of this name is left".to_owned(),
            };
            let _ = writeln!(text, "{}\n  removes it: {into}", gone.pass);
        }
        (Some(now), None) => {
            text.push_str("in the end\n");
            let view = module.tables.view(function);
            let definition = last_definition(view, item).unwrap_or_else(|| now.text.clone());
            let now = Moment {
                text: definition,
                ..now.clone()
            };
            print_moment(&now, &mut text);
            print_readers(view, item, &mut text);
            let format = machine.number;
            text.push_str(&errors::explain(view, item, format, states).unwrap_or_default());
        }
        (None, None) => {}
    }
    Ok(text)
}

/// The source equations, with their lines where the file is available.
fn origin(account: &Account, function: &Function, input: &ReadEquations) -> String {
    let sources = &input.module.tables.sources;
    let mut places: Vec<SourcePlace> = Vec::new();
    for place in account.sources.iter().flat_map(|&set| sources.places(set)) {
        if !places.contains(&place) {
            places.push(place);
        }
    }
    let mut report = Report::new();
    let count = match places.len() {
        0 => "no known equation".to_owned(),
        1 => "this equation".to_owned(),
        several => format!("these {several} equations"),
    };
    let message = format!("{} of '{}' comes from {count}", account.name, function.name);
    let mut diagnostic = Diagnostic::note().with_message(message);
    let is_read = |place: &SourcePlace| sources.files[place.file as usize] == input.name;
    let text = if places.iter().any(is_read) {
        input.text()
    } else {
        None
    };
    let id = text.map(|text| report.add_file(&input.name, text));
    for (number, place) in places.iter().enumerate() {
        match id {
            Some(id) if number < MAX_EXCERPTS && is_read(place) => {
                let range = report.range_of(id, *place);
                diagnostic.labels.push(match number {
                    0 => Label::primary(id, range),
                    _ => Label::secondary(id, range),
                });
            }
            Some(_) | None if number < MAX_EXCERPTS => {
                diagnostic.notes.push(describe(input, *place));
            }
            Some(_) | None => {}
        }
    }
    if places.len() > MAX_EXCERPTS {
        let rest = places.len() - MAX_EXCERPTS;
        diagnostic.notes.push(format!("and from {rest} more"));
    }
    report.push(diagnostic);
    report.render_plain()
}

fn describe(input: &ReadEquations, place: SourcePlace) -> String {
    let file = &input.module.tables.sources.files[place.file as usize];
    format!("{file}, line {}, column {}", place.line, place.column)
}

fn print_entry(entry: &PassEntry, input: &ReadEquations, text: &mut String) {
    let mut rules: Vec<String> = Vec::new();
    for rule in entry.changes.iter().flat_map(|change| &change.rules) {
        if !rules.contains(rule) {
            rules.push(rule.clone());
        }
    }
    let rules = match &rules[..] {
        [] => String::new(),
        rules => format!(": {}", rules.join(", ")),
    };
    let _ = writeln!(text, "{}{rules}", entry.pass);
    for change in &entry.changes {
        print_change(change, input, text);
    }
}

fn describe_step(step: &HistoryStep) -> String {
    match &step.rules[..] {
        [] => step.pass.clone(),
        rules => format!("{} ({})", step.pass, rules.join(", ")),
    }
}

fn print_change(change: &DefinitionChange, input: &ReadEquations, text: &mut String) {
    let DefinitionChange {
        before,
        after,
        merged,
        ..
    } = change;
    if let Some(sources) = merged {
        let _ = writeln!(text, "  {}", after.text);
        let places = list_places(input, *sources);
        let _ = writeln!(text, "    now replaces the equations at {places}");
        return;
    }
    match before {
        Some(before) if before.text == after.text => {
            let _ = writeln!(text, "  {}", after.text);
            let _ = writeln!(
                text,
                "    the same value, computed in other steps\n   {}",
                timing(after)
            );
        }
        Some(before) => {
            let _ = writeln!(text, "- {}\n   {}", before.text, timing(before));
            let _ = writeln!(text, "+ {}\n   {}", after.text, timing(after));
        }
        None => {
            let _ = writeln!(text, "+ {}\n   {}", after.text, timing(after));
        }
    }
}

fn list_places(input: &ReadEquations, sources: SourceSet) -> String {
    let places = input.module.tables.sources.places(sources);
    let rest = places.len().saturating_sub(MAX_EXCERPTS);
    let places = places.take(MAX_EXCERPTS);
    let places: Vec<String> = places
        .map(|place| format!("{}:{}", place.line, place.column))
        .collect();
    let rest = match rest {
        0 => String::new(),
        rest => format!(" and {rest} more"),
    };
    places.join(", ") + &rest
}

fn print_moment(moment: &Moment, text: &mut String) {
    let _ = writeln!(text, "  {}\n   {}", moment.text, timing(moment));
}

fn timing(moment: &Moment) -> String {
    let Moment {
        arrival,
        slack,
        path,
        ..
    } = moment;
    let slack = match slack {
        0 => "on a longest path".to_owned(),
        slack => format!("slack {slack}"),
    };
    format!(" available at cycle {arrival} of {path}, {slack}")
}

/// The definition with all attributes of later levels.
fn last_definition(view: View<'_>, item: trail::TrackedItem) -> Option<String> {
    let trail::TrackedItem::Value(name) = item else {
        return None;
    };
    let mut values = view.function.values();
    let (value, _) = values.find(|(_, node)| node.name == name)?;
    // Its places were shown at the beginning.
    let definition = print::print_definition(view, value);
    let end = definition.find(" @").unwrap_or(definition.len());
    Some(definition[..end].to_owned())
}

fn print_readers(view: View<'_>, item: trail::TrackedItem, text: &mut String) {
    const MOST: usize = 8;
    let trail::TrackedItem::Value(name) = item else {
        return;
    };
    let function = view.function;
    let Some((value, _)) = function.values().find(|(_, node)| node.name == name) else {
        return;
    };
    let reads = |operand: &robovec_ir::Operand| operand.value() == Some(value);
    let symbols = &view.tables.symbols;
    let nodes = function.nodes().iter();
    let nodes = nodes.filter(|node| node.operands().iter().any(reads));
    let nodes = nodes.map(|node| {
        if node.name.is_none() {
            "an expression".to_owned()
        } else {
            format!("%{}", node.name.display(symbols))
        }
    });
    let outputs = function.assignments.iter();
    let outputs = outputs.filter(|assignment| reads(&assignment.operand));
    let outputs = outputs.map(|assignment| print::print_output(view, assignment.output));
    let all: Vec<String> = nodes.chain(outputs).collect();
    let rest = match all.len().saturating_sub(MOST) {
        0 => String::new(),
        rest => format!(" and {rest} more"),
    };
    let shown = &all[..all.len().min(MOST)];
    let _ = match shown {
        [] => writeln!(text, "    read by nothing"),
        shown => writeln!(text, "    read by {}{rest}", shown.join(", ")),
    };
}
