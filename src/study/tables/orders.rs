//! Table 2.2: cycles by the classical order and with mobility first.

use super::super::plan::{ChoiceKey, Printed, PriorityKey};
use super::super::printed::thesis;
use super::super::results::Results;
use super::super::table::{Cell, Table};

pub(super) fn table(results: &Results) -> Option<Table> {
    let model = results.plan.headline;
    let pipeline = results.pipeline(Printed::Original).unwrap_or(0);
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
            Some(place) if printed => Cell::count(cycles[place]),
            _ => Cell::Empty,
        };
        let ratio = match place {
            Some(place) if printed => {
                Cell::number(f64::from(alap) / f64::from(orders.alap[place]), 3)
            }
            _ => Cell::Empty,
        };
        Some(vec![
            Cell::text(format!("{count}+{count} ({})", 2 * count)),
            Cell::count(alap),
            Cell::count(mobility),
            cycles(PriorityKey::Best, count).map_or(Cell::Empty, |(best, _)| Cell::count(best)),
            Cell::count(bound),
            thesis(&orders.alap),
            thesis(&orders.mobility),
            ratio,
        ])
    });
    let rows: Vec<Vec<Cell>> = rows.collect();
    (!rows.is_empty()).then(|| Table {
        name: "table-2.2".to_owned(),
        title: format!(
            "Table 2.2: cycles by order of placement, {}",
            results.plan.models[model].name
        ),
        caption: "Elements count per kind: 4+4 are the thesis' 8 processing elements. No schedule \
            is shorter than the bound, which is proved. The thesis' saturation, 743 cycles, is \
            its ASAPCycle of 737 plus 6 cycles of start-up that its text does not explain; ours \
            is the longest chain itself."
            .to_owned(),
        columns: [
            "elements",
            "classical: ALAP, ASAP",
            "mobility first",
            "best of several",
            "lower bound",
            "thesis, classical",
            "thesis, mobility",
            "classical / thesis",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows,
    })
}
