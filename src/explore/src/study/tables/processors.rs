//! The array of elements and one core of a processor side by side.

use super::super::cpu::CpuTime;
use super::super::knee::{Split, knee};
use super::super::results::{Results, StudiedProgram};
use super::super::step::{PARTS, ROUNDS, StudyStep, placed, steps};
use super::placements::{costs, sum};
use crate::captions;
use crate::placing::with_elements;
use robovec_fpga::hardware::{Estimate, clock, estimated_clock_mhz};
use robovec_ir::Machine;
use robovec_present::{DataTable, columns};

/// Clock of the machine the thesis built (its section 1.3.4), MHz.
const BUILT_MHZ: f64 = 25.0;

/// The tables of times on one core; empty without measurements.
pub(in crate::study) fn tables(results: &Results, cpu: &[CpuTime]) -> Vec<DataTable> {
    let Some(first) = cpu.first() else {
        return Vec::new();
    };
    let tables = [
        winners(results, cpu, &first.processor),
        whole_steps(results, cpu, &first.processor),
        Some(programs(cpu, first)),
    ];
    tables.into_iter().flatten().collect()
}

/// Times of every program on one core.
fn programs(cpu: &[CpuTime], first: &CpuTime) -> DataTable {
    let columns = columns! { CpuTime;
        "model", [Hidden, All], |time| time.model.clone();
        "pipeline", [Hidden, All], |time| time.pipeline.clone();
        "operations", [Hidden, All], |time| time.operations;
        "straight-line C (µs)", [Hidden, Decimals(3)], |time| time.microseconds;
        "C with loops (µs)", [Hidden, Decimals(3)], |time| time.rolled;
        "batch C, per state (µs)", [Hidden, Decimals(3)], |time| time.batch;
        "remark", [Hidden, All], |time| time.remark.clone();
    };
    let words = [
        ("processor", first.processor.as_str()),
        ("compiler", &first.compiler),
    ];
    captions::table("cpu", &words, &columns, cpu)
}

/// A schedule on an array at the clock that is estimated for its machine.
struct ArrayTime {
    cycles: u32,
    clock: Estimate,
}

impl ArrayTime {
    fn of(cycles: u32, machine: &Machine) -> ArrayTime {
        ArrayTime {
            cycles,
            clock: estimated_clock_mhz(machine),
        }
    }

    /// With quick and with slow nets, µs.
    fn ends(&self) -> [f64; 2] {
        [self.clock.high, self.clock.low].map(|mhz| f64::from(self.cycles) / mhz)
    }

    fn text(&self) -> String {
        let [quick, slow] = self.ends();
        format!("{quick:.2} to {slow:.2}")
    }

    /// The faster one, and by which factor.
    fn winner(&self, processor: f64) -> String {
        let [quick, slow] = self.ends();
        let factors = |low: f64, high: f64| format!("{low:.1} to {high:.1} times");
        if quick > processor {
            let factors = factors(quick / processor, slow / processor);
            return format!("the processor, by {factors}");
        }
        if slow < processor {
            let factors = factors(processor / slow, processor / quick);
            return format!("the FPGA, by {factors}");
        }
        "neither: within the error of the estimate".to_owned()
    }
}

/// The fastest placed program of a model and its fastest C.
struct WinnerRow<'a> {
    placed: StudiedProgram<'a>,
    best: Split,
    array: ArrayTime,
    program: &'a CpuTime,
    single: f64,
    batch: Option<f64>,
}

