//! Studies: many programs placed on many machines, and the conclusions.
//!
//! `plan` lists the points; `run` places them, in parallel, with finished
//! points kept by [`crate::store`]; `tables` and `figures` are views of the
//! points, each named by its number in the thesis; `verdict` sums them up in
//! words; `page` puts everything into one HTML file. The figures of the thesis
//! itself are data (`printed`), shown beside ours and never mixed with them.
//!
//! **Invariant.** All results except processor times are a function of plan and
//! programs alone: they do not depend on a clock, the number of threads or the
//! order of work.

mod cpu;
mod figures;
mod knee;
mod page;
pub mod plan;
mod point;
mod printed;
mod program;
mod results;
mod run;
mod step;
mod tables;
mod verdict;

pub use cpu::{CpuJob, CpuTime, time};
pub use program::{ProgramSources, StudyEquations};
pub use results::Results;
pub use run::{StudyOutcome, run};

use robovec_ir::diagnostic::counted;
use robovec_present::json::json_text;
use robovec_present::plot;
use robovec_present::text::{headed, labelled};
use std::path::Path;

/// Name of the file of the page.
const PAGE: &str = "explore.html";

/// The files of a study: those of each folder, by name.
pub fn files(results: &Results, times: &[CpuTime]) -> [(&'static str, Vec<(String, String)>); 3] {
    let (tables, figures) = (tables::all(results), figures::all(results));
    let mut inside = [Vec::new(), Vec::new()];
    for table in &tables {
        inside[0].push((format!("{}.csv", table.name), table.to_csv()));
        inside[0].push((format!("{}.json", table.name), json_text(table)));
    }
    for figure in &figures {
        inside[1].push((format!("{}.svg", figure.name), plot::draw(figure)));
        inside[1].push((format!("{}.csv", figure.name), figure.to_csv()));
    }
    let page = page::page(results, &tables, &figures, times);
    let [tables, figures] = inside;
    let whole = vec![
        (PAGE.to_owned(), page),
        ("explore.json".to_owned(), lines(&results.to_json())),
    ];
    [("tables", tables), ("figures", figures), ("", whole)]
}

/// JSON with one line for each entry of the outermost lists.
fn lines(value: &serde_json::Value) -> String {
    let mut text = "{".to_owned();
    for (index, (key, value)) in value.as_object().into_iter().flatten().enumerate() {
        text += if index == 0 { "\n" } else { ",\n" };
        text += &format!("{}: ", serde_json::Value::from(key.as_str()));
        match value.as_array() {
            Some(list) if !list.is_empty() => {
                let entries: Vec<String> = list.iter().map(ToString::to_string).collect();
                text += &format!("[\n{}\n]", entries.join(",\n"));
            }
            _ => text += &value.to_string(),
        }
    }
    text + "\n}\n"
}

/// The answer about the headline, and the number of placements.
pub fn summary(results: &Results, folder: &Path) -> String {
    let verdicts = verdict::of_headline(results);
    let mut lines = verdict::lines(&verdicts);
    let reused = match results.outcome.reused {
        0 => String::new(),
        reused => format!(", {reused} of them from an earlier run"),
    };
    let placements = counted(results.outcome.points.len(), "placement");
    let folder = folder.join(PAGE);
    lines.push((
        "computed",
        format!("{placements}{reused}: {}", folder.display()),
    ));
    let mut failures = results.points().filter_map(|placed| {
        let reason = placed.point.failure.as_ref()?;
        Some((placed.request, reason))
    });
    if let Some((request, reason)) = failures.next() {
        let text = format!(
            "{}, the first is {} on {} with {}+{} elements: {reason}",
            counted(1 + failures.count(), "placement"),
            results.plan.models[request.model].name,
            results.plan.machines[request.machine].name,
            request.n_add,
            request.n_multi,
        );
        lines.push(("impossible", text));
    }
    headed(&results.plan.name, &verdict::headline(&verdicts)) + &labelled(&lines)
}
