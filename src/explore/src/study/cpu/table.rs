//! The array of elements and the processor side by side.

use super::super::captions;
use super::super::cost;
use super::super::knee::{Split, knee};
use super::super::plan::StudyPlan;
use super::super::results::Results;
use super::CpuTime;
use robovec_fpga::hardware::{Estimate, estimated_clock_mhz};
use robovec_ir::Machine;
use robovec_present::{DataCell, DataTable};

/// Clock of the machine the thesis built (its section 1.3.4), MHz.
const BUILT_MHZ: f64 = 25.0;

/// Times of every program on one core.
pub fn programs(cpu: &[CpuTime]) -> Option<DataTable> {
    let first = cpu.first()?;
    let number =
        |value: Option<f64>| value.map_or(DataCell::Empty, |value| DataCell::number(value, 3));
    let rows = cpu.iter().map(|time| {
        vec![
            DataCell::text(&time.model),
            DataCell::text(&time.pipeline),
            DataCell::count(time.operations),
            number(time.microseconds),
            number(time.rolled),
            number(time.batch),
            DataCell::text(&time.remark),
        ]
    });
    let words = [
        ("processor", first.processor.as_str()),
        ("compiler", &first.compiler),
    ];
    Some(captions::table("cpu", &words, rows))
}

/// For every model the fastest placed program and the fastest C, and which of
/// them wins.
pub fn winners(results: &Results, cpu: &[CpuTime]) -> Option<DataTable> {
    let first = cpu.first()?;
    let machine = results.main_machine()?;
    let plan = &results.plan;
    let models = 0..plan.models.len();
    let rows = models.filter_map(|model| row(results, model, machine, cpu));
    let words = [
        ("machine", plan.machines[machine].name.as_str()),
        ("built", &BUILT_MHZ.to_string()),
        ("processor", &first.processor),
    ];
    Some(captions::table("winners", &words, rows))
}

fn row(results: &Results, model: usize, machine: usize, cpu: &[CpuTime]) -> Option<Vec<DataCell>> {
    let plan = &results.plan;
    let name = &plan.models[model].name;
    let (pipeline, best) = fastest(results, model, machine)?;
    let own = || cpu.iter().filter(|time| time.model == *name);
    let times = own().filter_map(|time| Some((time.single()?, time)));
    let (single, program) = times.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let batch = own().filter_map(|time| time.batch).min_by(f64::total_cmp);
    let clock = clock(plan, machine, &best);
    let time = |mhz: f64| f64::from(best.cycles) / mhz;
    let facts = results.program(model, pipeline, machine);
    let mut row = vec![
        DataCell::text(name),
        DataCell::text(&plan.pipelines[pipeline].name),
        DataCell::text(best.text()),
        DataCell::count(best.cycles),
        DataCell::number(time(BUILT_MHZ), 2),
        DataCell::text(format!("{:.0} to {:.0}", clock.low, clock.high)),
        DataCell::text(format!("{:.2} to {:.2}", time(clock.high), time(clock.low))),
        DataCell::text(&program.pipeline),
        DataCell::number(single, 3),
        batch.map_or(DataCell::Empty, |batch| DataCell::number(batch, 3)),
        DataCell::text(winner([time(clock.high), time(clock.low)], single)),
    ];
    row.splice(7..7, cost::cells(Some(best.share), facts));
    Some(row)
}

/// The pipeline with the fewest cycles, and the elements it needs.
fn fastest(results: &Results, model: usize, machine: usize) -> Option<(usize, Split)> {
    let pipelines = 0..results.plan.pipelines.len();
    let placed = pipelines.filter_map(|pipeline| {
        let knee = knee(results, model, pipeline, machine)?;
        Some((pipeline, knee.fastest?))
    });
    placed.min_by_key(|(_, split)| (split.cycles, split.elements()))
}

/// The clock of the machine with these elements.
fn clock(plan: &StudyPlan, machine: usize, split: &Split) -> Estimate {
    let mut machine: Machine = plan.machines[machine].machine.clone();
    for element in &mut machine.elements {
        element.count = if element.operations.iter().any(|name| name == "mul") {
            split.n_multi
        } else {
            split.n_add
        };
    }
    estimated_clock_mhz(&machine)
}

/// Who needs less time, and by what factor; `array` from the quickest to the
/// slowest estimate.
pub(super) fn winner(array: [f64; 2], processor: f64) -> String {
    let [quick, slow] = array;
    let factors = |low: f64, high: f64| format!("{low:.1} to {high:.1} times");
    if quick > processor {
        return format!(
            "the processor, by {}",
            factors(quick / processor, slow / processor)
        );
    }
    if slow < processor {
        return format!(
            "the FPGA, by {}",
            factors(processor / slow, processor / quick)
        );
    }
    "neither: within the error of the estimate".to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_winner_is_said_with_its_range() {
        assert_eq!(
            winner([4.0, 6.0], 2.0),
            "the processor, by 2.0 to 3.0 times"
        );
        assert_eq!(winner([1.0, 2.0], 6.0), "the FPGA, by 3.0 to 6.0 times");
        assert!(winner([1.0, 3.0], 2.0).starts_with("neither"));
    }
}
