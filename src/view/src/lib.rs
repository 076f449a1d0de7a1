//! A compilation as one page: every state of a function with the origin of each
//! of its statements, schedule, errors and source, for late outputs.
//!
//! The page has the data once, as columns ([`data`]), and a script that draws
//! the visible part. **Invariants.** A page refers to no other file and no
//! address; it is the same bytes for the same run; statements of a state are in
//! the order of the text form, values before outputs.

mod data;
mod dot;
mod events;
pub mod report;
mod schedule;
mod statements;

pub use dot::dot;
pub use events::events;
pub use statements::place_lines;

use crate::report::{ModuleReport, PassReport, PassRunRecord, ReadCounts, ReportOptions};
use data::{FileData, FunctionData, JointData, TextTable, ViewData};
use robovec_framework::trail::{self, Trail};
use robovec_ir::states::States;
use robovec_ir::{Function, Machine, Module, View};
use robovec_passes::registry::REGISTRY;
use robovec_present::json::json_script;
use robovec_present::number::or_nothing;
use robovec_present::page::{STYLE, fill};
use statements::SourceTable;
use std::collections::BTreeMap;

/// Settings of the run that is shown.
pub struct ViewedRun<'a> {
    /// The module after the run.
    pub module: &'a Module,
    /// The states on the way.
    pub trail: &'a Trail,
    /// Passes that were run, in order.
    pub passes: &'a [PassRunRecord],
    /// The machine compiled for, whose format errors are measured in.
    pub machine: &'a Machine,
    /// Source of random states.
    pub states: &'a States,
    /// The files of equations, name and text, if available.
    pub files: &'a [(String, String)],
    /// The model of the equations, if available.
    pub model: Option<&'a ModelText>,
    /// The pipeline as the user wrote it.
    pub pipeline: &'a str,
    /// The counts of the functions as they were read.
    pub read: Vec<ReadCounts>,
}

/// A model as far as a page shows it.
pub struct ModelText {
    /// The name of its file.
    pub name: String,
    /// The text of its file.
    pub text: String,
    /// The names of its joints, in the order of their numbers.
    pub joints: Vec<String>,
}

impl ModelText {
    /// Joints with the lines that name them first, in a file of this number.
    fn joints(&self, file: u32) -> Vec<JointData> {
        let is_part = |character: char| character.is_alphanumeric() || "_-.".contains(character);
        let names = |line: &str, joint: &str| line.split(|c| !is_part(c)).any(|word| word == joint);
        let joints = self.joints.iter().map(|joint| {
            let mut lines = self.text.lines().zip(1..);
            let line = lines.find(|(line, _)| names(line, joint));
            JointData {
                name: joint.clone(),
                place: line.map(|(_, number)| [file, number]),
            }
        });
        joints.collect()
    }
}

/// The page of a run.
pub fn page(run: &ViewedRun<'_>) -> String {
    let data = ViewData::collect(run);
    let title = format!("{} through {}", data.title, run.pipeline);
    let title = robovec_present::escape::Escaped(&title).to_string();
    let json = json_script(&data);
    let parts = [
        ("title", title.as_str()),
        ("css", STYLE),
        ("view-css", include_str!("page/view.css")),
        ("data", &json),
        ("model", include_str!("page/model.js")),
        ("lists", include_str!("page/lists.js")),
        ("drawings", include_str!("page/drawings.js")),
        ("timeline", include_str!("page/timeline.js")),
        ("history", include_str!("page/history.js")),
        ("start", include_str!("page/start.js")),
    ];
    fill(include_str!("page/view.html"), &parts)
}

impl ViewData {
    fn collect(run: &ViewedRun<'_>) -> ViewData {
        let mut texts = TextTable::default();
        let mut sources = SourceTable::default();
        let options = ReportOptions {
            states: run.states.clone(),
            read: run.read.clone(),
            ..ReportOptions::default()
        };
        let report = ModuleReport::collect(run.module, run.machine, run.passes, &options);
        assert_eq!(
            report.functions.len(),
            run.module.functions.len(),
            "every function has a report"
        );
        let functions = run.module.functions.iter().zip(report.functions);
        let functions = functions.map(|(function, mut report)| {
            let passes = report.passes.clone();
            // The page has a table of its own for what passes did.
            report.passes.clear();
            let single = ModuleReport {
                robovec: env!("CARGO_PKG_VERSION").to_owned(),
                functions: vec![report],
            };
            let tables = (&mut texts, &mut sources);
            function_data(run, function, (passes, single.to_text()), tables)
        });
        let functions: Vec<FunctionData> = functions.collect();
        let known = &run.module.tables.sources.files;
        let files = known.iter().map(|name| {
            let given = run.files.iter().find(|(given, _)| given == name);
            FileData {
                name: name.clone(),
                lines: given.map(|(_, text)| text.lines().map(str::to_owned).collect()),
            }
        });
        let mut files: Vec<FileData> = files.collect();
        let mut joints = Vec::new();
        if let Some(model) = run.model {
            joints = model.joints(files.len() as u32);
            files.push(FileData {
                name: model.name.clone(),
                lines: Some(model.text.lines().map(str::to_owned).collect()),
            });
        }
        ViewData {
            robovec: env!("CARGO_PKG_VERSION").to_owned(),
            title: or_nothing(run.files.first(), |(name, _)| name.clone()),
            pipeline: run.pipeline.to_owned(),
            files,
            joints,
            summaries: summaries(),
            sources: sources.places(&run.module.tables),
            functions,
            texts: texts.into_texts(),
        }
    }
}

/// Description of every pass, in a sentence.
fn summaries() -> BTreeMap<String, String> {
    let passes = REGISTRY.passes.iter();
    passes
        .map(|info| (info.name.to_owned(), info.summary().to_owned()))
        .collect()
}

fn function_data(
    run: &ViewedRun<'_>,
    function: &Function,
    (passes, report): (Vec<PassReport>, String),
    (texts, sources): (&mut TextTable, &mut SourceTable),
) -> FunctionData {
    let tables = &run.module.tables;
    let states = trail::states(tables, function, run.trail);
    let mut before: Option<&Function> = None;
    let mut written = Vec::new();
    for state in &states {
        let target = (run.machine, run.states);
        let statements =
            statements::collect(tables, state, before, target, (&mut *texts, &mut *sources));
        written.push(statements);
        before = Some(state.function);
    }
    let view = View { tables, function };
    FunctionData {
        name: function.name.clone(),
        machine: run.machine.name.clone(),
        format: run.machine.number.to_string(),
        passes,
        states: written,
        schedule: schedule::collect(function, run.machine),
        heat: statements::heat(view, run.machine.number, run.states),
        report,
    }
}
