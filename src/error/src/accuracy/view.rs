//! Errors of passes as text, table and figure.

use super::{FunctionAccuracy, PassAccuracy};
use robovec_analysis::rounding::{MedianChange, Trend};
use robovec_ir::diagnostic::counted;
use robovec_present::number::units;
use robovec_present::{
    AxisScale, ColumnList, Curve, DataTable, Figure, Mark, Paint, Panel, PlotAxis, Stroke, columns,
};
use std::fmt::Write;

/// The errors of one subject, one line for each pass.
pub fn text(subject: &FunctionAccuracy) -> String {
    let Some(first) = subject.steps.first() else {
        return String::new();
    };
    let mut text = format!(
        "{}: rounding errors in binary32 in units of 2^-24, {}, seed {}\n",
        subject.name,
        counted(first.rounding.states, "random state"),
        first.rounding.seed
    );
    let rows: Vec<MeasuredStep<'_>> = subject.steps.iter().map(|step| (subject, step)).collect();
    text += &columns().text(&rows);
    text
}

type MeasuredStep<'a> = (&'a FunctionAccuracy, &'a PassAccuracy);

fn columns<'a>() -> ColumnList<'a, MeasuredStep<'a>> {
    let shown = |row: &MeasuredStep<'a>| match row.1.pass.as_str() {
        "" => "(as read)",
        pass => pass,
    };
    columns! { MeasuredStep<'_>;
        "function", [Hidden, All], |row| row.0.name.as_str();
        "pass", [All, Hidden], shown;
        "pass", [Hidden, All], |row| row.1.pass.as_str();
        "operations", [All, All], |row| row.1.operations;
        "path (cycles)", [All, All], |row| row.1.path;
        "states", [Hidden, All], |row| row.1.rounding.states;
        "relative median (2^-24)", [Words(units), Decimals(4)], |r| r.1.rounding.relative.median;
        "relative 99 % (2^-24)", [Words(units), Decimals(4)], |r| r.1.rounding.relative.percentile_99;
        "relative worst (2^-24)", [Words(units), Decimals(4)], |r| r.1.rounding.relative.worst;
        "normwise median (2^-24)", [Words(units), Decimals(4)], |r| r.1.rounding.normwise.median;
        "normwise 99 % (2^-24)", [Words(units), Decimals(4)], |r| r.1.rounding.normwise.percentile_99;
        "normwise worst (2^-24)", [Words(units), Decimals(4)], |r| r.1.rounding.normwise.worst;
        "median became", [All, Hidden], |row| Some(row.1.changes?[0].to_string());
        "relative median after/before", [Hidden, Decimals(4)], |row| Some(row.1.changes?[0].ratio);
        "noise", [Hidden, Decimals(4)], |row| Some(row.1.changes?[0].noise);
        "trend", [Hidden, All], |row| Some(row.1.changes?[0].trend.name());
        "normwise median after/before", [Hidden, Decimals(4)], |row| Some(row.1.changes?[1].ratio);
        "noise", [Hidden, Decimals(4)], |row| Some(row.1.changes?[1].noise);
        "trend", [Hidden, All], |row| Some(row.1.changes?[1].trend.name());
    }
}

/// Passes that made the median worse, pass by pass, and the whole pipeline.
pub fn summary(subjects: &[FunctionAccuracy]) -> String {
    const WHOLE: &str = "(whole pipeline)";
    let mut tallies: Vec<PassTally<'_>> = Vec::new();
    let mut whole = PassTally::new(WHOLE);
    for subject in subjects {
        if let Some(changes) = subject.overall() {
            whole.count(&subject.name, changes);
        }
        for step in &subject.steps {
            let Some(changes) = step.changes else {
                continue;
            };
            let index = tallies.iter().position(|tally| tally.pass == step.pass);
            let index = index.unwrap_or_else(|| {
                tallies.push(PassTally::new(&step.pass));
                tallies.len() - 1
            });
            tallies[index].count(&subject.name, changes);
        }
    }
    tallies.push(whole);
    let columns = columns! { PassTally<'_>;
        "pass", [All, Hidden], |tally| tally.pass;
        "relative: better", [All, Hidden], |tally| tally.counts[0][0];
        "same", [All, Hidden], |tally| tally.counts[0][1];
        "worse", [All, Hidden], |tally| tally.counts[0][2];
        "normwise: better", [All, Hidden], |tally| tally.counts[1][0];
        "same", [All, Hidden], |tally| tally.counts[1][1];
        "worse", [All, Hidden], |tally| tally.counts[1][2];
        "worse for", [All, Hidden], |tally| tally.worse.join(", ");
    };
    let mut text = format!("The medians of {}:\n", counted(subjects.len(), "function"));
    text += &columns.text(&tallies);
    text
}

