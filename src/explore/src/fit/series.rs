//! Sines and cosines on the elements: of each method the smallest order.

use super::format::FormatErrors;
use super::{FitError, FitProgram, FitTask};
use crate::ExplorationProgress;
use crate::program::transformed_by;
use robovec_error::yardstick::Yardstick;
use robovec_ir::Format;
use robovec_num::trigonometry::host::Implementation;
use serde::Serialize;
use std::fmt;
use std::sync::Arc;

/// Place where sines and cosines are computed.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SinePlace {
    /// Before the run.
    #[default]
    Host,
    /// Before the run, by a unit with an error: a polynomial, a table or CORDIC.
    Unit,
    /// By the elements, as series.
    Elements,
}

/// Way in which the sines and cosines of a program are computed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SineTreatment {
    /// Exact ones, before the run.
    True,
    /// By a Taylor polynomial of an order.
    Taylor(u32),
    /// By a minimax polynomial of an order.
    Minimax(u32),
    /// Before the run, by a unit.
    Unit(Implementation),
}

impl SineTreatment {
    /// The pass that writes it as a series; `None` if there is none.
    fn pass(self) -> Option<String> {
        match self {
            SineTreatment::True | SineTreatment::Unit(_) => None,
            SineTreatment::Taylor(order) => {
                Some(format!("trigonometry{{method=taylor order={order}}}"))
            }
            SineTreatment::Minimax(order) => {
                Some(format!("trigonometry{{method=minimax order={order}}}"))
            }
        }
    }
}

impl fmt::Display for SineTreatment {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SineTreatment::True => formatter.write_str("true sin and cos"),
            SineTreatment::Taylor(order) => write!(formatter, "Taylor order {order}"),
            SineTreatment::Minimax(order) => write!(formatter, "minimax order {order}"),
            SineTreatment::Unit(implementation) => write!(formatter, "unit {implementation}"),
        }
    }
}

const ORDERS: [u32; 7] = [1, 3, 5, 7, 9, 11, 13];

/// Passes after a series: its products shared with others, its sums in time.
const BEHIND: &str = "fold{inexact},zero-removal,balance,cse,dce";

/// Writes sines and cosines as series on request: a program with sines becomes
/// one per method and order, up to the first that is exact enough.
pub(super) fn write(
    task: &FitTask<'_>,
    yardstick: &Yardstick,
    programs: &mut Vec<FitProgram>,
    progress: ExplorationProgress<'_>,
) -> Result<(), FitError> {
    if task.trigonometry != SinePlace::Elements {
        return Ok(());
    }
    let mut written: Vec<FitProgram> = shortest_with_sines(programs).into_iter().collect();
    for program in programs.drain(..) {
        if !program.has_sines() {
            written.push(program);
            continue;
        }
        progress(&format!("{}: series", program.name));
        for method in [SineTreatment::Taylor, SineTreatment::Minimax] {
            for treatment in ORDERS.map(method) {
                let new = with_series(task, yardstick, &program, treatment)?;
                let enough = new.model_share <= task.of_series();
                written.push(new);
                if enough {
                    break;
                }
            }
        }
    }
    *programs = written;
    Ok(())
}

/// The shortest program whose sines and cosines a host would compute.
fn shortest_with_sines(programs: &[FitProgram]) -> Option<FitProgram> {
    let with_sines = programs.iter().filter(|program| program.has_sines());
    let shortest = with_sines.min_by_key(|program| program.module.functions[0].nodes().len());
    shortest.map(|program| FitProgram {
        excluded: Some("the scene has sines and cosines computed by the elements".to_owned()),
        ..program.clone()
    })
}

fn with_series(
    task: &FitTask<'_>,
    yardstick: &Yardstick,
    program: &FitProgram,
    treatment: SineTreatment,
) -> Result<FitProgram, FitError> {
    let Some(pass) = treatment.pass() else {
        return Ok(program.clone());
    };
    let stage = format!("{pass},{BEHIND}");
    let module = transformed_by(&program.module, &stage, task.machine, Some(task.scene))?;
    let mut new = FitProgram {
        pipeline: format!("{},{stage}", program.pipeline),
        treatment,
        module: Arc::new(module),
        ..program.clone()
    };
    new.model_share = FormatErrors::at(task, &new, Format::BINARY64, yardstick)?.used();
    Ok(new)
}
