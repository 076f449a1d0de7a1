//! How far a command is, told where somebody looks: on a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::Duration;

/// A bar over so many steps; `text` stands beside it.
pub(super) fn bar(steps: usize, text: &str) -> ProgressBar {
    styled(Some(steps), &format!("{{bar:40}} {text}"))
}

/// What is being done, for work whose length is not known.
pub(super) fn spinner() -> ProgressBar {
    let bar = styled(None, "{spinner} {elapsed} {msg}");
    if stderr().is_terminal() {
        bar.enable_steady_tick(Duration::from_millis(200));
    }
    bar
}

/// A bar that is told how many steps there are as it goes.
pub(super) fn plain() -> ProgressBar {
    let bar = ProgressBar::hidden();
    if stderr().is_terminal() {
        bar.set_draw_target(ProgressDrawTarget::stderr());
    }
    bar
}

fn styled(steps: Option<usize>, template: &str) -> ProgressBar {
    let steps = steps.map(|steps| steps as u64);
    let bar = plain();
    if let Some(steps) = steps {
        bar.set_length(steps);
    }
    bar.set_style(ProgressStyle::with_template(template).expect("templates are written here"));
    bar
}
