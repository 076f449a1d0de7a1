//! The whole step on the array of elements and on one core.

use super::super::captions;
use super::super::cost;
use super::super::results::Results;
use super::super::step::{PARTS, StudyStep, placed, steps};
use super::super::tables::whole_step::step_share;
use super::CpuTime;
use super::table::winner;
use robovec_fpga::hardware::{clock, estimated_clock_mhz};
use robovec_present::{DataCell, DataTable};

/// For every step and machine the fastest placement, one core's time, and
/// which of them wins.
pub fn table(results: &Results, cpu: &[CpuTime]) -> Option<DataTable> {
    let first = cpu.first()?;
    let mut rows = Vec::new();
    for step in steps(results) {
        for machine in 0..results.plan.machines.len() {
            rows.extend(row(results, &step, machine, cpu));
        }
    }
    captions::filled("whole-step-cpu", &[("processor", &first.processor)], rows)
}

fn row(
    results: &Results,
    step: &StudyStep,
    machine: usize,
    cpu: &[CpuTime],
) -> Option<Vec<DataCell>> {
    let plan = &results.plan;
    let pipelines = 0..plan.pipelines.len();
    let all = pipelines.flat_map(|pipeline| {
        let all = placed(results, step, pipeline, machine);
        all.into_iter().map(move |placed| (pipeline, placed))
    });
    let (pipeline, best) = all.min_by_key(|(_, placed)| placed.cycles)?;
    let core = one_core(results, step, cpu)?;
    let request = best.accelerations().request;
    let model = step.accelerations();
    let clock_there = clock(&best.machine(results));
    let estimate = estimated_clock_mhz(&best.machine(results));
    let time = |mhz: f64| f64::from(best.cycles) / mhz;
    let [quick, slow] = [time(estimate.high), time(estimate.low)];
    let mut row = vec![
        DataCell::text(&plan.models[model].source),
        DataCell::text(&plan.machines[machine].name),
        DataCell::text(&plan.pipelines[pipeline].name),
        DataCell::text(format!("{}+{}", request.n_add, request.n_multi)),
        DataCell::count(best.cycles),
        DataCell::number(clock_there.microseconds(best.cycles), 3),
        DataCell::text(format!("{quick:.2} to {slow:.2}")),
    ];
    let facts = results.program(model, pipeline, machine);
    row.extend(cost::cells(Some(step_share(results, &best)), facts));
    row.push(DataCell::number(core, 3));
    row.push(DataCell::text(winner([quick, slow], core)));
    Some(row)
}

/// The time of a step on one core: of each function the fastest program, as
/// often as it is called, µs. `None` where one was not timed.
fn one_core(results: &Results, step: &StudyStep, cpu: &[CpuTime]) -> Option<f64> {
    let mut sum = 0.0;
    for (model, (_, calls)) in step.models.iter().zip(PARTS) {
        let Some(model) = *model else { continue };
        let name = &results.plan.models[model].name;
        let times = cpu.iter().filter(|time| time.model == *name);
        let least = times.filter_map(CpuTime::single).min_by(f64::total_cmp)?;
        sum += least * f64::from(calls);
    }
    Some(sum)
}
