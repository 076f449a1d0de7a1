//! A plan and its results, with the queries of tables and figures.

use super::knee::{Zone, zone};
use super::plan::{NamedPipeline, PlacementRequest, Printed, StudyPlan, StudySubject};
use super::point::PlacedPoint;
use super::printed::{self, PrintedRow, PrintedSystem};
use super::program::ProgramFacts;
use super::run::StudyOutcome;
use crate::device;
use crate::placing::{with_elements, words_of_a_side};
use robovec_fpga::hardware::{MachineClock, MachineShape};
use robovec_ir::Machine;
use serde_json::{Value, json};

/// The results of a study.
#[derive(Clone, Debug)]
pub struct Results {
    /// The plan.
    pub plan: StudyPlan,
    /// Its outcome.
    pub outcome: StudyOutcome,
}

/// A placement: the request and its result.
#[derive(Clone, Copy, Debug)]
pub(super) struct StudyPlacement<'a> {
    pub(super) results: &'a Results,
    pub(super) request: &'a PlacementRequest,
    pub(super) point: &'a PlacedPoint,
}

impl<'a> StudyPlacement<'a> {
    pub(super) fn elements(&self) -> u32 {
        self.request.n_add + self.request.n_multi
    }

    /// Adders and multipliers.
    pub(super) fn counts(&self) -> [u32; 2] {
        [self.request.n_add, self.request.n_multi]
    }

    /// True for equal numbers of adders and multipliers.
    pub(super) fn is_equal(&self) -> bool {
        self.request.n_add == self.request.n_multi
    }

    /// The program that was placed.
    pub(super) fn program(&self) -> Option<StudiedProgram<'a>> {
        let request = self.request;
        let place = [request.model, request.pipeline, request.machine];
        self.results.program(place)
    }

    /// The machine, with the elements of the placement.
    pub(super) fn machine(&self) -> Machine {
        with_elements(
            &self.results.plan.machines[self.request.machine].machine,
            self.counts(),
        )
    }

    /// The hardware: memories and buffers of needed size, unless that is fixed.
    pub(super) fn shape(&self) -> MachineShape {
        let kinds = &self.point.kinds;
        let most = |words: [f64; 2]| words[0].max(words[1]) as u32;
        let buffer = most([kinds[0].buffer[2], kinds[1].buffer[2]]).max(1);
        let machine = self.machine();
        let memory = most([kinds[0].memory[2], kinds[1].memory[2]]);
        let words = words_of_a_side(memory, &machine).max(1);
        let mut shape = MachineShape::of(&machine, self.point.cycles, words);
        if let (Some(own), Some(declared)) = (&mut shape.buffer, &machine.buffer) {
            own.0 = declared.words.unwrap_or(buffer);
        }
        shape
    }

    /// The machine's share of the device; above 1, or none, it does not fit.
    pub(super) fn share(&self) -> Option<f64> {
        let shape = self.point.failure.is_none().then(|| self.shape())?;
        Some(device::taken_by(&shape, shape.device).share(shape.device))
    }

    /// The time at the clock of the study.
    pub(super) fn time_us(&self) -> f64 {
        let clock = self.results.plan.machines[self.request.machine].clock();
        f64::from(self.point.cycles) / clock.mhz
    }

    /// The zone that it lies in, of a program that was placed.
    pub(super) fn zone(&self) -> Option<Zone> {
        let program = self.program().filter(|_| self.point.failure.is_none())?;
        Some(zone(program.facts, *self))
    }
}

/// A program on a machine of the plan.
#[derive(Clone, Copy, Debug)]
pub(super) struct StudiedProgram<'a> {
    pub(super) results: &'a Results,
    /// Indices of its model, pipeline and machine.
    pub(super) place: [usize; 3],
    pub(super) facts: &'a ProgramFacts,
}

