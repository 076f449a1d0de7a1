//! Table 2.2: cycles by the classical order and with mobility first.

use super::super::captions;
use super::super::plan::{ChoiceKey, PriorityKey};
use super::super::printed::thesis;
use super::super::results::Results;
use robovec_present::{DataCell, DataTable};

pub(super) fn table(results: &Results) -> Option<DataTable> {
    let model = results.plan.headline;
    let pipeline = results.original();
    let machine = results.main_machine()?;
    let cycles = |priority: PriorityKey, count: u32| {
        let mut placed = results.placed();
        let found = placed.find(|placed| {
            let request = placed.request;
            (request.model, request.pipeline, request.machine) == (model, pipeline, machine)
                && (request.n_add, request.n_multi) == (count, count)
                && (request.priority, request.choice) == (priority, ChoiceKey::Preferential)
        });
        found.map(|placed| (placed.point.cycles, placed.point.lower_bound))
    };
    let mut counts: Vec<u32> = results
        .placed()
        .filter(|placed| placed.request.model == model && placed.is_equal())
        .map(|placed| placed.request.n_add)
        .collect();
    counts.sort_unstable();
    counts.dedup();
    let printed = results
        .system(model)
        .is_some_and(|system| system.name == "23-dof railway-bogie");
    let rows = counts.into_iter().filter_map(|count| {
        let (alap, bound) = cycles(PriorityKey::Alap, count)?;
        let (mobility, _) = cycles(PriorityKey::Mobility, count)?;
        let orders = &thesis().table_2_2;
        let place = orders.elements.iter().position(|&known| known == count);
        let thesis = |cycles: &[u32]| match place {
            Some(place) if printed => DataCell::count(cycles[place]),
            _ => DataCell::Empty,
        };
        let ratio = match place {
            Some(place) if printed => {
                DataCell::number(f64::from(alap) / f64::from(orders.alap[place]), 3)
            }
            _ => DataCell::Empty,
        };
        Some(vec![
            DataCell::text(format!("{count}+{count} ({})", 2 * count)),
            DataCell::count(alap),
            DataCell::count(mobility),
            cycles(PriorityKey::Best, count)
                .map_or(DataCell::Empty, |(best, _)| DataCell::count(best)),
            DataCell::count(bound),
            thesis(&orders.alap),
            thesis(&orders.mobility),
            ratio,
        ])
    });
    captions::filled(
        "table-2.2",
        &[("headline", captions::headline(results))],
        rows,
    )
}
