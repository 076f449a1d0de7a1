//! Programs: results of pipelines on equations.

use robovec_dynamics::generate::{Formulation, GenerateError};
use robovec_error::yardstick::Unmeasurable;
use robovec_framework::manager::{self, Config, RunError};
use robovec_framework::pipeline::Pipeline;
use robovec_framework::scene::Scene;
use robovec_ir::print::{print_operand, print_output};
use robovec_ir::{Input, Machine, Module, View};
use robovec_passes::registry::REGISTRY;
use robovec_passes::specialise::support::dependences;
use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;

/// Reason why a program could not be made or measured.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum ExplorationError {
    /// An invalid pipeline, or a pass that gave up.
    #[error("{0}")]
    Pass(String),
    /// The equations could not be made.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// The program does not match the function.
    #[error(transparent)]
    Unmeasurable(#[from] Unmeasurable),
    /// Too much work.
    #[error(
        "{designs} designs of {operations} operations are more than is placed at once; ask for \
         fewer elements, couples or instances"
    )]
    TooMuch {
        /// Designs requested.
        designs: u64,
        /// Operations of all programs.
        operations: usize,
    },
    /// No design can hold the function.
    #[error("none of {0} could be placed, the first because {1}")]
    NothingPlaced(String, String),
    /// A placement could not be written.
    #[error("cannot keep a placement: {0}")]
    NotKept(String),
    /// The model does not have an input of the equations.
    #[error("the model has no {0}")]
    Input(String),
}

impl From<RunError> for ExplorationError {
    fn from(error: RunError) -> ExplorationError {
        ExplorationError::Pass(error.to_string())
    }
}

/// The first function of a module, with its tables.
pub fn view(module: &Module) -> View<'_> {
    module.tables.view(&module.functions[0])
}

/// Module that a pipeline makes of a module, for a scene or in general. Remarks
/// of the passes are for who compiles and are not kept.
pub fn transformed(
    module: &Module,
    pipeline: &Pipeline,
    machine: &Machine,
    scene: Option<&Scene>,
) -> Result<Module, RunError> {
    let mut module = module.clone();
    let mut log = io::sink();
    let config = Config {
        scene,
        ..Config::new(machine, &mut log)
    };
    manager::run(&mut module, pipeline, config)?;
    Ok(module)
}

/// As [`transformed`], by the text of the pipeline.
///
/// # Errors
///
/// Fails when the text is no pipeline, or a pass gives up.
pub fn transformed_by(
    module: &Module,
    passes: &str,
    machine: &Machine,
    scene: Option<&Scene>,
) -> Result<Module, ExplorationError> {
    let pipeline = REGISTRY
        .pipeline(passes)
        .map_err(|error| ExplorationError::Pass(error.to_string()))?;
    Ok(transformed(module, &pipeline, machine, scene)?)
}

/// Programs by formulation and stages; the same first stages share their work.
pub(crate) struct ProgramWorkshop<'a> {
    machine: &'a Machine,
    /// By the name of the formulation, none for equations as they came, and the stages.
    made: BTreeMap<(Option<&'static str>, Vec<String>), Arc<Module>>,
}

impl<'a> ProgramWorkshop<'a> {
    /// A workshop for a module of one function, and the same in other formulations.
    pub(crate) fn new(
        machine: &'a Machine,
        module: Module,
        others: Vec<(Formulation, Module)>,
    ) -> ProgramWorkshop<'a> {
        let others = others.into_iter();
        let others = others.map(|(formulation, module)| (Some(formulation.name()), module));
        let starts = [(None, module)].into_iter().chain(others);
        ProgramWorkshop {
            machine,
            made: starts
                .map(|(name, module)| ((name, Vec::new()), Arc::new(module)))
                .collect(),
        }
    }

    /// The program that stages of passes make of a formulation, or of equations
    /// as they came. Fails when a stage is no pipeline or a pass gives up.
    pub(crate) fn program(
        &mut self,
        formulation: Option<Formulation>,
        stages: &[String],
    ) -> Result<Arc<Module>, ExplorationError> {
        let start = formulation.map(Formulation::name);
        let mut module = self.made[&(start, Vec::new())].clone();
        for count in 1..=stages.len() {
            let key = (start, stages[..count].to_vec());
            module = match self.made.get(&key) {
                Some(known) => known.clone(),
                None => {
                    let next = transformed_by(&module, &stages[count - 1], self.machine, None)?;
                    self.made.entry(key).or_insert(Arc::new(next)).clone()
                }
            };
        }
        Ok(module)
    }
}

/// The inputs that every output of a program depends on, a line each.
pub fn depending(view: View<'_>) -> String {
    let Some(dependences) = dependences(view) else {
        return "too large to test which inputs each output depends on\n".to_owned();
    };
    let lines = view.function.assignments.iter().zip(&dependences);
    let text = lines.map(|(assignment, places)| {
        let input = |&place: &usize| print_operand(view, Input(place as u32).into());
        let inputs: Vec<String> = places.iter().map(input).collect();
        let inputs = match inputs.len() {
            0 => "no input".to_owned(),
            _ => inputs.join(", "),
        };
        let output = print_output(view, assignment.output);
        format!("{output} depends on {inputs}\n")
    });
    text.collect()
}