/// Number of functions a pass made better, left the same and made worse.
struct PassTally<'a> {
    pass: &'a str,
    counts: [[usize; 3]; 2],
    worse: Vec<String>,
}

impl PassTally<'_> {
    fn new(pass: &str) -> PassTally<'_> {
        PassTally {
            pass,
            counts: [[0; 3]; 2],
            worse: Vec::new(),
        }
    }

    fn count(&mut self, subject: &str, changes: [MedianChange; 2]) {
        let measures = ["relative", "normwise"];
        for ((change, counts), measure) in changes.iter().zip(&mut self.counts).zip(measures) {
            let column = match change.trend {
                Trend::Better => 0,
                Trend::Same => 1,
                Trend::Worse => 2,
            };
            counts[column] += 1;
            if change.trend == Trend::Worse {
                let percent = (change.ratio - 1.0) * 100.0;
                self.worse
                    .push(format!("{subject} ({measure} {percent:+.1} %)"));
            }
        }
    }
}

/// The same as a table for programs.
pub fn table(subjects: &[FunctionAccuracy]) -> DataTable {
    let rows: Vec<MeasuredStep<'_>> = subjects
        .iter()
        .flat_map(|subject| subject.steps.iter().map(move |step| (subject, step)))
        .collect();
    columns().table(
        "passes",
        "Rounding errors in binary32 after every pass",
        "All outputs in all states as one population, in units of the rounding of \
                  one operation, 2^-24; relative to the element, and to the largest element \
                  of its array. A line without a pass is the function as it was read.",
        &rows,
    )
}

/// Speed against error: for each subject the path through the passes.
pub fn figure(subjects: &[FunctionAccuracy]) -> Figure {
    let panels: Vec<Panel> = subjects
        .iter()
        .filter(|subject| !subject.steps.is_empty())
        .map(panel)
        .collect();
    Figure::new(
        "passes",
        "Speed against error, pass by pass",
        "The longest path and the median of the relative error in binary32 after every pass.",
        panels.len().clamp(1, 3),
        panels,
    )
    .with_note(Stroke::Plain, "The line joins the passes in order.")
}

fn panel(subject: &FunctionAccuracy) -> Panel {
    let mark = |step: &PassAccuracy| Mark::at(f64::from(step.path), step.rounding.relative.median);
    let mut curves = vec![Curve::new(
        "",
        Paint::Distinct(0),
        Stroke::Plain,
        subject.steps.iter().map(mark),
    )];
    // Passes that stay where they are share the mark of the one before.
    let mut last: Option<(u32, f64)> = None;
    for step in &subject.steps {
        let place = (step.path, step.rounding.relative.median);
        let name = match step.pass.split('{').next() {
            None | Some("") => "as read",
            Some(pass) => pass,
        };
        if last == Some(place)
            && let Some(curve) = curves.last_mut()
        {
            let _ = write!(curve.label, ", {name}");
            continue;
        }
        last = Some(place);
        curves.push(Curve::points(name, curves.len() - 1, vec![mark(step)]));
    }
    Panel::curves(
        subject.name.clone(),
        PlotAxis::new("longest path (cycles)", AxisScale::Linear),
        // A scale of its own would make noise look like a cliff.
        PlotAxis::new("median relative error (2^-24)", AxisScale::Linear).from(0.0),
        curves,
    )
}
