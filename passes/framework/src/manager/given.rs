//! The function that a pipeline is given, verified against the machine before
//! any pass.
//!
//! Text that was read is well formed, and no more: a placement in it may be
//! wrong on its machine, or be for another one. A fault found only after the
//! first pass would be attributed to that pass.

use super::RunError;
use crate::pass::Gives;
use crate::pipeline::{Pipeline, PipelineStep};
use robovec_ir::verify::verify_placement;
use robovec_ir::{Level, Machine, Module};

/// Refuses schedules of another machine and placements that are wrong, unless
/// the first pass makes them again.
pub(super) fn check(
    module: &Module,
    pipeline: &Pipeline,
    machine: &Machine,
) -> Result<(), RunError> {
    let first = pipeline.steps.iter().find_map(|step| match step {
        PipelineStep::Pass(pass) => Some(pass),
        PipelineStep::Open { .. } | PipelineStep::Close => None,
    });
    let Some(first) = first else {
        return Ok(());
    };
    if first.info.gives == Gives::Level(Level::Placed) {
        return Ok(());
    }
    check_schedules(module, machine)
}

/// Refuses a module with a schedule of another machine or a placement that is
/// wrong.
///
/// # Errors
///
/// [`RunError::Given`], of the first such function.
pub fn check_schedules(module: &Module, machine: &Machine) -> Result<(), RunError> {
    for function in &module.functions {
        let Some(schedule) = &function.schedule else {
            continue;
        };
        let given = |violations: Vec<String>, help: String| RunError::Given {
            function: function.name.clone(),
            violations,
            help,
        };
        if let Err(mismatch) = schedule.check_machine(machine) {
            return Err(given(vec![mismatch.to_string()], mismatch.advice()));
        }
        if function.level != Level::Placed {
            continue;
        }
        let view = module.tables.view(function);
        let found = verify_placement(view, machine).into_iter();
        let violations: Vec<String> = found.map(|violation| violation.message).collect();
        if !violations.is_empty() {
            let help = "correct the text, or place the program again: -passes=place";
            return Err(given(violations, help.to_owned()));
        }
    }
    Ok(())
}
