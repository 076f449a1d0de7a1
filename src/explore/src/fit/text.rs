//! Result of a search as text, table and figure.

use super::confirm::Confirmation;
use super::{
    Challenge, CostMeasure, FitCandidate, FitOutcome, FitTask, MotionShare, SineTreatment,
    VALIDATION_FACTOR,
};
use crate::captions;
use robovec_error::yardstick::account::measure_text;
use robovec_framework::scene::{Measure, OutputTolerance};
use robovec_ir::diagnostic::counted;
use robovec_num::trigonometry::host::TrigonometricUnit;
use robovec_present::number::exponential;
use robovec_present::number::or_nothing;
use robovec_present::{
    AxisScale, ColumnList, Curve, DataTable, Digits, Figure, Mark, Panel, PlotAxis, columns,
};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Lines of the front that are shown; all of it is in the files.
const SHOWN: usize = 24;

/// The choice, why, and the front.
pub fn text(
    task: &FitTask<'_>,
    outcome: &FitOutcome,
    confirmation: Option<&Confirmation>,
) -> String {
    let mut text = format!("scene {}", task.scene.name);
    // Writing to a string cannot fail, here and below.
    let _ = match task.scene.deadline {
        Some(deadline) => writeln!(text, ", deadline {deadline} us"),
        None => writeln!(text, ", no deadline"),
    };
    let _ = writeln!(
        text,
        "{}, {} measured at {} of the scene\n",
        counted(outcome.programs.len(), "program"),
        counted(outcome.candidates.len(), "candidate"),
        counted(task.states, "state")
    );
    match outcome.chosen {
        Some(chosen) => text += &choice(task, outcome, chosen),
        None => text += &refusal(task, outcome),
    }
    if let Some(challenge) = &outcome.challenge {
        text += &held(task, outcome, challenge);
        if let Some(motion) = &outcome.motion {
            text += &over_time(outcome, motion);
        }
    }
    text += &or_nothing(confirmation, run);
    text += &units(outcome);
    text += &excluded(outcome);
    let front = outcome.front();
    let rows: Vec<usize> = front.iter().copied().take(SHOWN).collect();
    let _ = writeln!(
        text,
        "\nFront of time, error and cost, {}: {} of {} shown; errors are parts of the largest \
         element of an array, tolerances as the scene measures them\n{}",
        match outcome.chosen {
            Some(_) => "what meets the scene",
            None => "everything",
        },
        rows.len(),
        front.len(),
        columns(outcome).text(&rows)
    );
    text
}

/// Standing of a candidate in the search.
fn standing(outcome: &FitOutcome, index: usize) -> &'static str {
    match (
        outcome.chosen == Some(index),
        outcome.candidates[index].meets,
    ) {
        (true, _) => "chosen",
        (false, true) => "meets",
        (false, false) => "",
    }
}

/// The columns of a table of candidates, whose rows are their indices.
fn columns(outcome: &FitOutcome) -> ColumnList<'_, usize> {
    let of = |index: &usize| &outcome.candidates[*index];
    let program = move |index: &usize| &outcome.programs[of(index).program];
    let front = outcome.front();
    let elements =
        move |index: &usize| format!("{}+{}", of(index).elements[0], of(index).elements[1]);
    columns! { usize;
        "standing", [All, Hidden], |index| standing(outcome, *index);
        "program", [All, All], move |index| program(index).name.as_str();
        "sin, cos", [All, All], move |index| program(index).treatment.to_string();
        "format", [All, All], move |index| of(index).format.as_str();
        "elements", [All, Hidden], elements;
        "adders", [Hidden, All], move |index| of(index).elements[0];
        "multipliers", [Hidden, All], move |index| of(index).elements[1];
        "operations", [All, All], move |index| of(index).operations;
        "path (cycles)", [Hidden, All], move |index| of(index).path;
        "cycles", [All, All], move |index| of(index).cycles;
        "time (us)", [Decimals(3), Decimals(4)], move |index| of(index).microseconds;
        "relative median", [Hidden, Exponent(3)], move |index| of(index).relative.median;
        "normwise median", [Exponent(1), Exponent(3)], move |index| of(index).normwise.median;
        "normwise 99 %", [Hidden, Exponent(3)], move |index| of(index).normwise.percentile_99;
        "normwise worst", [Exponent(1), Exponent(3)], move |index| of(index).normwise.worst;
        "of tolerance", [Words(percent), Exponent(3)], move |index| of(index).used;
        "share of device", [Words(percent), Decimals(4)], move |index| of(index).share;
        "cells", [Decimals(0), Decimals(0)], move |index| of(index).cells;
        "standing", [Hidden, All], |index| standing(outcome, *index);
        "front", [Hidden, All], move |index| if front.contains(index) { "front" } else { "" };
        "why not", [Hidden, All], move |index| of(index).remark.as_str();
    }
}

