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
        method: &page::fill(
            include_str!("method.html"),
            &[("device", &task.machine.device.device().name)],
        ),
        data: json_script(&outcome.candidates),
    };
    page.to_html()
}
