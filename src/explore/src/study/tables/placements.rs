//! Tables with a row for every placement, or for several that are compared.

use super::super::plan::PlacementRequest;
use super::super::printed::thesis;
use super::super::results;
use super::super::results::{Results, StudiedProgram, StudyPlacement};
use super::super::step::{PARTS, PlacedStep, ROUNDS, placed, steps};
use crate::captions;
use crate::operators::{Couple, MEMORY_CAP_MHZ, couples as all_couples};
use robovec_error::yardstick::account::ERROR_HEADS;
use robovec_fpga::hardware::{MachineClock, clock};
use robovec_framework::options::OptionValue;
use robovec_present::{ColumnList, DataTable, Digits, columns};
use robovec_schedule::{PlaceOptions, Priority};

/// Share of the device and errors, of rows that have a share and a program.
pub(super) fn costs<'a, R: 'a>(
    share: impl Fn(&R) -> Option<f64> + 'a,
    program: impl Fn(&R) -> Option<StudiedProgram<'a>> + Clone + 'a,
) -> ColumnList<'a, R> {
    let [median, worst] = ERROR_HEADS;
    let errors = move |row: &R| Some(program(row)?.facts.errors());
    let worst_error = errors.clone();
    columns! { R;
        "share of device (%)", [Hidden, Decimals(2)], move |row| Some(100.0 * share(row)?);
        median, [Hidden, Exponent(1)], move |row| Some(errors(row)?[0]);
        worst, [Hidden, Exponent(1)], move |row| Some(worst_error(row)?[1]);
    }
}

/// `4+4`.
pub(super) fn sum([add, multi]: [u32; 2]) -> String {
    format!("{add}+{multi}")
}

/// Table 2.1: preference and frequency of ranks; status of both operands.
const RANKS: [[&str; 2]; 9] = [
    ["memory", "memory"],
    ["memory", "direct"],
    ["direct", "memory"],
    ["direct", "direct"],
    ["memory", "indirect"],
    ["indirect", "memory"],
    ["direct", "indirect"],
    ["indirect", "direct"],
    ["indirect", "indirect"],
];

pub(super) fn ranks(results: &Results) -> Option<DataTable> {
    let placed = results.original_headline()?.ladder();
    let mut columns = columns! { usize;
        "rank", [Hidden, All], |rank| rank + 1;
        "left operand", [Hidden, All], |rank| RANKS[*rank][0];
        "right operand", [Hidden, All], |rank| RANKS[*rank][1];
    };
    for placed in &placed {
        let head = format!("{} (% of operations)", sum(placed.counts()));
        let ranks = placed.point.ranks;
        let total: u32 = ranks.iter().sum();
        let share = move |rank: &usize| 100.0 * f64::from(ranks[*rank]) / f64::from(total.max(1));
        columns = columns.with(head, Digits::Hidden, Digits::Decimals(1), share);
    }
    let words = [("headline", results.headline())];
    let rows: Vec<usize> = (0..RANKS.len()).collect();
    (!placed.is_empty()).then(|| captions::table("table-2.1", &words, &columns, &rows))
}

/// Cycles with a number of elements of each kind, by order of placement.
struct OrderRow {
    count: u32,
    alap: u32,
    mobility: u32,
    best: Option<u32>,
    bound: u32,
    /// Cycles of the thesis: by the classical order, and with mobility first.
    thesis: Option<[u32; 2]>,
}

/// Table 2.2: cycles by the classical order and with mobility first.
pub(super) fn orders(results: &Results) -> Option<DataTable> {
    let (model, machine) = (results.plan.headline, results.main_machine()?);
    let found = |priority: Priority, count: u32| {
        let request = PlacementRequest {
            model,
            pipeline: results.original(),
            machine,
            n_add: count,
            n_multi: count,
            options: PlaceOptions {
                priority,
                ..PlaceOptions::default()
            },
        };
        let point = results.outcome.points.get(&request);
        point.filter(|point| point.failure.is_none())
    };
    let own = results.placed();
    let own = own.filter(|placed| placed.request.model == model && placed.is_equal());
    let mut counts: Vec<u32> = own.map(|placed| placed.request.n_add).collect();
    counts.sort_unstable();
    counts.dedup();
    let system = results.system(model);
    let is_printed = system.is_some_and(|system| system.name == "23-dof railway-bogie");
    let printed = &thesis().table_2_2;
    let row = |&count: &u32| {
        let alap = found(Priority::Alap, count)?;
        let place = printed.elements.iter().position(|&known| known == count);
        let place = place.filter(|_| is_printed);
        Some(OrderRow {
            count,
            alap: alap.cycles,
            mobility: found(Priority::Mobility, count)?.cycles,
            best: found(Priority::Best, count).map(|point| point.cycles),
            bound: alap.lower_bound,
            thesis: place.map(|place| [printed.alap[place], printed.mobility[place]]),
        })
    };
    let rows: Vec<OrderRow> = counts.iter().filter_map(row).collect();
    let columns = columns! { OrderRow;
        "elements", [Hidden, All], |row| format!("{0}+{0} ({1})", row.count, 2 * row.count);
        "classical: ALAP, ASAP", [Hidden, All], |row| row.alap;
        "mobility first", [Hidden, All], |row| row.mobility;
        "best of several", [Hidden, All], |row| row.best;
        "lower bound", [Hidden, All], |row| row.bound;
        "thesis, classical", [Hidden, All], |row| Some(row.thesis?[0]);
        "thesis, mobility", [Hidden, All], |row| Some(row.thesis?[1]);
        "classical / thesis", [Hidden, Decimals(3)],
            |row| Some(f64::from(row.alap) / f64::from(row.thesis?[0]));
    };
    let words = [("headline", results.headline())];
    captions::filled("table-2.2", &words, &columns, &rows)
}

