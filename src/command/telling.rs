//! Verbosity on the standard error while a command works: `-q`, `-v`.
//!
//! Warnings, errors and results are always printed. One setting holds for the
//! whole process: it is made once, before the command runs, and read where
//! progress and remarks are printed.

use clap::Args;
use std::io::{self, Write};
use std::sync::OnceLock;
use std::time::Duration;

/// The words of the command line.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct TellingArguments {
    /// Print no progress, no remarks and no summary of a compilation
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Print progress every two seconds, and the time taken at the end
    #[arg(short, long, global = true)]
    pub(crate) verbose: bool,
}

static TELLING: OnceLock<TellingArguments> = OnceLock::new();

/// Sets the amount of output; the first setting stays.
pub(super) fn set(arguments: TellingArguments) {
    TELLING.get_or_init(|| arguments);
}

fn current() -> TellingArguments {
    TELLING.get().copied().unwrap_or_default()
}

/// Tests whether nothing but warnings and errors is printed.
pub(super) fn is_quiet() -> bool {
    current().quiet
}

/// Tests whether more than usual is printed.
pub(super) fn is_verbose() -> bool {
    current().verbose
}

/// Time between messages from continuing work without a terminal.
pub(super) fn interval() -> Duration {
    Duration::from_secs(if is_verbose() { 2 } else { 10 })
}

/// Target of remarks: the standard error, or nowhere.
pub(super) fn remarks() -> Box<dyn Write> {
    if is_quiet() {
        Box::new(io::sink())
    } else {
        Box::new(io::stderr())
    }
}
