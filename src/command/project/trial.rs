//! A copy of a project, built and run with the old equations and the new ones.

use super::find::FoundProject;
use super::replace::NewEquations;
use super::{CommandFailure, real, whole};
use crate::command::output;
use crate::command::progress;
use clap::Args;
use robovec_io::files::{Replace, TemporaryFolder, limited};
use robovec_io::process::ProgramCall;
use robovec_present::text::text_lines;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Commands that build and run a project.
#[derive(Args, Debug)]
#[command(next_help_heading = "Trial in a copy of the project")]
pub(super) struct TrialArguments {
    /// Command that configures the copy, once
    #[arg(long, value_name = "COMMAND", requires = "run")]
    configure: Option<String>,
    /// Command that builds it
    #[arg(long, value_name = "COMMAND", requires = "run")]
    build: Option<String>,
    /// Command that runs it to its end
    #[arg(long, value_name = "COMMAND", requires = "result")]
    run: Option<String>,
    /// File of numbers that a run writes, in the project
    #[arg(long, value_name = "FILE", requires = "run")]
    result: Option<PathBuf>,
    /// Command that configures it for the whole step
    #[arg(long, value_name = "COMMAND", requires = "run")]
    step_configure: Option<String>,
    /// Command that runs it with the whole step, instead of --run
    #[arg(long, value_name = "COMMAND", requires = "run")]
    step_run: Option<String>,
    /// Number of runs of each, of which the fastest counts
    #[arg(long, value_name = "N", default_value_t = 3, add = whole(1, 100, "each is a whole run"))]
    times: u32,
    /// Largest difference of numbers, in parts of the largest of their column
    /// (at least 1)
    #[arg(long, value_name = "NUMBER", default_value_t = 1e-10,
          add = real(0.0, 1.0, "a larger one compares nothing"))]
    tolerance: f64,
}

impl TrialArguments {
    /// True where a trial is requested.
    pub(super) fn is_asked(&self) -> bool {
        self.run.is_some()
    }
}

/// A copy of a project.
struct ProjectCopy<'a> {
    arguments: &'a TrialArguments,
    folder: PathBuf,
    /// Folder of equations in it.
    symbolic: PathBuf,
}

/// Numbers and the least time of runs.
struct TrialRun {
    numbers: Vec<Vec<f64>>,
    seconds: f64,
}

/// Tries a project; a failure where results differ.
pub(super) fn run(
    arguments: &TrialArguments,
    project: &FoundProject,
    new: &[NewEquations],
    step: Option<&NewEquations>,
) -> Result<String, CommandFailure> {
    let failed = |error: std::io::Error| CommandFailure::plain(format!("no copy: {error}"));
    let temporary = TemporaryFolder::new().map_err(failed)?;
    let copy = ProjectCopy::new(arguments, project, temporary.path())?;
    let spinner = progress::spinner();
    if let Some(command) = &arguments.configure {
        copy.shell(command)?;
    }
    let usual = arguments.run.as_deref().expect("a trial has a run");
    spinner.set_message("Robotran's equations");
    let robotran = copy.measured(usual)?;
    let mut rows = vec![row("Robotran", 0, &robotran, None)];
    let mut worst = 0.0f64;
    let files: Vec<&(String, String)> = new.iter().flat_map(|one| &one.files).collect();
    copy.put(&files)?;
    spinner.set_message("robovec's equations");
    let mut compare = |name: &str, files: usize, run: &TrialRun| {
        let apart = difference(&robotran.numbers, &run.numbers);
        worst = worst.max(apart.unwrap_or(f64::INFINITY));
        rows.push(row(name, files, run, Some((robotran.seconds, apart))));
    };
    compare("robovec", files.len(), &copy.measured(usual)?);
    let is_step = arguments.step_run.is_some() || arguments.step_configure.is_some();
    if let Some(step) = step.filter(|step| is_step && !step.files.is_empty()) {
        let files: Vec<&(String, String)> = step.files.iter().collect();
        copy.put(&files)?;
        if let Some(command) = &arguments.step_configure {
            copy.shell(command)?;
            // Configuring may have fetched Robotran's own again.
            copy.put(&files)?;
        }
        spinner.set_message("the whole step");
        let command = arguments.step_run.as_deref().unwrap_or(usual);
        compare("whole step", files.len(), &copy.measured(command)?);
    }
    spinner.finish_and_clear();
    let text = text_lines(
        "equations | >files | >seconds | >speed | >largest difference",
        &rows,
    );
    if worst <= arguments.tolerance {
        return Ok(format!("\n{text}"));
    }
    Err(CommandFailure::advised(
        format!(
            "results differ by {worst:.1e} of the largest in a column; {:e} is allowed",
            arguments.tolerance
        ),
        vec![
            text,
            "--tolerance allows more; a bounce or a fall amplifies the last digit".to_owned(),
        ],
    ))
}

