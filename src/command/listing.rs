//! `--list-passes`, `--help-pass`, `--list-machines`: the registry for users;
//! `--time-passes` and `--stats`.

use super::CommandFailure;
use super::arguments::TableFormat;
use robovec_framework::manager::PassRecord;
use robovec_framework::pass::{Gives, PassInfo, Property};
use robovec_ir::diagnostic::suggestion;
use robovec_ir::{Machine, machine};
use robovec_passes::registry::REGISTRY;
use robovec_present::text_table;
use serde_json::{Value, json};
use std::fmt::Write;

/// The passes and presets, a line each.
pub(crate) fn passes() -> String {
    let width = REGISTRY
        .passes
        .iter()
        .map(|info| info.name.len())
        .chain(REGISTRY.presets.iter().map(|preset| preset.name.len() + 1))
        .fold(0, usize::max);
    let mut text = "passes:\n".to_owned();
    for info in REGISTRY.passes {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {:width$}  {}", info.name, info.summary());
    }
    text.push_str("groups:\n");
    let _ = writeln!(
        text,
        "  fixpoint{{max=N}}(…)  repeats passes until nothing changes, at most N times (8)"
    );
    text.push_str("presets:\n");
    for preset in REGISTRY.presets {
        let name = format!("${}", preset.name);
        let _ = writeln!(text, "  {name:width$}  {}", preset.summary);
        let _ = writeln!(text, "  {:width$}  = {}", "", preset.pipeline);
    }
    text
}

/// The manual page of a pass.
pub(crate) fn pass(name: &str) -> Result<String, CommandFailure> {
    let Some(info) = REGISTRY.find(name) else {
        let names: Vec<&str> = REGISTRY.passes.iter().map(|info| info.name).collect();
        let mut notes: Vec<String> = suggestion(name, names.iter().copied())
            .into_iter()
            .collect();
        notes.push(format!("passes: {}", names.join(", ")));
        return Err(CommandFailure::advised(
            format!("there is no pass '{name}'"),
            notes,
        ));
    };
    Ok(page(info))
}

fn page(info: &PassInfo) -> String {
    let mut text = format!("{}\n\n", info.name);
    for line in info.documentation.lines() {
        let _ = writeln!(text, "  {}", line.trim_start());
    }
    let levels: Vec<&str> = info.takes.iter().map(|level| level.name()).collect();
    let gives = match info.gives {
        Gives::Same => "the same",
        Gives::Level(level) => level.name(),
    };
    let _ = writeln!(text, "\n  takes     {}", levels.join(", "));
    let _ = writeln!(text, "  gives     {gives}");
    let _ = writeln!(text, "  numerics  {}", info.class.name());
    for (label, properties) in [
        ("needs", info.requires),
        ("sets", info.sets),
        ("destroys", info.destroys),
    ] {
        if !properties.is_empty() {
            let names: Vec<&str> = properties.iter().map(|&p| Property::name(p)).collect();
            let _ = writeln!(text, "  {label:8}  {}", names.join(", "));
        }
    }
    if !info.options.is_empty() {
        text.push_str("\n  options\n");
    }
    for option in info.options {
        let _ = writeln!(
            text,
            "    {}=<{}>  (default {})",
            option.name,
            (option.type_name)(),
            (option.default)()
        );
        for line in option.documentation.lines() {
            let _ = writeln!(text, "      {}", line.trim());
        }
    }
    text
}

pub(crate) fn machines() -> String {
    let width = machine::BUILT_IN
        .iter()
        .map(|(name, _)| name.len())
        .fold(0, usize::max);
    let mut text = String::new();
    for (name, _) in machine::BUILT_IN {
        let machine = Machine::built_in(name).expect("the machines of the table ship");
        let _ = writeln!(text, "{name:width$}  {}", machine.description);
    }
    text
}

/// A step that is not a pass: reading, writing.
pub(crate) struct MeasuredStage {
    pub(crate) name: &'static str,
    pub(crate) cpu_s: f64,
    /// Largest memory of the process so far, in MB.
    pub(crate) peak_mb: f64,
}

/// Time and memory of reading, every pass and writing.
pub(crate) fn times(
    records: &[PassRecord],
    stages: &[MeasuredStage],
    format: TableFormat,
) -> String {
    let total: f64 = records.iter().map(|record| record.cpu_s).sum::<f64>()
        + stages.iter().map(|stage| stage.cpu_s).sum::<f64>();
    if format == TableFormat::Json {
        let passes: Vec<Value> = records
            .iter()
            .map(|record| {
                json!({
                    "function": record.function,
                    "name": record.name,
                    "cpu_s": record.cpu_s,
                    "peak_mb": record.peak_mb,
                    "operations": record.operations,
                    "asap_cycle": record.asap_cycle,
                })
            })
            .collect();
        let stages: Vec<Value> = stages
            .iter()
            .map(
                |stage| json!({"name": stage.name, "cpu_s": stage.cpu_s, "peak_mb": stage.peak_mb}),
            )
            .collect();
        return format!(
            "{:#}\n",
            json!({"passes": passes, "stages": stages, "cpu_s": total})
        );
    }
    let mut rows: Vec<Vec<String>> = Vec::new();
    let share = |seconds: f64| format!("{:.1}", 100.0 * seconds / total.max(1e-9));
    for record in records {
        rows.push(vec![
            record.name.clone(),
            record.function.clone(),
            format!("{:.2}", record.cpu_s * 1e3),
            share(record.cpu_s),
            format!("{:.1}", record.peak_mb),
            record.operations.to_string(),
            record.asap_cycle.to_string(),
        ]);
    }
    for stage in stages {
        rows.push(vec![
            stage.name.to_owned(),
            String::new(),
            format!("{:.2}", stage.cpu_s * 1e3),
            share(stage.cpu_s),
            format!("{:.1}", stage.peak_mb),
            String::new(),
            String::new(),
        ]);
    }
    let head = "pass | function | >CPU ms | >% | >peak MB | >operations | >path";
    let table = text_table(head, &rows);
    format!("{table}\nCPU time in all: {:.2} ms\n", total * 1e3)
}

pub(crate) fn statistics(records: &[PassRecord], format: TableFormat) -> String {
    if format == TableFormat::Json {
        let rows: Vec<Value> = records
            .iter()
            .map(|record| {
                let counts: serde_json::Map<String, Value> = record
                    .statistics
                    .iter()
                    .map(|(name, count)| ((*name).to_owned(), json!(count)))
                    .collect();
                json!({"function": record.function, "name": record.name, "statistics": counts})
            })
            .collect();
        return format!("{:#}\n", Value::from(rows));
    }
    let mut rows: Vec<Vec<String>> = Vec::new();
    for record in records {
        for (name, count) in &record.statistics {
            rows.push(vec![
                record.name.clone(),
                record.function.clone(),
                count.to_string(),
                (*name).to_owned(),
            ]);
        }
    }
    format!("{}\n", text_table("pass | function | >number | of", &rows))
}
