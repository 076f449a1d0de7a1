//! The front as aligned text, as a table for programs, and as a figure.

use super::measure::FrontPoint;
use super::{Front, FrontVerdict};
use crate::captions;
use crate::exploration::Exploration;
use robovec_error::yardstick::account::{measure_text, random_states};
use robovec_fpga::hardware;
use robovec_ir::Machine;
use robovec_ir::diagnostic::counted;
use robovec_present::number::share_percent;
use robovec_present::page;
use robovec_present::text::distinct;
use robovec_present::{
    AxisScale, ColumnList, Curve, DataTable, Figure, Mark, MarkFill, MarkZone, Panel, PlotAxis,
    columns,
};
use std::fmt::Write;

/// The unit of errors in figures: the rounding of one operation in binary32.
const UNIT: f64 = 1.0 / (1u32 << 24) as f64;

/// Standing of a point with a number of elements: on the front, beaten, or not
/// possible.
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

/// A point with a number of elements.
struct PointRow<'a> {
    front: &'a Front,
    place: usize,
    index: usize,
    point: &'a FrontPoint,
    standing: String,
}

/// The rows of a number of elements, the fastest first.
fn rows_of(front: &Front, place: usize) -> Vec<PointRow<'_>> {
    let undominated = front.undominated(place);
    let row = |index| PointRow {
        front,
        place,
        index,
        point: &front.points[index],
        standing: standing(front, index, place, &undominated),
    };
    order(front, place).into_iter().map(row).collect()
}

fn columns<'a>() -> ColumnList<'a, PointRow<'a>> {
    let by = |row: &PointRow<'_>| if row.point.thesis { "thesis" } else { "ours" };
    columns! { PointRow<'_>;
        "function", [Hidden, All], |row| row.front.name.as_str();
        "elements per kind", [Hidden, All], |row| row.front.elements[row.place];
        "by", [All, All], by;
        "choice", [All, All], |row| row.point.choice.as_str();
        "format", [All, All], |row| row.point.format.as_str();
        "operations", [All, All], |row| row.point.operations;
        "path (cycles)", [All, All], |row| row.point.path;
        "cycles", [All, All], |row| row.point.cycles[row.place];
        "time (us)", [Decimals(2), Decimals(3)], |row| row.point.microseconds[row.place];
        "CPU (ns)", [Decimals(0), Decimals(1)], |row| row.point.cpu_ns;
        "share of device", [Words(share_percent), Decimals(4)], |row| row.point.shares[row.place];
        "relative median", [Exponent(1), Exponent(3)], |row| row.point.relative.median;
        "relative 99 %", [Exponent(1), Exponent(3)], |row| row.point.relative.percentile_99;
        "relative worst", [Hidden, Exponent(3)], |row| row.point.relative.worst;
        "normwise median", [Exponent(1), Exponent(3)], |row| row.point.normwise.median;
        "normwise 99 %", [Hidden, Exponent(3)], |row| row.point.normwise.percentile_99;
        "normwise worst", [Exponent(1), Exponent(3)], |row| row.point.normwise.worst;
        "of", [Hidden, All], |row| row.point.worst.0.as_str();
        "in state", [Hidden, All], |row| row.point.worst.1;
        "standing", [All, All], |row| row.standing.clone();
    }
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

/// A choice of the thesis with what of ours is nowhere worse, and what of ours
/// in the same format.
struct VerdictRow<'a> {
    front: &'a Front,
    place: usize,
    old: &'a FrontPoint,
    new: Option<&'a FrontPoint>,
    alike: Option<&'a FrontPoint>,
}

