//! The whole step of a system by functions: loops closed, then accelerations.
//!
//! A plan names the functions of a step as separate models with one source.
//! This module combines them on one machine with the same elements.

use super::plan::StudySubject;
use super::results::{Results, StudiedProgram, StudyPlacement};
use robovec_robotran::FunctionKind;
use std::collections::BTreeMap;

/// Rounds of Newton's method that a step is counted with.
pub(super) const ROUNDS: u32 = 2;

/// The functions of a step, in the order of their calls, and the number of
/// calls of each: every iteration, and once more to find the loops closed.
pub(super) const PARTS: [(FunctionKind, u32); 3] = [
    (FunctionKind::LoopPositions, ROUNDS + 1),
    (FunctionKind::LoopVelocities, 1),
    (FunctionKind::Accelred, 1),
];

/// The functions of a system's step, by places; without loops the last.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct StudyStep {
    /// The models of [`PARTS`].
    pub(super) models: [Option<usize>; 3],
}

impl StudyStep {
    pub(super) fn accelerations(&self) -> usize {
        self.models[2].expect("a step has accelerations")
    }
}

/// The steps that a study has all functions of: none or both of those of loops,
/// and accelerations. Every formulation of accelerations is a step.
pub(super) fn steps(results: &Results) -> Vec<StudyStep> {
    let models = &results.plan.models;
    let function = |index: usize| models[index].function.as_deref();
    let accelred = FunctionKind::Accelred.name();
    let all = (0..models.len()).filter(|&index| function(index) == Some(accelred));
    let steps = all.map(|index| {
        let of = |wanted: FunctionKind| {
            let same = |other: &StudySubject| {
                (&other.source, &other.folder) == (&models[index].source, &models[index].folder)
            };
            (0..models.len())
                .find(|&other| same(&models[other]) && function(other) == Some(wanted.name()))
        };
        StudyStep {
            models: [of(PARTS[0].0), of(PARTS[1].0), Some(index)],
        }
    });
    let is_whole = |step: &StudyStep| step.models[0].is_some() == step.models[1].is_some();
    steps.filter(is_whole).collect()
}

#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedStep<'a> {
    /// The placements of [`PARTS`].
    pub(super) parts: [Option<StudyPlacement<'a>>; 3],
    /// Cycles of all calls.
    pub(super) cycles: u32,
}

impl PlacedStep<'_> {
    /// The machine's share of its device, of the function that takes most.
    pub(super) fn share(&self) -> f64 {
        let parts = self.parts.iter().flatten();
        parts.filter_map(StudyPlacement::share).fold(0.0, f64::max)
    }

    /// The placement of the accelerations, which has the elements of all.
    pub(super) fn accelerations(&self) -> StudyPlacement<'_> {
        self.parts[2].expect("a step has accelerations")
    }
}

/// The placements of a step by the usual order that have all functions.
pub(super) fn placed<'a>(
    results: &'a Results,
    step: &StudyStep,
    pipeline: usize,
    machine: usize,
) -> Vec<PlacedStep<'a>> {
    let of = |model: Option<usize>| -> BTreeMap<[u32; 2], StudyPlacement<'a>> {
        let program = model.and_then(|model| results.program([model, pipeline, machine]));
        let placed = program.iter().flat_map(StudiedProgram::usual);
        placed.map(|placed| (placed.counts(), placed)).collect()
    };
    let parts = step.models.map(of);
    let all = parts[2].keys().filter_map(|elements| {
        let own = [0, 1, 2].map(|part| parts[part].get(elements).copied());
        let is_missing = |part: usize| step.models[part].is_some() && own[part].is_none();
        if (0..3).any(is_missing) {
            return None;
        }
        let cycles = own.iter().zip(PARTS).map(|(placed, (_, calls))| {
            placed.map_or(0, |placed| placed.point.cycles.saturating_mul(calls))
        });
        Some(PlacedStep {
            parts: own,
            cycles: cycles.fold(0, u32::saturating_add),
        })
    });
    all.collect()
}
