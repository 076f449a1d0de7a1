//! Changes by a call, beside the evaluation of the function.

use super::number;
use super::program::Changes;
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Boundary, Input, View};
use robovec_num::arithmetic::Binary64;

/// Compares the evaluation with the elements that a call changed: the number of
/// equal elements, or the first that differs.
pub(crate) fn differences(view: View<'_>, state: u64, changed: &Changes) -> Result<usize, String> {
    let inputs: Vec<f64> = (0..view.function.input_len() as u32)
        .map(|input| input_number(view, Input(input), state))
        .collect();
    let numbers = evaluate(view.function, &Binary64, &inputs);
    let mut left = changed.clone();
    left.retain(|(name, _, _), _| !name.starts_with("call"));
    let mut equal = 0;
    for (assignment, number_of_ours) in view.function.assignments.iter().zip(numbers) {
        let (array, indices, rank) = view.function.output_element(assignment.output);
        let name = view.tables.symbols.text(array.name);
        let indices = [indices[0], indices[1]].map(|index| if rank == 0 { 0 } else { index });
        let keys = places(view, name);
        for key in keys {
            let key = (key, indices[0], indices[1]);
            let theirs = match changed.get(&key) {
                Some(&bits) => f64::from_bits(bits),
                None if key.0.starts_with("call") => continue,
                None => number(state, &key.0, key.1, key.2),
            };
            left.remove(&key);
            let both_nan = theirs.is_nan() && number_of_ours.is_nan();
            if theirs.to_bits() != number_of_ours.to_bits() && !both_nan {
                return Err(format!(
                    "{} in state {state}: {}[{},{}] is {theirs:e}, robovec has {number_of_ours:e}",
                    view.function.name, key.0, key.1, key.2
                ));
            }
            equal += 1;
        }
    }
    match left.into_iter().next() {
        None => Ok(equal),
        Some(((name, i, j), bits)) => Err(format!(
            "{} in state {state}: {name}[{i},{j}] is set to {:e}, robovec does not set it",
            view.function.name,
            f64::from_bits(bits)
        )),
    }
}

/// Place where an output array is found: in the structure, or, when it is
/// handed to user functions, among their arguments.
fn places(view: View<'_>, name: &str) -> Vec<String> {
    let known = [
        "q", "qd", "qdd", "m", "g", "lrod", "c", "Qq", "h", "Jdqd", "Flink", "Z", "Zd", "dpt", "l",
        "In", "frc", "trq", "M", "Jac",
    ];
    if name == "Flnk" {
        return vec!["Flink".to_owned()];
    }
    if known.contains(&name) || name.starts_with("sens.") {
        return vec![name.to_owned()];
    }
    let mut places = Vec::new();
    for call in &view.function.boundaries {
        let arguments = call.arguments.iter().enumerate();
        let places_of_call = arguments.filter(|(_, argument)| *argument == name);
        places
            .extend(places_of_call.map(|(place, _)| format!("call{}.{place}", call_number(call))));
    }
    if places.is_empty() {
        // Nothing the program has: a difference, not a panic.
        places.push(name.to_owned());
    }
    places
}

fn call_number(call: &Boundary) -> u32 {
    let last = call.arguments.last().map(|text| text.parse());
    last.and_then(Result::ok).unwrap_or(0)
}

/// The number of an input: given by the state, or by a user function.
fn input_number(view: View<'_>, input: Input, state: u64) -> f64 {
    let (array, indices, rank) = view.function.input_element(input);
    let name = view.tables.symbols.text(array.name);
    let mut calls = view.function.boundaries.iter();
    let call = calls.find(|call| call.result.as_deref() == Some(name));
    match (call, rank) {
        (Some(call), 0) => number(state, "Force", call_number(call), 0),
        (Some(call), _) if call.callee.ends_with("ExtForces") => {
            number(state, &format!("SWr{}", call_number(call)), indices[0], 0)
        }
        (_, 0) => number(state, name, 0, 0),
        (_, 1) => number(state, name, indices[0], 0),
        (_, _) => number(state, name, indices[0], indices[1]),
    }
}
