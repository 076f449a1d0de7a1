//! `--simulate`: the placed program against equations; wrong placed text.

use super::CommandFailure;
use robovec_fpga::write_images;
use robovec_framework::manager::{RunError, check_schedules};
use robovec_io::sources::ReadEquations;
use robovec_ir::diagnostic::{Diagnostic, Report, counted};
use robovec_ir::evaluate::evaluate_mixed;
use robovec_ir::parse::{VerificationTarget, parse_placed};
use robovec_ir::print::print_output;
use robovec_ir::states::States;
use robovec_ir::{Function, Level, Machine, Module, View};
use robovec_num::soft_float::FormatArithmetic;
use robovec_simulate::LoadedProgram;
use std::fmt::Write;

/// Generates the memory images of every placed function, runs them cycle by
/// cycle on random states, and compares each output with the evaluator, bit
/// for bit. Returns a line per function for the user.
pub(crate) fn simulate(
    module: &Module,
    machine: &Machine,
    states: u32,
    draws: &States,
) -> Result<String, CommandFailure> {
    let mut text = String::new();
    for function in &module.functions {
        if function.level != Level::Placed {
            return Err(CommandFailure::advised(
                format!(
                    "'{}' is at the level {}, not placed",
                    function.name, function.level
                ),
                vec!["'--simulate' needs a pipeline with 'place' in it".to_owned()],
            ));
        }
        let view = module.tables.view(function);
        let cycles = compare(view, machine, states, draws).map_err(|reason| {
            CommandFailure::plain(format!("simulating '{}': {reason}", function.name))
        })?;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{}: {} of {}, {} each, all equal to the evaluator's bit for bit",
            function.name,
            counted(states, "simulated run"),
            counted(cycles, "cycle"),
            counted(function.assignments.len(), "output"),
        );
    }
    Ok(text)
}

fn compare(view: View<'_>, machine: &Machine, states: u32, draws: &States) -> Result<u32, String> {
    let mut files: Vec<(String, String)> = Vec::new();
    write_images(view, machine, None, &mut files).map_err(|error| error.to_string())?;
    let program = LoadedProgram::load(&files, machine).map_err(|error| error.to_string())?;
    let places: Vec<u32> = program.outputs().map(|(_, place)| place).collect();
    let arithmetic = FormatArithmetic::new(machine.number);
    for index in 0..states {
        let inputs = draws.draw(view, index);
        let outputs = program.run(&inputs).map_err(|hazard| hazard.to_string())?;
        let expected = expected(view.function, &arithmetic, &inputs);
        for (place, word) in places.iter().zip(&outputs.words) {
            // Assignments stand in the order of their outputs.
            let (_, wanted) = expected
                .binary_search_by_key(place, |(output, _)| *output)
                .map(|found| &expected[found])
                .map_err(|_| "the images set an output the function does not have")?;
            if word != wanted {
                let name = print_output(view, robovec_ir::Output(*place));
                return Err(format!(
                    "state {index}: {name} is {word:#x} in the machine and {wanted:#x} in the \
                     evaluator"
                ));
            }
        }
    }
    Ok(program.cycles())
}

/// Outputs of the evaluator: place among the flattened outputs, and bits.
fn expected(function: &Function, arithmetic: &FormatArithmetic, inputs: &[f64]) -> Vec<(u32, u64)> {
    let outputs = evaluate_mixed(function, arithmetic.format(), inputs);
    function
        .assignments
        .iter()
        .zip(outputs)
        .map(|(assignment, number)| (assignment.output.0, arithmetic.word(number)))
        .collect()
}

/// Refuses input scheduled for another machine, or with a wrong placement.
pub(super) fn check(input: &ReadEquations, machine: &Machine) -> Result<(), CommandFailure> {
    check_schedules(&input.module, machine).map_err(|error| match &error {
        RunError::Given { help, .. } => refusal(&error.to_string(), help, input, machine),
        _ => CommandFailure::plain(error.to_string()),
    })
}

/// The message of [`RunError::Given`], in the text where that can be read.
pub(super) fn refusal(
    message: &str,
    help: &str,
    input: &ReadEquations,
    machine: &Machine,
) -> CommandFailure {
    let functions = &input.module.functions;
    let wanted = |name: &str| functions.iter().any(|function| function.name == name);
    let target = VerificationTarget {
        machine,
        wanted: &wanted,
    };
    let advice = format!("help: {help}");
    if let Some(text) = input.text()
        && let Err(mut found) = parse_placed(&input.name, &text, target)
    {
        if let Some(last) = found.last_mut() {
            last.notes.push(advice);
        }
        return CommandFailure(Report::of(&input.name, text, found));
    }
    let mut report = Report::new();
    let diagnostic = Diagnostic::error().with_message(format!("{}: {message}", input.name));
    report.push(diagnostic.with_notes(vec![advice]));
    CommandFailure(report)
}
