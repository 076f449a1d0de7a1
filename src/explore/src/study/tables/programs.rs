//! Tables with a row for every program.

use super::super::knee::{Knee, Split, knee};
use super::super::plan::Printed;
use super::super::printed::PrintedRow;
use super::super::program::ProgramFacts;
use super::super::results;
use super::super::results::{Results, StudiedProgram};
use super::reasons;
use crate::captions::{self, Words};
use robovec_analysis::rounding::MedianChange;
use robovec_error::yardstick::account::ERROR_HEADS;
use robovec_present::{CellValue, ColumnList, DataTable, Digits, columns};

type Programs<'a> = ColumnList<'a, StudiedProgram<'a>>;

/// Names of model and pipeline, and the operations.
fn names<'a>() -> Programs<'a> {
    columns! { StudiedProgram<'_>;
        "model", [Hidden, All], |row| row.facts.model.as_str();
        "pipeline", [Hidden, All], |row| row.facts.pipeline.as_str();
    }
}

/// A figure of a program that the thesis prints for its systems: the name of the cell
/// in the data, its head, ours and the thesis'.
type PrintedFigure = (
    &'static str,
    &'static str,
    fn(&ProgramFacts) -> f64,
    fn(&PrintedRow) -> f64,
);

const PRINTED: [PrintedFigure; 4] = [
    (
        "operations",
        "operations",
        |facts| facts.operations as f64,
        |row| f64::from(row.operations),
    ),
    (
        "asap",
        "ASAP",
        |facts| f64::from(facts.asap),
        |row| f64::from(row.asap),
    ),
    (
        "asap_cycle",
        "ASAPCycle",
        |facts| f64::from(facts.asap_cycle),
        |row| f64::from(row.asap_cycle),
    ),
    ("y", "Y", ProgramFacts::number_y, |row| row.y),
];

/// Table 3.1: the study cases beside the figures the thesis prints.
pub(super) fn cases(results: &Results) -> Option<DataTable> {
    let figure = |name: &str, figure: f64| match name {
        "y" => CellValue::Number(figure),
        _ => CellValue::Count(figure as u64),
    };
    let mut columns = columns! { StudiedProgram<'_>; "system", [Hidden, All], title; }.and(names());
    for (name, head, own, _) in PRINTED {
        let cell = move |row: &StudiedProgram<'_>| figure(name, own(row.facts));
        columns = columns.with(head, Digits::Hidden, Digits::Decimals(2), cell);
    }
    for (name, head, _, printed) in PRINTED {
        let cell = move |row: &StudiedProgram<'_>| match row.row() {
            None => CellValue::Nothing,
            Some(row) if row.is_sound(name) => figure(name, printed(row)),
            Some(row) => CellValue::Doubtful(printed(row)),
        };
        let head = format!("thesis: {head}");
        columns = columns.with(head, Digits::Hidden, Digits::Decimals(2), cell);
    }
    for (name, head, own, printed) in PRINTED {
        let cell = move |row: &StudiedProgram<'_>| {
            let printed = printed(row.row().filter(|row| row.is_sound(name))?);
            Some(own(row.facts) / printed)
        };
        let head = format!("ratio {head}");
        columns = columns.with(head, Digits::Hidden, Digits::Decimals(3), cell);
    }
    let columns = columns.with(
        "reason for the difference",
        Digits::Hidden,
        Digits::All,
        reasons::of,
    );
    let rows = (results.ordinary()).filter(|row| !results::is_variant(results, row.place[0]));
    captions::filled("table-3.1", &[], &columns, &rows.collect::<Vec<_>>())
}

/// The name of a program's system in the thesis, or of its model.
fn title(row: &StudiedProgram<'_>) -> String {
    match (row.results.system(row.place[0]), row.pipeline().printed) {
        (Some(system), Some(Printed::Modified)) => format!("{}, modified", system.name),
        (Some(system), _) => system.name.clone(),
        (None, _) => row.facts.model.clone(),
    }
}

/// A program with its knee, and the first formulation of its system.
struct KneeRow<'a> {
    program: StudiedProgram<'a>,
    knee: Option<Knee>,
    first: Option<&'a ProgramFacts>,
}

