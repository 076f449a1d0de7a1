//! A search as a page: one HTML file that needs nothing else.

use super::confirm::Confirmation;
use super::text::{candidates_table, figure, text};
use super::{Outcome, Task};
use crate::front::page::TEMPLATE;
use crate::study::page::{STYLE, figure as drawn, fill, table};
use crate::study::plot::Escaped;

/// The page of a search.
pub fn page(task: &Task<'_>, outcome: &Outcome, confirmation: Option<&Confirmation>) -> String {
    let title = format!("Scene {}", task.scene.name);
    let subtitle = format!(
        "{}. Machine {}: {}, {} MHz. Computed by robovec {}.",
        task.scene.description.trim_end_matches('.'),
        task.machine.name,
        task.machine.description,
        task.machine.clock_mhz,
        env!("CARGO_PKG_VERSION")
    );
    let told = text(task, outcome, confirmation);
    // Candidates are plain data; numbers that are not finite become null.
    let data = serde_json::to_string(&outcome.candidates).unwrap_or_default();
    // Escaping is for one line at a time.
    let lines: Vec<String> = told.lines().map(|line| Escaped(line).to_string()).collect();
    let figures = format!(
        "<div class=\"scroll\"><pre>{}</pre></div>\n{}",
        lines.join("\n"),
        drawn(&figure(task, outcome))
    );
    let parts = [
        ("title", Escaped(&title).to_string()),
        ("subtitle", Escaped(&subtitle).to_string()),
        ("css", STYLE.to_owned()),
        ("figures", figures),
        ("points", "All candidates".to_owned()),
        ("tables", table(&candidates_table(outcome))),
        ("method", METHOD.to_owned()),
        // A closing tag inside a string would end the script.
        ("data", data.replace("</", "<\\/")),
    ];
    fill(TEMPLATE, &parts)
}

/// What the numbers mean.
const METHOD: &str = "<p>Every formulation is specialised to the scene and rewritten by several \
pipelines; sines and cosines are left to a host or written as series of the least order that is \
exact enough; the format is the narrowest that meets the tolerances, beside binary32; the elements \
are the fewest within the deadline, and powers of two. Errors are those of the whole program \
against the general function in double-double arithmetic with true sines and cosines, at random \
states of the scene.</p>\
<p><b>Of tolerance</b>: the largest error of any output over what the scene allows it. <b>Share of \
the device</b>: the largest of the shares of look-up tables, memory blocks and multiplier blocks of \
a 5CSEBA6U23I7, estimated by formulas; nothing was synthesised. <b>Held</b>: measured again at so \
many states that the search has not seen, and run cycle by cycle from memory images in so many runs, \
within the tolerances; it says nothing of other states.</p>";