/// Cells of arithmetic.
fn cells(cells: f64) -> String {
    format!("{cells:.0}")
}

/// The units that would do for sines and cosines, with what they take.
fn units(outcome: &FitOutcome) -> String {
    let mut text = String::new();
    for (index, program) in outcome.programs.iter().enumerate() {
        let SineTreatment::Unit(implementation) = program.treatment else {
            continue;
        };
        let mut own = outcome.candidates.iter();
        let own = own.find(|candidate| candidate.program == index && candidate.used <= 1.0);
        let (Some(candidate), Ok(unit)) = (own, TrigonometricUnit::new(implementation)) else {
            continue;
        };
        if text.is_empty() {
            text +=
                "\nUnits for sines and cosines before the run that do at the states measured at\n";
        }
        let cost = unit.cost();
        let _ = writeln!(
            text,
            "  {implementation} with {} in {}: about {} cycles each, {} bits of tables; {} of the \
             tolerance",
            program.name,
            candidate.format,
            cost.latency,
            cost.table_bits,
            percent(candidate.used)
        );
    }
    text
}

/// Candidates that cannot be chosen, whatever they cost: of every reason the
/// cheapest that keeps the tolerances, by the cells of its arithmetic; and
/// those that could not even be tried.
fn excluded(outcome: &FitOutcome) -> String {
    let mut best: BTreeMap<&str, usize> = BTreeMap::new();
    for (index, candidate) in outcome.candidates.iter().enumerate() {
        if candidate.remark.is_empty() || candidate.used > 1.0 {
            continue;
        }
        // Formats differ from program to program, and their names with them.
        let reason = candidate
            .remark
            .split(':')
            .next()
            .expect("a split has a first part");
        let known = best.entry(reason).or_insert(index);
        if candidate.cells < outcome.candidates[*known].cells {
            *known = index;
        }
    }
    let mut text = String::new();
    if !best.is_empty() {
        let shown = [
            "program",
            "sin, cos",
            "format",
            "of tolerance",
            "share of device",
            "cells",
        ];
        let why = |index: &usize| outcome.candidates[*index].remark.as_str();
        let columns = columns(outcome)
            .only(&shown)
            .with("why", Digits::All, Digits::Hidden, why);
        let rows: Vec<usize> = best.into_values().collect();
        let _ = write!(
            text,
            "\nWithin the tolerances at the states it was measured at, but not to be chosen\n{}",
            columns.text(&rows)
        );
    }
    if !outcome.untried.is_empty() {
        text += "\nNot tried any further\n";
    }
    for line in &outcome.untried {
        let _ = writeln!(text, "  {line}");
    }
    text
}

fn percent(share: f64) -> String {
    match share {
        _ if share >= 100.0 => format!("{share:.0} x"),
        _ => format!("{:.3} %", share * 100.0),
    }
}

fn choice(task: &FitTask<'_>, outcome: &FitOutcome, chosen: usize) -> String {
    let validated = task.states * VALIDATION_FACTOR;
    let candidate = &outcome.candidates[chosen];
    let program = &outcome.programs[candidate.program];
    let [add, multi] = candidate.elements;
    let by = match task.cost {
        CostMeasure::Device => "by its share of the device",
        CostMeasure::Cells => "by the cells of its arithmetic",
    };
    let mixture = match &program.mixture {
        Some(mixture) => format!(" for inputs; {}", mixture.text),
        None => String::new(),
    };
    format!(
        "The cheapest that meets everything, {by}\n  \
         program    {}\n  \
         sin, cos   {}; alone it takes {} of the tolerance\n  \
         format     {}{mixture}\n  \
         elements   {add} that add, {multi} that multiply\n  \
         operations {}, longest chain {} cycles\n  \
         schedule   {} cycles, {:.3} us\n  \
         error      median {}, worst {} {}\n  \
         tolerance  {}\n  \
         device     {} of {} (estimates: look-up tables {:.0}, memory blocks {:.0}, multiplier blocks {})\n  \
         arithmetic {} cells: products cost the square of the bits, sums the bits\n  \
         pipeline   {}\n",
        program.name,
        program.treatment,
        percent(program.model_share),
        candidate.format,
        candidate.operations,
        candidate.path,
        candidate.cycles,
        candidate.microseconds,
        exponential(candidate.normwise.median),
        exponential(candidate.normwise.worst),
        measure_text(&format!("at least {validated} states of the scene")),
        allowed(task, candidate.used),
        percent(candidate.share),
        task.machine.device.device().name,
        candidate.resources.look_up_tables,
        candidate.resources.memory_blocks,
        candidate.resources.multiplier_blocks,
        cells(candidate.cells),
        program.pipeline,
    )
}