impl<'a> KneeRow<'a> {
    fn of(program: StudiedProgram<'a>) -> KneeRow<'a> {
        KneeRow {
            program,
            knee: knee(&program),
            first: None,
        }
    }

    /// The numbers of elements at its cheapest knee.
    fn cheapest(&self) -> Option<Split> {
        self.knee.as_ref()?.cheapest
    }

    fn microseconds(&self, split: Option<Split>) -> Option<f64> {
        Some(self.program.clock().microseconds(split?.cycles))
    }
}

/// Share of the device and errors of a chosen program.
fn costs<'a>() -> ColumnList<'a, KneeRow<'a>> {
    let [median, worst] = ERROR_HEADS;
    columns! { KneeRow<'_>;
        "share of device (%)", [Hidden, Decimals(2)], |row| Some(100.0 * row.cheapest()?.share);
        median, [Hidden, Exponent(1)], |row| row.program.facts.errors()[0];
        worst, [Hidden, Exponent(1)], |row| row.program.facts.errors()[1];
    }
}

fn with_clock<'a>(
    name: &str,
    rows: &[KneeRow<'a>],
    columns: &ColumnList<'_, KneeRow<'a>>,
) -> Option<DataTable> {
    let clock = rows.first()?.program.clock().text();
    let words: &Words<'_> = &[("clock", &clock)];
    captions::filled(name, words, columns, rows)
}

/// The number of elements that every program is worth.
pub(super) fn knees(results: &Results) -> Option<DataTable> {
    let text = |split: fn(&Knee) -> Option<Split>| {
        move |row: &KneeRow<'_>| Some(split(row.knee.as_ref()?)?.text())
    };
    let exact = |row: &KneeRow<'_>| {
        let knee = row.knee.as_ref()?;
        Some(if knee.is_exact { "yes" } else { "no" })
    };
    let faster = |row: &KneeRow<'_>| {
        let (single, best) = (row.knee.as_ref()?.single?, row.cheapest()?);
        Some(f64::from(single.cycles) / f64::from(best.cycles.max(1)))
    };
    let columns = columns! { KneeRow<'_>;
        "model", [Hidden, All], |row| row.program.facts.model.as_str();
        "pipeline", [Hidden, All], |row| row.program.facts.pipeline.as_str();
        "number Y", [Hidden, Decimals(2)], |row| row.program.facts.number_y();
        "busy up to", [Hidden, All], text(|knee| knee.busiest);
        "knee", [Hidden, All], text(|knee| knee.equal);
        "exact", [Hidden, All], exact;
        "cheapest", [Hidden, All], text(|knee| knee.cheapest);
        "cycles there", [Hidden, All], |row| Some(row.cheapest()?.cycles);
        "time there (µs)", [Hidden, Decimals(3)], |row| row.microseconds(row.cheapest());
    };
    let columns = columns.and(costs()).and(columns! { KneeRow<'_>;
        "parallelisation rate there (%)", [Hidden, Decimals(1)],
            |row| Some(100.0 * row.cheapest()?.rate);
        "times as fast as 1+1", [Hidden, Decimals(1)], faster;
    });
    let rows = results.ordinary().map(KneeRow::of);
    let rows: Vec<KneeRow<'_>> = rows.filter(|row| row.knee.is_some()).collect();
    with_clock("knee", &rows, &columns)
}