/// Choices of the thesis, and those of ours that are nowhere worse.
fn verdicts_table(fronts: &[Front]) -> DataTable {
    let mut rows = Vec::new();
    for front in fronts {
        rows.extend(front.verdicts.iter().map(|verdict| {
            VerdictRow {
                front,
                place: verdict.elements,
                old: &front.points[verdict.point],
                new: verdict.by.map(|by| &front.points[by]),
                alike: verdict
                    .by
                    .and(verdict.in_its_format)
                    .map(|by| &front.points[by]),
            }
        }));
    }
    let cycles = |row: &VerdictRow<'_>, point: &FrontPoint| point.cycles[row.place];
    let faster = move |row: &VerdictRow<'_>| {
        let (old, new) = (cycles(row, row.old)?, cycles(row, row.new?)?);
        Some(f64::from(old) / f64::from(new.max(1)))
    };
    let ours = |row: &VerdictRow<'_>| match row.new {
        Some(new) => format!("{}, {}", new.choice, new.format),
        None => "not dominated".to_owned(),
    };
    let accurate = |row: &VerdictRow<'_>| Some(row.old.normwise.worst / row.new?.normwise.worst);
    let columns = columns! { VerdictRow<'_>;
        "function", [Hidden, All], |row| row.front.name.as_str();
        "elements per kind", [Hidden, All], |row| row.front.elements[row.place];
        "thesis", [Hidden, All], |row| row.old.choice.as_str();
        "cycles", [Hidden, All], move |row| cycles(row, row.old);
        "worst error", [Hidden, Exponent(1)], |row| row.old.normwise.worst;
        "ours", [Hidden, All], ours;
        "cycles", [Hidden, All], move |row| cycles(row, row.new?);
        "worst error", [Hidden, Exponent(1)], |row| Some(row.new?.normwise.worst);
        "times faster", [Hidden, Decimals(2)], faster;
        "times more accurate", [Hidden, Decimals(1)], accurate;
        "ours in its format", [Hidden, All], |row| Some(row.alike?.choice.as_str());
        "cycles", [Hidden, All], move |row| cycles(row, row.alike?);
    };
    captions::table("verdicts", &[], &columns, &rows)
}

impl Exploration for Front {
    const POINTS: &'static str = "All points";
    const METHOD: &'static str = include_str!("method.html");

    fn name(&self) -> &str {
        &self.name
    }

    /// One table per number of elements, and what became of the thesis' choices.
    fn text(&self) -> String {
        let mut text = format!(
            "{}: {} as they came, {}\n",
            self.name,
            counted(self.operations, "operation"),
            counted(self.states, "state")
        );
        for (name, reason) in &self.left {
            // Writing to a string cannot fail, here and below.
            let _ = writeln!(text, "formulation {name} was left out: {reason}");
        }
        for (place, count) in self.elements.iter().enumerate() {
            let undominated = self.undominated(place);
            // What another one of ours beats is in the files.
            let rows: Vec<PointRow<'_>> = rows_of(self, place)
                .into_iter()
                .filter(|row| row.point.thesis || undominated.contains(&row.index))
                .collect();
            let _ = writeln!(
                text,
                "\n{count}+{count} elements\n{}",
                columns().text(&rows)
            );
        }
        let drawn = random_states(self.states as usize, self.seed, self.has_ranges);
        let _ = writeln!(
            text,
            "\nmedian and worst error in parts {}; relative errors in parts of the element",
            measure_text(&drawn)
        );
        let count = |by: fn(&FrontVerdict) -> Option<usize>| {
            let verdicts = self.verdicts.iter();
            verdicts.filter(|verdict| by(verdict).is_some()).count()
        };
        let _ = writeln!(
            text,
            "\nof {} of the thesis, counted per number of elements, {} dominated, {} of them within \
             the own number format",
            counted(self.verdicts.len(), "choice"),
            count(|verdict| verdict.by),
            count(|verdict| verdict.in_its_format),
        );
        text
    }

    fn table(fronts: &[Front]) -> DataTable {
        let places = |front: &Front| 0..front.elements.len();
        let rows = fronts.iter();
        let rows =
            rows.flat_map(|front| places(front).flat_map(move |place| rows_of(front, place)));
        let rows: Vec<PointRow<'_>> = rows.collect();
        DataTable {
            name: "explore".to_owned(),
            ..captions::table("front", &[], &columns(), &rows)
        }
    }

    /// One panel per function and number of elements: cycles against error.
    fn figure(fronts: &[Front]) -> Figure {
        let panels = fronts.iter();
        let panels = panels.flat_map(|front| {
            let places = 0..front.elements.len();
            places.map(|place| panel(front, place))
        });
        let figure = captions::figure("front", "explore", &[], panels.collect());
        figure.expect("a function has a panel")
    }

    fn machines(fronts: &[Front]) -> [String; 2] {
        let mut machines: Vec<&Machine> = Vec::new();
        for front in fronts {
            if !machines.contains(&&front.machine) {
                machines.push(&front.machine);
            }
        }
        let devices = machines.iter();
        let devices = devices.map(|machine| machine.device.device().name.as_str());
        let devices = distinct(devices);
        let about = machines.into_iter().map(|machine| {
            let (name, clock) = (&machine.name, hardware::clock(machine).text());
            format!("Machine {name}: {}, {clock}.", machine.description)
        });
        [about.collect::<Vec<_>>().join(" "), devices]
    }

    fn opening(fronts: &[Front], figure: String) -> String {
        page::folding_table(&verdicts_table(fronts), "", true) + &figure
    }
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
        let label = if point.thesis {
            format!("thesis: {}", point.choice)
        } else {
            format!("ours, {}", point.format)
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
