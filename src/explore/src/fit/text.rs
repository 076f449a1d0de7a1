//! Result of a search as text, table and figure.

use super::confirm::Confirmation;
use super::{FitCandidate, FitOutcome, FitTask, SineTreatment, answer};
use crate::exploration::scene_subtitle;
use crate::front::{STEPS, front_curve};
use crate::program::{depending, view};
use crate::{captions, pareto};
use robovec_error::yardstick::account::ERROR_HEADS;
use robovec_num::trigonometry::host::TrigonometricUnit;
use robovec_present::json::json_script;
use robovec_present::number::{exponential, or_nothing, share_percent};
use robovec_present::page::{self, PointsPage};
use robovec_present::text::{headed, labelled, thinned};
use robovec_present::{
    AxisScale, ColumnList, Curve, DataTable, Digits, Figure, Mark, MarkFill, MarkZone, Panel,
    PlotAxis, Stroke, columns,
};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Maximum number of rows of the front, and of all lines, on the terminal.
const SHOWN: usize = 8;
const SCREEN: usize = 20;

/// The answer, and the front; all evidence, units for sines and cosines,
/// excluded candidates and the whole front in detailed output.
pub fn text(
    task: &FitTask<'_>,
    outcome: &FitOutcome,
    confirmation: Option<&Confirmation>,
    is_verbose: bool,
) -> String {
    let lines = if is_verbose {
        answer::lines
    } else {
        answer::brief
    };
    let head = headed(&task.scene.name, &answer::headline(task, outcome))
        + &labelled(&lines(task, outcome, confirmation));
    // A blank line and the head of the table are three lines.
    let rows = SHOWN.min(SCREEN.saturating_sub(head.lines().count() + 3));
    let table = short_table(outcome, rows);
    if is_verbose {
        format!("{head}\n{table}\n{}", details(outcome))
    } else {
        format!("{head}\n{table}")
    }
}

/// Units for sines and cosines, excluded candidates, and the front.
pub(super) fn details(outcome: &FitOutcome) -> String {
    let front = outcome.front();
    let program = outcome
        .chosen
        .map(|chosen| outcome.candidates[chosen].program);
    let pipeline = or_nothing(program, |program| {
        format!("pipeline: {}\n", outcome.programs[program].pipeline)
    });
    let needed = or_nothing(program, |program| {
        depending(view(&outcome.programs[program].module))
    });
    format!(
        "{pipeline}{needed}{}{}\nFront of time, error and cost, {}\n{}\n",
        units(outcome),
        excluded(outcome),
        match outcome.chosen {
            Some(_) => "of those that meet the scene",
            None => "of all candidates",
        },
        columns(outcome).text(&front)
    )
}

/// The front of time, error and cost, fastest first, at most `most` rows.
fn short_table(outcome: &FitOutcome, most: usize) -> String {
    let mut rows: Vec<usize> = Vec::new();
    let figures = |index: usize| {
        let FitCandidate {
            format,
            elements,
            cycles,
            ..
        } = &outcome.candidates[index];
        (format, elements, cycles)
    };
    for index in outcome.chosen.into_iter().chain(outcome.front()) {
        if !rows.iter().any(|&known| figures(known) == figures(index)) {
            rows.push(index);
        }
    }
    let chosen = usize::from(outcome.chosen.is_some());
    let mut shown = rows[..chosen].to_vec();
    shown.extend(thinned(&rows[chosen..], most.saturating_sub(chosen)));
    shown.sort_by_key(|&index| (outcome.candidates[index].cycles, index));
    let of = |index: &usize| &outcome.candidates[*index];
    let elements =
        move |index: &usize| format!("{}+{}", of(index).elements[0], of(index).elements[1]);
    let [_, worst] = ERROR_HEADS;
    let list = columns! { usize;
        "format", [All, All], move |index| of(index).format.as_str();
        "elements", [All, All], elements;
        "cycles", [All, All], move |index| of(index).cycles;
        worst, [Exponent(1), All], move |index| of(index).normwise.worst;
        "of device", [Words(share_percent), All], move |index| of(index).share;
        "", [All, All], |index| standing(outcome, *index);
    };
    list.text(&shown)
}

/// Result of the search for a candidate, in words.
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

/// The sufficient units for sines and cosines, with their resources.
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
            text += "\nUnits for sines and cosines before the run that meet the tolerances at the measured states\n";
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

/// Candidates that cannot be chosen at any cost: of every reason the one of
/// fewest cells that keeps the tolerances; and those that could not be tried.
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
            "\nWithin the tolerances at the measured states, but not allowed as a choice\n{}",
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

