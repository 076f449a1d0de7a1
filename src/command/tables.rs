//! `--time-passes` and `--stats`.

use super::arguments::TableFormat;
use robovec_framework::manager::PassRecord;
use robovec_present::text_table;
use serde_json::{Value, json};

/// A step that is not a pass: reading, writing.
pub(crate) struct MeasuredStage {
    /// Work that was done.
    pub(crate) name: &'static str,
    /// CPU seconds.
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
