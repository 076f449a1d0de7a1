//! What the search finds, for those who measure programs themselves: fronts,
//! fits and sweeps compare them with their own, so that none of them shows as
//! the best what `robovec optimise` beats.

use super::start::{self, OptimisationStart};
use super::{OptimisationQuestion, OptimisationTarget, maker};
use crate::explore::ExplorationProgress;
use crate::explore::placing::with_counts;
use crate::explore::program::ExplorationError;
use robovec_ir::states::States;
use robovec_ir::{Machine, Module, Operation};
use robovec_passes::optimise::VariantClass;
use std::sync::Arc;

/// A program that was found.
#[derive(Clone, Debug)]
pub struct FoundProgram {
    /// The steps it went through, those of the start first.
    pub name: String,
    /// Index of the start it comes from.
    pub start: usize,
    /// The passes from there.
    pub passes: String,
    /// One function at the level atomic, not placed.
    pub program: Arc<Module>,
}

/// The best programs that one effort finds for a machine with so many adders
/// and multipliers each, in this order and each once. Numbers of elements with
/// which the machine can place no program are left out.
///
/// # Errors
///
/// When a pass gives up on the equations.
pub fn found(
    starts: &[OptimisationStart],
    machine: &Machine,
    elements: &[[u32; 2]],
    progress: ExplorationProgress<'_>,
) -> Result<Vec<FoundProgram>, ExplorationError> {
    let mut programs: Vec<FoundProgram> = Vec::new();
    for &[add, multi] in elements {
        progress(&format!("search for {add}+{multi}"));
        let counts = [
            (Operation::Add, add),
            (Operation::Mul, multi),
            (Operation::Fma, multi),
        ];
        let machine = with_counts(machine, &counts);
        let question = OptimisationQuestion {
            target: OptimisationTarget::Fpga,
            machine: &machine,
            scene: None,
            class: VariantClass::RealTrig,
            effort: 1,
            states: &States::new(1),
            count: 0,
            compiler: None,
            flags: "",
            store: None,
        };
        let prepared = start::prepared(starts, &question)?;
        let outcome = maker::programs(starts, &prepared, &question, progress)?;
        let Some(trial) = outcome.best.map(|best| &outcome.trials[best]) else {
            continue;
        };
        let passes = prepared.passes(&trial.pipeline);
        let known =
            |program: &FoundProgram| (program.start, &program.passes) == (trial.start, &passes);
        if !programs.iter().any(known) {
            programs.push(FoundProgram {
                name: trial.name.clone(),
                start: trial.start,
                passes,
                program: trial.program.module.clone(),
            });
        }
    }
    Ok(programs)
}
