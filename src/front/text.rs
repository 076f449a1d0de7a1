//! The front as aligned text, as a table for programs, and as a figure.

use super::measure::Point;
use super::{Front, Verdict};
use crate::report::table;
use crate::study::figure::{Axis, Content, Curve, Figure, Mark, Paint, Panel, Scale, Stroke};
use crate::study::table::{Cell, Table};
use std::fmt::Write;

/// The unit of errors in figures: the rounding of one operation in binary32.
const UNIT: f64 = 1.0 / (1u32 << 24) as f64;

/// What a point is worth with a number of elements: on the front, beaten, or
/// not possible.
fn standing(front: &Front, index: usize, elements: usize, undominated: &[usize]) -> String {
    if front.points[index].cycles[elements].is_none() {
        return "does not fit".to_owned();
    }
    if undominated.contains(&index) {
        return "front".to_owned();
    }
    let verdict = front
        .verdicts
        .iter()
        .find(|verdict| (verdict.point, verdict.elements) == (index, elements));
    match verdict.map(|verdict| verdict.by) {
        Some(Some(by)) => {
            let better = &front.points[by];
            format!("beaten: {}, {}", better.choice, better.format)
        }
        Some(None) => "not beaten by ours".to_owned(),
        None => String::new(),
    }
}

fn exponential(number: f64) -> String {
    format!("{number:.1e}")
}

/// One table per number of elements, and what became of the thesis' choices.
pub fn text(front: &Front) -> String {
    let mut text = format!(
        "{}: {} operations as they came, {} states\n",
        front.name, front.operations, front.states
    );
    for (place, count) in front.elements.iter().enumerate() {
        let undominated = front.undominated(place);
        // What another one of ours beats is in the files.
        let shown = |index: &usize| front.points[*index].thesis || undominated.contains(index);
        let rows: Vec<Vec<String>> = order(front, place)
            .into_iter()
            .filter(shown)
            .map(|index| {
                let point = &front.points[index];
                let cycles = point.cycles[place];
                vec![
                    if point.thesis { "thesis" } else { "ours" }.to_owned(),
                    point.choice.clone(),
                    point.format.clone(),
                    point.operations.to_string(),
                    point.path.to_string(),
                    cycles.map_or("-".to_owned(), |cycles| cycles.to_string()),
                    point.microseconds[place].map_or("-".to_owned(), |time| format!("{time:.2}")),
                    point
                        .cpu_ns
                        .map_or("-".to_owned(), |time| format!("{time:.0}")),
                    exponential(point.relative.median),
                    exponential(point.relative.percentile_99),
                    exponential(point.normwise.worst),
                    standing(front, index, place, &undominated),
                ]
            })
            .collect();
        let head = [
            "by",
            "choice",
            "format",
            "operations",
            "path",
            "cycles",
            "us",
            "CPU ns",
            "median",
            "99 %",
            "worst normwise",
            "",
        ];
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "\n{count}+{count} elements\n{}",
            table(&head, &rows, &[3, 4, 5, 6, 7, 8, 9, 10])
        );
    }
    let count = |by: fn(&Verdict) -> Option<usize>| {
        let verdicts = front.verdicts.iter();
        verdicts.filter(|verdict| by(verdict).is_some()).count()
    };
    let _ = writeln!(
        text,
        "\nof the {} choices of the thesis, counted per number of elements, {} are dominated, {} \
         of them within their own number format",
        front.verdicts.len(),
        count(|verdict| verdict.by),
        count(|verdict| verdict.in_its_format),
    );
    text
}

/// Points from the fastest on.
fn order(front: &Front, elements: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..front.points.len()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (&front.points[a], &front.points[b]);
        let cycles = |point: &Point| point.cycles[elements].unwrap_or(u32::MAX);
        let faster = cycles(a).cmp(&cycles(b));
        faster.then(a.normwise.worst.total_cmp(&b.normwise.worst))
    });
    order
}

/// All points of all functions as one table.
pub fn points_table(fronts: &[Front]) -> Table {
    let mut rows = Vec::new();
    for front in fronts {
        for (place, count) in front.elements.iter().enumerate() {
            let undominated = front.undominated(place);
            for index in order(front, place) {
                let point = &front.points[index];
                let errors = [point.relative, point.normwise];
                let mut row = vec![
                    Cell::text(&front.name),
                    Cell::count(*count),
                    Cell::text(if point.thesis { "thesis" } else { "ours" }),
                    Cell::text(&point.choice),
                    Cell::text(&point.format),
                    Cell::count(point.operations),
                    Cell::count(point.path),
                    point.cycles[place].map_or(Cell::Empty, Cell::count),
                    point.microseconds[place].map_or(Cell::Empty, |time| Cell::number(time, 3)),
                    point
                        .cpu_ns
                        .map_or(Cell::Empty, |time| Cell::number(time, 1)),
                ];
                for spread in errors {
                    for error in [spread.median, spread.percentile_99, spread.worst] {
                        row.push(Cell::text(format!("{error:.3e}")));
                    }
                }
                row.push(Cell::text(&point.worst.0));
                row.push(Cell::count(point.worst.1));
                row.push(Cell::text(standing(front, index, place, &undominated)));
                rows.push(row);
            }
        }
    }
    let columns = [
        "function",
        "elements per kind",
        "by",
        "choice",
        "format",
        "operations",
        "path (cycles)",
        "cycles",
        "time (us)",
        "CPU (ns)",
        "relative median",
        "relative 99 %",
        "relative worst",
        "normwise median",
        "normwise 99 %",
        "normwise worst",
        "of",
        "in state",
        "standing",
    ];
    Table {
        name: "front".to_owned(),
        title: "Speed against error".to_owned(),
        caption: "Every choice in every format. Errors are those of the whole program against \
                  double-double: series, rounding, data. A choice is beaten when another one is \
                  nowhere worse and somewhere better in cycles, in the median of the relative \
                  errors and in the worst normwise error."
            .to_owned(),
        columns: columns.map(str::to_owned).to_vec(),
        rows,
    }
}

