//! The programs: every formulation specialised, short or of few operations.

use super::format::FormatErrors;
use super::{FitError, FitProgram, FitTask, SineTreatment};
use crate::ExplorationProgress;
use crate::optimise::found::found;
use crate::optimise::start::OptimisationStart;
use crate::program::{ExplorationError, transformed_by, view};
use crate::share::SharedWork;
use robovec_dynamics::generate::Formulation;
use robovec_error::yardstick::Yardstick;
use robovec_ir::count::Counts;
use robovec_ir::print::print_function;
use robovec_ir::{Format, Module};
use robovec_passes::optimise::steps;
use std::sync::Arc;

/// Adders and multipliers that programs are searched for: few, many, between.
const SEARCHED: [[u32; 2]; 3] = [[1, 1], [4, 4], [16, 16]];

/// Passes for the fewest operations, for chains of any length.
const FACTORED: &str = "dce{order=outputs},fold,cse,factor-trig{path=free},cse,dce";

/// Sums that round less, for more time, which costs less than a bit.
const ACCURATE: &str = "accurate{growth=100 slack=100}";

/// Passes that compute the constants other passes have made.
const FOLDED: &str = "fold{inexact},zero-removal,cse,dce";

/// Every formulation balanced, and the results of the search of `robovec
/// optimise` from all of them. Formulations on which a pass fails, or that
/// compute a different function for this scene, are left out.
pub(super) fn programs(
    task: &FitTask<'_>,
    yardstick: &Yardstick,
    progress: ExplorationProgress<'_>,
) -> Result<Vec<FitProgram>, FitError> {
    let mut programs: Vec<FitProgram> = Vec::new();
    let mut last: Option<ExplorationError> = None;
    let mut texts: Vec<String> = Vec::new();
    let mut starts: Vec<(Formulation, Module)> = Vec::new();
    for (formulation, module) in &task.formulations {
        let special = match transformed_by(module, "specialise", task.machine, Some(task.scene)) {
            Ok(special) => special,
            Err(error) => {
                last = Some(error);
                continue;
            }
        };
        // One may read a length that the result does not depend on, of which the
        // states say nothing.
        if let Err(error) = yardstick.inputs(view(&special)) {
            last = Some(error.into());
            continue;
        }
        // Some formulations are the same for small models.
        let text = print_function(view(&special));
        if texts.contains(&text) {
            continue;
        }
        texts.push(text);
        for (words, steps) in [
            ("balanced", steps::REASSOCIATED),
            ("factored freely", FACTORED),
        ] {
            let stages = format!("atomise,{steps}");
            let name = format!("{}, {words}", formulation.name());
            progress(&name);
            match transformed_by(&special, &stages, task.machine, Some(task.scene)) {
                Ok(module) => {
                    programs.push(specialised(name, &stages, *formulation, Arc::new(module)));
                }
                Err(error) => last = Some(error),
            }
        }
        starts.push((*formulation, special));
    }
    programs.extend(searched(task, &starts, progress)?);
    let mut texts: Vec<String> = Vec::new();
    for program in &mut programs {
        fold(task, program)?;
        let measured = FormatErrors::at(task, program, Format::BINARY64, yardstick)?;
        program.model_share = measured.used();
    }
    // Of small models many become the same.
    programs.retain(|program| {
        let text = print_function(view(&program.module));
        let is_new = !texts.contains(&text);
        texts.extend(is_new.then_some(text));
        is_new
    });
    if programs.is_empty() {
        let reason = last.map_or("none was given".to_owned(), |error| error.to_string());
        return Err(FitError::NoProgram(reason));
    }
    Ok(programs)
}

/// A program with sums of smaller rounding error; `None` without a change.
pub(super) fn accurate(task: &FitTask<'_>, program: &FitProgram) -> Option<FitProgram> {
    // The pass gives up on what has no sums, or formats of its own.
    let module = transformed_by(&program.module, ACCURATE, task.machine, Some(task.scene)).ok()?;
    (print_function(view(&module)) != print_function(view(&program.module))).then(|| FitProgram {
        name: format!("{}, accurate", program.name),
        pipeline: format!("{},{ACCURATE}", program.pipeline),
        module: Arc::new(module),
        ..program.clone()
    })
}

/// Computes the constants that regrouping has brought together.
fn fold(task: &FitTask<'_>, program: &mut FitProgram) -> Result<(), ExplorationError> {
    let folded = transformed_by(&program.module, FOLDED, task.machine, Some(task.scene))?;
    let operations = |module: &Module| Counts::of(&module.functions[0]).operations;
    if operations(&folded) < operations(&program.module) {
        program.pipeline += &format!(",{FOLDED}");
        program.module = Arc::new(folded);
    }
    Ok(())
}

/// Programs that the search finds from specialised formulations.
fn searched(
    task: &FitTask<'_>,
    formulations: &[(Formulation, Module)],
    progress: ExplorationProgress<'_>,
) -> Result<Vec<FitProgram>, ExplorationError> {
    let starts = formulations.iter().map(|(formulation, module)| {
        OptimisationStart::formulation(*formulation, module.clone(), String::new())
    });
    let starts: Vec<OptimisationStart> = starts.collect();
    if starts.is_empty() {
        return Ok(Vec::new());
    }
    let (machine, work) = (task.machine, SharedWork::ALONE);
    let found = found(&starts, machine, &SEARCHED, work, progress)?;
    let programs = found.into_iter().map(|found| {
        let formulation = formulations[found.start].0;
        specialised(found.name, &found.passes, formulation, found.program)
    });
    Ok(programs.collect())
}

/// A program that passes made of a specialised formulation, not measured yet.
fn specialised(
    name: String,
    passes: &str,
    formulation: Formulation,
    module: Arc<Module>,
) -> FitProgram {
    FitProgram {
        name,
        pipeline: format!("specialise,{passes}"),
        formulation,
        treatment: SineTreatment::True,
        module,
        model_share: 0.0,
        mixture: None,
        excluded: None,
    }
}