/// The best split of each total, and the cycles of equal numbers.
pub(super) fn splits(results: &Results) -> Option<DataTable> {
    type Row<'a> = (StudiedProgram<'a>, StudyPlacement<'a>, Option<u32>);
    let mut rows: Vec<Row<'_>> = Vec::new();
    for program in results.of_headline() {
        let all = program.grid();
        rows.extend(program.best_splits().into_iter().map(|best| {
            let is_equal = |placed: &&StudyPlacement<'_>| {
                placed.is_equal() && placed.elements() == best.elements()
            };
            let equal = all.iter().find(is_equal);
            (program, best, equal.map(|placed| placed.point.cycles))
        }));
    }
    let saved = |(_, best, equal): &Row<'_>| {
        Some(100.0 * (1.0 - f64::from(best.point.cycles) / f64::from((*equal)?)))
    };
    let columns = columns! { Row<'_>;
        "pipeline", [Hidden, All], |row| row.0.pipeline().name.as_str();
        "elements", [Hidden, All], |row| row.1.elements();
        "adders", [Hidden, All], |row| row.1.request.n_add;
        "multipliers", [Hidden, All], |row| row.1.request.n_multi;
        "cycles", [Hidden, All], |row| row.1.point.cycles;
        "share of device (%)", [Hidden, Decimals(2)], |row| Some(100.0 * row.1.share()?);
        "cycles of equal numbers", [Hidden, All], |row| row.2;
        "saved (%)", [Hidden, Decimals(1)], saved;
    };
    let words = [("headline", results.headline())];
    captions::filled("split", &words, &columns, &rows)
}

