//! The front as aligned text, as a table for programs, and as a figure.

use super::measure::FrontPoint;
use super::{Front, FrontVerdict};
use robovec_error::yardstick::account::{measure_text, random_states};
use robovec_ir::diagnostic::counted;
use robovec_present::number::{exponential, or_dash};
use robovec_present::{
    AxisScale, Curve, DataCell, DataTable, Figure, Mark, MarkFill, MarkZone, Panel, PlotAxis,
    text_table,
};
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

/// One table per number of elements, and what became of the thesis' choices.
pub fn text(front: &Front) -> String {
    let mut text = format!(
        "{}: {} as they came, {}\n",
        front.name,
        counted(front.operations, "operation"),
        counted(front.states, "state")
    );
    for (name, reason) in &front.left {
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(text, "formulation {name} was left out: {reason}");
    }
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
                    or_dash(cycles, |cycles| cycles.to_string()),
                    or_dash(point.microseconds[place], |time| format!("{time:.2}")),
                    or_dash(point.cpu_ns, |time| format!("{time:.0}")),
                    or_dash(point.shares[place], |share| {
                        format!("{:.2} %", share * 100.0)
                    }),
                    exponential(point.relative.median),
                    exponential(point.relative.percentile_99),
                    exponential(point.normwise.median),
                    exponential(point.normwise.worst),
                    standing(front, index, place, &undominated),
                ]
            })
            .collect();
        let head = "by | choice | format | >operations | >path | >cycles | >us | >CPU ns | >of device | \
         >relative median | >99 % | >median error | >worst error | ";
        let _ = writeln!(
            text,
            "\n{count}+{count} elements\n{}",
            text_table(head, &rows)
        );
    }
    let drawn = random_states(front.states as usize, front.seed, front.has_ranges);
    let _ = writeln!(
        text,
        "\nmedian and worst error in parts {}; relative errors in parts of the element",
        measure_text(&drawn)
    );
    let count = |by: fn(&FrontVerdict) -> Option<usize>| {
        let verdicts = front.verdicts.iter();
        verdicts.filter(|verdict| by(verdict).is_some()).count()
    };
    let _ = writeln!(
        text,
        "\nof {} of the thesis, counted per number of elements, {} dominated, {} of them within \
         the own number format",
        counted(front.verdicts.len(), "choice"),
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
        let cycles = |point: &FrontPoint| point.cycles[elements].unwrap_or(u32::MAX);
        let faster = cycles(a).cmp(&cycles(b));
        faster.then(a.normwise.worst.total_cmp(&b.normwise.worst))
    });
    order
}

/// All points of all functions as one table.
pub fn points_table(fronts: &[Front]) -> DataTable {
    let mut rows = Vec::new();
    for front in fronts {
        for (place, count) in front.elements.iter().enumerate() {
            let undominated = front.undominated(place);
            for index in order(front, place) {
                let point = &front.points[index];
                let errors = [point.relative, point.normwise];
                let mut row = vec![
                    DataCell::text(&front.name),
                    DataCell::count(*count),
                    DataCell::text(if point.thesis { "thesis" } else { "ours" }),
                    DataCell::text(&point.choice),
                    DataCell::text(&point.format),
                    DataCell::count(point.operations),
                    DataCell::count(point.path),
                    point.cycles[place].map_or(DataCell::Empty, DataCell::count),
                    point.microseconds[place]
                        .map_or(DataCell::Empty, |time| DataCell::number(time, 3)),
                    point
                        .cpu_ns
                        .map_or(DataCell::Empty, |time| DataCell::number(time, 1)),
                    point.shares[place].map_or(DataCell::Empty, |share| DataCell::number(share, 4)),
                ];
                for spread in errors {
                    for error in [spread.median, spread.percentile_99, spread.worst] {
                        row.push(DataCell::text(format!("{error:.3e}")));
                    }
                }
                row.push(DataCell::text(&point.worst.0));
                row.push(DataCell::count(point.worst.1));
                row.push(DataCell::text(standing(front, index, place, &undominated)));
                rows.push(row);
            }
        }
    }
    DataTable::new(
        "front",
        "Speed against error",
        "Every choice in every format. Errors are those of the whole program against \
                  double-double: series, rounding, data. A choice is beaten when another one is \
                  nowhere worse and somewhere better in cycles, in the median of the relative \
                  errors, in the worst normwise error and in the share of the device.",
        "function | elements per kind | by | choice | format | operations | path (cycles) | \
         cycles | time (us) | CPU (ns) | share of device | relative median | relative 99 % | relative worst | \
         normwise median | normwise 99 % | normwise worst | of | in state | standing",
        rows,
    )
}

