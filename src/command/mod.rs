//! The programs.
//!
//! Results go to the standard output or to `-o`; all other output goes to the
//! standard error or to the file an option names. Mistakes of the user end in a
//! diagnostic and exit code 1, wrong command lines in 2.

pub(crate) mod arguments;
mod base_parameters;
mod bench;
mod compare;
mod dump;
mod error;
mod eval;
mod explain;
mod explore;
pub(crate) mod fit;
pub mod flags;
mod generation;
pub mod grammar;
pub(crate) mod input;
mod listing;
mod manual;
mod model;
pub mod opt;
mod optimise;
mod output;
mod progress;
mod project;
mod reduction;
mod reproducer;
mod robot_bench;
mod rtl;
mod rules;
mod shares;
mod sim;
mod simulation;
mod stress;
mod subjects;
mod summary;
pub mod tool;
mod view;

use robovec_bench::Compiler;
use robovec_ir::diagnostic::{Report, termcolor::ColorChoice};

/// The command lines of both programs, with the limits of their numbers.
pub fn commands() -> [clap::Command; 2] {
    [arguments::command(), tool::command()]
}

/// Reason why a program stops, already as messages for the user.
#[derive(Debug)]
pub(crate) struct CommandFailure(pub(crate) Report);

impl CommandFailure {
    /// A failure that is about no text.
    pub(crate) fn plain(message: impl Into<String>) -> CommandFailure {
        CommandFailure::advised(message, Vec::new())
    }

    /// A failure about no text, with advice.
    pub(crate) fn advised(message: impl Into<String>, notes: Vec<String>) -> CommandFailure {
        CommandFailure(Report::error(message, notes))
    }

    /// Prints the messages on the standard error.
    pub(crate) fn emit(&self) {
        emit(&self.0);
    }
}

/// Prints a report on the standard error.
pub(crate) fn emit(report: &Report) {
    // When the standard error is closed there is no reader.
    drop(report.emit_to_stderr(ColorChoice::Auto));
}

impl From<Report> for CommandFailure {
    fn from(report: Report) -> CommandFailure {
        CommandFailure(report)
    }
}

/// An error when the C compiler of `--cpu` is requested and does not run.
fn require_compiler(asked: bool) -> Result<(), CommandFailure> {
    if asked {
        let note = "'--cpu' times programs with the C compiler 'cc'".to_owned();
        Compiler::find("cc").map_err(|reason| CommandFailure::advised(reason, vec![note]))?;
    }
    Ok(())
}

fn threads(jobs: Option<u32>) -> Result<rayon::ThreadPool, CommandFailure> {
    let pool = rayon::ThreadPoolBuilder::new();
    // 0 stands for as many as there are processors.
    let pool = pool.num_threads(jobs.map_or(0, |jobs| jobs as usize));
    pool.build()
        .map_err(|error| CommandFailure::plain(format!("cannot start threads: {error}")))
}
