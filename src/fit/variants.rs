//! The programs: every formulation specialised, with the equations as short
//! or as few as the passes make them.

use super::{FitError, FitProgram, FitTask, SineTreatment, largest_tolerance_share};
use crate::explore::ExplorationProgress;
use crate::explore::program::{ExplorationError, transformed_by, view};
use crate::explore::yardstick::Yardstick;
use robovec_ir::Format;
use robovec_ir::count::Counts;
use robovec_ir::print::print_function;
use std::sync::Arc;

/// Passes behind `specialise`, by name: few operations first.
const VARIANTS: [(&str, &str); 3] = [
    ("balanced", "atomise,fold,zero-removal,balance,cse,dce"),
    (
        "look-ahead 100 %",
        "atomise,fold,zero-removal,balance,cse,dce,lookahead{growth=100},balance,cse,dce",
    ),
    (
        "look-ahead 130 %",
        "atomise,fold,zero-removal,balance,cse,dce,lookahead{growth=130},balance,cse,dce",
    ),
];

/// Larger programs are only balanced: look-ahead takes a quarter of a
/// millisecond per operation.
const LARGE: usize = 60_000;

/// Every formulation in every variant. Formulations that a pass gives up on,
/// or that compute something else for this scene, are left out.
pub(super) fn programs(
    task: &FitTask<'_>,
    yardstick: &Yardstick,
    progress: ExplorationProgress<'_>,
) -> Result<Vec<FitProgram>, FitError> {
    let mut programs: Vec<FitProgram> = Vec::new();
    let mut last: Option<ExplorationError> = None;
    let mut texts: Vec<String> = Vec::new();
    for (formulation, module) in &task.formulations {
        let special = match transformed_by(module, "specialise", task.machine, Some(task.scene)) {
            Ok(special) => special,
            Err(error) => {
                last = Some(error);
                continue;
            }
        };
        // Some formulations are the same for small models.
        let text = print_function(view(&special));
        if texts.contains(&text) {
            continue;
        }
        texts.push(text);
        for (variant, stages) in VARIANTS {
            let name = format!("{}, {variant}", formulation.name());
            progress(&name);
            let size = Counts::of(&special.functions[0]).operations;
            if size > LARGE && variant != VARIANTS[0].0 {
                continue;
            }
            match transformed_by(&special, stages, task.machine, Some(task.scene)) {
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
        }
    }
    for program in &mut programs {
        let errors = yardstick
            .errors(view(&program.module), Format::BINARY64)
            .map_err(ExplorationError::from)?;
        program.model_share = largest_tolerance_share(task.scene, program, &errors);
    }
    if programs.is_empty() {
        let reason = last.map_or("none was given".to_owned(), |error| error.to_string());
        return Err(FitError::NoProgram(reason));
    }
    Ok(programs)
}
