//! The proof that a program is equal to the input function.

use super::maker::MadeProgram;
use super::start::{PreparedStarts, compared};
use super::{OptimisationQuestion, OptimisationTarget};
use crate::placing::verified;
use robovec_framework::manager::{self, Config};
use robovec_ir::Module;
use robovec_passes::optimise::trial::VariantTrial;
use robovec_passes::registry::REGISTRY;
use robovec_schedule::PlaceOptions;
use std::io;

/// Points of two prime fields, and states.
const POINTS: u32 = 8;

/// Proves a program equal to the equations as they came: as a function, for
/// the scene if there is one; for a machine also its placement.
///
/// # Errors
///
/// The difference, in words.
pub(super) fn prove(
    prepared: &PreparedStarts,
    trial: &VariantTrial<MadeProgram>,
    question: &OptimisationQuestion<'_>,
) -> Result<String, String> {
    let program = &trial.program.module;
    // For a scene numbers are put in and rounded, after which two formulations
    // are equal but for that: each is compared with what it was made from.
    let wanted = match question.scene {
        None => &prepared.modules[0],
        Some(_) => &prepared.modules[trial.start],
    };
    let verdict = compared(
        wanted,
        program,
        question.class.numeric(),
        question.states,
        POINTS,
    );
    if !verdict.holds() {
        return Err(verdict.to_string());
    }
    let evidence = verdict.to_string();
    let class = format!("{}, ", verdict.class);
    let mut established = match evidence.strip_prefix(&class) {
        Some(evidence) => format!("{evidence} ({})", verdict.class),
        None => evidence,
    };
    if question.scene.is_some() {
        specialised(&prepared.starts[trial.start], prepared, question)?;
        established += ", for the scene; specialised pass by pass";
    }
    if question.target == OptimisationTarget::Fpga {
        let placed = verified(program, question.machine, PlaceOptions::default())?;
        let promised = trial.cycles.ok_or("it was not placed")?;
        if placed.summary.cycles != promised {
            let found = placed.summary.cycles;
            return Err(format!(
                "placed again it takes {found} cycles, not {promised}"
            ));
        }
    }
    Ok(established)
}

/// Equations specialised to a scene, checked pass by pass.
fn specialised(
    start: &Module,
    prepared: &PreparedStarts,
    question: &OptimisationQuestion<'_>,
) -> Result<(), String> {
    let pipeline = REGISTRY.pipeline(&prepared.passes("cse"));
    let pipeline = pipeline.map_err(|error| error.to_string())?;
    let mut module = start.clone();
    let mut log = io::sink();
    let config = Config {
        check_each: Some(POINTS),
        states: question.states.clone(),
        scene: question.scene,
        ..Config::new(question.machine, &mut log)
    };
    manager::run(&mut module, &pipeline, config)
        .map(drop)
        .map_err(|error| error.to_string())
}
