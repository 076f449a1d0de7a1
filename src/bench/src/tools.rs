//! Compilers and other programs of the user's.

use robovec_io::process::{FinishedProcess, ProgramCall};
use std::path::Path;

/// A C or C++ compiler that is installed.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Compiler {
    /// Command that calls it.
    pub command: String,
    /// The first line of its version text.
    pub version: String,
}

impl Compiler {
    /// The compiler, if it is installed.
    ///
    /// # Errors
    ///
    /// Its message, or the reason why it does not run.
    pub fn find(command: &str) -> Result<Compiler, String> {
        let run = ProgramCall::version(command, "--version").run();
        let text = output_or_reason(command, &run.map_err(|error| error.to_string())?)?;
        Ok(Compiler {
            command: command.to_owned(),
            version: text.lines().next().unwrap_or(command).to_owned(),
        })
    }
}

/// A command that makes a part of a program.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct BuildStep {
    /// The program.
    pub command: String,
    /// Its arguments.
    pub arguments: Vec<String>,
    /// True if its time counts as time of compiling the function.
    pub timed: bool,
    /// The object file whose code is measured.
    pub object: Option<String>,
}

impl BuildStep {
    /// A command with arguments separated by blanks.
    pub fn new(command: &str, arguments: &str) -> BuildStep {
        BuildStep {
            command: command.to_owned(),
            arguments: arguments.split_whitespace().map(str::to_owned).collect(),
            timed: false,
            object: None,
        }
    }

    /// One more argument, blanks and all.
    pub fn with(mut self, argument: impl Into<String>) -> BuildStep {
        self.arguments.push(argument.into());
        self
    }

    /// Marks the step that compiles the function into an object file.
    pub fn function(mut self, object: &str) -> BuildStep {
        self.timed = true;
        self.object = Some(object.to_owned());
        self
    }

    /// Runs it; its processor time in s.
    pub(super) fn run(&self, place: &Path) -> Result<f64, String> {
        // The shell's `times` prints the processor time of its children.
        let mut arguments = vec![
            "-c".to_owned(),
            "\"$@\" 2>&1 || exit 1; times".to_owned(),
            "sh".to_owned(),
            self.command.clone(),
        ];
        arguments.extend(self.arguments.iter().cloned());
        let call = ProgramCall::new("sh").called(&self.command).folder(place);
        let run = call.arguments(arguments).run();
        let run = run.map_err(|error| error.to_string())?;
        let text = output_or_reason(&self.command, &run)?;
        let last = text.lines().next_back().into_iter();
        let times: Vec<f64> = (last.flat_map(str::split_whitespace))
            .filter_map(seconds)
            .collect();
        let [user, system] = times[..] else {
            return Err(format!("'{}': the shell gives no times", self.command));
        };
        Ok(user + system)
    }
}

/// A time as the shell prints it: `1m2.340s`.
fn seconds(text: &str) -> Option<f64> {
    let (minutes, rest) = text.split_once('m')?;
    let rest = rest.strip_suffix('s')?.replace(',', ".");
    Some(60.0 * minutes.parse::<f64>().ok()? + rest.parse::<f64>().ok()?)
}

/// Output of a program, or the reason or message of its failure.
pub(super) fn output(place: &Path, command: &str, arguments: &[String]) -> Result<String, String> {
    let call = ProgramCall::new(command).folder(place).arguments(arguments);
    output_or_reason(command, &call.run().map_err(|error| error.to_string())?)
}

/// Output of a program that succeeded; else the line with the reason: the first
/// error, or the first that is no warning.
fn output_or_reason(command: &str, run: &FinishedProcess) -> Result<String, String> {
    let text = run.text();
    if run.status.success() {
        return Ok(text);
    }
    let messages = run.messages();
    let lines = || messages.lines().chain(text.lines());
    let has = |line: &str, word: &str| line.to_ascii_lowercase().contains(word);
    let error = lines().find(|line| has(line, "error") || has(line, "fatal"));
    let line = error.or_else(|| lines().find(|line| !has(line, "warning")));
    Err(format!("'{command}': {}", line.unwrap_or("it failed")))
}

/// Bytes of code in an object file, when `size` is installed.
pub(super) fn code_bytes(object: &Path) -> Option<u64> {
    let name = object.to_string_lossy().into_owned();
    let text = output(Path::new("."), "size", &["-B".to_owned(), name]).ok()?;
    text.lines().nth(1)?.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_the_shell_are_read() {
        assert_eq!(seconds("1m2.500s"), Some(62.5));
        assert_eq!(seconds("0m0,040s"), Some(0.04));
        assert_eq!(seconds("user"), None);
    }

    #[test]
    fn the_reason_of_a_failing_step_is_its_first_error() {
        let script = "echo 'f.c: In function f:'; echo 'error: no such thing' >&2; exit 3";
        let step = BuildStep::new("sh", "-c").with(script);
        let message = step.run(Path::new(".")).expect_err("it exits with 3");
        assert_eq!(message, "'sh': error: no such thing");
    }
}