/// All couples of Table 1.3, with and without the cap.
pub(super) fn couples(results: &Results) -> Option<DataTable> {
    type Row<'a> = (Couple, StudiedProgram<'a>, StudyPlacement<'a>);
    let mut rows: Vec<Row<'_>> = Vec::new();
    for pipeline in 0..results.plan.pipelines.len() {
        rows.extend(all_couples().into_iter().filter_map(|couple| {
            let machine = results.couple_machine(couple.stages())?;
            let program = results.program([results.plan.headline, pipeline, machine])?;
            let placed = program.ladder().into_iter();
            let best = placed.min_by_key(|placed| (placed.point.cycles, placed.elements()))?;
            Some((couple, program, best))
        }));
    }
    let time = |couple: &Couple, cycles: u32, cap: u32| {
        f64::from(cycles) / f64::from(couple.mhz().min(cap))
    };
    let chain = move |row: &Row<'_>, cap| time(&row.0, row.1.facts.asap_cycle, cap);
    let fastest = move |row: &Row<'_>, cap| time(&row.0, row.2.point.cycles, cap);
    let columns = columns! { Row<'_>;
        "pipeline", [Hidden, All], |row| row.1.pipeline().name.as_str();
        "stages", [Hidden, All], |row| sum(row.0.stages());
        "clock (MHz)", [Hidden, All], |row| row.0.mhz();
        "ASAPCycle", [Hidden, All], |row| row.1.facts.asap_cycle;
        "longest chain (µs)", [Hidden, Decimals(3)], move |row| chain(row, u32::MAX);
        "longest chain, capped (µs)", [Hidden, Decimals(3)],
            move |row| chain(row, MEMORY_CAP_MHZ);
        "number Y", [Hidden, Decimals(2)], |row| row.1.facts.number_y();
        "fastest", [Hidden, All], |row| sum(row.2.counts());
        "fastest (µs)", [Hidden, Decimals(3)], move |row| fastest(row, u32::MAX);
        "fastest, capped (µs)", [Hidden, Decimals(3)], move |row| fastest(row, MEMORY_CAP_MHZ);
    };
    let columns = columns.and(costs(|row: &Row<'_>| row.2.share(), |row| Some(row.1)));
    let words = [("headline", results.headline())];
    captions::filled("couples", &words, &columns, &rows)
}

pub(super) fn points(results: &Results) -> DataTable {
    let plan = &results.plan;
    let machine = |row: &StudyPlacement<'_>| &plan.machines[row.request.machine];
    let columns = columns! { StudyPlacement<'_>;
        "model", [Hidden, All], |row| plan.models[row.request.model].name.as_str();
        "pipeline", [Hidden, All], |row| plan.pipelines[row.request.pipeline].name.as_str();
        "machine", [Hidden, All], move |row| machine(row).name.as_str();
        "adders", [Hidden, All], |row| row.request.n_add;
        "multipliers", [Hidden, All], |row| row.request.n_multi;
        "order", [Hidden, All], |row| row.request.options.priority.print();
        "choice", [Hidden, All], |row| row.request.options.choice.print();
        "cycles", [Hidden, All], |row| row.point.cycles;
        "lower bound", [Hidden, All], |row| row.point.lower_bound;
        "clock", [Hidden, All], move |row| machine(row).clock().text();
        "time (µs)", [Hidden, Decimals(3)], |row| row.time_us();
    };
    let more = columns! { StudyPlacement<'_>;
        "parallelisation rate (%)", [Hidden, Decimals(1)], |row| 100.0 * row.point.rate;
        "memory of adders (words)", [Hidden, Decimals(0)], |row| row.point.kinds[0].memory[2];
        "memory of multipliers (words)", [Hidden, Decimals(0)],
            |row| row.point.kinds[1].memory[2];
        "buffer of adders (words)", [Hidden, Decimals(0)], |row| row.point.kinds[0].buffer[2];
        "buffer of multipliers (words)", [Hidden, Decimals(0)],
            |row| row.point.kinds[1].buffer[2];
        "direct writes", [Hidden, All], |row| row.point.direct_writes;
        "indirect writes", [Hidden, All], |row| row.point.indirect_writes;
        "zone", [Hidden, All], |row| row.zone().map_or("", |zone| zone.name());
        "failure", [Hidden, All], |row| row.point.failure.as_deref().unwrap_or_default();
    };
    let columns = columns.and(costs(StudyPlacement::share, StudyPlacement::program));
    let rows: Vec<StudyPlacement<'_>> = results.points().collect();
    captions::table("points", &[], &columns.and(more), &rows)
}

/// A whole step on a machine, and that with the fewest elements.
struct WholeStepRow<'a> {
    program: StudiedProgram<'a>,
    placed: PlacedStep<'a>,
    first: u32,
    clock: MachineClock,
}

/// The whole step of systems: loops closed, then accelerations.
pub(super) fn whole_step(results: &Results) -> Option<DataTable> {
    let plan = &results.plan;
    let mut rows: Vec<WholeStepRow<'_>> = Vec::new();
    for step in steps(results) {
        for pipeline in 0..plan.pipelines.len() {
            for machine in 0..plan.machines.len() {
                let place = [step.accelerations(), pipeline, machine];
                let Some(program) = results.program(place) else {
                    continue;
                };
                let all = placed(results, &step, pipeline, machine);
                let first = all.first().map_or(0, |first| first.cycles);
                rows.extend(all.into_iter().map(|placed| WholeStepRow {
                    program,
                    first,
                    clock: clock(&placed.accelerations().machine()),
                    placed,
                }));
            }
        }
    }
    let mut columns = columns! { WholeStepRow<'_>;
        "system", [Hidden, All], |row| row.program.subject().source.as_str();
        "formulation", [Hidden, All], |row| results::label(row.program.subject());
        "pipeline", [Hidden, All], |row| row.program.pipeline().name.as_str();
        "machine", [Hidden, All], |row| row.program.facts.machine.as_str();
        "adders + multipliers", [Hidden, All], |row| sum(row.placed.accelerations().counts());
    };
    for (part, (kind, _)) in PARTS.iter().enumerate() {
        let head = format!("{} (cycles)", kind.name());
        let cycles = move |row: &WholeStepRow<'_>| Some(row.placed.parts[part]?.point.cycles);
        columns = columns.with(head, Digits::Hidden, Digits::All, cycles);
    }
    let faster =
        |row: &WholeStepRow<'_>| f64::from(row.first) / f64::from(row.placed.cycles.max(1));
    let columns = columns.and(columns! { WholeStepRow<'_>;
        "whole step (cycles)", [Hidden, All], |row| row.placed.cycles;
        "times as fast", [Hidden, Decimals(2)], faster;
        "clock", [Hidden, All], |row| row.clock.text();
        "whole step (µs)", [Hidden, Decimals(3)], |row| row.clock.microseconds(row.placed.cycles);
    });
    let columns = columns.and(costs(
        |row: &WholeStepRow<'_>| Some(row.placed.share()),
        |row| Some(row.program),
    ));
    captions::filled(
        "whole-step",
        &[("rounds", &ROUNDS.to_string())],
        &columns,
        &rows,
    )
}