/// A share of a tolerance or of a device in percent.
pub(super) fn percent(share: f64) -> String {
    match share {
        _ if share >= 100.0 => format!("{share:.0} x"),
        _ if share >= 0.01 => format!("{:.1} %", share * 100.0),
        _ => format!("{:.3} %", share * 100.0),
    }
}

/// All candidates as a table for programs.
pub fn candidates_table(outcome: &FitOutcome) -> DataTable {
    let rows: Vec<usize> = (0..outcome.candidates.len()).collect();
    captions::table("fit", &[], &columns(outcome), &rows)
}

/// A kind of number formats, with its colour and marker.
fn kind(outcome: &FitOutcome, candidate: &FitCandidate) -> &'static str {
    match candidate.format.as_str() {
        _ if outcome.programs[candidate.program].mixture.is_some() => "a format for every value",
        format if format.starts_with("fixed") => "fixed point",
        format if format.starts_with("float") => "narrow floats",
        _ => "binary32",
    }
}

/// Kinds of formats in the order of their colours.
const KINDS: [&str; 4] = [
    "binary32",
    "narrow floats",
    "fixed point",
    "a format for every value",
];

const MEETS: MarkZone = MarkZone {
    name: "meets the scene",
    fill: MarkFill::Full,
};

const MISSES: MarkZone = MarkZone {
    name: "does not meet the scene",
    fill: MarkFill::Hollow,
};

/// Time against error, and time against the share of the device.
pub fn figure(task: &FitTask<'_>, outcome: &FitOutcome) -> Figure {
    type Measure = fn(&FitCandidate) -> f64;
    let panel = |title: &str, axis: &str, number: fn(f64) -> String, measure: Measure| {
        let mark = |index: usize| {
            let candidate = &outcome.candidates[index];
            let zone = if candidate.meets { MEETS } else { MISSES };
            Mark {
                zone: Some(zone),
                ..Mark::at(candidate.microseconds, measure(candidate))
            }
        };
        let all = 0..outcome.candidates.len();
        let good = |index: &usize| outcome.chosen.is_none() || outcome.candidates[*index].meets;
        let plane = all.clone().filter(good).map(|index| {
            let mark = mark(index);
            (index, [mark.x, mark.y])
        });
        let mut curves = vec![front_curve(pareto::steps(plane).into_iter().map(mark))];
        for (place, name) in KINDS.into_iter().enumerate() {
            let own = |index: &usize| kind(outcome, &outcome.candidates[*index]) == name;
            curves.push(Curve::points(
                name,
                3 + place,
                all.clone().filter(own).map(mark),
            ));
        }
        let plain = answer::baseline(task, outcome).filter(|&plain| outcome.chosen != Some(plain));
        for (name, index, colour) in [("cheapest", plain, 1), ("chosen", outcome.chosen, 2)] {
            let marks = index.map(mark);
            let label: String = marks
                .iter()
                .map(|mark| format!("{name} {:.2}, {}", mark.x, number(mark.y)))
                .collect();
            curves.push(Curve::points(label, colour, marks));
        }
        Panel::curves(
            title,
            PlotAxis::new("time (us)", AxisScale::Decades),
            PlotAxis::new(axis, AxisScale::Decades),
            curves,
        )
    };
    let panels = vec![
        panel("Error", "worst normwise error", exponential, |candidate| {
            candidate.normwise.worst
        }),
        panel(
            "Cost",
            "share of the device (%)",
            |share| format!("{share:.2} %"),
            |candidate| candidate.share * 100.0,
        ),
    ];
    let words = [("scene", task.scene.name.as_str())];
    captions::figure("fit", "fit", &words, panels)
        .expect("it has panels")
        .with_note(Stroke::Steps, STEPS)
}

/// The page of a search.
pub fn page(
    task: &FitTask<'_>,
    outcome: &FitOutcome,
    confirmation: Option<&Confirmation>,
) -> String {
    let lines = answer::lines(task, outcome, confirmation);
    let page = PointsPage {
        title: format!("Scene {}", task.scene.name),
        subtitle: scene_subtitle(task.scene, task.machine),
        figures: page::card(&answer::headline(task, outcome), &lines)
            + &page::figure(&figure(task, outcome)),
        points: "All candidates",
        tables: page::table(&candidates_table(outcome), "fit.csv")
            + &page::lines("Excluded, and the front", &details(outcome)),
        method: &page::fill(
            include_str!("method.html"),
            &[("device", &task.machine.device.device().name)],
        ),
        data: json_script(&outcome.candidates),
    };
    page.to_html()
}
