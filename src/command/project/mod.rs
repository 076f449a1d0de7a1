//! `robovec project`: a project of Robotran with its equations replaced.
//!
//! The parts of the project are found ([`find`]), its own calls are read where
//! they are plain ([`calls`]), and every file of equations is made anew, from
//! the file or from the model, whichever takes fewer operations ([`replace`]).
//! Nothing is written without a request; what `--apply` replaces is kept and
//! comes back with `--undo` ([`keep`]). A copy of the project is built and run
//! with both ([`trial`]), by the build of the project ([`build`]).

mod build;
mod calls;
mod copy;
mod find;
mod keep;
mod replace;
mod results;
mod trial;

use super::flags::{real, whole};
use super::{CommandFailure, input, output, progress};
use clap::Args;
use find::FoundProject;
use replace::NewEquations;
use robovec_io::sources;
use robovec_ir::diagnostic::counted;
use robovec_model::{Model, Nature};
use robovec_present::text::{labelled, text_lines};
use robovec_robotran::Language;
use std::io::Write as _;
use std::path::PathBuf;
use trial::TrialArguments;

/// Replace the equations of a project of Robotran, compare both, and undo it
#[derive(Args, Debug)]
pub(super) struct ProjectArguments {
    /// Folder of the project: symbolicR, userfctR, dataR and what builds it
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Model of the equations; by default the file .mbs of their name
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Replace the equations in the project, and add the whole step; the
    /// originals are kept in the folder .robovec of the project
    #[arg(long, conflicts_with_all = ["undo", "output"])]
    apply: bool,
    /// Bring back what --apply replaced
    #[arg(long, conflicts_with_all = ["output", "model", "run", "trial"])]
    undo: bool,
    /// Folder to write the new files to, instead of the project
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Joints that the project drives, beside those that it names in plain
    /// calls
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    driven: Vec<String>,
    /// Number of constraints of the project, where it is in no plain call
    #[arg(long, value_name = "ROWS",
          add = whole(0, 32, "each row is eliminated with all joints"))]
    user_constraints: Option<usize>,
    #[command(flatten)]
    trial: TrialArguments,
}

pub(super) fn run(arguments: &ProjectArguments) -> Result<String, CommandFailure> {
    if arguments.undo {
        return keep::undo(&arguments.folder);
    }
    let project = find::project(&arguments.folder, arguments.model.as_deref())?;
    let model = model(&project, arguments)?;
    let new = replace::equations(&project, model.as_ref().map(|model| &model.model));
    let step = match &model {
        Some(model) if project.language == Language::C => {
            Some(replace::whole_step(&new, &model.model, model.constraints))
        }
        _ => None,
    };
    let mut text = headline(&project, model.as_ref(), &new);
    text += &table(&new, step.as_ref());
    let all = new.iter().chain(&step);
    let files: Vec<(String, String)> = all.flat_map(|one| one.files.clone()).collect();
    if files.is_empty() {
        return Err(CommandFailure::advised(
            format!("no equations of {} can be replaced", project.name),
            vec![text],
        ));
    }
    let is_tried = arguments.trial.is_asked();
    let trial = if is_tried {
        // A trial that fails leaves the project as it is.
        trial::run(&arguments.trial, &project, &new, step.as_ref())?
    } else {
        String::new()
    };
    text += &match (&arguments.output, arguments.apply) {
        (Some(folder), _) => {
            output::write_files(folder, &files)?;
            format!("written to  {}\n", folder.display())
        }
        (None, true) => {
            keep::apply(&project, &files)?;
            "replaced    bring the originals back with --undo\n".to_owned()
        }
        (None, false) if is_tried => String::new(),
        (None, false) => {
            "nothing is written: --apply replaces the files, -o FOLDER writes them elsewhere\n"
                .to_owned()
        }
    };
    text += &trial;
    Ok(text)
}

