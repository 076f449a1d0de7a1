//! Formulations of the same system, compared.

use super::super::captions;
use super::super::cost;
use super::super::knee::knee;
use super::super::results::Results;
use super::super::variants;
use robovec_present::{DataCell, DataTable};

pub(super) fn table(results: &Results) -> Option<DataTable> {
    let machine = results.main_machine()?;
    let clock = results.plan.machines[machine].clock();
    let mut rows = Vec::new();
    for group in variants::groups(results) {
        for pipeline in 0..results.plan.pipelines.len() {
            let first = results.program(group[0], pipeline, machine);
            for &model in &group {
                let Some(facts) = results.program(model, pipeline, machine) else {
                    continue;
                };
                let subject = &results.plan.models[model];
                let knee = knee(results, model, pipeline, machine);
                let worth = knee.as_ref().and_then(|knee| knee.cheapest);
                let ratio = |own: f64, first: Option<f64>| {
                    first.map_or(DataCell::Empty, |first| DataCell::number(own / first, 3))
                };
                let time = |cycles: u32| DataCell::number(clock.microseconds(cycles), 2);
                let mut row = vec![
                    DataCell::text(&subject.source),
                    DataCell::text(variants::label(subject)),
                    DataCell::text(&facts.pipeline),
                    DataCell::count(facts.operations),
                    DataCell::count(facts.asap_cycle),
                    DataCell::number(facts.number_y(), 2),
                    ratio(
                        facts.operations as f64,
                        first.map(|first| first.operations as f64),
                    ),
                    ratio(
                        f64::from(facts.asap_cycle),
                        first.map(|first| f64::from(first.asap_cycle)),
                    ),
                    worth.map_or(DataCell::Empty, |split| DataCell::text(split.text())),
                    worth.map_or(DataCell::Empty, |split| time(split.cycles)),
                    knee.and_then(|knee| knee.single)
                        .map_or(DataCell::Empty, |single| time(single.cycles)),
                ];
                row.splice(
                    10..10,
                    cost::cells(worth.map(|split| split.share), Some(facts)),
                );
                rows.push(row);
            }
        }
    }
    captions::filled("formulations", &[("clock", &clock.text())], rows)
}
