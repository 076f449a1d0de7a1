//! The report: one HTML file that needs nothing else.
//!
//! Figures are those for paper, tables are HTML, points JSON for a chart that a
//! reader composes. **Invariant.** The page refers to no file or address.

use super::cpu::CpuTime;
use super::results::Results;
use super::tables::processors;
use super::verdict::{headline, of_headline, verdicts};
use robovec_ir::diagnostic::counted;
use robovec_present::escape::Escaped;
use robovec_present::json::json_script;
use robovec_present::number::or_nothing;
use robovec_present::number::round;
use robovec_present::{DataTable, Figure, page};
use serde_json::{Value, json};

const TEMPLATE: &str = include_str!("page.html");
const SCRIPT: &str = include_str!("page.js");

/// Tables with more rows than this are left to the files.
const LONGEST_TABLE: usize = 400;

pub(super) fn page(
    results: &Results,
    tables: &[DataTable],
    figures: &[Figure],
    times: &[CpuTime],
) -> String {
    let plan = &results.plan;
    let subtitle = format!(
        "{}. {}, {}, computed by robovec {}.",
        plan.description.trim_end_matches('.'),
        counted(plan.models.len(), "model"),
        counted(results.outcome.points.len(), "placement"),
        env!("CARGO_PKG_VERSION")
    );
    let measured = processors::tables(results, times);
    let shown = measured
        .iter()
        .chain(tables)
        .filter(|table| table.rows.len() <= LONGEST_TABLE);
    let title = format!("Study: {}", plan.name);
    let parts = [
        ("title", Escaped(&title).to_string()),
        ("subtitle", Escaped(&subtitle).to_string()),
        ("css", page::STYLE.to_owned()),
        ("js", format!("{}\n{SCRIPT}", page::TABLES)),
        ("tables", shown.map(table).collect()),
        ("figures", figures.iter().map(page::figure).collect()),
        ("method", method(results)),
        ("card", page::card(&headline(&of_headline(results)), &[])),
        ("data", json_script(&data(results, times))),
    ];
    let parts: Vec<(&str, &str)> = parts
        .iter()
        .map(|(name, part)| (*name, part.as_str()))
        .collect();
    page::fill(TEMPLATE, &parts)
}

/// A table as HTML, most with a link to their file; the thesis' are folded.
fn table(table: &DataTable) -> String {
    match table.name.as_str() {
        "cpu" | "winners" | "whole-step-cpu" => page::table(table, ""),
        name if name.starts_with("table-1.") => page::folding_table(table, &file(name), false),
        name => page::table(table, &file(name)),
    }
}

fn file(name: &str) -> String {
    format!("tables/{name}.csv")
}

fn data(results: &Results, cpu: &[CpuTime]) -> Value {
    let plan = &results.plan;
    let machine = results
        .main_machine()
        .map(|machine| &plan.machines[machine]);
    let points = results.points().map(|placed| {
        let (request, point) = (placed.request, placed.point);
        let most = |words: [f64; 3]| words[2];
        json!({
            "model": plan.models[request.model].name,
            "pipeline": plan.pipelines[request.pipeline].name,
            "machine": plan.machines[request.machine].name,
            "n_add": request.n_add,
            "n_multi": request.n_multi,
            "priority": request.options.priority,
            "choice": request.options.choice,
            "cycles": point.cycles,
            "lower_bound": point.lower_bound,
            "time_us": round(placed.time_us(), 4),
            "rate": round(point.rate, 4),
            "busy": [round(point.kinds[0].rate, 4), round(point.kinds[1].rate, 4)],
            "memory": [most(point.kinds[0].memory), most(point.kinds[1].memory)],
            "buffer": [most(point.kinds[0].buffer), most(point.kinds[1].buffer)],
            "zone": placed.zone(),
            "failure": point.failure,
        })
    });
    json!({
        "headline": plan.models.get(plan.headline).map(|model| &model.name),
        "machine": machine.map(|machine| &machine.name),
        "mhz": machine.map(|machine| machine.clock().mhz),
        "clock_origin": machine.map(|machine| machine.clock().origin),
        "pipelines": plan
            .pipelines
            .iter()
            .map(|pipeline| (pipeline.name.clone(), json!(pipeline.pipeline.to_string())))
            .collect::<serde_json::Map<_, _>>(),
        "points": points.collect::<Vec<_>>(),
        "verdicts": verdicts(results),
        "cpu": cpu,
    })
}

/// Models, pipelines and machines, and the words used.
fn method(results: &Results) -> String {
    let plan = &results.plan;
    let mut text = "<p>Every program is a straight line of additions, subtractions and \
        multiplications. A pipeline of passes rewrites it; the placer gives every operation a \
        cycle and an element of the machine; a verifier accepts the result before it is counted. \
        Lower bounds are proved. Elements are counted as adders + multipliers (all together): \
        the thesis uses both ways of counting.</p>\
        <details><summary>Pipelines, machines and models</summary><ul>"
        .to_owned();
    let mut item = |kind: &str, name: &str, about: &str| {
        text += &format!("<li>{kind} <b>{}</b>{about}</li>", Escaped(name));
    };
    for pipeline in &plan.pipelines {
        let passes = pipeline.pipeline.to_string();
        let passes = format!(": <code>{}</code>", Escaped(&passes));
        item("Pipeline", &pipeline.name, &passes);
    }
    let ordinary = plan.machines.iter();
    for machine in ordinary.filter(|machine| machine.couple.is_none()) {
        let (about, device) = (
            &machine.machine.description,
            machine.machine.device.device(),
        );
        let clock = machine.clock().text();
        let about = format!(": {about}, on {}, {clock}", device.name);
        item("Machine", &machine.name, &Escaped(&about).to_string());
    }
    for model in &plan.models {
        let row = model.printed.as_ref();
        let stands = or_nothing(row, |row| format!(", for the thesis' {row}"));
        let label = super::results::label(model);
        let about = format!(": {}, equations {label}{stands}", model.source);
        item("Model", &model.name, &Escaped(&about).to_string());
    }
    text + "</ul></details>"
}
