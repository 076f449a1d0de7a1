//! From a plan as written to a plan with indices, or messages with carets.

use super::file::{PlanFile, StyleEntry};
use super::{GenerationStyle, NamedPipeline, Selection, StudyPlan, StudySubject};
use crate::study::printed;
use robovec_dynamics::generate::Formulation;
use robovec_framework::pass::Gives;
use robovec_framework::pipeline::Pipeline;
use robovec_ir::diagnostic::{Diagnostic, Label, Report, did_you_mean};
use robovec_ir::document;
use robovec_passes::registry::REGISTRY;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

/// The name that means the model of the verdict.
pub(super) const HEADLINE: &str = "headline";

/// Maximum number of placements of a study; more are probably a mistake.
pub(super) const MAX_PLACEMENTS: usize = 1_000_000;

/// Reads a machine by name or file; messages are the reader's own.
pub(super) type ReadMachine<'a> = &'a dyn Fn(&str) -> Result<robovec_ir::Machine, Report>;

/// Reads a plan and resolves it.
///
/// # Errors
///
/// Messages for the user, with a caret under each wrong place of the plan.
pub fn resolve(
    name: &str,
    text: &str,
    selection: Selection<'_>,
    read_machine: ReadMachine<'_>,
) -> Result<StudyPlan, Report> {
    let file: PlanFile = document::read(text).map_err(|error| {
        let mut diagnostic = Diagnostic::error().with_message(error.message);
        diagnostic
            .labels
            .extend(error.span.map(|span| Label::primary(0, span)));
        Report::of(name, text, vec![diagnostic])
    })?;
    let mut resolver = PlanResolver {
        plan: StudyPlan {
            name: file.name.clone(),
            description: file.description.clone(),
            headline: 0,
            models: Vec::new(),
            pipelines: Vec::new(),
            machines: Vec::new(),
            exact_knees: file.exact_knees,
            requests: Vec::new(),
        },
        problems: Vec::new(),
        foreign: Report::new(),
        read_machine,
        selection,
    };
    resolver.models(&file);
    resolver.pipelines(&file);
    let mut requests = BTreeSet::new();
    for sweep in &file.sweeps {
        resolver.sweep(sweep, &mut requests);
    }
    resolver.plan.requests = requests.into_iter().collect();
    resolver.finish(name, text)
}

/// A plan during the run from names to indices.
pub(super) struct PlanResolver<'a> {
    pub(super) plan: StudyPlan,
    problems: Vec<Diagnostic>,
    /// Messages about other texts than the plan: pipelines, machine files.
    pub(super) foreign: Report,
    pub(super) read_machine: ReadMachine<'a>,
    pub(super) selection: Selection<'a>,
}

