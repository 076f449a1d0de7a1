//! What the pipelines do to the rounding errors.

use super::super::results::Results;
use super::super::table::{Cell, Table};
use robovec_analysis::rounding::Change;

pub(super) fn table(results: &Results) -> Option<Table> {
    let machine = results.main_machine()?;
    let name = &results.plan.machines[machine].name;
    let programs = results.outcome.programs.values();
    let rows: Vec<Vec<Cell>> = programs
        .filter(|facts| facts.machine == *name)
        .map(|facts| {
            let [read, now] = &facts.rounding;
            let change = Change::relative(read, now);
            vec![
                Cell::text(&facts.model),
                Cell::text(&facts.pipeline),
                Cell::count(facts.operations),
                Cell::count(facts.asap_cycle),
                Cell::number(read.relative.median, 2),
                Cell::number(now.relative.median, 2),
                Cell::number(now.relative.percentile_99, 0),
                Cell::number(read.normwise.median, 2),
                Cell::number(now.normwise.median, 2),
                Cell::number(now.normwise.worst, 1),
                Cell::number(change.ratio, 3),
                Cell::number(change.noise, 3),
                Cell::text(change.trend.name()),
            ]
        })
        .collect();
    (!rows.is_empty()).then(|| Table {
        name: "errors".to_owned(),
        title: "Speed against error".to_owned(),
        caption: "Rounding errors in binary32, all outputs in all states as one population, in \
            units of the rounding of one operation, 2^-24: relative to the element, and \
            normwise to the largest element of its array. Better and worse mean that the \
            relative median changed by more than 2 % and 3.5 times its noise."
            .to_owned(),
        columns: [
            "model",
            "pipeline",
            "operations",
            "ASAPCycle",
            "median as read",
            "median",
            "99 %",
            "normwise median as read",
            "normwise median",
            "normwise worst",
            "median over as read",
            "noise",
            "trend",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows,
    })
}
