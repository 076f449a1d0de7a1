//! All programs and all placements, as plain tables.

use super::super::captions;
use super::super::cost;
use super::super::plan::{ChoiceKey, PriorityKey};
use super::super::results::{Results, time_us};
use super::super::zone::zone;
use robovec_present::{DataCell, DataTable};

/// Every program.
pub(super) fn programs(results: &Results) -> DataTable {
    let rows = results.outcome.programs.values().map(|facts| {
        let mut row = vec![
            DataCell::text(&facts.model),
            DataCell::text(&facts.pipeline),
            DataCell::text(&facts.machine),
            DataCell::count(facts.equations),
            DataCell::count(facts.operations),
            DataCell::count(facts.add_sub),
            DataCell::count(facts.mul),
            DataCell::count(facts.asap),
            DataCell::count(facts.asap_cycle),
            DataCell::count(facts.path_add),
            DataCell::count(facts.path_mul),
            DataCell::number(facts.number_y(), 2),
        ];
        row.extend(cost::cells(None, Some(facts)).into_iter().skip(1));
        row
    });
    captions::table("programs", &[], rows)
}

/// Every placement.
pub(super) fn points(results: &Results) -> DataTable {
    let all = results.outcome.points.iter();
    let rows = all.map(|(request, point)| {
        let machine = &results.plan.machines[request.machine];
        let placed = super::super::results::StudyPlacement { request, point };
        let facts = results.program(request.model, request.pipeline, request.machine);
        let zone = facts
            .filter(|_| point.failure.is_none())
            .map(|facts| zone(facts, placed));
        let memory = |kind: usize| DataCell::number(point.kinds[kind].memory[2], 0);
        let buffer = |kind: usize| DataCell::number(point.kinds[kind].buffer[2], 0);
        let share = point
            .failure
            .is_none()
            .then(|| cost::share(results, placed));
        let mut row = vec![
            DataCell::text(&results.plan.models[request.model].name),
            DataCell::text(&results.plan.pipelines[request.pipeline].name),
            DataCell::text(&machine.name),
            DataCell::count(request.n_add),
            DataCell::count(request.n_multi),
            DataCell::text(match request.priority {
                PriorityKey::Best => "best",
                PriorityKey::Alap => "alap",
                PriorityKey::FanOut => "fan-out",
                PriorityKey::Mobility => "mobility",
            }),
            DataCell::text(match request.choice {
                ChoiceKey::Preferential => "preferential",
                ChoiceKey::First => "first",
            }),
            DataCell::count(point.cycles),
            DataCell::count(point.lower_bound),
            DataCell::text(machine.clock().text()),
            DataCell::number(time_us(point, machine.clock().mhz), 3),
            DataCell::number(100.0 * point.rate, 1),
            memory(0),
            memory(1),
            buffer(0),
            buffer(1),
            DataCell::count(point.direct_writes),
            DataCell::count(point.indirect_writes),
            DataCell::text(zone.map_or("", |zone| zone.name())),
            DataCell::text(point.failure.as_deref().unwrap_or_default()),
        ];
        row.splice(11..11, cost::cells(share, facts));
        row
    });
    captions::table("points", &[], rows)
}
