//! A copy of a project, built and run with the old equations and the new ones.

use super::build::{self, ProjectBuild};
use super::copy::{ProjectCopy, TrialRun};
use super::find::FoundProject;
use super::replace::NewEquations;
use super::results::{self, ResultFile};
use super::{CommandFailure, counted, real, whole};
use crate::command::progress;
use clap::Args;
use robovec_io::files::TemporaryFolder;
use robovec_present::text::{labelled, text_lines};
use std::path::{Path, PathBuf};

/// Part of the names of files with the forces of driven joints.
const FORCES: &str = "_Qc.";

/// The trial of a project, and commands instead of those found in it.
#[derive(Args, Debug)]
#[command(next_help_heading = "Trial in a copy of the project")]
pub(super) struct TrialArguments {
    /// Build and run a copy with the old and the new equations, and compare
    /// the numbers and the times; a command below does the same
    #[arg(long)]
    trial: bool,
    /// Folder of MBsysC, MBsysPy or MBsysLab, where the build does not find it
    #[arg(long, value_name = "FOLDER")]
    library: Option<PathBuf>,
    /// Command that configures the copy, once, instead of the one found
    #[arg(long, value_name = "COMMAND")]
    configure: Option<String>,
    /// Command that builds it, instead of the one found
    #[arg(long, value_name = "COMMAND")]
    build: Option<String>,
    /// Command that runs it to its end, instead of the program found
    #[arg(long, value_name = "COMMAND")]
    run: Option<String>,
    /// File of numbers that a run writes, in the project, instead of all
    #[arg(long, value_name = "FILE")]
    pub(super) result: Option<PathBuf>,
    /// Command that configures it for the whole step
    #[arg(long, value_name = "COMMAND")]
    step_configure: Option<String>,
    /// Command that runs it with the whole step, instead of --run
    #[arg(long, value_name = "COMMAND")]
    step_run: Option<String>,
    /// Number of runs of each, of which the fastest counts
    #[arg(long, value_name = "N", default_value_t = 3, add = whole(1, 100, "each is a whole run"))]
    pub(super) times: u32,
    /// Largest difference of numbers beyond one unit in their last printed
    /// place, in parts of the largest of their column (at least 1)
    #[arg(long, value_name = "NUMBER", default_value_t = 1e-10,
          add = real(0.0, 1.0, "a larger one compares nothing"))]
    tolerance: f64,
}

impl TrialArguments {
    /// True where a trial is requested.
    pub(super) fn is_asked(&self) -> bool {
        let commands = [
            &self.configure,
            &self.build,
            &self.run,
            &self.step_configure,
            &self.step_run,
        ];
        let is_given = commands.iter().any(|command| command.is_some());
        self.trial || is_given || self.library.is_some() || self.result.is_some()
    }

    /// The commands given, and for the others those of the project.
    fn build(&self, project: &FoundProject) -> Result<ProjectBuild, CommandFailure> {
        let given = |command: &Option<String>, other| command.clone().or(other);
        // Who gives the run gives what it needs.
        let found = match &self.run {
            Some(_) => ProjectBuild::default(),
            None => build::find(project, self.library.as_deref())?,
        };
        Ok(ProjectBuild {
            run: given(&self.run, found.run),
            configure: given(&self.configure, found.configure),
            step_configure: given(&self.step_configure, found.step_configure),
            build: given(&self.build, found.build),
            ..found
        })
    }
}

/// Tries a project; a failure where results differ.
pub(super) fn run(
    arguments: &TrialArguments,
    project: &FoundProject,
    new: &[NewEquations],
    step: Option<&NewEquations>,
) -> Result<String, CommandFailure> {
    let build = arguments.build(project)?;
    let failed = |error: std::io::Error| CommandFailure::plain(format!("no copy: {error}"));
    let temporary = TemporaryFolder::new().map_err(failed)?;
    let copy = ProjectCopy::new(arguments, build, project, temporary.path())?;
    let spinner = progress::spinner();
    if let Some(command) = &copy.build.configure {
        spinner.set_message("configuring");
        copy.shell(command)?;
    }
    spinner.set_message("Robotran's equations");
    let mut robotran = copy.measured(None)?;
    let compared = compared(project, &copy.build.file, &robotran.results);
    let mut rows = vec![row("Robotran", 0, &robotran, None)];
    let mut worst = (0.0f64, String::new());
    let files: Vec<&(String, String)> = new.iter().flat_map(|one| &one.files).collect();
    copy.put(&files)?;
    spinner.set_message("robovec's equations");
    let mut compare = |name: &str, files: usize, robotran: &TrialRun, run: &TrialRun| {
        let apart = results::difference(&robotran.results, &run.results);
        rows.push(row(name, files, run, Some((robotran.seconds, apart.0))));
        if apart.0 > worst.0 {
            worst = apart;
        }
    };
    compare("robovec", files.len(), &robotran, &copy.measured(None)?);
    let configure = &copy.build.step_configure;
    let is_step = arguments.step_run.is_some() || configure.is_some();
    if let Some(step) = step.filter(|step| is_step && !step.files.is_empty()) {
        let files: Vec<&(String, String)> = step.files.iter().collect();
        copy.put(&files)?;
        if let Some(command) = configure {
            copy.shell(command)?;
            // Configuring may have fetched Robotran's own again.
            copy.put(&files)?;
        }
        spinner.set_message("the whole step");
        let mut run = copy.measured(arguments.step_run.as_deref())?;
        // It gives no forces of driven joints where a model has loops.
        robotran.results.retain(|file| !file.name.contains(FORCES));
        run.results.retain(|file| !file.name.contains(FORCES));
        compare("whole step", files.len(), &robotran, &run);
    }
    spinner.finish_and_clear();
    let text = format!(
        "{compared}\n{}",
        text_lines(
            "equations | >files | >seconds | >speed | >largest difference",
            &rows,
        )
    );
    if worst.0 <= arguments.tolerance {
        return Ok(format!("\n{text}"));
    }
    Err(CommandFailure::advised(
        format!(
            "results in {} differ by {:.1e} of the largest in a column; {:e} is allowed",
            worst.1, worst.0, arguments.tolerance
        ),
        vec![
            text,
            "--tolerance allows more; a bounce or a fall amplifies the last digit".to_owned(),
        ],
    ))
}

/// The build that was found and the results.
fn compared(project: &FoundProject, build: &Path, results: &[ResultFile]) -> String {
    let from = if build.as_os_str().is_empty() {
        "commands given".to_owned()
    } else {
        project.shown(build)
    };
    let some = results.first().map_or("", |file| &file.name);
    let count = counted(results.len(), "file");
    let lines = [
        ("trial", format!("a copy, built and run as {from} asks")),
        ("results", format!("{count}, such as {some}")),
    ];
    labelled(&lines)
}

fn row(name: &str, files: usize, run: &TrialRun, against: Option<(f64, f64)>) -> Vec<String> {
    let mut row = vec![
        name.to_owned(),
        files.to_string(),
        format!("{:.3}", run.seconds),
    ];
    match against {
        None => row.extend(["-", "-"].map(str::to_owned)),
        Some((first, apart)) => row.extend([
            format!("{:.2} times", first / run.seconds),
            if apart.is_infinite() {
                "other rows".to_owned()
            } else if apart == 0.0 {
                "none".to_owned()
            } else {
                format!("{apart:.1e}")
            },
        ]),
    }
    row
}
