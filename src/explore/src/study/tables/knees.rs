//! Number of elements that each program is worth.

use super::super::captions;
use super::super::cost;
use super::super::figures::{best_splits, grid, ladder};
use super::super::knee::{Split, knee};
use super::super::results::Results;
use crate::operators::{MEMORY_CAP_MHZ, couples};
use robovec_present::{DataCell, DataTable};

/// The knee of every program.
pub(super) fn table(results: &Results) -> Option<DataTable> {
    let machine = results.main_machine()?;
    let clock = results.plan.machines[machine].clock();
    let mut rows = Vec::new();
    for model in 0..results.plan.models.len() {
        for pipeline in 0..results.plan.pipelines.len() {
            let Some((facts, knee)) = results
                .program(model, pipeline, machine)
                .zip(knee(results, model, pipeline, machine))
            else {
                continue;
            };
            let text = |split: Option<Split>| match split {
                Some(split) => DataCell::text(split.text()),
                None => DataCell::Empty,
            };
            let number = |value: Option<f64>, decimals| {
                value.map_or(DataCell::Empty, |value| DataCell::number(value, decimals))
            };
            let time = |split: Split| clock.microseconds(split.cycles);
            let mut row = vec![
                DataCell::text(&facts.model),
                DataCell::text(&facts.pipeline),
                DataCell::number(knee.number_y, 2),
                text(knee.busiest),
                text(knee.equal),
                DataCell::text(if knee.is_exact { "yes" } else { "no" }),
                text(knee.cheapest),
                knee.cheapest
                    .map_or(DataCell::Empty, |split| DataCell::count(split.cycles)),
                number(knee.cheapest.map(time), 3),
                number(knee.cheapest.map(|split| 100.0 * split.rate), 1),
                number(
                    knee.single.zip(knee.cheapest).map(|(single, best)| {
                        f64::from(single.cycles) / f64::from(best.cycles.max(1))
                    }),
                    1,
                ),
            ];
            let share = knee.cheapest.map(|split| split.share);
            row.splice(9..9, cost::cells(share, Some(facts)));
            rows.push(row);
        }
    }
    captions::filled("knee", &[("clock", &clock.text())], rows)
}

/// The best split of each total.
pub(super) fn splits(results: &Results) -> Option<DataTable> {
    let model = results.plan.headline;
    let mut rows = Vec::new();
    for pipeline in 0..results.plan.pipelines.len() {
        let all = grid(results, model, pipeline);
        let largest = all
            .iter()
            .map(|placed| placed.request.n_add)
            .max()
            .unwrap_or(0);
        for best in best_splits(&all) {
            let equal = all
                .iter()
                .find(|placed| placed.is_equal() && placed.elements() == best.elements());
            if best.elements() > largest + 1 {
                continue;
            }
            let cycles = |cycles: Option<u32>| cycles.map_or(DataCell::Empty, DataCell::count);
            let equal = equal.map(|placed| placed.point.cycles);
            let gain = equal.map_or(DataCell::Empty, |equal| {
                DataCell::number(
                    100.0 * (1.0 - f64::from(best.point.cycles) / f64::from(equal)),
                    1,
                )
            });
            rows.push(vec![
                DataCell::text(&results.plan.pipelines[pipeline].name),
                DataCell::count(best.elements()),
                DataCell::count(best.request.n_add),
                DataCell::count(best.request.n_multi),
                DataCell::count(best.point.cycles),
                DataCell::number(100.0 * cost::share(results, best), 2),
                cycles(equal),
                gain,
            ]);
        }
    }
    captions::filled("split", &[("headline", captions::headline(results))], rows)
}

/// All couples of Table 1.3, with and without the cap.
pub(super) fn couples_table(results: &Results) -> Option<DataTable> {
    let model = results.plan.headline;
    let mut rows = Vec::new();
    for pipeline in 0..results.plan.pipelines.len() {
        for couple in couples() {
            let machines = &results.plan.machines;
            let Some(machine) = machines
                .iter()
                .position(|machine| machine.couple == Some(couple.stages()))
            else {
                continue;
            };
            let Some(facts) = results.program(model, pipeline, machine) else {
                continue;
            };
            let placed = ladder(results, model, pipeline, machine);
            let Some(best) = placed
                .iter()
                .min_by_key(|placed| (placed.point.cycles, placed.elements()))
            else {
                continue;
            };
            let [add, multi] = couple.stages();
            let capped = couple.mhz().min(MEMORY_CAP_MHZ);
            let time =
                |cycles: u32, mhz: u32| DataCell::number(f64::from(cycles) / f64::from(mhz), 3);
            let mut row = vec![
                DataCell::text(&results.plan.pipelines[pipeline].name),
                DataCell::text(format!("{add}+{multi}")),
                DataCell::count(couple.mhz()),
                DataCell::count(facts.asap_cycle),
                time(facts.asap_cycle, couple.mhz()),
                time(facts.asap_cycle, capped),
                DataCell::number(facts.number_y(), 2),
                DataCell::text(format!("{}+{}", best.request.n_add, best.request.n_multi)),
                time(best.point.cycles, couple.mhz()),
                time(best.point.cycles, capped),
            ];
            row.extend(cost::cells(Some(cost::share(results, *best)), Some(facts)));
            rows.push(row);
        }
    }
    captions::filled(
        "couples",
        &[("headline", captions::headline(results))],
        rows,
    )
}
