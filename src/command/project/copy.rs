//! A copy of a project, built and run.

use super::build::{self, ProjectBuild};
use super::find::{self, FoundProject};
use super::results::{self, ResultFile};
use super::trial::TrialArguments;
use super::{CommandFailure, counted, missing};
use crate::command::output;
use robovec_io::files::Replace;
use robovec_io::process::ProgramCall;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Files of the copy whose times are those of its making and of the last start.
const MADE: &str = ".robovec-made";
const START: &str = ".robovec-start";

/// A copy of a project.
pub(super) struct ProjectCopy<'a> {
    arguments: &'a TrialArguments,
    pub(super) build: ProjectBuild,
    folder: PathBuf,
    /// Folder of equations in it.
    symbolic: PathBuf,
}

/// Results and the least time of runs.
pub(super) struct TrialRun {
    pub(super) results: Vec<ResultFile>,
    pub(super) seconds: f64,
}

impl<'a> ProjectCopy<'a> {
    pub(super) fn new(
        arguments: &'a TrialArguments,
        build: ProjectBuild,
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
        let copy = ProjectCopy {
            arguments,
            build,
            symbolic: folder.join(project.symbolic_inside()),
            folder,
        };
        copy.shell(&format!("touch {MADE}"))?;
        Ok(copy)
    }

    /// The output of a command.
    pub(super) fn shell(&self, command: &str) -> Result<String, CommandFailure> {
        let call = ProgramCall::new("bash")
            .called(command)
            .arguments(["-ec", command])
            .folder(&self.folder);
        run_tool(&call, command)
    }

    pub(super) fn put(&self, files: &[&(String, String)]) -> Result<(), CommandFailure> {
        for (name, text) in files {
            let path = self.symbolic.join(name);
            output::write_over(&path, Replace::Anything, |writer| {
                writer.write_all(text.as_bytes())
            })?;
        }
        Ok(())
    }

    /// Builds and runs the copy, with a command instead of its main program.
    pub(super) fn measured(&self, command: Option<&str>) -> Result<TrialRun, CommandFailure> {
        if let Some(build) = &self.build.build {
            self.shell(build)?;
        }
        let command = match command.or(self.build.run.as_deref()) {
            Some(command) => command.to_owned(),
            None => self.program(&self.build.folder)?,
        };
        let (mut seconds, mut results) = (f64::INFINITY, Vec::new());
        for _ in 0..self.arguments.times {
            self.shell(&format!("touch {START}"))?;
            let start = Instant::now();
            let said = self.shell(&command)?;
            seconds = seconds.min(start.elapsed().as_secs_f64());
            results = self.results(&said)?;
        }
        Ok(TrialRun { results, seconds })
    }

    /// The command that runs the program which a build made.
    fn program(&self, folder: &Path) -> Result<String, CommandFailure> {
        let found = self.shell(&format!(
            "find {} -type f -perm -u+x ! -name '*.so*' ! -name '*.dylib' ! -path '*/CMakeFiles/*' \
             -newer {MADE}",
            build::quoted(folder)
        ))?;
        let mut programs: Vec<&str> = found.lines().collect();
        // Robotran's template gives the program a name; tools are deeper inside.
        let rank = |path: &&str| (!path.contains("/exe_"), path.matches('/').count());
        programs.sort_by_key(rank);
        match programs.as_slice() {
            [program, rest @ ..] if rest.first().map(rank) != Some(rank(program)) => {
                let (folder, name) = program.rsplit_once('/').unwrap_or((".", program));
                let (folder, name) = (build::quoted(folder), build::quoted(name));
                Ok(format!("cd {folder} && ./{name}"))
            }
            programs => Err(CommandFailure::advised(
                format!(
                    "the build in {} makes {}",
                    folder.display(),
                    counted(programs.len(), "program")
                ),
                vec![format!(
                    "--run and --result give the one to run: {}",
                    programs.join(", ")
                )],
            )),
        }
    }

    /// The numbers of a run: of the file named, else of all that it wrote, else
    /// of its output.
    fn results(&self, said: &str) -> Result<Vec<ResultFile>, CommandFailure> {
        let failed = |text: String| CommandFailure::plain(text);
        if let Some(result) = &self.arguments.result {
            let path = self.folder.join(result);
            let file = ResultFile::read(&path, &self.folder);
            let shown = result.display();
            return file
                .map(|file| vec![file])
                .ok_or_else(|| failed(format!("{shown}: no line of numbers")));
        }
        let mut files = Vec::new();
        let start = self.folder.join(START).metadata();
        let since = start.and_then(|data| data.modified());
        let since = since.and_then(|since| {
            find::walk(&self.folder, 0, &["CMakeFiles"], &mut files)?;
            Ok(since)
        });
        let since = since.map_err(|error| failed(format!("no results: {error}")))?;
        let mut found = results::written(&files, &self.folder, since);
        if found.is_empty() {
            found.extend(ResultFile::new("the output".to_owned(), said));
        }
        if found.is_empty() {
            return Err(CommandFailure::advised(
                "the program ends without numbers to compare".to_owned(),
                vec!["--result names the file that holds them".to_owned()],
            ));
        }
        Ok(found)
    }
}

/// Runs a tool: its output, or what is missing.
fn run_tool(call: &ProgramCall, name: &str) -> Result<String, CommandFailure> {
    let ended = call
        .run()
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    if ended.status.success() {
        return Ok(ended.text());
    }
    let said = ended.text() + &ended.messages();
    let lines: Vec<&str> = said
        .lines()
        .filter(|line| !line.trim().is_empty())
        .collect();
    let last = |most: usize| lines[lines.len().saturating_sub(most)..].join("\n");
    let failed = format!("failed, {}: {name}", ended.status);
    Err(match missing::reason(&said) {
        Some(reason) => CommandFailure::advised(reason, vec![failed, last(5)]),
        None => CommandFailure::advised(failed, vec![last(20)]),
    })
}
