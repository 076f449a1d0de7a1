//! Running a plan: every program is made once and placed for all elements.
//!
//! Models follow one another, so that only two of them are in memory: while one
//! is placed, on all cores, the next is made ready. Results are in order.

use super::knee::is_saturated;
use super::plan::{NamedMachine, NamedPipeline, PlacementRequest, StudyPlan};
use super::point::{PlacedPoint, measure};
use super::program::{ProgramFacts, ProgramSources, StudyEquations, StudyProgram};
use crate::ExplorationProgress;
use crate::share::SharedWork;
use crate::store::PointKey;
use rayon::prelude::*;
use robovec_analysis::critical_path::Weights;
use robovec_ir::diagnostic::Report;
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

/// Runs a plan; the model of every finished placement is reported.
///
/// # Errors
///
/// Fails when a model cannot be read, a pipeline fails, or a point cannot be
/// stored. An impossible placement is no error: its point records it.
pub fn run(
    plan: &StudyPlan,
    sources: &dyn ProgramSources,
    work: SharedWork<'_>,
    progress: ExplorationProgress<'_>,
) -> Result<StudyOutcome, Report> {
    let runner = StudyRunner {
        plan,
        sources,
        work,
        progress,
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
    work: SharedWork<'a>,
    progress: ExplorationProgress<'a>,
}

/// A model made ready.
struct PreparedModel {
    model: usize,
    /// Key of its equations; `None` without a store.
    key: Option<PointKey>,
    programs: Vec<StudyProgram>,
    /// The program of each pipeline and machine.
    variant_of: BTreeMap<(usize, usize), usize>,
    facts: BTreeMap<(usize, usize, usize), ProgramFacts>,
}

/// A placement, and a flag: true when it was found on disk.
type FoundPlacement = (PlacementRequest, PlacedPoint, bool);

impl StudyRunner<'_> {
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
                    let (model, pipeline) = (&subject.name, &pipeline.name);
                    let message = format!("{model}, pipeline '{pipeline}': {reason}");
                    Report::error(message, Vec::new())
                })
            })
            .collect();
        let programs = programs?;
        let facts = variant_of.iter().map(|(&(pipeline, machine), &variant)| {
            let mut facts = programs[variant].facts.clone();
            facts.machine.clone_from(&self.plan.machines[machine].name);
            ((model, pipeline, machine), facts)
        });
        let key = self.work.key("study");
        Ok(PreparedModel {
            model,
            key: key.map(|key| key.with_module(&equations.module)),
            facts: facts.collect(),
            programs,
            variant_of,
        })
    }

    /// Places a model as the plan requests, then searches for its knees.
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

    /// One placement, from disk if it is stored there.
    fn point(
        &self,
        prepared: &PreparedModel,
        request: PlacementRequest,
    ) -> Result<FoundPlacement, Report> {
        let pipeline = &self.plan.pipelines[request.pipeline];
        let machine = &self.plan.machines[request.machine];
        let key = prepared.key;
        let key = key.map(|key| placement_key(key, pipeline, machine, &request));
        (self.progress)(&self.plan.models[request.model].name);
        let variant = prepared.variant_of[&(request.pipeline, request.machine)];
        let program = &prepared.programs[variant];
        let point = self.work.point(key, || measure(program, machine, &request));
        let (point, reused) = point
            .map_err(|error| Report::error(format!("cannot store a point: {error}"), Vec::new()))?;
        Ok((request, point, reused))
    }

    /// Halves the distance of the largest equal numbers that fall short of the
    /// longest chain from the smallest that reach it, to one.
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
        let mut low = shorter.map(|(count, _)| *count).fold(0, u32::max);
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

/// The key of a placement, given that of its equations. Of `pipeline` and `machine` the
/// names are left out, and of `request` the indices into the plan: another plan that
/// asks for the same finds the same point. The numbers of elements in `request` replace
/// those of the machine.
fn placement_key(
    equations: PointKey,
    pipeline: &NamedPipeline,
    machine: &NamedMachine,
    request: &PlacementRequest,
) -> PointKey {
    let (add, multi, options) = (request.n_add, request.n_multi, request.options);
    let key = equations.with(&pipeline.pipeline.to_string());
    key.with_machine(&machine.machine)
        .with(&format!("{add}+{multi} {options:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::{Format, Machine};
    use robovec_passes::registry::REGISTRY;
    use robovec_schedule::{ElementChoice, Priority};

    struct KeyParts {
        equations: PointKey,
        pipeline: NamedPipeline,
        machine: NamedMachine,
        request: PlacementRequest,
    }

    impl KeyParts {
        fn key(&self) -> PointKey {
            placement_key(self.equations, &self.pipeline, &self.machine, &self.request)
        }
    }

    fn example() -> KeyParts {
        KeyParts {
            equations: PointKey::new().with("function f equations {}"),
            pipeline: NamedPipeline {
                name: "usual".to_owned(),
                pipeline: REGISTRY.pipeline("atomise,cse,place").expect("a pipeline"),
                printed: None,
            },
            machine: NamedMachine {
                name: "thesis".to_owned(),
                machine: Machine::built_in("thesis").expect("it ships"),
                couple: None,
            },
            request: PlacementRequest {
                model: 0,
                pipeline: 0,
                machine: 0,
                n_add: 4,
                n_multi: 4,
                options: PlaceOptions::default(),
            },
        }
    }

    #[test]
    fn a_key_depends_on_everything_a_point_depends_on() {
        type Change = fn(&mut KeyParts);
        let changes: [(&str, Change); 11] = [
            ("nothing", |_| {}),
            ("equations", |parts| {
                parts.equations = parts.equations.with("another");
            }),
            ("pipeline", |parts| {
                parts.pipeline.pipeline = REGISTRY.pipeline("atomise,place").expect("a pipeline");
            }),
            ("stages", |parts| {
                parts.machine.machine.elements[0].stages += 1
            }),
            ("words", |parts| {
                parts.machine.machine.memory.words = Some(77)
            }),
            ("number", |parts| {
                parts.machine.machine.number = Format::BINARY64
            }),
            ("adders", |parts| parts.request.n_add += 1),
            ("multipliers", |parts| parts.request.n_multi += 1),
            ("priority", |parts| {
                parts.request.options.priority = Priority::Alap
            }),
            ("another", |parts| {
                parts.request.options.priority = Priority::FanOut
            }),
            ("choice", |parts| {
                parts.request.options.choice = ElementChoice::First
            }),
        ];
        let mut keys = Vec::new();
        for (what, change) in changes {
            let mut parts = example();
            change(&mut parts);
            let key = parts.key();
            assert!(!keys.contains(&key), "{what}");
            keys.push(key);
        }
        // Two numbers that stand side by side are not taken for others.
        let mut parts = example();
        (parts.request.n_add, parts.request.n_multi) = (1, 12);
        let one = parts.key();
        (parts.request.n_add, parts.request.n_multi) = (11, 2);
        assert_ne!(one, parts.key());
    }
}
