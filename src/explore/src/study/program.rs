//! Preparation of a program for placement: read or generate the model's
//! equations, run a pipeline, measure the result.

use super::plan::{NamedMachine, NamedPipeline, StudySubject};
use crate::program::{transformed, view};
use robovec_analysis::critical_path::critical_path;
use robovec_analysis::rounding::{RoundingErrors, UNIT, rounding, usual_states};
use robovec_error::yardstick::account::random_states;
use robovec_ir::count::Counts;
use robovec_ir::diagnostic::{Report, did_you_mean};
use robovec_ir::states::States;
use robovec_ir::{Machine, Module, Operation};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Seed of the states at which rounding errors are measured.
const SEED: u64 = 1;

/// Source of programs: the caller supplies files and models.
pub trait ProgramSources: Sync {
    /// The equations of a source: a file, a model, a built-in name.
    fn equations(&self, subject: &StudySubject) -> Result<Module, Report>;
}

/// Counts of a program before placement.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct ProgramFacts {
    pub model: String,
    pub pipeline: String,
    /// The machine with the latencies for the pipeline.
    pub machine: String,
    pub function: String,
    /// Equations as read or generated.
    pub equations: usize,
    /// Groups of equations that need only those before them, as read.
    pub vectors: usize,
    pub operations: usize,
    /// Additions and subtractions.
    pub add_sub: usize,
    /// Multiplications.
    pub mul: usize,
    /// The longest chain, in operations.
    pub asap: u32,
    /// The longest chain, in cycles.
    pub asap_cycle: u32,
    /// Number of operations of one longest chain that multiply.
    pub path_mul: u32,
    /// Number of them that add or subtract.
    pub path_add: u32,
    /// Rounding errors in binary32, as read and now, at the same states.
    #[serde(skip)]
    pub rounding: [Arc<RoundingErrors>; 2],
}

impl ProgramFacts {
    /// The thesis' Y: operations per cycle of the longest chain, 0 without any.
    pub fn number_y(&self) -> f64 {
        match self.asap_cycle {
            0 => 0.0,
            cycles => self.operations as f64 / f64::from(cycles),
        }
    }

    /// Median and worst error in binary32, relative to the largest element.
    pub(super) fn errors(&self) -> [f64; 2] {
        let normwise = self.rounding[1].normwise;
        [normwise.median * UNIT, normwise.worst * UNIT]
    }

    /// Source of the errors, in words.
    pub(super) fn states(&self) -> String {
        let rounding = &self.rounding[1];
        random_states(rounding.states as usize, rounding.seed, false)
    }
}

/// The equations of one model.
pub struct StudyEquations {
    /// The function studied, alone in its module.
    pub module: Module,
    equations: usize,
    vectors: usize,
    rounding: Arc<RoundingErrors>,
}

impl StudyEquations {
    /// Reads or generates a model and picks the function.
    pub fn load(
        subject: &StudySubject,
        sources: &dyn ProgramSources,
    ) -> Result<StudyEquations, Report> {
        let mut module = sources.equations(subject)?;
        pick(&mut module, subject)?;
        let function = &module.functions[0];
        let counts = Counts::of(function);
        let states = usual_states(counts.operations);
        Ok(StudyEquations {
            rounding: Arc::new(rounding(view(&module), &States::new(SEED), states)),
            module,
            equations: counts.equations,
            vectors: counts.vectors,
        })
    }

    /// Runs a pipeline for a machine.
    ///
    /// # Errors
    ///
    /// The pass manager's message.
    pub fn optimise(
        &self,
        subject: &StudySubject,
        pipeline: &NamedPipeline,
        machine: &NamedMachine,
    ) -> Result<StudyProgram, String> {
        let module = transformed(&self.module, &pipeline.pipeline, &machine.machine, None)
            .map_err(|error| error.to_string())?;
        let function = &module.functions[0];
        let counts = Counts::of(function);
        let path = critical_path(function, &machine.machine);
        let [path_add, path_mul] = kinds_on_path(function, &machine.machine);
        let now = rounding(view(&module), &States::new(SEED), self.rounding.states);
        let facts = ProgramFacts {
            model: subject.name.clone(),
            pipeline: pipeline.name.clone(),
            machine: machine.name.clone(),
            function: function.name.clone(),
            equations: self.equations,
            vectors: self.vectors,
            operations: counts.operations,
            add_sub: counts.add_sub,
            mul: counts.mul,
            asap: path.asap,
            asap_cycle: path.asap_cycle,
            path_mul,
            path_add,
            rounding: [self.rounding.clone(), Arc::new(now)],
        };
        Ok(StudyProgram { module, facts })
    }
}

/// A program ready to be placed.
pub struct StudyProgram {
    /// One function, at the atomic level.
    pub module: Module,
    /// Its figures.
    pub facts: ProgramFacts,
}

/// Leaves the wanted function alone in the module.
fn pick(module: &mut Module, subject: &StudySubject) -> Result<(), Report> {
    let names: Vec<String> = module.functions.iter().map(|f| f.name.clone()).collect();
    let wanted = match (&subject.function, &names[..]) {
        (Some(name), _) => name.clone(),
        (None, [only]) => only.clone(),
        (None, _) => "dirdyna".to_owned(),
    };
    module.functions.retain(|function| function.name == wanted);
    if module.functions.len() == 1 {
        return Ok(());
    }
    let mut notes = vec![format!("functions: {}", names.join(", "))];
    if let Some(near) = did_you_mean(&wanted, names.iter().map(String::as_str)) {
        notes.insert(0, format!("did you mean '{near}'?"));
    }
    let message = format!("the model '{}' has no function '{wanted}'", subject.name);
    Err(Report::error(message, notes))
}

/// Additions and multiplications on the first of the longest chains.
fn kinds_on_path(function: &robovec_ir::Function, machine: &Machine) -> [u32; 2] {
    use robovec_analysis::critical_path::{Weights, arrivals};
    let weights = Weights::cycles(machine);
    let arrivals = arrivals(function, &weights);
    let nodes = function.nodes();
    let longest = arrivals.iter().copied().fold(0, u32::max);
    let mut next = arrivals.iter().position(|&arrival| arrival == longest);
    let mut counts = [0; 2];
    while let Some(index) = next {
        let node = &nodes[index];
        match node.operation {
            Operation::Mul => counts[1] += 1,
            Operation::Add | Operation::Sub | Operation::Neg => counts[0] += 1,
            _ => {}
        }
        let ready = arrivals[index].saturating_sub(weights.of(node.operation));
        let mut operands = node.operands().iter().filter_map(|operand| operand.value());
        let late = |value: &robovec_ir::Value| ready > 0 && arrivals[value.index()] == ready;
        // Operands stand earlier in program order, so the walk ends.
        next = operands.find(late).map(|value| value.index());
    }
    counts
}