impl PlanResolver<'_> {
    pub(super) fn problem(&mut self, span: Range<usize>, message: String, notes: Vec<String>) {
        let label = Label::primary(0, span);
        let diagnostic = Diagnostic::error().with_message(message);
        self.problems
            .push(diagnostic.with_labels(vec![label]).with_notes(notes));
    }

    fn finish(self, name: &str, text: &str) -> Result<StudyPlan, Report> {
        if !self.problems.is_empty() {
            return Err(Report::of(name, text, self.problems));
        }
        if self.foreign.has_errors() {
            return Err(self.foreign);
        }
        let problem = match self.plan.requests.len() {
            0 => Diagnostic::error()
                .with_message("the plan and the options leave nothing to place")
                .with_note("a sweep needs models, pipelines, machines and 'elements' or 'grid'"),
            1..=MAX_PLACEMENTS => return Ok(self.plan),
            count => Diagnostic::error().with_message(format!(
                "the plan asks for {count} placements; there can be {MAX_PLACEMENTS}"
            )),
        };
        Err(Report::of(name, text, vec![problem]))
    }

    fn models(&mut self, file: &PlanFile) {
        let mut seen: BTreeSet<&str> = BTreeSet::new();
        let mut all = Vec::new();
        let usual = self.style(&[&file.generate]);
        for entry in &file.models {
            let name = entry.name.get_ref();
            if !is_name(name) || name == HEADLINE || !seen.insert(name) {
                let message = format!("'{name}' cannot be a model's name, or is one already");
                self.problem(entry.name.span(), message, vec![NAMES.to_owned()]);
            }
            if let Some(row) = &entry.printed
                && printed::systems().all(|known| known != row.get_ref())
            {
                let message = format!("the thesis has no system '{}'", row.get_ref());
                let near = did_you_mean(row.get_ref(), printed::systems());
                self.problem(row.span(), message, suggestion(near));
            }
            all.push(StudySubject {
                name: name.clone(),
                source: (entry.source.as_ref())
                    .map_or(name, |source| source.get_ref())
                    .clone(),
                folder: self.selection.folder.map(Path::to_owned),
                function: entry.function.clone(),
                printed: entry.printed.as_ref().map(|row| row.get_ref().clone()),
                by_name: entry.by_name,
                style: self.style(&[&entry.generate, &file.generate]),
            });
        }
        let headline = file.headline.as_ref();
        if let Some(headline) = headline
            && !seen.contains(headline.get_ref().as_str())
        {
            let message = format!("there is no model '{}' in this plan", headline.get_ref());
            let near = did_you_mean(headline.get_ref(), seen.iter().copied());
            self.problem(headline.span(), message, suggestion(near));
        }
        self.plan.models = match self.selection.models {
            [] => all,
            wanted => {
                let mut models: Vec<StudySubject> = Vec::new();
                for wanted in wanted {
                    let model = pick_model(&all, wanted, &usual);
                    if !models.contains(&model) {
                        models.push(unique(model, &models));
                    }
                }
                models
            }
        };
        let headline = headline.map(|headline| headline.get_ref());
        let found = self.plan.models.iter();
        let mut found = found.map(|subject| Some(&subject.name));
        self.plan.headline = found.position(|name| name == headline).unwrap_or(0);
    }

    /// The style, each field from the first entry that sets it.
    fn style(&mut self, entries: &[&StyleEntry]) -> GenerationStyle {
        let flag = |pick: fn(&StyleEntry) -> Option<bool>, usual: bool| {
            entries
                .iter()
                .find_map(|entry| pick(entry))
                .unwrap_or(usual)
        };
        let formulation = entries.iter().find_map(|entry| entry.formulation.as_ref());
        if let Some(name) = formulation
            && Formulation::from_name(name.get_ref()).is_none()
        {
            let message = format!("there is no formulation '{}'", name.get_ref());
            let mut notes = suggestion(did_you_mean(name.get_ref(), Formulation::names()));
            if notes.is_empty() {
                notes.push(format!("formulations: {}", Formulation::names().join(", ")));
            }
            self.problem(name.span(), message, notes);
        }
        let usual = Formulation::default().name();
        GenerationStyle {
            formulation: formulation.map_or(usual, |name| name.get_ref()).to_owned(),
            child_first: flag(|entry| entry.child_first, false),
            expanded: flag(|entry| entry.expanded, false),
            leading_signs: flag(|entry| entry.leading_signs, false),
            forces: flag(|entry| entry.forces, true),
            any_angles: flag(|entry| entry.any_angles, false),
            all_parameters: flag(|entry| entry.all_parameters, false),
        }
    }

    fn pipelines(&mut self, file: &PlanFile) {
        let mut seen: BTreeSet<&str> = BTreeSet::new();
        let mut all = Vec::new();
        for entry in &file.pipelines {
            let name = entry.name.get_ref();
            if !is_name(name) || !seen.insert(name) {
                let message = format!("'{name}' cannot be a pipeline's name, or is one already");
                self.problem(entry.name.span(), message, vec![NAMES.to_owned()]);
            }
            match read_pipeline(entry.passes.get_ref()) {
                Ok(pipeline) => all.push(NamedPipeline {
                    name: name.clone(),
                    pipeline,
                    printed: entry.printed,
                }),
                Err(reason) => self.problem(entry.passes.span(), reason, Vec::new()),
            }
        }
        if self.selection.pipelines.is_empty() {
            self.plan.pipelines = all;
            return;
        }
        for wanted in self.selection.pipelines {
            let known = |one: &&NamedPipeline| one.name == *wanted;
            if self.plan.pipelines.iter().any(|one| known(&one)) {
                continue;
            }
            let pipeline = match all.iter().find(known) {
                Some(known) => Ok(known.clone()),
                None => read_pipeline(wanted).map(|pipeline| NamedPipeline {
                    name: wanted.clone(),
                    pipeline,
                    printed: None,
                }),
            };
            match pipeline {
                Ok(pipeline) => self.plan.pipelines.push(pipeline),
                Err(reason) => {
                    let names: Vec<&str> = all.iter().map(|known| known.name.as_str()).collect();
                    let names = names.join(", ");
                    let message = format!("--passes: '{wanted}': {reason}");
                    let note =
                        format!("pipelines of this plan: {names}; or passes as in robovec-opt");
                    let diagnostic = Diagnostic::error().with_message(message);
                    self.foreign.push(diagnostic.with_note(note));
                }
            }
        }
    }
}

