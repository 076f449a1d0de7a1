//! New equations for a project, from its files or its model.

use super::find::FoundProject;
use crate::command::generation::{self, transform_remarking};
use crate::command::{CommandFailure, input};
use robovec_cgen::c;
use robovec_cgen::kind::Generation;
use robovec_dynamics::generate::{Formulation, Options, fewest};
use robovec_dynamics::stale;
use robovec_dynamics::whole_step::{self, StepFunction, StepStyle};
use robovec_io::sources;
use robovec_ir::Module;
use robovec_ir::count::Counts;
use robovec_ir::diagnostic::Report;
use robovec_model::{Model, Nature};
use robovec_robotran::drop_in::{DropInOptions, drop_in};
use robovec_robotran::write::{WriteOptions, write};
use robovec_robotran::{FunctionKind, Language};
use std::path::{Path, PathBuf};

pub(super) struct NewEquations {
    pub(super) function: String,
    /// Operations of the project's file.
    pub(super) before: Option<usize>,
    /// Operations of the new equations.
    pub(super) after: Option<usize>,
    /// Source of the new equations.
    pub(super) remark: String,
    /// The reason why there are none.
    pub(super) reason: Option<String>,
    /// True where the file's equations are not those of the model.
    pub(super) is_stale: bool,
    /// The generator whose names the file has.
    generation: Generation,
    /// Names and texts of the new files; none where the old ones stay.
    pub(super) files: Vec<(String, String)>,
}

pub(super) fn equations(project: &FoundProject, model: Option<&Model>) -> Vec<NewEquations> {
    let make = |(kind, path): &(FunctionKind, PathBuf)| {
        let mut new = NewEquations {
            function: kind.name().to_owned(),
            before: None,
            after: None,
            remark: String::new(),
            reason: None,
            is_stale: false,
            generation: Generation::Current,
            files: Vec::new(),
        };
        if let Err(reason) = renewed(project, model, (*kind, path), &mut new) {
            "stays".clone_into(&mut new.remark);
            new.reason = Some(reason);
        }
        new
    };
    project.equations.iter().map(make).collect()
}

fn renewed(
    project: &FoundProject,
    model: Option<&Model>,
    (kind, path): (FunctionKind, &Path),
    new: &mut NewEquations,
) -> Result<(), String> {
    let read = sources::equations_or_stubs(path, None, None).map_err(|report| first(&report))?;
    if let Some(function) = read.module.functions.first() {
        new.generation = Generation::of(function);
    }
    let before = operations(&read.module);
    new.before = Some(before);
    if before == 0 {
        new.remark = "stays: it computes nothing".to_owned();
        return Ok(());
    }
    let mut module = read.module.clone();
    optimise(&mut module)?;
    let mut origin = "from the file".to_owned();
    if let Some(model) = model {
        let comparison = stale::compare(model, &read.module);
        if comparison.is_stale() {
            origin = "from the file, which is not the model's".to_owned();
            new.is_stale = true;
        } else if let Ok(other) = of_model(model, kind)
            && operations(&other) < operations(&module)
        {
            (module, origin) = (other, "from the model".to_owned());
        }
    }
    new.after = Some(operations(&module));
    for function in &mut module.functions {
        new.generation.mark(function);
    }
    let options = WriteOptions {
        model: Some(project.name.clone()),
        ..WriteOptions::default()
    };
    let files = match project.language {
        Language::C => drop_in(
            &module,
            &DropInOptions {
                write: options,
                ..DropInOptions::default()
            },
        ),
        language => write(&module, language, &options),
    };
    new.files = files.map_err(|error| error.to_string())?;
    new.remark = origin;
    Ok(())
}

/// A function of the model, in few operations.
fn of_model(model: &Model, kind: FunctionKind) -> Result<Module, String> {
    let failed = |failure: CommandFailure| first(&failure.0);
    let mut module =
        generation::functions(model, &[kind], Formulation::Composite, &Options::default())
            .map_err(failed)?;
    optimise(&mut module)?;
    Ok(module)
}

fn optimise(module: &mut Module) -> Result<(), String> {
    let failed = |failure: CommandFailure| first(&failure.0);
    let pipeline = input::passes("$cpu").map_err(failed)?;
    transform_remarking(module, &pipeline, &mut std::io::sink()).map_err(failed)
}

fn first(report: &Report) -> String {
    let message = report.diagnostics().first();
    message.map_or_else(String::new, |message| message.message.clone())
}

fn operations(module: &Module) -> usize {
    let counts = module.functions.iter().map(Counts::of);
    counts.map(|counts| counts.operations).sum()
}

/// The whole step of the model, beside new equations.
pub(super) fn whole_step(
    equations: &[NewEquations],
    model: &Model,
    user_constraints: usize,
) -> NewEquations {
    let is_stale = equations.iter().any(|one| one.is_stale);
    let is_old = equations
        .iter()
        .any(|one| one.generation == Generation::Old);
    let remark = if is_stale {
        "whole step of the model, which some files are not"
    } else {
        "whole step: for the option accelred"
    };
    let mut new = NewEquations {
        function: "accelred".to_owned(),
        before: None,
        after: None,
        remark: remark.to_owned(),
        reason: None,
        is_stale,
        generation: if is_old {
            Generation::Old
        } else {
            Generation::Current
        },
        files: Vec::new(),
    };
    let drives = model.joints.iter().any(|one| one.nature == Nature::Driven);
    let options = Options {
        user_constraints,
        // Forces of driven joints cost little without loops.
        multipliers: drives && model.cuts.is_empty() && user_constraints == 0,
        ..Options::default()
    };
    if let Err(reason) = stepped(model, &options, &mut new) {
        "no whole step".clone_into(&mut new.remark);
        new.reason = Some(reason);
    }
    new
}

fn stepped(model: &Model, options: &Options, new: &mut NewEquations) -> Result<(), String> {
    let steps = [StepFunction::Accelerations];
    let formulation = fewest(model, FunctionKind::Accelred, options);
    let mut module = whole_step::generate_parts(model, &steps, formulation, options)
        .map_err(|error| error.to_string())?;
    optimise(&mut module)?;
    new.after = Some(operations(&module));
    let style = StepStyle {
        c: &c::Options::default(),
        generation: new.generation,
        options,
    };
    new.files =
        whole_step::files(model, &steps, &module, &style).map_err(|error| error.to_string())?;
    Ok(())
}
