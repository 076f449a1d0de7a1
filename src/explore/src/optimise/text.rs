//! Programs that were tried, as a table for the terminal, a file and a figure.

use super::answer::{OptimisationAnswer, SpeedMeasure, nanoseconds};
use super::{OptimisationPoint, Optimised};
use crate::captions;
use robovec_error::yardstick::account::{ERROR_HEADS, measure_text};
use robovec_ir::diagnostic::counted;
use robovec_present::json::json_script;
use robovec_present::number::{exponential, share_percent};
use robovec_present::page::{self, PointsPage};
use robovec_present::text::cut;
use robovec_present::{
    AxisScale, ColumnList, Curve, DataTable, Digits, Figure, Mark, Paint, Panel, PlotAxis, Stroke,
    columns,
};
use std::fmt::Write;

/// The rows of a table from the best on: measured ones, then the others.
fn order(points: &[OptimisationPoint]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (&points[a], &points[b]);
        let time = |point: &OptimisationPoint| {
            let time = point.nanoseconds.or(point.cycles.map(f64::from));
            time.unwrap_or(f64::INFINITY)
        };
        let faster = b.taken.cmp(&a.taken).then(time(a).total_cmp(&time(b)));
        faster.then(a.operations.cmp(&b.operations))
    });
    order
}

/// The columns of a table of points; those of speed and cost on the terminal
/// are a processor's where programs were timed, else a machine's.
fn columns<'a>(is_timed: bool) -> ColumnList<'a, &'a OptimisationPoint> {
    let timed = |digits| if is_timed { digits } else { Digits::Hidden };
    let placed = |digits| if is_timed { Digits::Hidden } else { digits };
    let error =
        |place: usize| move |point: &&OptimisationPoint| point.errors.map(|errors| errors[place]);
    let [median, worst] = ERROR_HEADS;
    columns! { &OptimisationPoint;
        "program", [All, All], |point| point.name.as_str();
        "starts from", [Hidden, All], |point| point.start.as_str();
        "passes", [Hidden, All], |point| point.passes.as_str();
        "operations", [All, All], |point| point.operations;
        "path (cycles)", [timed(All), All], |point| point.path;
        "bound (cycles)", [placed(All), All], |point| point.bound;
        "cycles", [placed(All), All], |point| point.cycles;
        "time (us)", [Hidden, Decimals(3)], |point| point.microseconds;
        "C (ns per state)", [timed(Words(nanoseconds)), Decimals(3)], |point| point.nanoseconds;
        "share of device", [placed(Words(share_percent)), Decimals(4)], |point| point.share;
        "code (bytes)", [timed(All), All], |point| point.code_bytes;
        median, [Exponent(1), Exponent(3)], error(0);
        worst, [Exponent(1), Exponent(3)], error(1);
        "found", [Exponent(1), Exponent(3)], |point| point.found;
        "proved", [Exponent(1), Exponent(3)], |point| point.proved;
        "note", [All, All], |point| match mark(point) { "" => point.remark.as_str(), mark => mark };
    }
}

/// Maximum number of programs in the table for the terminal.
pub(super) const SHOWN: usize = 8;
/// Maximum number of programs where more is requested.
const SHOWN_MORE: usize = 40;
/// Maximum number of characters of a name on the terminal.
const NAME: usize = 24;

/// The table for the terminal: the Pareto front of speed against error, the
/// fastest first, with the input and the program that was taken in it; of this
/// number of rows, at least two and at most eight.
pub fn front_table(found: &Optimised, measure: SpeedMeasure, rows: usize) -> String {
    let rows: Vec<_> = found
        .shown(measure, rows.clamp(2, SHOWN))
        .into_iter()
        .map(|index| &found.points[index])
        .collect();
    let [_, worst] = ERROR_HEADS;
    let digits = match measure {
        SpeedMeasure::Operations | SpeedMeasure::Cycles => Digits::Decimals(0),
        _ => Digits::Words(nanoseconds),
    };
    let list = columns! { &OptimisationPoint;
        "program", [All, All], |point| cut(&point.name, NAME);
        measure.name(), [digits, All], move |point| measure.of(point);
        worst, [Exponent(1), All], |point| point.errors.map(|errors| errors[1]);
        "found", [Exponent(1), All], |point| point.found;
        "proved", [Exponent(1), All], |point| point.proved;
        "", [All, All], |point| mark(point);
    };
    list.text(&rows)
}

fn mark(point: &OptimisationPoint) -> &str {
    match (point.taken, point.is_input) {
        (true, _) => "taken",
        (false, true) => "input",
        (false, false) => "",
    }
}

