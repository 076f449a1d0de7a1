//! The programs: every formulation specialised, with the equations as short
//! or as few as the passes make them.

use super::tolerance::FormatErrors;
use super::{FitError, FitProgram, FitTask, SineTreatment};
use crate::explore::ExplorationProgress;
use crate::explore::program::{ExplorationError, transformed_by, view};
use crate::generate::Formulation;
use crate::optimise::found::found;
use crate::optimise::start::OptimisationStart;
use crate::yardstick::Yardstick;
use robovec_ir::print::print_function;
use robovec_ir::{Format, Module};
use robovec_passes::optimise::steps;
use std::sync::Arc;

/// Numbers of adders and multipliers that programs are searched for: few
/// operations, short paths, and between the two.
const SEARCHED: [[u32; 2]; 3] = [[1, 1], [4, 4], [16, 16]];

/// Every formulation balanced, and what the search of `robovec optimise` finds
/// from all of them. Formulations that a pass gives up on, or that compute
/// something else for this scene, are left out.
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
        let stages = format!("atomise,{}", steps::REASSOCIATED);
        let name = format!("{}, balanced", formulation.name());
        progress(&name);
        match transformed_by(&special, &stages, task.machine, Some(task.scene)) {
            Ok(module) => programs.push(FitProgram {
                name,
                pipeline: format!("specialise,{stages}"),
                formulation: *formulation,
                treatment: SineTreatment::True,
                module: Arc::new(module),
                model_share: 0.0,
            }),
            Err(error) => last = Some(error),
        }
        starts.push((*formulation, special));
    }
    programs.extend(searched(task, &starts, progress)?);
    for program in &mut programs {
        let measured = FormatErrors::at(task, program, Format::BINARY64, yardstick)?;
        program.model_share = measured.used();
    }
    if programs.is_empty() {
        let reason = last.map_or("none was given".to_owned(), |error| error.to_string());
        return Err(FitError::NoProgram(reason));
    }
    Ok(programs)
}

/// What the search finds from specialised formulations.
fn searched(
    task: &FitTask<'_>,
    formulations: &[(Formulation, Module)],
    progress: ExplorationProgress<'_>,
) -> Result<Vec<FitProgram>, ExplorationError> {
    let starts = formulations.iter().map(|(formulation, module)| {
        let made = module.clone();
        match formulation {
            Formulation::Recursive => OptimisationStart {
                name: formulation.name().to_owned(),
                ..OptimisationStart::given(made)
            },
            _ => OptimisationStart::formulation(*formulation, made, String::new()),
        }
    });
    let starts: Vec<OptimisationStart> = starts.collect();
    if starts.is_empty() {
        return Ok(Vec::new());
    }
    let found = found(&starts, task.machine, &SEARCHED, progress)?;
    let programs = found.into_iter().map(|found| FitProgram {
        name: found.name,
        pipeline: format!("specialise,{}", found.passes),
        formulation: formulations[found.start].0,
        treatment: SineTreatment::True,
        module: found.program,
        model_share: 0.0,
    });
    Ok(programs.collect())
}