/// The used part of a scene's tolerances, each with its own measure, which is
/// not that of the error beside them.
fn allowed(task: &FitTask<'_>, used: f64) -> String {
    let needs = task.scene.outputs.iter();
    let allowed: Vec<String> = needs
        .filter_map(|need| Some(format!("{} {}", need.pattern, need.tolerance?)))
        .collect();
    if allowed.is_empty() {
        "none".to_owned()
    } else {
        format!(
            "{} of it at the worst output: {}",
            percent(used),
            allowed.join("; ")
        )
    }
}

/// Reason why nothing meets the scene: what comes nearest.
fn refusal(task: &FitTask<'_>, outcome: &FitOutcome) -> String {
    let fastest = outcome
        .candidates
        .iter()
        .min_by_key(|candidate| candidate.cycles);
    let exact = |candidate: &&FitCandidate| candidate.used.is_finite();
    let exact = outcome.candidates.iter().filter(exact);
    let exact = exact.min_by(|a, b| a.used.total_cmp(&b.used));
    let mut text = "Nothing meets this scene.\n".to_owned();
    if let (Some(fastest), Some(deadline)) = (fastest, task.scene.deadline) {
        let _ = writeln!(
            text,
            "  the fastest takes {:.3} us of {deadline} us",
            fastest.microseconds
        );
    }
    if let Some(exact) = exact {
        let _ = writeln!(
            text,
            "  the most accurate takes {} of the tolerance",
            percent(exact.used)
        );
    }
    text
}

/// Facts established about the choice: the states it was tried at, and the
/// results.
fn held(task: &FitTask<'_>, outcome: &FitOutcome, challenge: &Challenge) -> String {
    let has_tolerances = task
        .scene
        .outputs
        .iter()
        .any(|need| need.tolerance.is_some());
    if !has_tolerances {
        return format!(
            "The scene allows every error. All results are numbers at {} (seed {})\n",
            counted(challenge.fresh, "fresh state"),
            challenge.seed
        );
    }
    let mut text = format!(
        "Held at {} (seed {}): with a confidence of 95 %, at {:.4} % of the states \
         in the ranges, or more\n  \
         fresh states     worst {} of the tolerance\n  \
         directed search  {}, bred from the worst ones: {} of the tolerance\n",
        counted(challenge.fresh, "fresh state"),
        challenge.seed,
        (challenge.share() * 1e6).floor() / 1e4,
        percent(challenge.fresh_used),
        counted(challenge.directed, "more state"),
        percent(challenge.used),
    );
    text += &match outcome.bound {
        Some(bound) if bound.holds() => format!(
            "  proved           for every state in the ranges: bounds of the rounding of all {} \
             outputs, at most {} of the tolerance\n",
            bound.outputs,
            percent(bound.used)
        ),
        Some(bound) => format!(
            "  not established  for every state: bounds of the rounding are within the tolerance \
             for {} of {} outputs, the largest is {}\n",
            bound.proved,
            bound.outputs,
            if bound.used.is_finite() {
                format!("{} of it", percent(bound.used))
            } else {
                "without end".to_owned()
            }
        ),
        None => "  not established  for every state: no bound was computed (the program is large, \
                 has series, or reads inputs without a range)\n"
            .to_owned(),
    };
    if outcome.broken > 0 {
        let _ = writeln!(
            text,
            "  before it        {} failed such a search",
            counted(outcome.broken, "cheaper choice")
        );
    }
    let sizes = scales(task);
    if !sizes.is_empty() {
        let _ = writeln!(
            text,
            "  errors           in parts of the largest element of the array, or of its usual \
             size where that is larger: {sizes}"
        );
    }
    let mut tolerances = task.scene.outputs.iter().filter_map(|need| need.tolerance);
    if tolerances.any(|one| one.measure == Measure::Relative && one.scale.is_none()) {
        text += "  relative errors  in parts of the element, or of a thousandth of its usual size \
                 where that is larger\n";
    }
    text
}

