//! Trial of a choice on the machine itself.
//!
//! The search used the evaluator and formulas for machines. The chosen program
//! is placed, written as memory images and run cycle by cycle by the simulator,
//! which shares no code with the placer, at the worst states that were found:
//! its results must be the evaluator's bit for bit, and within the tolerances.

use super::{Challenge, FitCandidate, FitError, FitProgram, FitTask, format};
use crate::placing::{placed, with_fused};
use crate::program::{ExplorationError, view};
use robovec_error::yardstick::{Yardstick, results};
use robovec_fpga::write_images;
use robovec_ir::{Machine, Module, View};
use robovec_schedule::PlaceOptions;
use serde::Serialize;

/// States that are run cycle by cycle.
const SIMULATED: usize = 8;

/// Runs of a choice on the machine: their states, and the results.
#[derive(Clone, PartialEq, Default, Debug, Serialize)]
pub struct Confirmation {
    /// States run cycle by cycle.
    pub simulated: usize,
    /// Cycles of a run.
    pub cycles: u32,
    /// True if the simulator's results are the evaluator's, bit for bit.
    pub equal: bool,
    /// The largest error of the simulator's results over its tolerance.
    pub simulated_used: f64,
    /// Reason for a missing or failed simulation.
    pub remark: String,
    /// No machine runs it: each value has its own format.
    pub is_for_other_hardware: bool,
}

impl Confirmation {
    /// True when the choice held in every possible run.
    pub fn holds(&self) -> bool {
        self.is_for_other_hardware || self.equal && self.simulated_used <= 1.0
    }
}

/// A program ready for the machine: placed, in its format.
pub struct Ready {
    /// The function alone: placed, or atomic where each value has its format.
    pub module: Module,
    /// The machine with its elements and format.
    pub machine: Machine,
}

/// Places a candidate; a program with a format for each value is unchanged.
///
/// # Errors
///
/// Fails when it cannot be placed any more, a mistake of the search.
pub fn ready(
    task: &FitTask<'_>,
    program: &FitProgram,
    candidate: &FitCandidate,
) -> Result<Ready, FitError> {
    let mut machine = with_fused(task.machine, candidate.elements);
    if let Ok(number) = candidate.format.parse() {
        machine.number = number;
    }
    if program.mixture.is_some() {
        return Ok(Ready {
            module: (*program.module).clone(),
            machine,
        });
    }
    let placed = placed(&program.module, &machine, PlaceOptions::default())
        .map_err(|error| ExplorationError::Pass(error.to_string()))?;
    let mut module = (*program.module).clone();
    module.functions[0] = placed.function;
    Ok(Ready { module, machine })
}

/// Runs a candidate cycle by cycle at the worst states of its challenge.
///
/// # Errors
///
/// See [`FitError`]; that it does not hold is no error.
pub fn confirm(
    task: &FitTask<'_>,
    (program, candidate): (&FitProgram, &FitCandidate),
    challenge: &Challenge,
) -> Result<Confirmation, FitError> {
    if program.mixture.is_some() {
        return Ok(Confirmation {
            cycles: candidate.cycles,
            remark: "a machine's elements compute in one format, its values do not".to_owned(),
            is_for_other_hardware: true,
            ..Confirmation::default()
        });
    }
    let ready = ready(task, program, candidate)?;
    let worst = &challenge.worst[..SIMULATED.min(challenge.worst.len())];
    let worst = Yardstick::at(view(task.general), worst.to_vec());
    let view = view(&program.module);
    let inputs = worst.inputs(view)?;
    let mut confirmation = Confirmation {
        cycles: candidate.cycles,
        simulated_used: f64::INFINITY,
        ..Confirmation::default()
    };
    match run(&ready, &inputs) {
        Err(reason) => confirmation.remark = reason,
        Ok((cycles, simulated)) => {
            let expected = results(view, ready.machine.number, &inputs);
            let bits = |rows: &[Vec<f64>]| -> Vec<u64> {
                rows.iter().flatten().copied().map(f64::to_bits).collect()
            };
            confirmation.cycles = cycles;
            confirmation.simulated = inputs.len();
            confirmation.equal = bits(&simulated) == bits(&expected);
            let shares = format::shares(task, program, &worst, &simulated)?;
            confirmation.simulated_used = shares.into_iter().fold(0.0, f64::max);
        }
    }
    Ok(confirmation)
}

/// Runs the images of a placed program: cycles, and results by assignments.
fn run(ready: &Ready, states: &[Vec<f64>]) -> Result<(u32, Vec<Vec<f64>>), String> {
    let placed: View<'_> = view(&ready.module);
    let mut files: Vec<(String, String)> = Vec::new();
    write_images(placed, &ready.machine, None, &mut files).map_err(|error| error.to_string())?;
    let program = robovec_simulate::LoadedProgram::load(&files, &ready.machine)
        .map_err(|error| error.to_string())?;
    let places: Vec<u32> = program.outputs().map(|(_, place)| place).collect();
    let mut rows = Vec::with_capacity(states.len());
    for state in states {
        let outputs = program.run(state).map_err(|hazard| hazard.to_string())?;
        let number = |place: u32| {
            let index = places.iter().position(|&known| known == place);
            index.map_or(f64::NAN, |index| outputs.values[index])
        };
        let assignments = placed.function.assignments.iter();
        rows.push(assignments.map(|a| number(a.output.0)).collect());
    }
    Ok((program.cycles(), rows))
}
