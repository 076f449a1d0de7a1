//! `--auto-reduce` and `--reproducer`: reduction of a failing pass.

use super::arguments::OptimiserArguments;
use super::{CommandFailure, output, reproducer};
use robovec_framework::pass::TargetFolder;
use robovec_framework::pipeline::Pipeline;
use robovec_framework::reduce::{self, Broken, Reduction, TrialSetting};
use robovec_framework::scene::Scene;
use robovec_ir::diagnostic::Diagnostic;
use robovec_ir::{Machine, Module};
use robovec_rules::RuleSet;
use std::io::{self, Write as _};
use std::panic;
use std::path::Path;

/// Keeps a copy of the module that was read, when a reduction may need it.
pub(super) fn keep(arguments: &OptimiserArguments, module: &Module) -> Option<Module> {
    let wanted = arguments.auto_reduce.is_some() || arguments.reproducer.is_some();
    wanted.then(|| module.clone())
}

/// Adds requested parts to a failure of a pass: a program, a reproducer.
pub(super) fn follow_up(
    mut failure: CommandFailure,
    kept: Option<&Module>,
    pipeline: &Pipeline,
    (machine, rules, scene, target): (&Machine, &RuleSet, Option<&Scene>, Option<&TargetFolder>),
    arguments: &OptimiserArguments,
) -> CommandFailure {
    let Some(module) = kept else {
        return failure;
    };
    let setting = TrialSetting {
        machine,
        rules,
        scene,
        target,
        points: reproducer::points(arguments),
        seed: arguments.seed,
    };
    // Panics are counted, not told: a reduction may see thousands.
    panic::set_hook(Box::new(|_| {}));
    let attempt = write_files(module, pipeline, setting, arguments);
    drop(panic::take_hook());
    match attempt {
        Ok(notes) => {
            for note in notes {
                failure.0.push(Diagnostic::note().with_message(note));
            }
            failure
        }
        Err(worse) => {
            failure.0.extend(worse.0.diagnostics().iter().cloned());
            failure
        }
    }
}

/// Writes the files requested, and reports it.
fn write_files(
    module: &Module,
    pipeline: &Pipeline,
    setting: TrialSetting<'_>,
    arguments: &OptimiserArguments,
) -> Result<Vec<String>, CommandFailure> {
    let mut notes = Vec::new();
    if let Some(path) = &arguments.reproducer
        && let Some(broken) = reduce::broken_pass(module, pipeline, setting)
    {
        write_broken(path, &broken, arguments)?;
        notes.push(again(path, "the function before the pass is in"));
    }
    if let Some(path) = &arguments.auto_reduce
        && let Some(reduction) = reduce::reduce(module, pipeline, setting, arguments.reduce_work)
    {
        write_reduction(path, &reduction, arguments)?;
        // As everywhere: a closed standard error has no reader.
        let _ = write!(io::stderr(), "{reduction}");
        notes.push(again(path, "the smallest program is in"));
    }
    Ok(notes)
}

fn again(path: &Path, what: &str) -> String {
    let path = path.display();
    format!("{what} {path}; run it again with: robovec-opt {path} --run-reproducer")
}

fn write_broken(
    path: &Path,
    broken: &Broken,
    arguments: &OptimiserArguments,
) -> Result<(), CommandFailure> {
    let about = &broken.problem.message;
    let text = reproducer::text(&broken.program, &broken.pipeline, arguments, about);
    output::write_file(path, |writer| writer.write_all(text.as_bytes()))
}

fn write_reduction(
    path: &Path,
    reduction: &Reduction,
    arguments: &OptimiserArguments,
) -> Result<(), CommandFailure> {
    let about = reduction.small_summary();
    let text = reproducer::text(&reduction.program, &reduction.pipeline, arguments, &about);
    output::write_file(path, |writer| writer.write_all(text.as_bytes()))
}