/// Result of the scene's motion.
fn over_time(outcome: &FitOutcome, motion: &MotionShare) -> String {
    let mut text = format!(
        "  over time        {} s of the scene's motion in {}: {} of the largest displacement \
         of a watched joint, {} allowed\n",
        motion.time,
        counted(motion.steps, "step"),
        exponential(motion.error),
        exponential(motion.allowed)
    );
    if let Some(energy) = motion.energy {
        let _ = writeln!(
            text,
            "                   energy drifts by {} of the largest kinetic energy, {} allowed",
            exponential(energy.drift),
            exponential(energy.allowed)
        );
    }
    let _ = writeln!(
        text,
        "                   {} erred more; dearer ones were not tried over time",
        counted(outcome.drifted, "cheaper choice")
    );
    text
}

/// The sizes that errors are measured by at least, of arrays with a tolerance
/// in parts of the largest element.
fn scales(task: &FitTask<'_>) -> String {
    let mut sizes: Vec<String> = Vec::new();
    for need in &task.scene.outputs {
        let array = &need.pattern.array;
        let is_normwise = |tolerance: &OutputTolerance| tolerance.measure == Measure::Norm;
        let Some(tolerance) = need.tolerance.filter(is_normwise) else {
            continue;
        };
        let size = match tolerance.scale {
            Some(scale) => format!("{} {scale} (the scene's)", need.pattern),
            None => format!("{array} {:.3e}", task.sizes.get(array)),
        };
        if !sizes.contains(&size) {
            sizes.push(size);
        }
    }
    sizes.join(", ")
}

/// Result of the runs on the machine.
fn run(confirmation: &Confirmation) -> String {
    if !confirmation.remark.is_empty() {
        return format!("  not simulated: {}\n", confirmation.remark);
    }
    format!(
        "  cycle by cycle   {} of {} from memory images at the worst states, {} the \
         evaluator's bit for bit; {} of the tolerance\n",
        counted(confirmation.simulated, "run"),
        counted(confirmation.cycles, "cycle"),
        if confirmation.equal { "all" } else { "NOT" },
        percent(confirmation.simulated_used),
    )
}

/// All candidates as a table for programs.
pub fn candidates_table(outcome: &FitOutcome) -> DataTable {
    let rows: Vec<usize> = (0..outcome.candidates.len()).collect();
    captions::table("fit", &[], &columns(outcome), &rows)
}

/// Time against error, and time against the share of the device.
pub fn figure(task: &FitTask<'_>, outcome: &FitOutcome) -> Figure {
    type Measure = fn(&FitCandidate) -> f64;
    let panel = |title: &str, axis: &str, measure: Measure| {
        let mark = |index: usize| {
            let candidate = &outcome.candidates[index];
            Mark::at(candidate.microseconds, measure(candidate))
        };
        let drawable = |index: &usize| measure(&outcome.candidates[*index]).is_finite();
        let group = |label: &str, place: usize, indices: Vec<usize>| {
            Curve::points(label, place, indices.into_iter().filter(drawable).map(mark))
        };
        let all = 0..outcome.candidates.len();
        let meets = |index: &usize| outcome.candidates[*index].meets;
        let (good, bad): (Vec<usize>, Vec<usize>) = all.partition(meets);
        Panel::curves(
            title,
            PlotAxis::new("time (us)", AxisScale::Decades),
            PlotAxis::new(axis, AxisScale::Decades),
            vec![
                group("does not meet the scene", 1, bad),
                group("meets the scene", 0, good),
                group("chosen", 3, outcome.chosen.into_iter().collect()),
            ],
        )
    };
    let panels = vec![
        panel("Error", "worst normwise error (2^-24)", |candidate| {
            candidate.normwise.worst * f64::from(1u32 << 24)
        }),
        panel("Cost", "share of the device (%)", |candidate| {
            candidate.share * 100.0
        }),
    ];
    let words = [("scene", task.scene.name.as_str())];
    captions::figure("fit", "fit", &words, panels).expect("it has panels")
}