/// Formulations of the same system, compared.
pub(super) fn formulations(results: &Results) -> Option<DataTable> {
    let mut rows = Vec::new();
    for group in results::groups(results) {
        for pipeline in 0..results.plan.pipelines.len() {
            let of = |model: usize| results.program([model, pipeline, results.main_machine()?]);
            let first = of(group[0]).map(|first| first.facts);
            let programs = group.iter().filter_map(|&model| of(model));
            rows.extend(programs.map(|program| KneeRow {
                first,
                ..KneeRow::of(program)
            }));
        }
    }
    let ratio = |figure: fn(&ProgramFacts) -> f64| {
        move |row: &KneeRow<'_>| Some(figure(row.program.facts) / figure(row.first?))
    };
    let single = |row: &KneeRow<'_>| row.microseconds(row.knee.as_ref()?.single);
    let columns = columns! { KneeRow<'_>;
        "system", [Hidden, All], |row| row.program.subject().source.as_str();
        "formulation", [Hidden, All], |row| results::label(row.program.subject());
        "pipeline", [Hidden, All], |row| row.program.facts.pipeline.as_str();
        "operations", [Hidden, All], |row| row.program.facts.operations;
        "ASAPCycle", [Hidden, All], |row| row.program.facts.asap_cycle;
        "number Y", [Hidden, Decimals(2)], |row| row.program.facts.number_y();
        "ratio operations", [Hidden, Decimals(3)], ratio(|facts| facts.operations as f64);
        "ratio ASAPCycle", [Hidden, Decimals(3)], ratio(|facts| f64::from(facts.asap_cycle));
        "worth", [Hidden, All], |row| Some(row.cheapest()?.text());
        "time there (µs)", [Hidden, Decimals(2)], |row| row.microseconds(row.cheapest());
    };
    let columns = columns.and(costs());
    let columns = columns.with(
        "time with 1+1 (µs)",
        Digits::Hidden,
        Digits::Decimals(2),
        single,
    );
    with_clock("formulations", &rows, &columns)
}

/// Effect of the pipelines on the rounding errors.
pub(super) fn errors(results: &Results) -> Option<DataTable> {
    let change = |row: &StudiedProgram<'_>| {
        let [read, now] = &row.facts.rounding;
        MedianChange::relative(read, now)
    };
    let columns = names().and(columns! { StudiedProgram<'_>;
        "operations", [Hidden, All], |row| row.facts.operations;
        "ASAPCycle", [Hidden, All], |row| row.facts.asap_cycle;
        "median as read", [Hidden, Decimals(2)], |row| row.facts.rounding[0].relative.median;
        "median", [Hidden, Decimals(2)], |row| row.facts.rounding[1].relative.median;
        "99 %", [Hidden, Decimals(0)], |row| row.facts.rounding[1].relative.percentile_99;
        "normwise median as read", [Hidden, Decimals(2)],
            |row| row.facts.rounding[0].normwise.median;
        "normwise median", [Hidden, Decimals(2)], |row| row.facts.rounding[1].normwise.median;
        "normwise worst", [Hidden, Decimals(1)], |row| row.facts.rounding[1].normwise.worst;
        "median over as read", [Hidden, Decimals(3)], move |row| change(row).ratio;
        "noise", [Hidden, Decimals(3)], move |row| change(row).noise;
        "trend", [Hidden, All], move |row| change(row).trend.name();
    });
    let rows: Vec<StudiedProgram<'_>> = results.ordinary().collect();
    captions::filled("errors", &[], &columns, &rows)
}

pub(super) fn programs(results: &Results) -> DataTable {
    let [median, worst] = ERROR_HEADS;
    let columns = names().and(columns! { StudiedProgram<'_>;
        "machine", [Hidden, All], |row| row.facts.machine.as_str();
        "equations", [Hidden, All], |row| row.facts.equations;
        "operations", [Hidden, All], |row| row.facts.operations;
        "additions", [Hidden, All], |row| row.facts.add_sub;
        "multiplications", [Hidden, All], |row| row.facts.mul;
        "ASAP", [Hidden, All], |row| row.facts.asap;
        "ASAPCycle", [Hidden, All], |row| row.facts.asap_cycle;
        "additions on the chain", [Hidden, All], |row| row.facts.path_add;
        "multiplications on the chain", [Hidden, All], |row| row.facts.path_mul;
        "number Y", [Hidden, Decimals(2)], |row| row.facts.number_y();
        median, [Hidden, Exponent(1)], |row| row.facts.errors()[0];
        worst, [Hidden, Exponent(1)], |row| row.facts.errors()[1];
    });
    let rows: Vec<StudiedProgram<'_>> = results.programs().collect();
    captions::table("programs", &[], &columns, &rows)
}
