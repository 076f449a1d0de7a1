//! States that a file lists.

use super::input_name;
use hashbrown::HashMap;
use robovec_dynamics::kinematics::parameter;
use robovec_ir::diagnostic::{Diagnostic, Label, clip};
use robovec_ir::{Function, Input, Tables, View};
use robovec_model::Model;
use robovec_num::hexadecimal;
use std::ops::Range;

/// One state: the numbers of the elements by name, and its place.
pub(super) struct GivenState<'t> {
    numbers: HashMap<&'t str, f64>,
    range: Range<usize>,
}

pub(super) fn read_states(text: &str) -> Result<Vec<GivenState<'_>>, Vec<Diagnostic>> {
    let mut states: Vec<GivenState<'_>> = Vec::new();
    let mut errors = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let range = start..start + line.trim_end().len();
        start += line.len();
        let content = line.split('#').next().unwrap_or_default().trim();
        if content.is_empty() {
            continue;
        }
        if content == "state" {
            states.push(GivenState {
                numbers: HashMap::new(),
                range,
            });
            continue;
        }
        let entry = content
            .rsplit_once(char::is_whitespace)
            .and_then(|(name, number)| Some((name.trim_end(), hexadecimal::parse(number)?)));
        match (entry, states.last_mut()) {
            (Some((name, number)), Some(state)) => {
                state.numbers.insert(name, number);
            }
            (Some(_), None) => {
                errors.push(wrong(
                    range,
                    "a number before the first `state`",
                    "begin with a line `state`",
                ));
            }
            (None, _) => errors.push(wrong(
                range,
                "this line is not understood",
                "write `q[3] 0.25`, `dpt[3,1] 0x1.8p+1`, `Flink1 2`, or `state`",
            )),
        }
        if errors.len() >= 20 {
            return Err(errors);
        }
    }
    if states.is_empty() && errors.is_empty() {
        errors.push(wrong(
            0..0,
            "the file holds no state",
            "begin with a line `state`",
        ));
    }
    if errors.is_empty() {
        Ok(states)
    } else {
        Err(errors)
    }
}

fn wrong(range: Range<usize>, message: &str, note: &str) -> Diagnostic {
    Diagnostic::error()
        .with_message(message)
        .with_labels(vec![Label::primary(0, range)])
        .with_note(note)
}

pub(super) fn missing(name: &str, function: &Function, state: &GivenState<'_>) -> Diagnostic {
    Diagnostic::error()
        .with_message(format!("this state gives no number to `{}`", clip(name)))
        .with_labels(vec![Label::primary(0, state.range.clone())])
        .with_note(format!("the function `{}` reads it", clip(&function.name)))
}

impl GivenState<'_> {
    /// The numbers of a function's flattened inputs; the model gives the
    /// parameters that the state does not. Elements that no equation reads
    /// may be absent. The error is the name of an absent one that is read.
    pub(super) fn inputs(
        &self,
        tables: &Tables,
        function: &Function,
        model: Option<&Model>,
    ) -> Result<Vec<f64>, String> {
        let needed = needed(function);
        let view = View { tables, function };
        let mut inputs = vec![0.0; function.input_len()];
        for (index, number) in inputs.iter_mut().enumerate() {
            let input = Input(index as u32);
            let name = input_name(view, input);
            let (array, indices, rank) = function.input_element(input);
            let array = tables.symbols.text(array.name);
            let given = self.numbers.get(name.as_str()).copied();
            let of_model = || parameter(model?, array, &indices[..rank]);
            match given.or_else(of_model) {
                Some(given) => *number = given,
                None if needed[index] => return Err(name),
                None => {}
            }
        }
        Ok(inputs)
    }
}

/// Flattened inputs that are read.
fn needed(function: &Function) -> Vec<bool> {
    let mut needed = vec![false; function.input_len()];
    let assigned = function
        .assignments
        .iter()
        .map(|assignment| &assignment.operand);
    let read = function
        .nodes()
        .iter()
        .flat_map(|node| node.operands())
        .chain(assigned);
    for input in read.filter_map(|operand| operand.input()) {
        needed[input.index()] = true;
    }
    needed
}
