//! What was tried, as a table for the terminal, a file and a figure.

use super::{OptimisationPoint, Optimised};
use robovec_error::yardstick::account::{ERROR_COLUMNS, ERROR_HEADS, measure_text, share_cell};
use robovec_present::{AxisScale, Curve, Mark, Paint, Panel, PlotAxis, Stroke};
use robovec_present::{DataCell, DataTable, Figure, text_table};
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

fn error(point: &OptimisationPoint, place: usize) -> String {
    let error = point.errors.map(|errors| errors[place]);
    error.map_or("-".to_owned(), |error| format!("{error:.1e}"))
}

/// Programs in the table for the terminal.
const SHOWN: usize = 10;

/// The table for the terminal, of the best programs.
pub fn table(found: &Optimised) -> String {
    let is_timed = found.points.iter().any(|point| point.nanoseconds.is_some());
    let or_dash = |number: Option<String>| number.unwrap_or_else(|| "-".to_owned());
    let order = order(&found.points);
    let rows: Vec<Vec<String>> = order
        .iter()
        .take(SHOWN)
        .map(|&index| {
            let point = &found.points[index];
            let time = match is_timed {
                true => point.nanoseconds.map(|time| format!("{time:.1}")),
                false => point.cycles.map(|cycles| cycles.to_string()),
            };
            let second = match is_timed {
                true => point.path.to_string(),
                false => or_dash(point.bound.map(|bound| bound.to_string())),
            };
            let kilobytes = point.code_bytes.map(|bytes| bytes as f64 * 1e-3);
            let cost = match is_timed {
                true => or_dash(kilobytes.map(|size| format!("{size:.1}"))),
                false => share_cell(point.share),
            };
            vec![
                name(point),
                point.operations.to_string(),
                second,
                or_dash(time),
                cost,
                error(point, 0),
                error(point, 1),
                match point.taken {
                    true => "taken".to_owned(),
                    false => point.remark.clone(),
                },
            ]
        })
        .collect();
    let speed_and_cost = match is_timed {
        true => ">path | >ns/state | >code kB",
        false => ">bound | >cycles | >of device",
    };
    let head = format!("program | >operations | {speed_and_cost} | {ERROR_HEADS} | ");
    let mut text = text_table(&head, &rows);
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
    let rows = order(&found.points).into_iter().map(|index| {
        let point = &found.points[index];
        let number = |number: Option<f64>, decimals| {
            number.map_or(DataCell::Empty, |number| DataCell::number(number, decimals))
        };
        let count = |count: Option<u64>| count.map_or(DataCell::Empty, DataCell::count);
        let error = |place: usize| match point.errors {
            Some(errors) => DataCell::text(format!("{:.3e}", errors[place])),
            None => DataCell::Empty,
        };
        vec![
            DataCell::text(name(point)),
            DataCell::text(&point.start),
            DataCell::text(&point.passes),
            DataCell::count(point.operations),
            DataCell::count(point.path),
            count(point.bound.map(u64::from)),
            count(point.cycles.map(u64::from)),
            number(point.microseconds, 3),
            number(point.nanoseconds, 1),
            number(point.share, 4),
            count(point.code_bytes),
            error(0),
            error(1),
            DataCell::text(match point.taken {
                true => "taken",
                false => &point.remark,
            }),
        ]
    });
    let rows: Vec<Vec<DataCell>> = rows.collect();
    DataTable::new(
        "optimise",
        "What was tried",
        "Every program that was made: operations, the longest path, the proved bound of its \
         schedules, what was measured, the share of the device that the machine takes for it, and \
         the errors of its results in the number format of the target, in parts of the largest \
         element of an array, against double-double arithmetic.",
        &format!(
            "program | starts from | passes | operations | path (cycles) | bound (cycles) | \
             cycles | time (us) | C (ns per state) | share of device | code (bytes) | {ERROR_COLUMNS} | standing"
        ),
        rows,
    )
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
            let time = match is_timed {
                true => point.nanoseconds,
                false => point.cycles.map(f64::from),
            };
            Some(Mark::at(time?, point.errors?[1]))
        })
    };
    let curves = vec![
        Curve::points("tried".to_owned(), 1, marks(false)),
        Curve::new("taken", Paint::Distinct(0), Stroke::Plain, marks(true)),
    ];
    let axis = match is_timed {
        true => "C (ns per state)",
        false => "schedule (cycles)",
    };
    let panel = Panel::curves(
        "",
        PlotAxis::new(axis, AxisScale::Decades),
        PlotAxis::new("worst error", AxisScale::Decades),
        curves,
    );
    Figure::new(
        "optimise",
        "Speed against error",
        "Every program that was measured.",
        1,
        vec![panel],
    )
}