const NAMES: &str = "names are made of letters, digits, '-', '_' and '.', and are used once";

/// Names become names of files.
fn is_name(name: &str) -> bool {
    let fits = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
    !name.is_empty() && name.len() <= 60 && name.bytes().all(fits) && !name.starts_with('.')
}

pub(super) fn suggestion(near: Option<&str>) -> Vec<String> {
    let suggestion = near.map(|near| format!("did you mean '{near}'?"));
    suggestion.into_iter().collect()
}

/// A model of the plan, or one of the user's own, named after its file.
fn pick_model(all: &[StudySubject], wanted: &str, style: &GenerationStyle) -> StudySubject {
    if let Some(known) = all.iter().find(|known| known.name == wanted) {
        return known.clone();
    }
    let stem = Path::new(wanted).file_stem();
    let stem = stem.map_or(wanted.into(), |stem| stem.to_string_lossy());
    StudySubject {
        by_name: false,
        name: stem.replace(|c: char| !c.is_alphanumeric() && !"-_.".contains(c), "_"),
        source: wanted.to_owned(),
        folder: None,
        function: None,
        printed: None,
        style: style.clone(),
    }
}

/// The model with a unique name: files in different folders may share theirs.
fn unique(mut model: StudySubject, others: &[StudySubject]) -> StudySubject {
    let stem = model.name.clone();
    let mut number = 1;
    while others.iter().any(|other| other.name == model.name) {
        number += 1;
        model.name = format!("{stem}-{number}");
    }
    model
}

/// A pipeline that leaves its function ready to be placed.
fn read_pipeline(text: &str) -> Result<Pipeline, String> {
    let pipeline = REGISTRY.pipeline(text).map_err(|error| {
        let messages = error.0.diagnostics().iter();
        let messages: Vec<&str> = messages.map(|message| message.message.as_str()).collect();
        messages.join("; ")
    })?;
    if pipeline
        .passes()
        .any(|step| step.info.name == "place" || step.info.name == "codegen")
    {
        return Err("the study adds 'place' itself: leave 'place' and 'codegen' out".to_owned());
    }
    let lowers = |gives| matches!(gives, Gives::Level(robovec_ir::Level::Atomic));
    if !pipeline.passes().any(|step| lowers(step.info.gives)) {
        return Err("the pipeline does not contain 'atomise', which placement needs".to_owned());
    }
    Ok(pipeline)
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::Machine;

    fn machine(name: &str) -> Result<Machine, Report> {
        Machine::built_in(name).ok_or_else(Report::new)
    }

    fn thesis(selection: Selection<'_>) -> StudyPlan {
        resolve("thesis.toml", super::super::THESIS, selection, &machine)
            .expect("the built-in plan is right")
    }

    #[test]
    fn the_plan_of_the_thesis_has_a_model_for_every_system() {
        let plan = thesis(Selection::default());
        for system in printed::systems() {
            let stands = |model: &&StudySubject| model.printed.as_deref() == Some(system);
            assert_eq!(plan.models.iter().filter(stands).count(), 1, "{system}");
        }
        assert_eq!(plan.models[plan.headline].name, "bogie");
        assert!(plan.requests.is_sorted());
        // All couples of Table 1.3, the machine of the thesis and the solver.
        assert_eq!(plan.machines.len(), 17);
        // Whole steps are on the solver, and nothing else is.
        let solver = plan.machines.iter().position(|one| one.name == "solver");
        let requests = plan.requests.iter();
        for request in requests {
            let model = &plan.models[request.model];
            assert_eq!(
                model.by_name,
                Some(request.machine) == solver,
                "{}",
                model.name
            );
        }
    }

    #[test]
    fn files_of_one_name_become_two_models_and_repetitions_one() {
        let models = ["a/x.m", "b/x.m", "a/x.m", "serial-23", "serial-23"].map(str::to_owned);
        let pipelines = ["printed", "printed", "atomise,cse"].map(str::to_owned);
        let plan = thesis(Selection {
            models: &models,
            pipelines: &pipelines,
            ..Selection::default()
        });
        let names: Vec<&str> = plan
            .models
            .iter()
            .map(|model| model.name.as_str())
            .collect();
        assert_eq!(names, ["x", "x-2", "serial-23"]);
        assert_eq!(plan.headline, 0);
        assert_eq!(plan.pipelines.len(), 2);
    }
}
