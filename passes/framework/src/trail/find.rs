//! Resolution of a user's text to a value or output.

use super::Trail;
use robovec_ir::diagnostic::{clip, did_you_mean};
use robovec_ir::print::print_output;
use robovec_ir::{Function, Module, Name, Output, Tables, View};

/// Something whose story can be reported.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TrackedItem {
    /// The value of a name.
    Value(Name),
    /// An output element.
    Output(Output),
}

/// There is no such value or output.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("there is no value or output '{asked}'")]
pub struct NotFound {
    /// The name that was requested.
    pub asked: String,
    /// The advice to the user.
    pub help: String,
}

/// The function and the item that a text means: `%OM16.1` (the sign may be
/// missing) or `M[1,2]`. A value that some pass removed is found as well.
///
/// # Errors
///
/// Fails when no function has or had such a value or output, with the nearest
/// that exists.
pub fn find(module: &Module, trail: &Trail, asked: &str) -> Result<(usize, TrackedItem), NotFound> {
    let text: String = asked.split_whitespace().collect();
    let bare = text.strip_prefix('%');
    let name = bare.unwrap_or(&text);
    for (index, function) in module.functions.iter().enumerate() {
        if bare.is_none()
            && let Some(output) = output(&module.tables, function, &text)
        {
            return Ok((index, TrackedItem::Output(output)));
        }
    }
    let (base, suffix) = Name::split(name);
    if let Some(base) = module.tables.symbols.find(base) {
        let name = Name { base, suffix };
        for (index, function) in module.functions.iter().enumerate() {
            let stages = trail.of(&function.name);
            let states = stages.iter().map(|stage| &stage.before);
            let mut states = std::iter::once(function).chain(states);
            if states.any(|state| state.nodes().iter().any(|node| node.name == name)) {
                return Ok((index, TrackedItem::Value(name)));
            }
        }
    }
    Err(NotFound {
        help: advice(module, trail, &text),
        asked: clip(asked).into_owned(),
    })
}

fn output(tables: &Tables, function: &Function, text: &str) -> Option<Output> {
    let view = View { tables, function };
    let outputs = function
        .assignments
        .iter()
        .map(|assignment| assignment.output);
    // Printing every element would be the dearer way on large arrays.
    let array = array_of(text);
    let symbol = tables.symbols.find(array)?;
    let mut outputs = outputs.filter(|&output| function.output_element(output).0.name == symbol);
    outputs.find(|&output| print_output(view, output) == text)
}

fn advice(module: &Module, trail: &Trail, text: &str) -> String {
    let symbols = &module.tables.symbols;
    let mut names: Vec<String> = Vec::new();
    for function in &module.functions {
        let view = module.tables.view(function);
        let outputs = function.assignments.iter();
        names.extend(outputs.map(|assignment| print_output(view, assignment.output)));
        let stages = trail.of(&function.name);
        let first = stages.first().map(|stage| &stage.before);
        let values = first.into_iter().chain([function]);
        let values = values.flat_map(|state| state.nodes());
        let values = values.filter(|node| !node.name.is_none());
        names.extend(values.map(|node| format!("%{}", node.name.display(symbols))));
    }
    let array = array_of(text);
    let is_input = |function: &Function| {
        let mut inputs = function.inputs().iter();
        inputs.any(|input| symbols.text(input.name) == array)
    };
    let with_sign = format!("%{text}");
    let candidates = || names.iter().map(String::as_str);
    let near = did_you_mean(text, candidates()).or_else(|| did_you_mean(&with_sign, candidates()));
    match near {
        _ if module.functions.iter().any(is_input) => {
            format!("'{array}' is an input and has no history")
        }
        Some(near) => format!("did you mean '{near}'?"),
        None => "write a value as %OM16 or %OM16.1, an output element as M[1,2]".to_owned(),
    }
}

/// The name of the array in the text of an element.
fn array_of(text: &str) -> &str {
    let mut parts = text.split('[');
    parts.next().expect("a text has a first part")
}
