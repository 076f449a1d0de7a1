//! `robovec eval`: the functions of a module evaluated in 64-bit floats at
//! states that a file lists, without the loss of a bit.
//!
//! The file of states is lines of `name[indices] number`; a line `state`
//! starts the next state, `#` a comment. Numbers are decimal, or hexadecimal
//! as C's `%a` writes them. A state may hold more than a function reads.
//! The result is one line for each output element that is assigned:
//! `state 2 dirdyna M[1,1] 0x1.8p+1`.

use crate::hexadecimal;
use hashbrown::HashMap;
use robovec_ir::arithmetic::Binary64;
use robovec_ir::diagnostic::{Diagnostic, Label, clip};
use robovec_ir::evaluate::evaluate;
use robovec_ir::print::print_output;
use robovec_ir::{Function, Input, Module, Tables, View};
use std::fmt::Write;
use std::ops::Range;

/// One state: the numbers of the elements by name, and where it stands.
struct State<'t> {
    numbers: HashMap<&'t str, f64>,
    range: Range<usize>,
}

/// Evaluates every function of a module at every state of a text, in the
/// format described above.
///
/// # Errors
///
/// Messages that point into `states` (file 0): a line that is not understood,
/// no state at all, an input element to which a state gives no number.
pub fn evaluate_at_states(module: &Module, states: &str) -> Result<String, Vec<Diagnostic>> {
    let states = read_states(states)?;
    let mut text = String::new();
    let mut errors = Vec::new();
    for (index, state) in states.iter().enumerate() {
        for function in &module.functions {
            match flattened_inputs(&module.tables, function, state) {
                Ok(inputs) => {
                    let view = View {
                        tables: &module.tables,
                        function,
                    };
                    write_outputs(&mut text, view, index + 1, &inputs);
                }
                Err(name) => errors.push(missing(&name, function, state)),
            }
            if errors.len() >= 20 {
                return Err(errors);
            }
        }
    }
    if errors.is_empty() {
        Ok(text)
    } else {
        Err(errors)
    }
}

fn read_states(text: &str) -> Result<Vec<State<'_>>, Vec<Diagnostic>> {
    let mut states: Vec<State<'_>> = Vec::new();
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
            states.push(State {
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

fn missing(name: &str, function: &Function, state: &State<'_>) -> Diagnostic {
    Diagnostic::error()
        .with_message(format!("this state gives no number to `{}`", clip(name)))
        .with_labels(vec![Label::primary(0, state.range.clone())])
        .with_note(format!("the function `{}` reads it", clip(&function.name)))
}

/// The numbers of the flattened inputs; elements that no equation reads may
/// be absent. The error is the name of an absent one that is read.
fn flattened_inputs(
    tables: &Tables,
    function: &Function,
    state: &State<'_>,
) -> Result<Vec<f64>, String> {
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
    let mut name = String::new();
    let mut inputs = vec![0.0; function.input_len()];
    for (index, number) in inputs.iter_mut().enumerate() {
        let (array, indices, rank) = function.input_element(Input(index as u32));
        name.clear();
        name.push_str(tables.symbols.text(array.name));
        for (place, index) in indices[..rank].iter().enumerate() {
            let separator = if place == 0 { '[' } else { ',' };
            // Writing to a string cannot fail.
            let _ = write!(name, "{separator}{index}");
        }
        if rank > 0 {
            name.push(']');
        }
        match state.numbers.get(name.as_str()) {
            Some(&given) => *number = given,
            None if needed[index] => return Err(name),
            None => {}
        }
    }
    Ok(inputs)
}

fn write_outputs(text: &mut String, view: View<'_>, state: usize, inputs: &[f64]) {
    let numbers = evaluate(view.function, &Binary64, inputs);
    for (assignment, number) in view.function.assignments.iter().zip(numbers) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "state {state} {} {} {}",
            view.function.name,
            print_output(view, assignment.output),
            hexadecimal::format(number)
        );
    }
}
