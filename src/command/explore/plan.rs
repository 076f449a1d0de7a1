//! Explorations of a plan: models, pipelines and machines, tables and figures.

use super::ExploreArguments;
use crate::command::subjects::{self, SubjectFiles, locate};
use crate::command::{CommandFailure, input, output, progress};
use robovec_explore::processor::{Computer, LARGEST};
use robovec_explore::program::view;
use robovec_explore::share::{SharedWork, WorkShare};
use robovec_explore::study::plan::{self, Selection, StudyPlan};
use robovec_explore::study::{self, CpuJob, CpuTime, Results, StudyEquations};
use robovec_io::files::limited;
use robovec_ir::Module;
use robovec_ir::diagnostic::counted;
use robovec_present::json::json_text;
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// Keeps a share of a plan, all of a model and pipeline together.
fn keep(share: WorkShare, plan: &mut StudyPlan) {
    let mut groups: Vec<(usize, usize)> = Vec::new();
    plan.requests.retain(|request| {
        let group = (request.model, request.pipeline);
        let known = groups.iter().position(|&known| known == group);
        let number = known.unwrap_or_else(|| {
            groups.push(group);
            groups.len() - 1
        });
        share.holds(number)
    });
}

/// Text beside the bar.
const PROGRESS: &str = "{pos}/{len} placements, {eta} left, {msg}";

pub(super) fn run(arguments: &ExploreArguments, plan: &str) -> Result<String, CommandFailure> {
    let folder = arguments.output.as_deref();
    let folder = folder.expect("a plan requires a folder");
    let mut plan = read_plan(arguments, plan)?;
    let share = arguments.shares.share();
    keep(share, &mut plan);
    // A slip in a name is told before hours of work, not after them.
    for subject in &plan.models {
        locate(subject)?;
    }
    let store = arguments.shares.store(Some(folder))?;
    // All that is left of the plan is done.
    let results = compute(plan, SharedWork::new(store.as_ref(), WorkShare::ALL))?;
    if share != WorkShare::ALL {
        let (placed, found) = (results.outcome.points.len(), results.outcome.reused);
        return Ok(format!(
            "{}, {found} of them found\n",
            counted(placed, "placement")
        ));
    }
    let times = if arguments.cpu {
        time(arguments, folder, &results)?
    } else {
        Vec::new()
    };
    for (inner, files) in study::files(&results, &times) {
        output::write_files(&folder.join(inner), &files)?;
    }
    Ok(study::summary(&results, folder))
}

fn read_plan(arguments: &ExploreArguments, plan: &str) -> Result<StudyPlan, CommandFailure> {
    let path = Path::new(plan);
    let (name, text, folder) = if plan == "thesis" {
        ("thesis.toml".to_owned(), plan::THESIS.to_owned(), None)
    } else {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let text = input::text(path, &limited::PLAN)?;
        (name.into_owned(), text, path.parent())
    };
    let selection = Selection {
        folder,
        models: &arguments.subjects,
        pipelines: &arguments.passes,
        machines: &arguments.machine,
        elements: &arguments.elements,
    };
    let read_machine = |name: &str| {
        let file = folder.map(|folder| folder.join(name));
        let file = file.filter(|file| file.is_file());
        let name = file.map_or(name.into(), |file| file.to_string_lossy().into_owned());
        input::machine(&name).map_err(|failure| failure.0)
    };
    plan::resolve(&name, &text, selection, &read_machine).map_err(CommandFailure)
}

fn compute(plan: StudyPlan, work: SharedWork<'_>) -> Result<Results, CommandFailure> {
    let bar = progress::bar(plan.requests.len(), PROGRESS);
    let progress = |model: &str| {
        bar.inc(1);
        bar.set_message(model.to_owned());
    };
    let outcome = study::run(&plan, &SubjectFiles, work, &progress);
    bar.finish_and_clear();
    Ok(Results {
        outcome: outcome?,
        plan,
    })
}

/// Times every program on one core, in sequence; known times stay.
fn time(
    arguments: &ExploreArguments,
    folder: &Path,
    results: &Results,
) -> Result<Vec<CpuTime>, CommandFailure> {
    let path = folder.join("cpu.json");
    let earlier: Vec<CpuTime> = match fs::read_to_string(&path) {
        Ok(text) if arguments.shares.reuses() => serde_json::from_str(&text).unwrap_or_default(),
        Ok(_) | Err(_) => Vec::new(),
    };
    let computer = Computer::this();
    let plan = &results.plan;
    let bar = progress::bar(plan.models.len() * plan.pipelines.len(), PROGRESS);
    let mut times: Vec<CpuTime> = Vec::new();
    let mut timed: HashMap<String, usize> = HashMap::new();
    let mut measure = |model: &str, pipeline: &str, [module, shorter]: [&Module; 2]| {
        let job = CpuJob {
            model,
            pipeline,
            view: view(module),
            shorter: view(shorter),
        };
        // Models of several formulations are the same for a processor.
        let same = timed.entry(job.program()).or_insert(times.len());
        let known = earlier.iter().find(|time| time.is_of(&job, &computer));
        times.push(match (known, times.get(*same)) {
            (Some(known), _) => known.clone(),
            (None, Some(same)) => same.of(&job),
            (None, None) => study::time(&job, &computer, arguments.cpu_limit.unwrap_or(LARGEST)),
        });
        // What takes long is kept at once.
        output::write_file(&path, |writer| {
            writer.write_all(json_text(&times).as_bytes())
        })
    };
    for (index, subject) in plan.models.iter().enumerate() {
        let equations = StudyEquations::load(subject, &SubjectFiles)?;
        for (pipeline, named) in plan.pipelines.iter().enumerate() {
            bar.inc(1);
            bar.set_message(format!("{} on one core", subject.name));
            // That of the figures, or whatever the plan places the model on.
            let machines = results
                .main_machine()
                .into_iter()
                .chain(0..plan.machines.len());
            let is_there = |&machine: &usize| results.has_program(index, pipeline, machine);
            let mut machines = machines.filter(is_there);
            let Some(machine) = machines.next() else {
                continue;
            };
            let program = equations.optimise(subject, named, &plan.machines[machine]);
            let program = program.map_err(CommandFailure::plain)?;
            measure(&subject.name, &named.name, [&program.module; 2])?;
        }
        if let Some([module, shorter]) = subjects::for_processors(subject)? {
            measure(&subject.name, subjects::FOR_PROCESSORS, [&module, &shorter])?;
        }
    }
    bar.finish_and_clear();
    Ok(times)
}
