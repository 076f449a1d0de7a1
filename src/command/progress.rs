//! Progress of a command: a bar on a terminal, elsewhere a line at intervals,
//! so that the log of a long run shows that it continues; and `-q`, `-v`.
//!
//! Warnings, errors and results are always printed. One setting holds for the
//! whole process, made before the command runs.

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use robovec_present::text::cut;
use std::io::{self, IsTerminal, Write, stderr};
use std::sync::OnceLock;
use std::thread;
use std::time::Duration;

/// A bar over this number of steps; `text` is printed beside it.
pub(super) fn bar(steps: usize, text: &str) -> ProgressBar {
    styled(Some(steps), &format!("{{bar:40}} {text}"))
}

/// Indicator of work whose length is not known.
pub(super) fn spinner() -> ProgressBar {
    let bar = styled(None, "{spinner} {elapsed} {msg}");
    if is_drawn() {
        bar.enable_steady_tick(Duration::from_millis(200));
    }
    bar
}

/// A bar whose number of steps is set as it goes.
pub(super) fn plain() -> ProgressBar {
    let bar = ProgressBar::hidden();
    if is_drawn() {
        bar.set_draw_target(ProgressDrawTarget::stderr());
    } else if !is_quiet() {
        tell_in_lines(&bar);
    }
    bar
}

fn is_drawn() -> bool {
    stderr().is_terminal() && !is_quiet()
}

/// Prints the progress of a bar at intervals, where threads can be started.
fn tell_in_lines(bar: &ProgressBar) {
    let bar = bar.downgrade();
    let _ = thread::Builder::new().spawn(move || {
        loop {
            thread::sleep(interval());
            let Some(bar) = bar.upgrade() else { return };
            if bar.is_finished() {
                return;
            }
            // When the standard error is closed there is nobody left to tell.
            let _ = writeln!(stderr(), "{}", line(&bar));
        }
    });
}

/// Progress of a bar in one line: `40 s: 12/80 cases`.
fn line(bar: &ProgressBar) -> String {
    let steps = match bar.length() {
        Some(length) => format!(" {}/{length}", bar.position()),
        None => String::new(),
    };
    let text = format!(
        "{} s:{steps} {}",
        bar.elapsed().as_secs(),
        bar.message().trim()
    );
    cut(text.trim_end(), WIDTH)
}

/// Maximum number of characters of a line of progress.
const WIDTH: usize = 80;

fn styled(steps: Option<usize>, template: &str) -> ProgressBar {
    let steps = steps.map(|steps| steps as u64);
    let bar = plain();
    if let Some(steps) = steps {
        bar.set_length(steps);
    }
    bar.set_style(ProgressStyle::with_template(template).expect("templates are written here"));
    bar
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_tells_how_far_a_bar_is() {
        let bar = ProgressBar::hidden();
        bar.set_message("bogie, balanced");
        assert_eq!(line(&bar), "0 s: bogie, balanced");
        bar.set_length(80);
        bar.set_position(12);
        assert_eq!(line(&bar), "0 s: 12/80 bogie, balanced");
    }
}
