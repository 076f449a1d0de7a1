//! Progress of a command: a bar on a terminal, elsewhere a line at intervals,
//! so that the log of a long run shows that it continues.

use super::telling;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use robovec_present::text::cut;
use std::io::{IsTerminal, Write, stderr};
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
    } else if !telling::is_quiet() {
        tell_in_lines(&bar);
    }
    bar
}

fn is_drawn() -> bool {
    stderr().is_terminal() && !telling::is_quiet()
}

/// Prints the progress of a bar at intervals, until it is finished or dropped;
/// no output where no thread can be started, as in WebAssembly.
fn tell_in_lines(bar: &ProgressBar) {
    let bar = bar.downgrade();
    let _ = thread::Builder::new().spawn(move || {
        loop {
            thread::sleep(telling::interval());
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