/// What the thesis could choose, and what of ours is nowhere worse.
pub fn verdicts_table(fronts: &[Front]) -> Table {
    let mut rows = Vec::new();
    for front in fronts {
        for verdict in &front.verdicts {
            let (place, old) = (verdict.elements, &front.points[verdict.point]);
            let cycles = |point: &Point| point.cycles[place].map_or(Cell::Empty, Cell::count);
            let error = |point: &Point| Cell::text(exponential(point.normwise.worst));
            let mut row = vec![
                Cell::text(&front.name),
                Cell::count(front.elements[place]),
                Cell::text(&old.choice),
                cycles(old),
                error(old),
            ];
            let Some(new) = verdict.by.map(|by| &front.points[by]) else {
                row.push(Cell::text("not dominated"));
                row.resize(VERDICT_COLUMNS.len(), Cell::Empty);
                rows.push(row);
                continue;
            };
            let faster = old.cycles[place].zip(new.cycles[place]);
            let faster = faster.map(|(old, new)| f64::from(old) / f64::from(new.max(1)));
            let in_its_format = verdict.in_its_format.map(|by| &front.points[by]);
            row.extend([
                Cell::text(format!("{}, {}", new.choice, new.format)),
                cycles(new),
                error(new),
                faster.map_or(Cell::Empty, |faster| Cell::number(faster, 2)),
                Cell::number(old.normwise.worst / new.normwise.worst, 1),
                in_its_format.map_or(Cell::Empty, |point| Cell::text(&point.choice)),
                in_its_format.map_or(Cell::Empty, cycles),
            ]);
            rows.push(row);
        }
    }
    Table {
        name: "verdicts".to_owned(),
        title: "What the thesis could choose, and what dominates it".to_owned(),
        caption: "The fastest of ours that is nowhere worse in cycles, median and worst error; in \
                  the last columns the same with the number format of the thesis."
            .to_owned(),
        columns: VERDICT_COLUMNS.map(str::to_owned).to_vec(),
        rows,
    }
}

const VERDICT_COLUMNS: [&str; 12] = [
    "function",
    "elements per kind",
    "thesis",
    "cycles",
    "worst error",
    "ours",
    "cycles",
    "worst error",
    "times faster",
    "times more exact",
    "ours in its format",
    "cycles",
];

/// One panel per function and number of elements: cycles against error.
pub fn figure(fronts: &[Front]) -> Figure {
    let panels: Vec<Panel> = fronts
        .iter()
        .flat_map(|front| (0..front.elements.len()).map(|place| panel(front, place)))
        .collect();
    Figure {
        name: "front".to_owned(),
        title: "Speed against error".to_owned(),
        caption: "Length of the schedule against the worst normwise error, in units of the \
                  rounding of binary32 (2^-24); the line joins the points that no other one beats."
            .to_owned(),
        columns: panels.len().clamp(1, 2),
        panels,
    }
}

fn panel(front: &Front, place: usize) -> Panel {
    let mark = |index: usize| {
        let point = &front.points[index];
        let cycles = f64::from(point.cycles[place].unwrap_or(0));
        Mark::at(cycles, point.normwise.worst.min(1e9) / UNIT)
    };
    let mut curves = vec![Curve {
        label: String::new(),
        paint: Paint::Distinct(0),
        stroke: Stroke::Plain,
        marks: front.undominated(place).into_iter().map(mark).collect(),
    }];
    let placed = |index: &usize| front.points[*index].cycles[place].is_some();
    let mut groups: Vec<(bool, String)> = Vec::new();
    for index in (0..front.points.len()).filter(placed) {
        let point = &front.points[index];
        let label = match point.thesis {
            true => format!("thesis: {}", point.choice),
            false => format!("ours, {}", point.format),
        };
        let group = (point.thesis, label);
        let known = groups.iter().position(|known| *known == group);
        let number = known.unwrap_or_else(|| {
            groups.push(group.clone());
            curves.push(Curve {
                label: group.1,
                paint: Paint::Distinct(groups.len()),
                stroke: Stroke::Points,
                marks: Vec::new(),
            });
            groups.len() - 1
        });
        curves[number + 1].marks.push(mark(index));
    }
    let count = front.elements[place];
    Panel {
        title: format!("{}, {count}+{count} elements", front.name),
        x: Axis::new("schedule (cycles)", Scale::Decades),
        y: Axis::new("worst normwise error (2^-24)", Scale::Decades),
        content: Content::Curves(curves),
    }
}