/// The best programs with all their figures, for detailed output.
pub fn table(found: &Optimised) -> String {
    let is_timed = found.points.iter().any(|point| point.nanoseconds.is_some());
    let order = order(&found.points);
    let best: Vec<_> = order
        .iter()
        .take(SHOWN_MORE)
        .map(|&index| &found.points[index])
        .collect();
    let mut text = columns(is_timed).text(&best);
    // Writing to a string cannot fail, here and below.
    let _ = write!(
        text,
        "\nerrors in {}, in parts {}",
        found.errors.format,
        measure_text(&found.errors.states)
    );
    text
}

/// Programs in numbers: those that were measured, and those that were not.
pub fn numbers(found: &Optimised) -> String {
    let mut text = counted(found.points.len() - 1, "program");
    let mut others = Vec::new();
    if found.untimed > 0 {
        others.push(format!("{} not timed, of more work", found.untimed));
    }
    if found.alike > 0 {
        others.push(format!("{} alike", found.alike));
    }
    if !found.skipped.is_empty() {
        others.push(format!("{} not made", found.skipped.len()));
    }
    if !others.is_empty() {
        text += &format!(" ({})", others.join(", "));
    }
    text
}

/// All that was tried, for a file.
pub fn points_table(found: &Optimised) -> DataTable {
    let rows: Vec<_> = order(&found.points)
        .into_iter()
        .map(|index| &found.points[index])
        .collect();
    captions::table("optimise", &[], &columns(true), &rows)
}

/// Speed against error: the front as steps, the input and the chosen program.
pub fn figure(found: &Optimised, measure: SpeedMeasure) -> Figure {
    let place = |point: &OptimisationPoint| Some((measure.of(point)?, point.errors?[1]));
    let mark =
        |point: &OptimisationPoint| place(point).map(|(speed, error)| Mark::at(speed, error));
    let is_plain = |point: &&OptimisationPoint| !point.taken && !point.is_input;
    let tried = found.points.iter().filter(is_plain).filter_map(mark);
    let front = found.front(measure).into_iter();
    let front: Vec<Mark> = front
        .filter_map(|index| mark(&found.points[index]))
        .collect();
    let label = if front.len() > 1 { "front" } else { "" };
    let mut curves = vec![
        Curve::new("tried", Paint::Distinct(3), Stroke::Points, tried),
        Curve::new(label, Paint::Distinct(0), Stroke::Steps, front),
    ];
    type Error = fn(&OptimisationPoint) -> Option<f64>;
    let limits: [(&str, usize, Error); 2] = [
        ("found for any state", 4, |point| point.found),
        ("proved", 5, |point| point.proved),
    ];
    for (label, colour, error) in limits {
        let place = |point| Some(Mark::at(measure.of(point)?, error(point)?));
        let marks: Vec<Mark> = found.points.iter().filter_map(place).collect();
        if !marks.is_empty() {
            curves.push(Curve::points(label, colour, marks));
        }
    }
    for (name, index, colour) in [("input", 0, 1), ("taken", found.best, 2)] {
        let point = &found.points[index];
        if let Some((speed, error)) = place(point) {
            let label = format!("{name} {}, {}", measure.text(speed), exponential(error));
            curves.push(Curve::points(label, colour, [Mark::at(speed, error)]));
        }
    }
    let panel = Panel::curves(
        "",
        PlotAxis::new(measure.name(), AxisScale::Decades),
        PlotAxis::new("worst error", AxisScale::Decades),
        curves,
    );
    captions::figure("optimise", "optimise", &[], vec![panel]).expect("it has a panel")
}

/// Texts of a page about a search.
pub struct OptimisationPage<'a> {
    /// The file or model, and its function.
    pub subject: &'a str,
    /// The answer.
    pub answer: &'a OptimisationAnswer,
    /// Lines of evidence, with their labels.
    pub lines: &'a [(&'static str, String)],
    /// Commands that make the program again.
    pub commands: &'a str,
    /// Names and texts of the input and of the program.
    pub code: [(&'a str, &'a str); 2],
}

/// The page: answer, speed against error, code before and after, all trials.
pub fn page(found: &Optimised, texts: &OptimisationPage<'_>) -> String {
    let OptimisationPage {
        subject,
        answer,
        lines,
        commands,
        code,
    } = *texts;
    let page = PointsPage {
        title: subject.to_owned(),
        subtitle: format!("Optimised by robovec {}.", env!("CARGO_PKG_VERSION")),
        figures: page::card(&answer.headline(), lines)
            + &page::figure(&figure(found, answer.measure))
            + "<h2>Before and after</h2>"
            + &page::side_by_side(code),
        points: "All that was tried",
        tables: page::table(&points_table(found), "optimise.csv")
            + &page::lines("How to make it again", commands),
        method: include_str!("method.html"),
        data: json_script(&found.points),
    };
    page.to_html()
}
