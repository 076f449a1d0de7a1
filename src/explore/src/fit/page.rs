//! A search as a page.

use super::confirm::Confirmation;
use super::text::{candidates_table, figure, text};
use super::{FitOutcome, FitTask};
use robovec_fpga::hardware;
use robovec_present::escape::Escaped;
use robovec_present::json::json_script;
use robovec_present::page::{self, PointsPage};

/// The page of a search.
pub fn page(
    task: &FitTask<'_>,
    outcome: &FitOutcome,
    confirmation: Option<&Confirmation>,
) -> String {
    let told = text(task, outcome, confirmation);
    // Escaping is for one line at a time.
    let lines: Vec<String> = told.lines().map(|line| Escaped(line).to_string()).collect();
    let page = PointsPage {
        title: format!("Scene {}", task.scene.name),
        subtitle: format!(
            "{}. Machine {}: {}, {}. Computed by robovec {}.",
            task.scene.description.trim_end_matches('.'),
            task.machine.name,
            task.machine.description,
            hardware::clock(task.machine).text(),
            env!("CARGO_PKG_VERSION")
        ),
        figures: format!(
            "<div class=\"scroll\"><pre>{}</pre></div>\n{}",
            lines.join("\n"),
            page::figure(&figure(task, outcome))
        ),
        points: "All candidates",
        tables: page::table(&candidates_table(outcome), "fit.csv"),
        method: &page::fill(METHOD, &[("device", &task.machine.device.device().name)]),
        data: json_script(&outcome.candidates),
    };
    page.to_html()
}

/// Explanation of the numbers.
const METHOD: &str = "<p>Every formulation is specialised to the scene and rewritten by several \
pipelines; sines and cosines are left to a host or written as series of the least order that is \
exact enough; the format is the narrowest that meets the tolerances, beside binary32, and of the \
shortest programs fixed point and a format for every value; the elements are the fewest within the deadline, and powers of two. Errors are those of the whole program \
against the general function in double-double arithmetic with true sines and cosines, at random \
states of the scene.</p>\
<p><b>Of tolerance</b>: the largest error of any output over what the scene allows it. <b>Share of \
the device</b>: the largest of the shares of look-up tables, memory blocks and multiplier blocks of \
the device ({{device}}), estimated by formulas; nothing was synthesised. <b>Cells</b>: what the arithmetic costs, the square \
of the bits for a product and the bits for a sum. <b>Held</b>: measured again at so \
many states that the search has not seen and at states bred from the worst of them, and run cycle by \
cycle from memory images, within the tolerances; the share of states is what independent states \
establish with a confidence of 95 %.</p>";
