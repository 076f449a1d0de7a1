//! Running a plan: every program is made once and placed for every number of
//! elements from memory.
//!
//! Models follow one another, so that only two of them are in memory: while
//! one is placed, on all cores, the next is made ready. Results stand in the
//! order of the plan's requests, whatever the order of work.

use super::plan::{Plan, Request};
use super::point::{Point, measure};
use super::program::{Equations, Program, ProgramFacts, Sources};
use super::store::{self, Key, Store};
use rayon::prelude::*;
use robovec_ir::diagnostic::{Diagnostic, Report};
use robovec_passes::analysis::critical_path::Weights;
use std::collections::BTreeMap;
use std::sync::Mutex;

/// What a plan gave.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Outcome {
    /// One per request, in the plan's order.
    pub points: Vec<Point>,
    /// Programs by model, pipeline, machine; sorted.
    pub programs: BTreeMap<(usize, usize, usize), ProgramFacts>,
    /// Points that were found on disk.
    pub reused: usize,
}

/// Told of every finished placement.
pub type Progress<'a> = &'a (dyn Fn(usize, &str) + Sync);

/// Runs a plan.
///
/// # Errors
///
/// When a model cannot be read, a pipeline fails, or a point cannot be
/// stored. A program that a machine cannot hold is no error: its point says
/// so.
pub fn run(
    plan: &Plan,
    sources: &dyn Sources,
    store: &Store,
    progress: Progress<'_>,
) -> Result<Outcome, Report> {
    let runner = Runner {
        plan,
        sources,
        store,
        progress,
        build: store::build_key(),
    };
    let mut results: Vec<Option<Point>> = vec![None; plan.requests.len()];
    let mut outcome = Outcome::default();
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
        for (index, point) in placed?.into_iter().chain(current.found) {
            results[index] = Some(point);
        }
        outcome.reused += current.reused;
        outcome.programs.extend(current.facts);
        next = prepared?;
    }
    // Every request belongs to exactly one model.
    outcome.points = results.into_iter().map(Option::unwrap_or_default).collect();
    Ok(outcome)
}

struct Runner<'a> {
    plan: &'a Plan,
    sources: &'a dyn Sources,
    store: &'a Store,
    progress: Progress<'a>,
    build: Key,
}

/// A model made ready: its programs, and what is left to place.
struct Prepared {
    programs: Vec<Program>,
    /// Index of the request, its key, the index of its program.
    tasks: Vec<(usize, Key, usize)>,
    /// Points found on disk.
    found: Vec<(usize, Point)>,
    reused: usize,
    facts: Vec<((usize, usize, usize), ProgramFacts)>,
}

impl Runner<'_> {
    /// The models that requests ask for, most work first, so that the last
    /// model's placements are short.
    fn models(&self) -> Vec<usize> {
        let mut models: Vec<usize> = self.plan.requests.iter().map(|r| r.model).collect();
        models.dedup();
        models
    }

    fn requests(&self, model: usize) -> impl Iterator<Item = (usize, &Request)> {
        let requests = self.plan.requests.iter().enumerate();
        requests.filter(move |(_, request)| request.model == model)
    }

    fn prepare(&self, model: usize) -> Result<Prepared, Report> {
        let subject = &self.plan.models[model];
        let equations = Equations::load(subject, self.sources)?;
        // Machines with equal latencies share a program.
        let mut variants: Vec<(usize, usize, Weights)> = Vec::new();
        let mut variant_of: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        for (_, request) in self.requests(model) {
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
        let programs: Result<Vec<Program>, Report> = variants
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
        let facts = facts.collect();
        let (mut tasks, mut found) = (Vec::new(), Vec::new());
        for (index, request) in self.requests(model) {
            let pipeline = &self.plan.pipelines[request.pipeline];
            let machine = &self.plan.machines[request.machine];
            let key = store::key(equations.key, self.build, pipeline, machine, request);
            match self.store.load(key) {
                Some(point) => {
                    (self.progress)(1, &subject.name);
                    found.push((index, point));
                }
                None => {
                    let variant = variant_of[&(request.pipeline, request.machine)];
                    tasks.push((index, key, variant));
                }
            }
        }
        Ok(Prepared {
            programs,
            tasks,
            reused: found.len(),
            found,
            facts,
        })
    }

    fn place(&self, prepared: &Prepared) -> Result<Vec<(usize, Point)>, Report> {
        let unwritten = Mutex::new(None);
        let place = |&(index, key, program): &(usize, Key, usize)| {
            let request = &self.plan.requests[index];
            let machine = &self.plan.machines[request.machine];
            let point = measure(&prepared.programs[program], machine, request);
            if let Err(error) = self.store.save(key, &point)
                && let Ok(mut unwritten) = unwritten.lock()
            {
                unwritten.get_or_insert(format!("cannot store a point: {error}"));
            }
            (self.progress)(1, &self.plan.models[request.model].name);
            (index, point)
        };
        let points = prepared.tasks.par_iter().map(place).collect();
        match unwritten.into_inner() {
            Ok(Some(reason)) => Err(failure(reason)),
            Ok(None) | Err(_) => Ok(points),
        }
    }
}

fn failure(message: String) -> Report {
    let mut report = Report::new();
    report.push(Diagnostic::error().with_message(message));
    report
}
