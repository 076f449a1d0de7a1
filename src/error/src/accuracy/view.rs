//! Errors of passes as text, table and figure.

use super::{FunctionAccuracy, PassAccuracy};
use robovec_analysis::rounding::{MedianChange, Quantiles, Trend};
use robovec_ir::diagnostic::counted;
use robovec_present::number::units;
use robovec_present::{
    AxisScale, Curve, DataCell, DataTable, Figure, Mark, Paint, Panel, PlotAxis, Stroke, text_lines,
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
    let head = "pass | >operations | >path | >relative: median | >99 % | >worst | \
         >normwise: median | >99 % | >worst | median became";
    let rows: Vec<Vec<String>> = subject.steps.iter().map(row).collect();
    text += &text_lines(head, &rows);
    text
}

fn row(step: &PassAccuracy) -> Vec<String> {
    let name = match step.pass.as_str() {
        "" => "(as read)",
        pass => pass,
    };
    let mut row = vec![
        name.to_owned(),
        step.operations.to_string(),
        step.path.to_string(),
    ];
    for quantiles in [&step.rounding.relative, &step.rounding.normwise] {
        row.extend(numbers(quantiles).map(units));
    }
    row.push(match &step.changes {
        None => String::new(),
        Some([relative, _]) => relative.to_string(),
    });
    row
}

fn numbers(quantiles: &Quantiles) -> [f64; 3] {
    [quantiles.median, quantiles.percentile_99, quantiles.worst]
}

/// Which passes made the median worse, pass by pass, and the whole pipeline.
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
    let rows: Vec<Vec<String>> = tallies.iter().map(PassTally::row).collect();
    let head = "pass | >relative: better | >same | >worse | >normwise: better | >same | >worse | \
         worse for";
    let mut text = format!("The medians of {}:\n", counted(subjects.len(), "function"));
    text += &text_lines(head, &rows);
    text
}

/// How many functions a pass made better, left the same and made worse.
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

    fn row(&self) -> Vec<String> {
        let counts = self.counts.iter().flatten().map(ToString::to_string);
        let mut row = vec![self.pass.to_owned()];
        row.extend(counts);
        row.push(self.worse.join(", "));
        row
    }
}

/// The same as a table for programs.
pub fn table(subjects: &[FunctionAccuracy]) -> DataTable {
    let line = |subject: &FunctionAccuracy, step: &PassAccuracy| {
        let mut row = vec![
            DataCell::text(&subject.name),
            DataCell::text(&step.pass),
            DataCell::count(step.operations),
            DataCell::count(step.path),
            DataCell::count(step.rounding.states),
        ];
        for quantiles in [&step.rounding.relative, &step.rounding.normwise] {
            row.extend(numbers(quantiles).map(|number| DataCell::number(number, 4)));
        }
        for measure in 0..2 {
            row.extend(match step.changes.map(|changes| changes[measure]) {
                None => [DataCell::Empty, DataCell::Empty, DataCell::Empty],
                Some(change) => [
                    DataCell::number(change.ratio, 4),
                    DataCell::number(change.noise, 4),
                    DataCell::text(change.trend.name()),
                ],
            });
        }
        row
    };
    DataTable::new(
        "accuracy",
        "Rounding errors in binary32 after every pass",
        "All outputs in all states as one population, in units of the rounding of \
                  one operation, 2^-24; relative to the element, and to the largest element \
                  of its array. A line without a pass is the function as it was read.",
        "function | pass | operations | path (cycles) | states | relative median (2^-24) | \
         relative 99 % (2^-24) | relative worst (2^-24) | normwise median (2^-24) | \
         normwise 99 % (2^-24) | normwise worst (2^-24) | relative median after/before | \
         noise | trend | normwise median after/before | noise | trend",
        subjects
            .iter()
            .flat_map(|subject| subject.steps.iter().map(move |step| line(subject, step))),
    )
}

/// Speed against error: for each subject the way the passes take it.
pub fn figure(subjects: &[FunctionAccuracy]) -> Figure {
    let panels: Vec<Panel> = subjects
        .iter()
        .filter(|subject| !subject.steps.is_empty())
        .map(panel)
        .collect();
    Figure::new(
        "accuracy",
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
