//! Results of the search, for those who measure programs themselves: fronts,
//! fits and sweeps compare them with their own, so that none of them shows as
//! the best one that `robovec optimise` beats.

use super::start::{self, OptimisationStart};
use super::{OptimisationQuestion, OptimisationTarget, maker};
use crate::ExplorationProgress;
use crate::placing::with_fused;
use crate::program::{ExplorationError, transformed_by};
use crate::share::SharedWork;
use crate::store::PointKey;
use robovec_ir::states::States;
use robovec_ir::{Machine, Module};
use robovec_passes::optimise::VariantClass;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A program that was found.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FoundProgram {
    /// The steps it went through, those of the start first.
    pub name: String,
    /// Index of its start.
    pub start: usize,
    /// The passes from that start.
    pub passes: String,
    /// One atomic function, not placed; it follows from start and passes.
    #[serde(skip)]
    pub program: Arc<Module>,
}

/// The best programs that one effort finds for a machine with this number of
/// adders and multipliers each, in this order and each once. Numbers of
/// elements with which no program can be placed on the machine are left out. A
/// worker begins with its share, and finds what others stored meanwhile.
pub fn found(
    starts: &[OptimisationStart],
    machine: &Machine,
    elements: &[[u32; 2]],
    work: SharedWork<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<Vec<FoundProgram>, ExplorationError> {
    let forms = |key: PointKey, start: &OptimisationStart| {
        let key = key.with(&start.name).with(&format!("{:?}", start.form));
        key.with_module(&start.module)
    };
    let key = work.key("found").map(|key| starts.iter().fold(key, forms));
    let mut searched: Vec<Option<FoundProgram>> = vec![None; elements.len()];
    for index in work.share.own_and_others(elements.len()).concat() {
        let [add, multi] = elements[index];
        let machine = with_fused(machine, [add, multi]);
        let key = key.map(|key| key.with_machine(&machine));
        searched[index] = match work.load::<Option<FoundProgram>>(key) {
            Some(kept) => kept.map(|kept| made(starts, &machine, kept)).transpose()?,
            None => {
                progress(&format!("search for {add}+{multi}"));
                let found = searched_for(starts, &machine, progress)?;
                work.save(key, &found);
                found
            }
        };
    }
    let mut programs: Vec<FoundProgram> = Vec::new();
    for found in searched.into_iter().flatten() {
        let known = |program: &FoundProgram| {
            (program.start, &program.passes) == (found.start, &found.passes)
        };
        if !programs.iter().any(known) {
            programs.push(found);
        }
    }
    Ok(programs)
}

fn made(
    starts: &[OptimisationStart],
    machine: &Machine,
    kept: FoundProgram,
) -> Result<FoundProgram, ExplorationError> {
    let program = transformed_by(&starts[kept.start].module, &kept.passes, machine, None)?;
    Ok(FoundProgram {
        program: Arc::new(program),
        ..kept
    })
}

/// The best program for a machine, if it can place one.
fn searched_for(
    starts: &[OptimisationStart],
    machine: &Machine,
    progress: ExplorationProgress<'_>,
) -> Result<Option<FoundProgram>, ExplorationError> {
    let question = OptimisationQuestion {
        target: OptimisationTarget::Fpga,
        machine,
        scene: None,
        class: VariantClass::RealTrig,
        effort: 1,
        states: &States::new(1),
        count: 0,
        compiler: None,
        flags: "",
        file: None,
        work: SharedWork::ALONE,
    };
    let prepared = start::prepared(starts, &question)?;
    let (outcome, _) = maker::programs(starts, &prepared, &question, progress)?;
    let best = outcome.best.map(|best| &outcome.trials[best]);
    Ok(best.map(|trial| FoundProgram {
        name: trial.name.clone(),
        start: trial.start,
        passes: prepared.passes(&trial.pipeline),
        program: trial.program.module.clone(),
    }))
}
