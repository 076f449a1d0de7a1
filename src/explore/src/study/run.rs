//! Running a plan: every program is made once and placed for every number of
//! elements from memory.
//!
//! Models follow one another, so that only two of them are in memory: while
//! one is placed, on all cores, the next is made ready. Results stand in the
//! order of their requests, whatever the order of work.

use super::key::placement_key;
use super::plan::{PlacementRequest, StudyPlan};
use super::point::{PlacedPoint, measure};
use super::program::{ProgramFacts, ProgramSources, StudyEquations, StudyProgram};
use super::zone::is_saturated;
use crate::ExplorationProgress;
use crate::store::{PointKey, PointStore, build_key};
use rayon::prelude::*;
use robovec_analysis::critical_path::Weights;
use robovec_ir::diagnostic::{Diagnostic, Report};
use robovec_schedule::PlaceOptions;
use std::collections::BTreeMap;

/// Result of a plan.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct StudyOutcome {
    /// Every placement, those that the search for knees added included.
    pub points: BTreeMap<PlacementRequest, PlacedPoint>,
    /// Programs by model, pipeline, machine.
    pub programs: BTreeMap<(usize, usize, usize), ProgramFacts>,
    /// Points that were found on disk.
    pub reused: usize,
}

/// Runs a plan; the model of every finished placement is told.
///
/// # Errors
///
/// Fails when a model cannot be read, a pipeline fails, or a point cannot be
/// stored. A program that a machine cannot hold is no error: its point says so.
pub fn run(
    plan: &StudyPlan,
    sources: &dyn ProgramSources,
    store: &PointStore,
    progress: ExplorationProgress<'_>,
) -> Result<StudyOutcome, Report> {
    let runner = StudyRunner {
        plan,
        sources,
        store,
        progress,
        build: build_key().ok(),
    };
    let mut outcome = StudyOutcome::default();
    let models = runner.models();
    let mut next = models
        .first()
        .map(|&model| runner.prepare(model))
        .transpose()?;
    let mut position = 0;
    while let Some(current) = next.take() {
        position += 1;
        let following = models.get(position);
        let (placed, prepared) = rayon::join(
            || runner.place(&current),
            || following.map(|&model| runner.prepare(model)).transpose(),
        );
        for (request, point, reused) in placed? {
            outcome.reused += usize::from(reused);
            outcome.points.insert(request, point);
        }
        outcome.programs.extend(current.facts);
        next = prepared?;
    }
    Ok(outcome)
}

struct StudyRunner<'a> {
    plan: &'a StudyPlan,
    sources: &'a dyn ProgramSources,
    store: &'a PointStore,
    progress: ExplorationProgress<'a>,
    /// Of this robovec; absent when it cannot be known, and then no point is
    /// stored or found.
    build: Option<PointKey>,
}

/// A model made ready.
struct PreparedModel {
    model: usize,
    key: PointKey,
    programs: Vec<StudyProgram>,
    /// The program of each pipeline and machine.
    variant_of: BTreeMap<(usize, usize), usize>,
    facts: BTreeMap<(usize, usize, usize), ProgramFacts>,
}

/// A placement, and whether it was found on disk.
type FoundPlacement = (PlacementRequest, PlacedPoint, bool);

