//! The whole step of systems: loops closed, then accelerations.

use super::super::captions;
use super::super::cost;
use super::super::results::Results;
use super::super::step::{PARTS, PlacedStep, placed, steps};
use super::super::variants;
use robovec_fpga::hardware::clock;
use robovec_present::{DataCell, DataTable};

/// Share of its device that the machine of a step takes: that of the function
/// that takes most.
pub(in crate::study) fn step_share(results: &Results, placed: &PlacedStep<'_>) -> f64 {
    let parts = placed.parts.iter().flatten();
    parts
        .map(|part| cost::share(results, *part))
        .fold(0.0, f64::max)
}

pub(super) fn table(results: &Results) -> Option<DataTable> {
    let plan = &results.plan;
    let mut rows = Vec::new();
    for step in steps(results) {
        for pipeline in 0..plan.pipelines.len() {
            for machine in 0..plan.machines.len() {
                let all = placed(results, &step, pipeline, machine);
                let first = all.first().map(|first| first.cycles);
                for placed in &all {
                    let Some(first) = first else { continue };
                    let model = step.accelerations();
                    let facts = results.program(model, pipeline, machine);
                    let clock = clock(&placed.machine(results));
                    let request = placed.accelerations().request;
                    let mut row = vec![
                        DataCell::text(&plan.models[model].source),
                        DataCell::text(variants::label(&plan.models[model])),
                        DataCell::text(&plan.pipelines[pipeline].name),
                        DataCell::text(&plan.machines[machine].name),
                        DataCell::text(format!("{}+{}", request.n_add, request.n_multi)),
                    ];
                    row.extend(placed.parts.map(|part| {
                        part.map_or(DataCell::Empty, |part| DataCell::count(part.point.cycles))
                    }));
                    row.extend([
                        DataCell::count(placed.cycles),
                        DataCell::number(f64::from(first) / f64::from(placed.cycles.max(1)), 2),
                        DataCell::text(clock.text()),
                        DataCell::number(clock.microseconds(placed.cycles), 3),
                    ]);
                    row.extend(cost::cells(Some(step_share(results, placed)), facts));
                    rows.push(row);
                }
            }
        }
    }
    let [positions, velocities, accelerations] = PARTS.map(|(kind, _)| kind.name());
    let words = [
        ("positions", positions),
        ("velocities", velocities),
        ("accelerations", accelerations),
    ];
    captions::filled("whole-step", &words, rows)
}
