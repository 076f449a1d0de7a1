//! What a search found, as text, table and figure.

use super::confirm::Confirmation;
use super::{FitCandidate, FitOutcome, FitTask};
use crate::present::{
    AxisScale, Curve, DataCell, DataTable, Figure, Mark, Panel, PlotAxis, text_table,
};
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
        "{} programs, {} candidates measured at {} states of the scene\n",
        outcome.programs.len(),
        outcome.candidates.len(),
        task.states
    );
    match outcome.chosen {
        Some(chosen) => text += &choice(outcome, chosen),
        None => text += &refusal(task, outcome),
    }
    if let Some(confirmation) = confirmation {
        text += &held(confirmation);
    }
    let front = outcome.front();
    let rows: Vec<Vec<String>> = front
        .iter()
        .take(SHOWN)
        .map(|&index| row(outcome, index))
        .collect();
    let head = " | program | sin, cos | format | elements | >operations | >cycles | >us | \
         >worst normwise | >of tolerance | >of device";
    let _ = writeln!(
        text,
        "\nFront of time, error and share of the device, {}: {} of {} shown\n{}",
        match outcome.chosen {
            Some(_) => "what meets the scene",
            None => "everything",
        },
        rows.len(),
        front.len(),
        text_table(head, &rows)
    );
    text
}

fn row(outcome: &FitOutcome, index: usize) -> Vec<String> {
    let candidate = &outcome.candidates[index];
    let program = &outcome.programs[candidate.program];
    let [add, multi] = candidate.elements;
    let standing = match (outcome.chosen == Some(index), candidate.meets) {
        (true, _) => "chosen",
        (false, true) => "meets",
        (false, false) => "",
    };
    vec![
        standing.to_owned(),
        program.name.clone(),
        program.treatment.to_string(),
        candidate.format.clone(),
        format!("{add}+{multi}"),
        candidate.operations.to_string(),
        candidate.cycles.to_string(),
        format!("{:.3}", candidate.microseconds),
        format!("{:.1e}", candidate.normwise.worst),
        percent(candidate.used),
        percent(candidate.share),
    ]
}

fn percent(share: f64) -> String {
    match share {
        _ if share >= 100.0 => format!("{share:.0} x"),
        _ => format!("{:.3} %", share * 100.0),
    }
}

fn choice(outcome: &FitOutcome, chosen: usize) -> String {
    let candidate = &outcome.candidates[chosen];
    let program = &outcome.programs[candidate.program];
    let [add, multi] = candidate.elements;
    format!(
        "The cheapest that meets everything\n  \
         program    {}\n  \
         sin, cos   {}; alone it takes {} of the tolerance\n  \
         format     {}\n  \
         elements   {add} that add, {multi} that multiply\n  \
         operations {}, longest chain {} cycles\n  \
         schedule   {} cycles, {:.3} us\n  \
         error      worst {:.2e} of the largest element; {} of the tolerance\n  \
         device     {} ({:.0} look-up tables, {:.0} memory blocks, {} multiplier blocks: estimates)\n  \
         pipeline   {}\n",
        program.name,
        program.treatment,
        percent(program.model_share),
        candidate.format,
        candidate.operations,
        candidate.path,
        candidate.cycles,
        candidate.microseconds,
        candidate.normwise.worst,
        percent(candidate.used),
        percent(candidate.share),
        candidate.resources.look_up_tables,
        candidate.resources.memory_blocks,
        candidate.resources.multiplier_blocks,
        program.pipeline,
    )
}

/// Why nothing meets the scene: what comes nearest.
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
            "  the most exact takes {} of the tolerance",
            percent(exact.used)
        );
    }
    text
}

/// What was established of the choice: where it was tried, and what came out.
fn held(confirmation: &Confirmation) -> String {
    let mut text = format!(
        "{} at {} fresh states (seed {}), and cycle by cycle in {} runs; tried there, not \
         established for all states\n  fresh states     worst {:.2e}, {} of the tolerance\n",
        if confirmation.holds() {
            "Held"
        } else {
            "DID NOT HOLD"
        },
        confirmation.states,
        confirmation.seed,
        confirmation.simulated,
        confirmation.normwise.worst,
        percent(confirmation.used),
    );
    if confirmation.remark.is_empty() {
        let _ = writeln!(
            text,
            "  cycle by cycle   {} runs of {} cycles from memory images, {} the evaluator's bit \
             for bit; {} of the tolerance",
            confirmation.simulated,
            confirmation.cycles,
            if confirmation.equal { "all" } else { "NOT" },
            percent(confirmation.simulated_used),
        );
    } else {
        let _ = writeln!(text, "  not simulated: {}", confirmation.remark);
    }
    text
}

/// All candidates as a table for programs.
pub fn candidates_table(outcome: &FitOutcome) -> DataTable {
    let front = outcome.front();
    let rows = (0..outcome.candidates.len()).map(|index| {
        let candidate = &outcome.candidates[index];
        let program = &outcome.programs[candidate.program];
        let standing = match (outcome.chosen == Some(index), candidate.meets) {
            (true, _) => "chosen",
            (false, true) => "meets",
            (false, false) => "",
        };
        let on_front = if front.contains(&index) { "front" } else { "" };
        let mut row = vec![
            DataCell::text(&program.name),
            DataCell::text(program.treatment.to_string()),
            DataCell::text(&candidate.format),
            DataCell::count(candidate.elements[0]),
            DataCell::count(candidate.elements[1]),
            DataCell::count(candidate.operations),
            DataCell::count(candidate.path),
            DataCell::count(candidate.cycles),
            DataCell::number(candidate.microseconds, 4),
        ];
        for error in [
            candidate.relative.median,
            candidate.normwise.median,
            candidate.normwise.percentile_99,
            candidate.normwise.worst,
            candidate.used,
        ] {
            row.push(DataCell::text(format!("{error:.3e}")));
        }
        row.push(DataCell::number(candidate.share, 4));
        row.push(DataCell::text(standing));
        row.push(DataCell::text(on_front));
        row
    });
    DataTable::new(
        "fit",
        "Candidates",
        "Every program in every format and size that was measured. Errors are those of \
                  the whole program: series, rounding, data. Shares of the device are estimates.",
        "program | sin, cos | format | adders | multipliers | operations | path (cycles) | \
         cycles | time (us) | relative median | normwise median | normwise 99 % | \
         normwise worst | of tolerance | share of device | standing | front",
        rows,
    )
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
    Figure::new(
        "fit",
        format!("What scene {} can be computed with", task.scene.name),
        "Every candidate; errors in units of the rounding of binary32 (2^-24), shares \
                  of the device in per cent.",
        2,
        vec![
            panel("Error", "worst normwise error (2^-24)", |candidate| {
                candidate.normwise.worst * f64::from(1u32 << 24)
            }),
            panel("Cost", "share of the device (%)", |candidate| {
                candidate.share * 100.0
            }),
        ],
    )
}
