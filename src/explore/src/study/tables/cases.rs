//! Table 3.1: the study cases beside the figures the thesis prints.

use super::super::captions;
use super::super::plan::Printed;
use super::super::printed::{PrintedRow, PrintedSystem};
use super::super::program::ProgramFacts;
use super::super::results::Results;
use super::super::variants;
use super::reasons;
use robovec_present::{DataCell, DataTable};

pub(super) fn table(results: &Results) -> Option<DataTable> {
    let machine = results.main_machine()?;
    let mut rows = Vec::new();
    let models = 0..results.plan.models.len();
    for model in models.filter(|&model| !variants::is_variant(results, model)) {
        for pipeline in 0..results.plan.pipelines.len() {
            let Some(facts) = results.program(model, pipeline, machine) else {
                continue;
            };
            rows.push(row(results, model, pipeline, facts));
        }
    }
    captions::filled("table-3.1", &[], rows)
}

fn row(results: &Results, model: usize, pipeline: usize, facts: &ProgramFacts) -> Vec<DataCell> {
    let system = results.system(model);
    let printed = results.plan.pipelines[pipeline].printed;
    let title = match (system, printed) {
        (Some(system), Some(Printed::Modified)) => format!("{}, modified", system.name),
        (Some(system), _) => system.name.clone(),
        (None, _) => facts.model.clone(),
    };
    let mut cells = vec![
        DataCell::text(title),
        DataCell::text(&facts.model),
        DataCell::text(&facts.pipeline),
        DataCell::count(facts.operations),
        DataCell::count(facts.asap),
        DataCell::count(facts.asap_cycle),
        DataCell::number(facts.number_y(), 2),
    ];
    match results.row(model, pipeline) {
        Some(row) => cells.extend(printed_cells(facts, row)),
        None => cells.extend(std::iter::repeat_n(DataCell::Empty, 8)),
    }
    cells.push(DataCell::text(reason(
        results, system, model, pipeline, facts,
    )));
    cells
}

fn printed_cells(facts: &ProgramFacts, row: &PrintedRow) -> Vec<DataCell> {
    let cell = |name: &str, value: f64, decimals: u8| {
        if row.is_sound(name) {
            match decimals {
                0 => DataCell::count(value as u64),
                decimals => DataCell::number(value, decimals),
            }
        } else {
            DataCell::Doubtful { doubtful: value }
        }
    };
    let ratio = |name: &str, own: f64, printed: f64| {
        if row.is_sound(name) {
            DataCell::number(own / printed, 3)
        } else {
            DataCell::Empty
        }
    };
    let (operations, asap) = (f64::from(row.operations), f64::from(row.asap));
    let cycles = f64::from(row.asap_cycle);
    vec![
        cell("operations", operations, 0),
        cell("asap", asap, 0),
        cell("asap_cycle", cycles, 0),
        cell("y", row.y, 2),
        ratio("operations", facts.operations as f64, operations),
        ratio("asap", f64::from(facts.asap), asap),
        ratio("asap_cycle", f64::from(facts.asap_cycle), cycles),
        ratio("y", facts.number_y(), row.y),
    ]
}

/// Reason why a row differs from the thesis': facts about its model, the
/// pipeline, and the printed figures.
fn reason(
    results: &Results,
    system: Option<&'static PrintedSystem>,
    model: usize,
    pipeline: usize,
    facts: &ProgramFacts,
) -> String {
    let Some(system) = system else {
        return String::new();
    };
    let mut parts = Vec::new();
    match results.plan.pipelines[pipeline].printed {
        None => return "the thesis has no row for this pipeline".to_owned(),
        Some(Printed::Modified) if system.modified.is_none() => {
            return "the thesis changed only the bogie and the 23- and 50-dof systems by hand"
                .to_owned();
        }
        Some(Printed::Modified) => parts.push(reasons::modified(results, model, pipeline, facts)),
        Some(Printed::Original) => parts.push(reasons::original(
            system,
            &results.plan.models[model],
            facts,
        )),
    }
    if let Some(row) = results.row(model, pipeline) {
        parts.push(row.remark.clone());
    }
    parts.retain(|part| !part.is_empty());
    parts.join("; ")
}