fn row(
    name: &str,
    files: usize,
    run: &TrialRun,
    against: Option<(f64, Option<f64>)>,
) -> Vec<String> {
    let mut row = vec![
        name.to_owned(),
        files.to_string(),
        format!("{:.3}", run.seconds),
    ];
    match against {
        None => row.extend(["-", "-"].map(str::to_owned)),
        Some((first, apart)) => row.extend([
            format!("{:.2} times", first / run.seconds),
            apart.map_or("other rows".to_owned(), |apart| format!("{apart:.1e}")),
        ]),
    }
    row
}

impl<'a> ProjectCopy<'a> {
    fn new(
        arguments: &'a TrialArguments,
        project: &FoundProject,
        temporary: &Path,
    ) -> Result<ProjectCopy<'a>, CommandFailure> {
        let folder = temporary.join("project");
        let copied = ProgramCall::new("cp").arguments([
            Path::new("-r"),
            &project.root.join("."),
            folder.as_path(),
        ]);
        run_tool(&copied, "the copy of the project")?;
        Ok(ProjectCopy {
            arguments,
            symbolic: folder.join(project.symbolic_inside()),
            folder,
        })
    }

    fn shell(&self, command: &str) -> Result<(), CommandFailure> {
        let call = ProgramCall::new("bash")
            .called(command)
            .arguments(["-ec", command])
            .folder(&self.folder);
        run_tool(&call, command)
    }

    fn put(&self, files: &[&(String, String)]) -> Result<(), CommandFailure> {
        for (name, text) in files {
            let path = self.symbolic.join(name);
            output::write_over(&path, Replace::Anything, |writer| {
                writer.write_all(text.as_bytes())
            })?;
        }
        Ok(())
    }

    /// Builds and runs the copy.
    fn measured(&self, command: &str) -> Result<TrialRun, CommandFailure> {
        if let Some(build) = &self.arguments.build {
            self.shell(build)?;
        }
        let result = self.arguments.result.as_ref().expect("a run has a result");
        let path = self.folder.join(result);
        let mut seconds = f64::INFINITY;
        for _ in 0..self.arguments.times {
            let start = Instant::now();
            self.shell(command)?;
            seconds = seconds.min(start.elapsed().as_secs_f64());
        }
        let bytes = limited::read(&path, &limited::STATES)?;
        let numbers = numbers(&String::from_utf8_lossy(&bytes));
        if numbers.is_empty() {
            return Err(CommandFailure::plain(format!(
                "{}: no line of numbers",
                result.display()
            )));
        }
        Ok(TrialRun { numbers, seconds })
    }
}

fn run_tool(call: &ProgramCall, name: &str) -> Result<(), CommandFailure> {
    let ended = call
        .run()
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    if ended.status.success() {
        return Ok(());
    }
    let said = ended.text() + &ended.messages();
    let lines: Vec<&str> = said.lines().collect();
    let last = lines[lines.len().saturating_sub(20)..].join("\n");
    Err(CommandFailure::advised(
        format!("failed: {name}"),
        vec![last],
    ))
}

/// Lines of numbers; others are left out.
fn numbers(text: &str) -> Vec<Vec<f64>> {
    let line = |line: &str| {
        let words = line.split(|letter: char| letter.is_whitespace() || letter == ',');
        let words = words.filter(|word| !word.is_empty());
        let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
        numbers.filter(|numbers| !numbers.is_empty())
    };
    text.lines().filter_map(line).collect()
}

/// The largest difference in parts of the largest number of its column, at
/// least 1; `None` where rows differ in number or length.
fn difference(one: &[Vec<f64>], other: &[Vec<f64>]) -> Option<f64> {
    if one.len() != other.len() {
        return None;
    }
    let width = one.iter().map(Vec::len).fold(0, usize::max);
    let mut scale = vec![1.0f64; width];
    for row in one {
        for (scale, number) in scale.iter_mut().zip(row) {
            *scale = scale.max(number.abs());
        }
    }
    let mut worst = 0.0f64;
    for (one, other) in one.iter().zip(other) {
        if one.len() != other.len() {
            return None;
        }
        for ((one, other), scale) in one.iter().zip(other).zip(&scale) {
            let apart = (one - other).abs() / scale;
            worst = worst.max(if apart.is_nan() { f64::INFINITY } else { apart });
        }
    }
    Some(worst)
}
