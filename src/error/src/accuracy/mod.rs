//! Effect of every pass of a pipeline on the rounding errors of programs.
//!
//! [`measure`] runs a pipeline over a module and keeps, for every function and
//! pass, size, path and the distribution of the errors in binary32; [`view`]
//! shows them as text, table and figure. [`robovec_analysis::rounding`]
//! describes how errors are measured and when one counts as worse.

pub mod outputs;
mod view;

pub use view::{figure, summary, table, text};

use robovec_analysis::critical_path::critical_path;
use robovec_analysis::rounding::{MedianChange, RoundingErrors};
use robovec_framework::manager::{self, Config, Progress, RunError};
use robovec_framework::pipeline::Pipeline;
use robovec_framework::scene::Scene;
use robovec_ir::states::States;
use robovec_ir::{Function, Machine, Module};
use std::io;
use std::sync::Arc;

/// A function with its errors after every pass.
#[derive(Clone, Debug)]
pub struct FunctionAccuracy {
    /// The model, or the file, and the function.
    pub name: String,
    /// For the function as read, then after every pass.
    pub steps: Vec<PassAccuracy>,
}

/// The state of a function.
#[derive(Clone, Debug)]
pub struct PassAccuracy {
    /// The pass with its options; empty for the function as read.
    pub pass: String,
    /// Everything but sines, cosines and copies.
    pub operations: usize,
    /// The longest chain, in cycles of the machine.
    pub path: u32,
    /// The errors.
    pub rounding: Arc<RoundingErrors>,
    /// Change of the medians of the relative and of the normwise errors by the
    /// pass; `None` for the function as read.
    pub changes: Option<[MedianChange; 2]>,
}

/// Options of the measurement.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// Number of random states; 0 for one by the size of the function.
    pub states: u32,
    /// Their seed.
    pub seed: u64,
    /// The scene whose ranges they are drawn from.
    pub scene: Option<&'a Scene>,
}

/// Runs a pipeline over all functions of a module and measures the errors after
/// every pass. The only function of a module is named after the module; with
/// several functions, the function's name is added.
pub fn measure(
    name: &str,
    module: &mut Module,
    pipeline: &Pipeline,
    machine: &Machine,
    options: Options<'_>,
    progress: &mut Progress<'_>,
) -> Result<Vec<FunctionAccuracy>, RunError> {
    let mut subjects: Vec<FunctionAccuracy> = Vec::new();
    let mut sizes: Vec<(usize, u32)> = Vec::new();
    for function in &module.functions {
        let name = match module.functions.len() {
            1 => name.to_owned(),
            _ => format!("{name} {}", function.name),
        };
        subjects.push(FunctionAccuracy {
            name,
            steps: Vec::new(),
        });
        sizes.push(size(function, machine));
    }
    let names: Vec<String> = module.functions.iter().map(|f| f.name.clone()).collect();
    // Remarks of the passes are for who compiles.
    let mut log = io::sink();
    let config = Config {
        rounding: Some(options.states),
        states: match options.scene {
            Some(scene) => scene.states(options.seed),
            None => States::new(options.seed),
        },
        scene: options.scene,
        progress: Some(progress),
        ..Config::new(machine, &mut log)
    };
    let outcome = manager::run(module, pipeline, config)?;
    for record in outcome.records {
        let Some([before, after]) = record.rounding else {
            continue;
        };
        let Some(index) = names.iter().position(|name| *name == record.function) else {
            continue;
        };
        let steps = &mut subjects[index].steps;
        if steps.is_empty() {
            let (operations, path) = sizes[index];
            steps.push(PassAccuracy {
                pass: String::new(),
                operations,
                path,
                rounding: before.clone(),
                changes: None,
            });
        }
        steps.push(PassAccuracy {
            changes: Some(changes(&before, &after)),
            pass: record.name,
            operations: record.operations as usize,
            path: record.asap_cycle,
            rounding: after,
        });
    }
    Ok(subjects)
}

fn size(function: &Function, machine: &Machine) -> (usize, u32) {
    let operations = robovec_ir::count::Counts::of(function).operations;
    (operations, critical_path(function, machine).asap_cycle)
}

impl FunctionAccuracy {
    /// The changes from the function as read to the end.
    pub fn overall(&self) -> Option<[MedianChange; 2]> {
        let (first, last) = (self.steps.first()?, self.steps.last()?);
        Some(changes(&first.rounding, &last.rounding))
    }
}

fn changes(before: &RoundingErrors, after: &RoundingErrors) -> [MedianChange; 2] {
    [
        MedianChange::relative(before, after),
        MedianChange::normwise(before, after),
    ]
}