/// The model of a project, with its joints as the project uses them.
struct ProjectModel {
    model: Model,
    /// Rows of constraints that the project computes.
    constraints: usize,
}

fn model(
    project: &FoundProject,
    arguments: &ProjectArguments,
) -> Result<Option<ProjectModel>, CommandFailure> {
    let Some(path) = &project.model else {
        return Ok(None);
    };
    let read = sources::model(path)?;
    if !read.warnings.diagnostics().is_empty() {
        let _ = writeln!(
            progress::remarks(),
            "remark: {} for the model; 'robovec model {}' prints them",
            counted(read.warnings.diagnostics().len(), "warning"),
            path.display()
        );
    }
    let mut model = read.model;
    for (nature, joint) in &project.calls.roles {
        match calls::joint(&model, joint, &project.calls) {
            Some(place) => model.joints[place].nature = *nature,
            None => {
                let _ = writeln!(
                    progress::remarks(),
                    "remark: the project gives a role to the joint '{joint}', which the model has \
                     not; --driven names driven ones"
                );
            }
        }
    }
    input::drive(&mut model, &arguments.driven)?;
    Ok(Some(ProjectModel {
        model,
        constraints: arguments
            .user_constraints
            .or(project.calls.constraints)
            .unwrap_or(0),
    }))
}

/// The project, what is gained, and where its parts are.
fn headline(project: &FoundProject, model: Option<&ProjectModel>, new: &[NewEquations]) -> String {
    let replaced = new.iter().filter_map(|one| Some((one.before?, one.after?)));
    let (before, after) = replaced.fold((0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
    let language = match project.language {
        Language::C => "C",
        Language::Matlab => "Matlab",
        Language::Python => "Python",
    };
    let files = counted(project.equations.len(), "file");
    let mut lines = vec![
        ("operations", format!("{before} -> {after}")),
        (
            "equations",
            format!(
                "{files} in {language}, {}",
                project.shown(&project.symbolic)
            ),
        ),
    ];
    if let (Some(model), Some(path)) = (model, &project.model) {
        let joints = &model.model.joints;
        let driven = joints.iter().filter(|joint| joint.nature == Nature::Driven);
        lines.push((
            "model",
            format!(
                "{}: {}, {} driven, {}, {} of the project",
                project.shown(path),
                counted(joints.len(), "joint"),
                driven.count(),
                counted(model.model.cuts.len(), "loop"),
                counted(model.constraints, "constraint"),
            ),
        ));
    } else {
        let text = match project.candidates.first() {
            None => "none: without one the whole step cannot be made (--model FILE)".to_owned(),
            Some(first) => format!(
                "none has the name of the equations; of {}, --model chooses one: {} …",
                project.candidates.len(),
                project.shown(first)
            ),
        };
        lines.push(("model", text));
    }
    if let Some(first) = project.others.first() {
        let text = format!(
            "{}, such as {first}: name the folder, or --model",
            counted(project.others.len(), "other set of equations")
        );
        lines.push(("others", text));
    }
    format!("{}\n{}\n", project.name, labelled(&lines))
}

/// Operations of every function before and after.
fn table(new: &[NewEquations], step: Option<&NewEquations>) -> String {
    let number = |count: Option<usize>| count.map_or("-".to_owned(), |count| count.to_string());
    let rows: Vec<Vec<String>> = new
        .iter()
        .chain(step)
        .map(|one| {
            vec![
                one.function.clone(),
                number(one.before),
                number(one.after),
                one.remark.clone(),
            ]
        })
        .collect();
    let text = text_lines("function | >operations | >robovec's | ", &rows) + "\n";
    let reasons = new.iter().chain(step).filter_map(|one| {
        let reason = one.reason.as_deref()?;
        Some((one.function.as_str(), reason.to_owned()))
    });
    let reasons: Vec<(&str, String)> = reasons.collect();
    if reasons.is_empty() {
        return text;
    }
    text + &labelled(&reasons) + "\n"
}
