//! `robovec eval`: the functions of a module evaluated at states that a file
//! lists or that are drawn, in a kind of number of the user's choice.
//!
//! The result of 64-bit floats is written without the loss of a bit, one line
//! for each output element that is assigned: `state 2 dirdyna M[1,1]
//! 0x1.8p+1`; see [`ResultFormat`] for tables.

mod format;
mod given;
mod number;

pub use format::ResultFormat;
pub use number::{BITS, NumberSystem};

use format::ResultWriter;
use given::{missing, read_states};
use number::{BigFloatArithmetic, Show};
use robovec_dynamics::kinematics::{element_name, parameter};
use robovec_ir::diagnostic::{Diagnostic, clip};
use robovec_ir::print::print_output;
use robovec_ir::states::States;
use robovec_ir::{Input, Module, View};
use robovec_model::Model;
use robovec_num::double_double::DoubleDouble;
use robovec_num::field::PrimeField;
use robovec_num::soft_float::FormatArithmetic;

/// Origin of the states.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum StateSource<'t> {
    /// Lines `name[indices] number`; a line `state` starts the next state.
    /// Numbers are decimal, or hexadecimal as C's `%a` writes them; `#` starts
    /// a comment. A state may hold more than a function reads.
    Text(&'t str),
    /// Drawn with the physical scales of [`States`].
    Random {
        /// Their number.
        count: u32,
        /// Their source.
        states: &'t States,
    },
}

/// Evaluation to be done.
#[derive(Clone, Copy, Debug)]
pub struct EvaluationRequest<'a> {
    /// The functions.
    pub module: &'a Module,
    /// The model with the parameters that no state gives.
    pub model: Option<&'a Model>,
    /// The states.
    pub states: StateSource<'a>,
    /// Number system.
    pub number: NumberSystem,
    /// Way in which the result is written.
    pub format: ResultFormat,
}

/// Evaluates every function of a module at every state.
///
/// # Errors
///
/// Messages that point into the text of states (file 0): a line that is not
/// understood, no state at all, a missing number of an input element in a
/// state; or a parameter that the model does not have.
pub fn evaluate_at_states(request: &EvaluationRequest<'_>) -> Result<String, Vec<Diagnostic>> {
    let states = inputs(request)?;
    let text = match request.number {
        NumberSystem::Format(format) => write(request, &FormatArithmetic::new(format), &states),
        NumberSystem::DoubleDouble => write(request, &DoubleDouble, &states),
        NumberSystem::Field => {
            let seed = match request.states {
                StateSource::Text(_) => 1,
                StateSource::Random { states, .. } => states.seed(),
            };
            let [field, _] = PrimeField::pair(seed, true);
            write(request, &field, &states)
        }
        NumberSystem::Bits(bits) => write(request, &BigFloatArithmetic::new(bits), &states),
    };
    Ok(text)
}

/// The flattened inputs of every function, for every state.
type FlattenedInputs = Vec<Vec<Vec<f64>>>;

fn inputs(request: &EvaluationRequest<'_>) -> Result<FlattenedInputs, Vec<Diagnostic>> {
    match request.states {
        StateSource::Text(text) => given_inputs(request, text),
        StateSource::Random { count, states } => random_inputs(request, count, states),
    }
}

fn given_inputs(
    request: &EvaluationRequest<'_>,
    text: &str,
) -> Result<FlattenedInputs, Vec<Diagnostic>> {
    let tables = &request.module.tables;
    let mut inputs = Vec::new();
    let mut errors = Vec::new();
    for state in read_states(text)? {
        let mut functions = Vec::new();
        for function in &request.module.functions {
            match state.inputs(tables, function, request.model) {
                Ok(inputs) => functions.push(inputs),
                Err(name) => errors.push(missing(&name, function, &state)),
            }
            if errors.len() >= 20 {
                return Err(errors);
            }
        }
        inputs.push(functions);
    }
    if errors.is_empty() {
        Ok(inputs)
    } else {
        Err(errors)
    }
}

fn random_inputs(
    request: &EvaluationRequest<'_>,
    count: u32,
    states: &States,
) -> Result<FlattenedInputs, Vec<Diagnostic>> {
    let mut inputs = Vec::new();
    for index in 0..count {
        let mut functions = Vec::new();
        for function in &request.module.functions {
            let view = request.module.tables.view(function);
            let mut drawn = states.draw(view, index);
            if let Some(model) = request.model {
                take_parameters(model, view, &mut drawn)?;
            }
            functions.push(drawn);
        }
        inputs.push(functions);
    }
    Ok(inputs)
}

/// The arrays of parameters.
const PARAMETERS: [&str; 6] = ["m", "l", "In", "dpt", "g", "lrod"];

/// Replaces parameters by the model's; one that it lacks is an error.
fn take_parameters(
    model: &Model,
    view: View<'_>,
    inputs: &mut [f64],
) -> Result<(), Vec<Diagnostic>> {
    for (index, number) in inputs.iter_mut().enumerate() {
        let input = Input(index as u32);
        let (array, indices, rank) = view.function.input_element(input);
        let name = view.tables.symbols.text(array.name);
        match parameter(model, name, &indices[..rank]) {
            Some(given) => *number = given,
            None if PARAMETERS.contains(&name) => {
                let message = format!(
                    "the function '{}' reads {}, which the model '{}' does not have",
                    clip(&view.function.name),
                    input_name(view, input),
                    clip(&model.name)
                );
                let note = "check that this is the model of these equations";
                return Err(vec![
                    Diagnostic::error().with_message(message).with_note(note),
                ]);
            }
            None => {}
        }
    }
    Ok(())
}

fn input_name(view: View<'_>, input: Input) -> String {
    let (array, indices, rank) = view.function.input_element(input);
    element_name(view.tables.symbols.text(array.name), &indices[..rank])
}

fn write<A: Show>(
    request: &EvaluationRequest<'_>,
    arithmetic: &A,
    states: &FlattenedInputs,
) -> String {
    let mut writer = ResultWriter::new(request.format);
    for (state, functions) in states.iter().enumerate() {
        for (function, inputs) in request.module.functions.iter().zip(functions) {
            let view = request.module.tables.view(function);
            arithmetic.clear();
            let numbers = arithmetic.evaluate(function, inputs);
            writer.start(state + 1, &function.name);
            for (assignment, number) in function.assignments.iter().zip(numbers) {
                let element = print_output(view, assignment.output);
                writer.element(&element, &arithmetic.show(number, request.format));
            }
            writer.end();
        }
    }
    writer.finish()
}

#[cfg(test)]
mod tests;