/// For every model the fastest placed program and C, and which of them wins.
fn winners(results: &Results, cpu: &[CpuTime], processor: &str) -> Option<DataTable> {
    let machine = &results.plan.machines[results.main_machine()?];
    let row = |model: usize| {
        let own = results
            .ordinary()
            .filter(|program| program.place[0] == model);
        let placed = own.filter_map(|placed| Some((placed, knee(&placed)?.fastest?)));
        let (placed, best) = placed.min_by_key(|(_, split)| (split.cycles, split.elements()))?;
        let own = || (cpu.iter()).filter(|time| time.model == placed.subject().name);
        let times = own().filter_map(|time| Some((time.single()?, time)));
        let (single, program) = times.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let there = with_elements(&machine.machine, [best.n_add, best.n_multi]);
        Some(WinnerRow {
            placed,
            array: ArrayTime::of(best.cycles, &there),
            best,
            program,
            single,
            batch: own().filter_map(|time| time.batch).min_by(f64::total_cmp),
        })
    };
    let rows: Vec<WinnerRow<'_>> = (0..results.plan.models.len()).filter_map(row).collect();
    let clock =
        |row: &WinnerRow<'_>| format!("{:.0} to {:.0}", row.array.clock.low, row.array.clock.high);
    let columns = columns! { WinnerRow<'_>;
        "model", [Hidden, All], |row| row.placed.subject().name.as_str();
        "placed program", [Hidden, All], |row| row.placed.pipeline().name.as_str();
        "elements", [Hidden, All], |row| row.best.text();
        "cycles", [Hidden, All], |row| row.best.cycles;
        "FPGA as built (µs)", [Hidden, Decimals(2)], |row| f64::from(row.best.cycles) / BUILT_MHZ;
        "estimated clock (MHz)", [Hidden, All], clock;
        "FPGA estimated (µs)", [Hidden, All], |row| row.array.text();
    };
    let columns = columns.and(costs(
        |row: &WinnerRow<'_>| Some(row.best.share),
        |row| Some(row.placed),
    ));
    let columns = columns.and(columns! { WinnerRow<'_>;
        "C program", [Hidden, All], |row| row.program.pipeline.as_str();
        "one core (µs)", [Hidden, Decimals(3)], |row| row.single;
        "one core, batch (µs)", [Hidden, Decimals(3)], |row| row.batch;
        "who wins", [Hidden, All], |row| row.array.winner(row.single);
    });
    let words = [
        ("machine", machine.name.as_str()),
        ("built", &BUILT_MHZ.to_string()),
        ("processor", processor),
    ];
    Some(captions::table("winners", &words, &columns, &rows))
}

/// The fastest placement of a step, and its time on one core.
struct StepWinner<'a> {
    program: StudiedProgram<'a>,
    counts: [u32; 2],
    share: f64,
    microseconds: f64,
    array: ArrayTime,
    core: f64,
}

/// For every step and machine the fastest placement and C, and which wins.
fn whole_steps(results: &Results, cpu: &[CpuTime], processor: &str) -> Option<DataTable> {
    let mut rows: Vec<StepWinner<'_>> = Vec::new();
    for step in steps(results) {
        rows.extend((0..results.plan.machines.len()).filter_map(|machine| {
            let all = (0..results.plan.pipelines.len()).flat_map(|pipeline| {
                let all = placed(results, &step, pipeline, machine);
                all.into_iter().map(move |placed| (pipeline, placed))
            });
            let (pipeline, best) = all.min_by_key(|(_, placed)| placed.cycles)?;
            let there = best.accelerations().machine();
            Some(StepWinner {
                program: results.program([step.accelerations(), pipeline, machine])?,
                counts: best.accelerations().counts(),
                share: best.share(),
                microseconds: clock(&there).microseconds(best.cycles),
                array: ArrayTime::of(best.cycles, &there),
                core: one_core(results, &step, cpu)?,
            })
        }));
    }
    let columns = columns! { StepWinner<'_>;
        "system", [Hidden, All], |row| row.program.subject().source.as_str();
        "machine", [Hidden, All], |row| row.program.facts.machine.as_str();
        "pipeline", [Hidden, All], |row| row.program.pipeline().name.as_str();
        "adders + multipliers", [Hidden, All], |row| sum(row.counts);
        "cycles", [Hidden, All], |row| row.array.cycles;
        "FPGA (µs)", [Hidden, Decimals(3)], |row| row.microseconds;
        "FPGA, estimated (µs)", [Hidden, All], |row| row.array.text();
    };
    let columns = columns.and(costs(
        |row: &StepWinner<'_>| Some(row.share),
        |row| Some(row.program),
    ));
    let columns = columns.and(columns! { StepWinner<'_>;
        "one core (µs)", [Hidden, Decimals(3)], |row| row.core;
        "who wins", [Hidden, All], |row| row.array.winner(row.core);
    });
    let words = [("processor", processor), ("rounds", &ROUNDS.to_string())];
    captions::filled("whole-step-cpu", &words, &columns, &rows)
}

/// Time of a step on one core, by the fastest programs, µs; `None` untimed.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_winner_has_a_range() {
        let array = |low: f64, high: f64| ArrayTime {
            cycles: 12,
            clock: Estimate {
                low: 12.0 / high,
                mid: 12.0 / high,
                high: 12.0 / low,
            },
        };
        let winner = |low, high, processor| array(low, high).winner(processor);
        assert_eq!(winner(4.0, 6.0, 2.0), "the processor, by 2.0 to 3.0 times");
        assert_eq!(winner(1.0, 2.0, 6.0), "the FPGA, by 3.0 to 6.0 times");
        assert!(winner(1.0, 3.0, 2.0).starts_with("neither"));
    }
}
