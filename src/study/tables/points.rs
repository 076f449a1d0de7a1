//! All programs and all placements, as plain tables.

use super::super::figures::zone;
use super::super::plan::{ChoiceKey, PriorityKey};
use super::super::results::{Results, time_us};
use super::super::table::{Cell, Table};

/// Every program.
pub(super) fn programs(results: &Results) -> Table {
    let rows = results.outcome.programs.values().map(|facts| {
        vec![
            Cell::text(&facts.model),
            Cell::text(&facts.pipeline),
            Cell::text(&facts.machine),
            Cell::count(facts.equations),
            Cell::count(facts.operations),
            Cell::count(facts.add_sub),
            Cell::count(facts.mul),
            Cell::count(facts.asap),
            Cell::count(facts.asap_cycle),
            Cell::count(facts.path_add),
            Cell::count(facts.path_mul),
            Cell::number(facts.number_y(), 2),
        ]
    });
    Table {
        name: "programs".to_owned(),
        title: "All programs".to_owned(),
        caption: "One row per model, pipeline and machine; sines and cosines come from the host \
            and are not counted."
            .to_owned(),
        columns: [
            "model",
            "pipeline",
            "machine",
            "equations",
            "operations",
            "additions",
            "multiplications",
            "ASAP",
            "ASAPCycle",
            "additions on the chain",
            "multiplications on the chain",
            "number Y",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows: rows.collect(),
    }
}

/// Every placement.
pub(super) fn points(results: &Results) -> Table {
    let all = results.outcome.points.iter();
    let rows = all.map(|(request, point)| {
        let machine = &results.plan.machines[request.machine];
        let placed = super::super::results::Placed { request, point };
        let facts = results.program(request.model, request.pipeline, request.machine);
        let zone = facts
            .filter(|_| point.failure.is_none())
            .map(|facts| zone(facts, placed));
        let memory = |kind: usize| Cell::number(point.kinds[kind].memory[2], 0);
        let buffer = |kind: usize| Cell::number(point.kinds[kind].buffer[2], 0);
        vec![
            Cell::text(&results.plan.models[request.model].name),
            Cell::text(&results.plan.pipelines[request.pipeline].name),
            Cell::text(&machine.name),
            Cell::count(request.n_add),
            Cell::count(request.n_multi),
            Cell::text(match request.priority {
                PriorityKey::Best => "best",
                PriorityKey::Alap => "alap",
                PriorityKey::FanOut => "fan-out",
                PriorityKey::Mobility => "mobility",
            }),
            Cell::text(match request.choice {
                ChoiceKey::Preferential => "preferential",
                ChoiceKey::First => "first",
            }),
            Cell::count(point.cycles),
            Cell::count(point.lower_bound),
            Cell::number(time_us(point, machine.machine.clock_mhz), 3),
            Cell::number(100.0 * point.rate, 1),
            memory(0),
            memory(1),
            buffer(0),
            buffer(1),
            Cell::count(point.direct_writes),
            Cell::count(point.indirect_writes),
            Cell::text(zone.map_or("", |zone| zone.name())),
            Cell::text(point.failure.as_deref().unwrap_or_default()),
        ]
    });
    Table {
        name: "points".to_owned(),
        title: "All placements".to_owned(),
        caption: "One row per placement; memory and buffer are the most words of an element."
            .to_owned(),
        columns: [
            "model",
            "pipeline",
            "machine",
            "adders",
            "multipliers",
            "order",
            "choice",
            "cycles",
            "lower bound",
            "time (µs)",
            "parallelisation rate (%)",
            "memory of adders (words)",
            "memory of multipliers (words)",
            "buffer of adders (words)",
            "buffer of multipliers (words)",
            "direct writes",
            "indirect writes",
            "zone",
            "failure",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows: rows.collect(),
    }
}
