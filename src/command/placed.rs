//! Placed text that is wrong: the message names the file, not a pass.

use super::CommandFailure;
use robovec_framework::manager::{RunError, check_schedules};
use robovec_io::sources::ReadEquations;
use robovec_ir::Machine;
use robovec_ir::diagnostic::{Diagnostic, Report};
use robovec_ir::parse::{VerificationTarget, parse_placed};

/// Refuses input with a schedule of another machine, or a placement that is
/// wrong on its own.
pub(super) fn check(input: &ReadEquations, machine: &Machine) -> Result<(), CommandFailure> {
    check_schedules(&input.module, machine).map_err(|error| match &error {
        RunError::Given { help, .. } => refusal(&error.to_string(), help, input, machine),
        _ => CommandFailure::plain(error.to_string()),
    })
}

/// The message of [`RunError::Given`]: in the text where it can be read
/// again, else in the words of the verifier.
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
