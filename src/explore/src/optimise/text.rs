//! Programs that were tried, as a table for the terminal, a file and a figure.

use super::{OptimisationPoint, Optimised};
use crate::captions;
use robovec_error::yardstick::account::{ERROR_HEADS, measure_text};
use robovec_present::json::json_script;
use robovec_present::number::share_percent;
use robovec_present::page::{self, PointsPage};
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

/// The name of a point, with what it starts from.
fn name(point: &OptimisationPoint) -> String {
    match point.name.as_str() {
        "" => "as it came".to_owned(),
        name => name.to_owned(),
    }
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
        "program", [All, All], |point| name(point);
        "starts from", [Hidden, All], |point| point.start.as_str();
        "passes", [Hidden, All], |point| point.passes.as_str();
        "operations", [All, All], |point| point.operations;
        "path (cycles)", [timed(All), All], |point| point.path;
        "bound (cycles)", [placed(All), All], |point| point.bound;
        "cycles", [placed(All), All], |point| point.cycles;
        "time (us)", [Hidden, Decimals(3)], |point| point.microseconds;
        "C (ns per state)", [timed(Decimals(1)), Decimals(1)], |point| point.nanoseconds;
        "share of device", [placed(Words(share_percent)), Decimals(4)], |point| point.share;
        "code (bytes)", [timed(All), All], |point| point.code_bytes;
        median, [Exponent(1), Exponent(3)], error(0);
        worst, [Exponent(1), Exponent(3)], error(1);
        "standing", [All, All], |point| if point.taken { "taken" } else { &point.remark };
    }
}

/// Programs in the table for the terminal.
const SHOWN: usize = 10;

/// The table for the terminal, of the best programs.
pub fn table(found: &Optimised) -> String {
    let is_timed = found.points.iter().any(|point| point.nanoseconds.is_some());
    let order = order(&found.points);
    let best: Vec<_> = order
        .iter()
        .take(SHOWN)
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
    if order.len() > SHOWN {
        let more = order.len() - SHOWN;
        let _ = write!(text, "\n{more} more are in optimise.csv of '-o FOLDER'");
    }
    if found.untimed > 0 {
        let _ = write!(
            text,
            "\n{} more were made and not timed: by operations, loads and stores they promise less",
            found.untimed
        );
    }
    if !found.skipped.is_empty() || found.alike > 0 {
        let _ = write!(
            text,
            "\n{} more looked like one of these; {} were not made",
            found.alike,
            found.skipped.len()
        );
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

/// Speed against error of what was measured.
pub fn figure(found: &Optimised) -> Figure {
    let is_timed = found.points.iter().any(|point| point.nanoseconds.is_some());
    let marks = |taken: bool| {
        let points = found
            .points
            .iter()
            .filter(move |point| point.taken == taken);
        points.filter_map(move |point| {
            let time = if is_timed {
                point.nanoseconds
            } else {
                point.cycles.map(f64::from)
            };
            Some(Mark::at(time?, point.errors?[1]))
        })
    };
    let curves = vec![
        Curve::points("tried".to_owned(), 1, marks(false)),
        Curve::new("taken", Paint::Distinct(0), Stroke::Plain, marks(true)),
    ];
    let axis = if is_timed {
        "C (ns per state)"
    } else {
        "schedule (cycles)"
    };
    let panel = Panel::curves(
        "",
        PlotAxis::new(axis, AxisScale::Decades),
        PlotAxis::new("worst error", AxisScale::Decades),
        curves,
    );
    captions::figure("optimise", "optimise", &[], vec![panel]).expect("it has a panel")
}

/// The page: `facts` says what was taken and why, `commands` how it is made
/// again.
pub fn page(name: &str, found: &Optimised, facts: &str, commands: &str) -> String {
    let page = PointsPage {
        title: format!("The best program of {name}"),
        subtitle: format!("Computed by robovec {}.", env!("CARGO_PKG_VERSION")),
        figures: page::lines(facts) + &page::figure(&figure(found)),
        points: "All that was tried",
        tables: page::table(&points_table(found), "optimise.csv")
            + "<h2>How to make it again</h2>"
            + &page::lines(commands),
        method: include_str!("method.html"),
        data: json_script(&found.points),
    };
    page.to_html()
}
