//! `robovec gen --whole-step`: C that does the whole step of MBsysC.

use super::files::save;
use super::{FEWEST, GenArguments, not_a_model, transform, transform_remarking};
use crate::command::{CommandFailure, input, progress};
use robovec_cgen::c::{self, Real};
use robovec_dynamics::generate::{GenerateError, cuts_of_rows, redundant_rows};
use robovec_dynamics::whole_step::{self, StepFunction, StepStyle, step_error};
use robovec_io::sources;
use robovec_ir::{Format, Module};
use robovec_model::Model;
use robovec_robotran::FunctionKind;
use std::io::Write;

/// Writes the C of the whole step; gives the names of the files.
pub(super) fn run(arguments: &GenArguments) -> Result<String, CommandFailure> {
    let [path] = &arguments.subjects[..] else {
        return Err(CommandFailure::plain("--whole-step takes one model"));
    };
    let folder = arguments.output.as_deref();
    let folder = folder.expect("the command line requires -o");
    if !sources::is_model_path(path) {
        return Err(not_a_model("--whole-step", path));
    }
    let pipeline = input::passes(arguments.passes.as_deref().unwrap_or("$cpu"))?;
    let steps = steps(&arguments.function)?;
    let model = arguments.model(path, Some(FunctionKind::Accelred))?;
    let formulation = arguments.formulation(&model, FunctionKind::Accelred, FEWEST);
    let options = arguments.options();
    let mut module = whole_step::generate_parts(&model, &steps, formulation, &options)
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    tell_redundant(&model)?;
    // Passes of the preset that do not suit a part report nothing.
    match arguments.passes {
        Some(_) => transform(&mut module, &pipeline)?,
        None => transform_remarking(&mut module, &pipeline, &mut std::io::sink())?,
    }
    let real = arguments.files.number;
    let style = StepStyle {
        c: &c::Options {
            real,
            superwords: arguments.files.superwords,
            ..c::Options::default()
        },
        generation: arguments.files.generation.unwrap_or_default(),
        options: &options,
    };
    let files = whole_step::files(&model, &steps, &module, &style)
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    let saved = save(&files, folder)?;
    match real {
        Real::Double => Ok(saved),
        Real::Float => Ok(saved + &error_lines(&model, &steps, &module)?),
    }
}

/// Names the rows of loops that repeat others.
fn tell_redundant(model: &Model) -> Result<(), CommandFailure> {
    let failed = |error: GenerateError| CommandFailure::plain(error.to_string());
    let cuts = cuts_of_rows(model).map_err(failed)?;
    for row in redundant_rows(model).map_err(failed)? {
        let _ = writeln!(
            progress::remarks(),
            "remark: row {} of the constraints (cut '{}') repeats other rows, and is left out",
            row + 1,
            model.cuts[cuts[row]].name
        );
    }
    Ok(())
}

/// Effect of binary32 on the results of steps, a line each.
fn error_lines(
    model: &Model,
    steps: &[StepFunction],
    module: &Module,
) -> Result<String, CommandFailure> {
    let mut text = String::new();
    for &step in steps {
        let account = step_error(model, step, module, Format::BINARY32)
            .map_err(|error| CommandFailure::plain(error.to_string()))?;
        text += &match account {
            Some(account) => format!("{}: {}\n", step.name(), account.text()),
            None => format!(
                "{}: error in f32 not measured: no states with closed loops were found, or \
                 constraints of the user are part of it\n",
                step.name()
            ),
        };
    }
    Ok(text)
}

/// The steps requested; without a word on functions it is that of accelerations.
fn steps(names: &[String]) -> Result<Vec<StepFunction>, CommandFailure> {
    let all = [StepFunction::Accelerations, StepFunction::ActuatorForces];
    let known = |name: &String| all.iter().any(|step| step.name() == name);
    match names.iter().find(|name| !known(name)) {
        None if names.is_empty() => Ok(vec![StepFunction::Accelerations]),
        None => {
            let asked = |step: &StepFunction| names.iter().any(|name| name == step.name());
            Ok(all.into_iter().filter(asked).collect())
        }
        Some(name) => Err(CommandFailure::plain(format!(
            "--whole-step writes accelred and invdynared, and '{name}' is neither"
        ))),
    }
}
