//! Formulations of the same system, compared.

use super::super::knee::knee;
use super::super::results::Results;
use super::super::table::{Cell, Table};
use super::super::variants;

pub(super) fn table(results: &Results) -> Option<Table> {
    let machine = results.main_machine()?;
    let mhz = results.plan.machines[machine].machine.clock_mhz;
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
                    first.map_or(Cell::Empty, |first| Cell::number(own / first, 3))
                };
                let time = |cycles: u32| Cell::number(f64::from(cycles) / mhz, 2);
                rows.push(vec![
                    Cell::text(&subject.source),
                    Cell::text(variants::label(subject)),
                    Cell::text(&facts.pipeline),
                    Cell::count(facts.operations),
                    Cell::count(facts.asap_cycle),
                    Cell::number(facts.number_y(), 2),
                    ratio(
                        facts.operations as f64,
                        first.map(|first| first.operations as f64),
                    ),
                    ratio(
                        f64::from(facts.asap_cycle),
                        first.map(|first| f64::from(first.asap_cycle)),
                    ),
                    worth.map_or(Cell::Empty, |split| Cell::text(split.text())),
                    worth.map_or(Cell::Empty, |split| time(split.cycles)),
                    knee.and_then(|knee| knee.single)
                        .map_or(Cell::Empty, |single| time(single.cycles)),
                ]);
            }
        }
    }
    (!rows.is_empty()).then(|| Table {
        name: "formulations".to_owned(),
        title: "Formulations of the same systems".to_owned(),
        caption: "Other recursions for the same function. Ratios are to the first formulation of \
            each system and pipeline. All but the first use that sin^2 + cos^2 = 1, which the \
            thesis' machine with sin x = x does not keep."
            .to_owned(),
        columns: [
            "system",
            "formulation",
            "pipeline",
            "operations",
            "ASAPCycle",
            "number Y",
            "ratio operations",
            "ratio ASAPCycle",
            "worth",
            "time there (µs)",
            "time with 1+1 (µs)",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows,
    })
}