/// Columns of the table of verdicts.
const VERDICT_CELLS: usize = 12;

/// What the thesis could choose, and what of ours is nowhere worse.
pub fn verdicts_table(fronts: &[Front]) -> DataTable {
    let mut rows = Vec::new();
    for front in fronts {
        for verdict in &front.verdicts {
            let (place, old) = (verdict.elements, &front.points[verdict.point]);
            let cycles =
                |point: &FrontPoint| point.cycles[place].map_or(DataCell::Empty, DataCell::count);
            let error = |point: &FrontPoint| DataCell::text(exponential(point.normwise.worst));
            let mut row = vec![
                DataCell::text(&front.name),
                DataCell::count(front.elements[place]),
                DataCell::text(&old.choice),
                cycles(old),
                error(old),
            ];
            let Some(new) = verdict.by.map(|by| &front.points[by]) else {
                row.push(DataCell::text("not dominated"));
                row.resize(VERDICT_CELLS, DataCell::Empty);
                rows.push(row);
                continue;
            };
            let faster = old.cycles[place].zip(new.cycles[place]);
            let faster = faster.map(|(old, new)| f64::from(old) / f64::from(new.max(1)));
            let in_its_format = verdict.in_its_format.map(|by| &front.points[by]);
            row.extend([
                DataCell::text(format!("{}, {}", new.choice, new.format)),
                cycles(new),
                error(new),
                faster.map_or(DataCell::Empty, |faster| DataCell::number(faster, 2)),
                DataCell::number(old.normwise.worst / new.normwise.worst, 1),
                in_its_format.map_or(DataCell::Empty, |point| DataCell::text(&point.choice)),
                in_its_format.map_or(DataCell::Empty, cycles),
            ]);
            rows.push(row);
        }
    }
    DataTable::new(
        "verdicts",
        "What the thesis could choose, and what dominates it",
        "The fastest of ours that is nowhere worse in cycles, median and worst error, \
                  and share of the device; in the last columns the same with the number format of the thesis.",
        "function | elements per kind | thesis | cycles | worst error | ours | cycles | \
         worst error | times faster | times more accurate | ours in its format | cycles",
        rows,
    )
}

/// One panel per function and number of elements: cycles against error.
pub fn figure(fronts: &[Front]) -> Figure {
    let panels: Vec<Panel> = fronts
        .iter()
        .flat_map(|front| (0..front.elements.len()).map(|place| panel(front, place)))
        .collect();
    Figure::new(
        "front",
        "Speed against error",
        "Length of the schedule against the worst normwise error, in units of the \
                  rounding of binary32 (2^-24). Full marks: points that no other one beats.",
        panels.len().clamp(1, 2),
        panels,
    )
}

/// The zone of points that no other one beats.
const FRONT: MarkZone = MarkZone {
    name: "front",
    fill: MarkFill::Full,
};

/// The zone of all others.
const BEATEN: MarkZone = MarkZone {
    name: "beaten",
    fill: MarkFill::Hollow,
};

fn panel(front: &Front, place: usize) -> Panel {
    let undominated = front.undominated(place);
    let mark = |index: usize| {
        let point = &front.points[index];
        let cycles = point.cycles[place].expect("it was placed");
        Mark {
            zone: Some(if undominated.contains(&index) {
                FRONT
            } else {
                BEATEN
            }),
            ..Mark::at(f64::from(cycles), point.normwise.worst.min(1e9) / UNIT)
        }
    };
    let mut curves: Vec<Curve> = Vec::new();
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
            curves.push(Curve::points(group.1, groups.len(), Vec::new()));
            groups.len() - 1
        });
        curves[number].marks.push(mark(index));
    }
    let count = front.elements[place];
    Panel::curves(
        format!("{}, {count}+{count} elements", front.name),
        PlotAxis::new("schedule (cycles)", AxisScale::Decades),
        PlotAxis::new("worst normwise error (2^-24)", AxisScale::Decades),
        curves,
    )
}
