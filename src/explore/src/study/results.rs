//! A plan and what it gave, with the questions that tables and figures ask.

use super::cost;
use super::plan::{PlacementRequest, Printed, StudyPlan};
use super::point::PlacedPoint;
use super::printed::{self, PrintedRow, PrintedSystem};
use super::program::ProgramFacts;
use super::run::StudyOutcome;
use serde_json::{Value, json};

/// The results of a study.
#[derive(Clone, Debug)]
pub struct Results {
    /// The plan.
    pub plan: StudyPlan,
    /// Its outcome.
    pub outcome: StudyOutcome,
}

/// A placement: what was asked for and what it gave.
#[derive(Clone, Copy, Debug)]
pub struct StudyPlacement<'a> {
    /// The request.
    pub request: &'a PlacementRequest,
    /// The result.
    pub point: &'a PlacedPoint,
}

impl StudyPlacement<'_> {
    /// All elements.
    pub fn elements(&self) -> u32 {
        self.request.n_add + self.request.n_multi
    }

    /// True when there are as many adders as multipliers.
    pub fn is_equal(&self) -> bool {
        self.request.n_add == self.request.n_multi
    }
}

impl Results {
    /// The placements that succeeded, in the plan's order.
    pub fn placed(&self) -> impl Iterator<Item = StudyPlacement<'_>> {
        let all = self.outcome.points.iter();
        let all = all.map(|(request, point)| StudyPlacement { request, point });
        all.filter(|placed| placed.point.failure.is_none())
    }

    /// The placements that failed, with the reason.
    pub fn failures(&self) -> impl Iterator<Item = (&PlacementRequest, &str)> {
        let all = self.outcome.points.iter();
        all.filter_map(|(request, point)| Some((request, point.failure.as_deref()?)))
    }

    /// The placements of a program on a machine by the usual order and
    /// choice.
    pub fn usual(
        &self,
        model: usize,
        pipeline: usize,
        machine: usize,
    ) -> impl Iterator<Item = StudyPlacement<'_>> {
        self.placed().filter(move |placed| {
            let request = placed.request;
            (request.model, request.pipeline, request.machine) == (model, pipeline, machine)
                && request.is_usual()
        })
    }

    /// The machine of the ordinary figures: the first of the plan that is no
    /// couple.
    pub fn main_machine(&self) -> Option<usize> {
        let machines = &self.plan.machines;
        let ordinary = machines.iter().position(|machine| machine.couple.is_none());
        ordinary.or(if machines.is_empty() { None } else { Some(0) })
    }

    /// The figures of a program.
    pub fn program(&self, model: usize, pipeline: usize, machine: usize) -> Option<&ProgramFacts> {
        self.outcome.programs.get(&(model, pipeline, machine))
    }

    /// The system of the thesis a model stands for.
    pub fn system(&self, model: usize) -> Option<&'static PrintedSystem> {
        printed::system(self.plan.models[model].printed.as_deref()?)
    }

    /// The row of Table 3.1 that a program is compared with.
    pub fn row(&self, model: usize, pipeline: usize) -> Option<&'static PrintedRow> {
        self.system(model)?
            .row(self.plan.pipelines[pipeline].printed?)
    }

    /// The pipeline compared with these rows of the thesis.
    pub fn pipeline(&self, printed: Printed) -> Option<usize> {
        let pipelines = &self.plan.pipelines;
        pipelines
            .iter()
            .position(|pipeline| pipeline.printed == Some(printed))
    }

    /// The pipeline that leaves equations as they are printed, or the first.
    pub(super) fn original(&self) -> usize {
        self.pipeline(Printed::Original).unwrap_or(0)
    }

    /// Everything as JSON: one object per program and one per placement.
    pub fn to_json(&self) -> Value {
        let programs = self.outcome.programs.values().map(|facts| {
            let mut value = json!(facts);
            value["number_y"] = json!(facts.number_y());
            let [median, worst] = cost::errors(facts);
            value["errors"] = json!({
                "format": "binary32",
                "median": median,
                "worst": worst,
                "states": facts.rounding[1].states,
                "seed": facts.rounding[1].seed,
            });
            value
        });
        let all = self.outcome.points.iter();
        let points = all.map(|(request, point)| {
            let machine = &self.plan.machines[request.machine];
            let mut value = json!({
                "model": self.plan.models[request.model].name,
                "pipeline": self.plan.pipelines[request.pipeline].name,
                "machine": machine.name,
                "machine_hash": machine.machine.content_hash().text(),
                "n_add": request.n_add,
                "n_multi": request.n_multi,
                "priority": request.priority,
                "choice": request.choice,
            });
            if let (Value::Object(into), Value::Object(from)) = (&mut value, json!(point)) {
                into.extend(from);
                into.insert(
                    "time_us".to_owned(),
                    json!(time_us(point, machine.clock().mhz)),
                );
                let placed = StudyPlacement { request, point };
                let share = point.failure.is_none().then(|| cost::share(self, placed));
                into.insert("share".to_owned(), json!(share));
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

/// The time of a placement at a clock.
pub fn time_us(point: &PlacedPoint, mhz: f64) -> f64 {
    f64::from(point.cycles) / mhz
}