impl StudyRunner<'_> {
    /// The models that requests ask for.
    fn models(&self) -> Vec<usize> {
        let mut models: Vec<usize> = self.plan.requests.iter().map(|r| r.model).collect();
        models.dedup();
        models
    }

    fn requests(&self, model: usize) -> impl Iterator<Item = &PlacementRequest> {
        let requests = self.plan.requests.iter();
        requests.filter(move |request| request.model == model)
    }

    fn prepare(&self, model: usize) -> Result<PreparedModel, Report> {
        let subject = &self.plan.models[model];
        let equations = StudyEquations::load(subject, self.sources)?;
        // Machines with equal latencies share a program.
        let mut variants: Vec<(usize, usize, Weights)> = Vec::new();
        let mut variant_of: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        for request in self.requests(model) {
            let pair = (request.pipeline, request.machine);
            if variant_of.contains_key(&pair) {
                continue;
            }
            let weights = Weights::cycles(&self.plan.machines[request.machine].machine);
            let known = variants.iter().position(|(pipeline, _, known)| {
                *pipeline == request.pipeline && *known == weights
            });
            let place = known.unwrap_or_else(|| {
                variants.push((request.pipeline, request.machine, weights));
                variants.len() - 1
            });
            variant_of.insert(pair, place);
        }
        let programs: Result<Vec<StudyProgram>, Report> = variants
            .par_iter()
            .map(|&(pipeline, machine, _)| {
                let pipeline = &self.plan.pipelines[pipeline];
                let machine = &self.plan.machines[machine];
                let made = equations.optimise(subject, pipeline, machine);
                made.map_err(|reason| {
                    failure(format!(
                        "{}, pipeline '{}': {reason}",
                        subject.name, pipeline.name
                    ))
                })
            })
            .collect();
        let programs = programs?;
        let facts = variant_of.iter().map(|(&(pipeline, machine), &variant)| {
            let mut facts = programs[variant].facts.clone();
            facts.machine.clone_from(&self.plan.machines[machine].name);
            ((model, pipeline, machine), facts)
        });
        Ok(PreparedModel {
            model,
            key: equations.key,
            facts: facts.collect(),
            programs,
            variant_of,
        })
    }

    /// Places a model as the plan asks, then searches for its knees.
    fn place(&self, prepared: &PreparedModel) -> Result<Vec<FoundPlacement>, Report> {
        let requests: Vec<&PlacementRequest> = self.requests(prepared.model).collect();
        let placed: Result<Vec<FoundPlacement>, Report> = requests
            .par_iter()
            .map(|request| self.point(prepared, **request))
            .collect();
        let mut placed = placed?;
        if self.plan.exact_knees {
            let pairs: Vec<&(usize, usize)> = prepared.variant_of.keys().collect();
            let searches: Result<Vec<Vec<FoundPlacement>>, Report> = pairs
                .par_iter()
                .map(|&&(pipeline, machine)| self.knee(prepared, pipeline, machine, &placed))
                .collect();
            placed.extend(searches?.into_iter().flatten());
        }
        Ok(placed)
    }

    /// One placement, from disk if it is there.
    fn point(
        &self,
        prepared: &PreparedModel,
        request: PlacementRequest,
    ) -> Result<FoundPlacement, Report> {
        let pipeline = &self.plan.pipelines[request.pipeline];
        let machine = &self.plan.machines[request.machine];
        let key = self
            .build
            .map(|build| placement_key(prepared.key, build, pipeline, machine, &request));
        (self.progress)(&self.plan.models[request.model].name);
        let variant = prepared.variant_of[&(request.pipeline, request.machine)];
        let measure = || measure(&prepared.programs[variant], machine, &request);
        let (point, reused) = match key {
            None => (measure(), false),
            Some(key) => {
                let point = self.store.point(key, measure);
                point.map_err(|error| failure(format!("cannot store a point: {error}")))?
            }
        };
        Ok((request, point, reused))
    }

    /// Halves the distance between the largest equal numbers that fall short
    /// of the longest chain and the smallest that reach it, until they are
    /// neighbours.
    fn knee(
        &self,
        prepared: &PreparedModel,
        pipeline: usize,
        machine: usize,
        placed: &[FoundPlacement],
    ) -> Result<Vec<FoundPlacement>, Report> {
        let facts = &prepared.facts[&(prepared.model, pipeline, machine)];
        let usual = placed.iter().filter(|(request, point, _)| {
            (request.pipeline, request.machine) == (pipeline, machine)
                && request.n_add == request.n_multi
                && request.is_usual()
                && point.failure.is_none()
        });
        let mut equal: Vec<(u32, bool)> = usual
            .map(|(request, point, _)| (request.n_add, is_saturated(facts, point.cycles)))
            .collect();
        equal.sort_unstable();
        let mut added = Vec::new();
        let Some(&(mut high, _)) = equal.iter().find(|(_, saturated)| *saturated) else {
            return Ok(added);
        };
        let shorter = equal.iter().filter(|(count, _)| *count < high);
        let mut low = shorter.map(|(count, _)| *count).max().unwrap_or(0);
        while low + 1 < high {
            let middle = low.midpoint(high);
            let request = PlacementRequest {
                model: prepared.model,
                pipeline,
                machine,
                n_add: middle,
                n_multi: middle,
                options: PlaceOptions::default(),
            };
            let found = self.point(prepared, request)?;
            if is_saturated(facts, found.1.cycles) {
                high = middle;
            } else {
                low = middle;
            }
            added.push(found);
        }
        Ok(added)
    }
}

fn failure(message: String) -> Report {
    let mut report = Report::new();
    report.push(Diagnostic::error().with_message(message));
    report
}