impl<'a> StudiedProgram<'a> {
    pub(super) fn subject(&self) -> &'a StudySubject {
        &self.results.plan.models[self.place[0]]
    }

    pub(super) fn pipeline(&self) -> &'a NamedPipeline {
        &self.results.plan.pipelines[self.place[1]]
    }

    pub(super) fn clock(&self) -> MachineClock {
        self.results.plan.machines[self.place[2]].clock()
    }

    /// The row of Table 3.1 for comparison.
    pub(super) fn row(&self) -> Option<&'static PrintedRow> {
        let system = self.results.system(self.place[0])?;
        system.row(self.pipeline().printed?)
    }

    /// Its placements by the usual order and choice.
    pub(super) fn usual(&self) -> impl Iterator<Item = StudyPlacement<'a>> {
        let place = self.place;
        self.results.placed().filter(move |placed| {
            let request = placed.request;
            [request.model, request.pipeline, request.machine] == place && request.is_usual()
        })
    }

    /// The usual placements of the plan with equal numbers of adders and
    /// multipliers, ascending; of many, those whose number is a power of two.
    pub(super) fn ladder(&self) -> Vec<StudyPlacement<'a>> {
        let requests = &self.results.plan.requests;
        let mut equal: Vec<StudyPlacement<'a>> = (self.usual())
            .filter(|placed| placed.is_equal() && requests.binary_search(placed.request).is_ok())
            .collect();
        equal.sort_by_key(StudyPlacement::elements);
        let is_power = |placed: &StudyPlacement<'_>| placed.request.n_add.is_power_of_two();
        if equal.len() > 8 && equal.iter().filter(|&placed| is_power(placed)).count() >= 4 {
            equal.retain(is_power);
        }
        equal
    }

    /// The usual placements on all pairs of numbers: those of a full grid.
    pub(super) fn grid(&self) -> Vec<StudyPlacement<'a>> {
        let most = |placed: &StudyPlacement<'_>| placed.request.n_add.max(placed.request.n_multi);
        let all: Vec<StudyPlacement<'a>> = self.usual().collect();
        let unequal = all.iter().filter(|placed| !placed.is_equal());
        let largest = unequal.map(most).fold(0, u32::max);
        let within = |placed: &StudyPlacement<'_>| most(placed) <= largest;
        all.into_iter().filter(within).collect()
    }

    /// Of each total with all splits in a grid the placement of the fewest
    /// cycles, then nearest to equal numbers, then with more multipliers.
    pub(super) fn best_splits(&self) -> Vec<StudyPlacement<'a>> {
        let mut sorted = self.grid();
        let adders = sorted.iter().map(|placed| placed.request.n_add);
        let largest = adders.fold(0, u32::max);
        sorted.sort_by_key(|placed| {
            let [add, multi] = placed.counts();
            (add + multi, placed.point.cycles, add.abs_diff(multi), add)
        });
        sorted.dedup_by_key(|placed| placed.elements());
        sorted.retain(|placed| placed.elements() <= largest + 1);
        sorted
    }
}

