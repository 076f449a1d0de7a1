//! Effect of the pipelines on the rounding errors.

use super::super::captions;
use super::super::results::Results;
use robovec_analysis::rounding::MedianChange;
use robovec_present::{DataCell, DataTable};

pub(super) fn table(results: &Results) -> Option<DataTable> {
    let machine = results.main_machine()?;
    let name = &results.plan.machines[machine].name;
    let programs = results.outcome.programs.values();
    let rows = programs
        .filter(|facts| facts.machine == *name)
        .map(|facts| {
            let [read, now] = &facts.rounding;
            let change = MedianChange::relative(read, now);
            vec![
                DataCell::text(&facts.model),
                DataCell::text(&facts.pipeline),
                DataCell::count(facts.operations),
                DataCell::count(facts.asap_cycle),
                DataCell::number(read.relative.median, 2),
                DataCell::number(now.relative.median, 2),
                DataCell::number(now.relative.percentile_99, 0),
                DataCell::number(read.normwise.median, 2),
                DataCell::number(now.normwise.median, 2),
                DataCell::number(now.normwise.worst, 1),
                DataCell::number(change.ratio, 3),
                DataCell::number(change.noise, 3),
                DataCell::text(change.trend.name()),
            ]
        });
    captions::filled("errors", &[], rows)
}
