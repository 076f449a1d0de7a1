//! A copy of a project, built and run.

use super::build::{self, ProjectBuild};
use super::find::{self, FoundProject};
use super::results::{self, ResultFile};
use super::trial::TrialArguments;
use super::{CommandFailure, counted};
use crate::command::output;
use robovec_io::files::Replace;
use robovec_io::process::ProgramCall;
use robovec_ir::diagnostic::clip;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Files of the copy whose times are those of its making and of the last start.
const MADE: &str = ".robovec-made";
const START: &str = ".robovec-start";

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

    /// Numbers of a run: of the file named, else of all it wrote or printed.
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
    Err(match known_reason(&said) {
        Some(reason) => CommandFailure::advised(reason, vec![failed, last(5)]),
        None => CommandFailure::advised(failed, vec![last(20)]),
    })
}

/// A text that tools print, and the sentence for it.
type KnownText = (&'static str, &'static str);

/// Texts about the library of Robotran.
const ROBOTRAN: [KnownText; 7] = [
    ("ROBOTRAN_SOURCE_DIR-NOTFOUND", "MBsysC is not installed"),
    ("mbsysc package is not found", "MBsysC is not installed"),
    ("mbs_data.h: No such file", "MBsysC is not installed"),
    ("MBSdataStruct.h: No such file", "MBsysC is not installed"),
    ("MBsysPy not found", "MBsysPy is not installed"),
    ("No module named 'MBsysPy'", "MBsysPy is not installed"),
    ("'mbs_load' undefined", "MBsysLab is not installed"),
];

/// Texts after which the name of a missing part follows.
const PARTS: [(&str, &str); 9] = [
    (
        "Unknown CMake command ",
        "the MBsysC found has no CMake function",
    ),
    ("Could NOT find ", "a library is missing:"),
    ("configuration file provided by ", "a library is missing:"),
    ("Could not find ", "a part is missing:"),
    ("No module named ", "a module of Python is missing:"),
    ("fatal error: ", "a header is missing:"),
    (
        "has no member named ",
        "the MBsysC found, or a header, has no member",
    ),
    ("cannot find -l", "a library is missing:"),
    ("correctly in the CMake files:", "a library is missing:"),
];

/// The reason in the messages of a tool, if it is a known one.
fn known_reason(messages: &str) -> Option<String> {
    let known = ROBOTRAN.iter().find(|(text, _)| messages.contains(text));
    if let Some((_, sentence)) = known {
        return Some(format!("{sentence}: --library names its folder"));
    }
    for line in messages.lines() {
        if let Some((before, _)) = line.split_once(": command not found") {
            let tool = before.rsplit(": ").next().unwrap_or(before);
            return Some(format!("'{tool}' is not installed"));
        }
    }
    let part = |(text, sentence): &(&str, &str)| {
        let (_, after) = messages.split_once(text)?;
        let name = after.split_whitespace().next()?;
        let name = name.trim_matches(|letter: char| "\"'‘’:;,.()".contains(letter));
        Some(format!("{sentence} {name}"))
    };
    let error = |line: &&str| line.contains("rror: ") || line.contains("undefined reference");
    let first = || messages.lines().find(error);
    PARTS
        .iter()
        .find_map(part)
        .or_else(|| Some(clip(first()?.trim()).into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_named() {
        let cases = [
            (
                "bash: line 1: cmake: command not found",
                "'cmake' is not installed",
            ),
            (
                "CMake Error at CMakeLists.txt:100:\n  Unknown CMake command \"add_void\".",
                "the MBsysC found has no CMake function add_void",
            ),
            (
                "MBsysC path: ROBOTRAN_SOURCE_DIR-NOTFOUND",
                "MBsysC is not installed: --library names its folder",
            ),
            (
                "main.c:1:10: fatal error: a/b.h: No such file",
                "a header is missing: a/b.h",
            ),
            (
                "  Could NOT find LibXml2 (missing: A)",
                "a library is missing: LibXml2",
            ),
            (
                "ModuleNotFoundError: No module named 'numpy'",
                "a module of Python is missing: numpy",
            ),
            (
                "‘MbsData’ has no member named ‘x’",
                "the MBsysC found, or a header, has no member x",
            ),
        ];
        for (messages, sentence) in cases {
            assert_eq!(known_reason(messages).as_deref(), Some(sentence));
        }
        assert_eq!(known_reason("Segmentation fault"), None);
    }
}