impl Results {
    /// All placements, in the plan's order.
    pub(super) fn points(&self) -> impl Iterator<Item = StudyPlacement<'_>> {
        let all = self.outcome.points.iter();
        all.map(|(request, point)| StudyPlacement {
            results: self,
            request,
            point,
        })
    }

    /// The placements that succeeded, in the plan's order.
    pub(super) fn placed(&self) -> impl Iterator<Item = StudyPlacement<'_>> {
        self.points()
            .filter(|placed| placed.point.failure.is_none())
    }

    /// All programs, by model, pipeline and machine.
    pub(super) fn programs(&self) -> impl Iterator<Item = StudiedProgram<'_>> {
        let all = self.outcome.programs.iter();
        all.map(|(&(model, pipeline, machine), facts)| StudiedProgram {
            results: self,
            place: [model, pipeline, machine],
            facts,
        })
    }

    /// The programs on the machine of the ordinary figures.
    pub(super) fn ordinary(&self) -> impl Iterator<Item = StudiedProgram<'_>> {
        let machine = self.main_machine();
        self.programs()
            .filter(move |program| Some(program.place[2]) == machine)
    }

    /// The name of the model that the verdict is about.
    pub(super) fn headline(&self) -> &str {
        let subject = self.plan.models.get(self.plan.headline);
        subject.map_or("", |subject| &subject.name)
    }

    /// The programs of that model.
    pub(super) fn of_headline(&self) -> impl Iterator<Item = StudiedProgram<'_>> {
        self.ordinary()
            .filter(|program| program.place[0] == self.plan.headline)
    }

    /// The headline's program by the original pipeline, on the usual machine.
    pub(super) fn original_headline(&self) -> Option<StudiedProgram<'_>> {
        let original = self.original();
        self.of_headline()
            .find(|program| program.place[1] == original)
    }

    /// The program of a model, pipeline and machine.
    pub(super) fn program(&self, place: [usize; 3]) -> Option<StudiedProgram<'_>> {
        let [model, pipeline, machine] = place;
        let facts = self.outcome.programs.get(&(model, pipeline, machine))?;
        Some(StudiedProgram {
            results: self,
            place,
            facts,
        })
    }

    /// True when a model is placed by a pipeline on a machine.
    pub fn has_program(&self, model: usize, pipeline: usize, machine: usize) -> bool {
        self.program([model, pipeline, machine]).is_some()
    }

    /// Machine of the ordinary figures: the plan's first that is no couple.
    pub fn main_machine(&self) -> Option<usize> {
        let machines = &self.plan.machines;
        let ordinary = machines.iter().position(|machine| machine.couple.is_none());
        ordinary.or(if machines.is_empty() { None } else { Some(0) })
    }

    /// The machine of the couple of operators with this number of stages.
    pub(super) fn couple_machine(&self, stages: [u32; 2]) -> Option<usize> {
        let mut machines = self.plan.machines.iter();
        machines.position(|machine| machine.couple == Some(stages))
    }

    /// The system of the thesis that a model represents.
    pub(super) fn system(&self, model: usize) -> Option<&'static PrintedSystem> {
        printed::system(self.plan.models[model].printed.as_deref()?)
    }

    /// The pipeline compared with these rows of the thesis.
    pub(super) fn pipeline(&self, printed: Printed) -> Option<usize> {
        let pipelines = &self.plan.pipelines;
        pipelines
            .iter()
            .position(|pipeline| pipeline.printed == Some(printed))
    }

    /// The pipeline for unchanged equations, or the first.
    pub(super) fn original(&self) -> usize {
        self.pipeline(Printed::Original).unwrap_or(0)
    }

    /// Everything as JSON: one object per program and one per placement.
    pub fn to_json(&self) -> Value {
        let programs = self.outcome.programs.values().map(|facts| {
            let mut value = json!(facts);
            value["number_y"] = json!(facts.number_y());
            let [median, worst] = facts.errors();
            value["errors"] = json!({
                "format": "binary32",
                "median": median,
                "worst": worst,
                "states": facts.rounding[1].states,
                "seed": facts.rounding[1].seed,
            });
            value
        });
        let points = self.points().map(|placed| {
            let request = placed.request;
            let machine = &self.plan.machines[request.machine];
            let mut value = json!({
                "model": self.plan.models[request.model].name,
                "pipeline": self.plan.pipelines[request.pipeline].name,
                "machine": machine.name,
                "machine_hash": machine.machine.content_hash().text(),
                "n_add": request.n_add,
                "n_multi": request.n_multi,
                "priority": request.options.priority,
                "choice": request.options.choice,
            });
            if let (Value::Object(into), Value::Object(from)) = (&mut value, json!(placed.point)) {
                into.extend(from);
                into.insert("time_us".to_owned(), json!(placed.time_us()));
                into.insert("share".to_owned(), json!(placed.share()));
            }
            value
        });
        json!({
            "study": self.plan.name,
            "description": self.plan.description,
            "headline": self.plan.models.get(self.plan.headline).map(|model| &model.name),
            "robovec": env!("CARGO_PKG_VERSION"),
            "models": self.plan.models,
            "pipelines": self.plan.pipelines.iter().map(|pipeline| json!({
                "name": pipeline.name,
                "passes": pipeline.pipeline.to_string(),
                "printed": pipeline.printed,
            })).collect::<Vec<_>>(),
            "machines": self.plan.machines.iter().map(|machine| json!(machine.machine)).collect::<Vec<_>>(),
            "programs": programs.collect::<Vec<_>>(),
            "points": points.collect::<Vec<_>>(),
        })
    }
}

/// Models with the same source, in the plan's order, without groups of one.
pub(super) fn groups(results: &Results) -> Vec<Vec<usize>> {
    let models = &results.plan.models;
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (index, subject) in models.iter().enumerate() {
        let same = |group: &&mut Vec<usize>| {
            let first = &models[group[0]];
            (&first.source, &first.function) == (&subject.source, &subject.function)
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    groups.retain(|group| group.len() > 1);
    groups
}

/// True for a model that is another formulation of one before it.
pub(super) fn is_variant(results: &Results, model: usize) -> bool {
    let groups = groups(results);
    groups.iter().any(|group| group[1..].contains(&model))
}

/// Label that distinguishes a model from others of its group.
pub(super) fn label(subject: &StudySubject) -> String {
    let style = &subject.style;
    match (
        style.formulation.as_str(),
        style.expanded,
        style.child_first,
    ) {
        ("recursive", true, _) => "recursive, as Robotran".to_owned(),
        ("recursive", false, true) => "recursive, children first".to_owned(),
        (formulation, ..) => formulation.to_owned(),
    }
}

/// The pipeline that compares formulations: of short chains, or the last.
pub(super) fn pipeline(results: &Results) -> Option<usize> {
    let shortened = results.pipeline(Printed::Modified);
    shortened.or(results.plan.pipelines.len().checked_sub(1))
}
