//! The front as aligned text, as a table for programs, and as a figure.

use super::Front;
use super::answer::PlaceAnswer;
use super::measure::FrontPoint;
use crate::captions;
use crate::exploration::Exploration;
use robovec_error::yardstick::account::ERROR_HEADS;
use robovec_fpga::hardware;
use robovec_ir::Machine;
use robovec_ir::diagnostic::counted;
use robovec_present::number::{exponential, share_percent};
use robovec_present::page;
use robovec_present::text::{cut, distinct, thinned};
use robovec_present::{
    AxisScale, ColumnList, Curve, DataTable, Figure, Mark, Paint, Panel, PlotAxis, Stroke, columns,
};
use std::fmt::Write;

/// State of a point with some elements: on the front, dominated, or impossible.
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
        "normwise found", [Exponent(1), Exponent(3)], |row| row.point.found;
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

/// A choice of the thesis, and ours that dominate it: the best, and alike.
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

    fn headline(&self) -> String {
        self.gain_text()
    }

    fn lines(&self) -> Vec<(&'static str, String)> {
        self.evidence()
    }

    fn short_table(&self) -> String {
        let Some(answer) = self.headlined() else {
            return String::new();
        };
        let PlaceAnswer {
            place,
            thesis,
            best,
        } = answer;
        let compared: Vec<usize> = [thesis].into_iter().chain(best).collect();
        let mut steps = self.steps(place);
        steps.retain(|index| !compared.contains(index));
        let mut rows = compared.clone();
        rows.extend(thinned(&steps, SHOWN - rows.len()));
        rows.sort_by_key(|&index| (self.points[index].cycles[place], index));
        let mark = |index: &usize| {
            if *index == thesis {
                "thesis"
            } else if Some(*index) == best {
                "ours"
            } else {
                ""
            }
        };
        let point = |index: &usize| &self.points[*index];
        let [_, worst] = ERROR_HEADS;
        let list = columns! { usize;
            "choice", [All, All], |index| cut(&point(index).choice, CHOICE);
            "format", [All, All], |index| point(index).format.as_str();
            "cycles", [All, All], move |index| point(index).cycles[place];
            worst, [Exponent(1), All], |index| point(index).normwise.worst;
            "found", [Exponent(1), All], |index| point(index).found;
            "", [All, All], mark;
        };
        list.text(&rows)
    }

    fn details(&self) -> String {
        let mut text = format!("{} as they came\n", counted(self.operations, "operation"));
        for (place, count) in self.elements.iter().enumerate() {
            let undominated = self.undominated(place);
            // What another one of ours beats is in the files.
            let rows: Vec<PointRow<'_>> = rows_of(self, place)
                .into_iter()
                .filter(|row| row.point.thesis || undominated.contains(&row.index))
                .collect();
            let table = columns().text(&rows);
            // Writing to a string cannot fail.
            let _ = writeln!(text, "\n{count}+{count} elements\n{table}");
        }
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

    fn figure(fronts: &[Front]) -> Figure {
        let panels = fronts.iter();
        let panels = panels.flat_map(|front| {
            let places = 0..front.elements.len();
            places.map(|place| panel(front, place))
        });
        let figure = captions::figure("front", "explore", &[], panels.collect());
        let figure = figure.expect("a function has a panel");
        figure.with_note(Stroke::Steps, STEPS)
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
        figure + &page::table(&verdicts_table(fronts), "")
    }
}

/// Caption of the front where it has steps.
pub(crate) const STEPS: &str = "The steps connect the points that no other beats in both.";

pub(crate) fn front_curve(marks: impl IntoIterator<Item = Mark>) -> Curve {
    Curve::new("front", Paint::Distinct(0), Stroke::Steps, marks)
}

/// Maximum number of rows on the terminal.
const SHOWN: usize = 10;
/// Maximum number of characters of a choice there.
const CHOICE: usize = 24;

/// Cycles against worst error with a number of elements: the front as steps, a
/// colour and marker for every format, and the answer's points.
fn panel(front: &Front, place: usize) -> Panel {
    let mark = |index: usize| {
        let point = &front.points[index];
        let cycles = point.cycles[place]?;
        Some(Mark::at(f64::from(cycles), point.normwise.worst.min(1e9)))
    };
    let steps = front.steps(place).into_iter().filter_map(mark);
    let mut curves = vec![front_curve(steps)];
    let mut group = |label: &str, colour, is_in: &dyn Fn(&FrontPoint) -> bool| {
        let indices = 0..front.points.len();
        let own = indices.filter(|&index| is_in(&front.points[index]));
        curves.push(Curve::points(label, colour, own.filter_map(mark)));
    };
    let ours = || front.points.iter().filter(|point| !point.thesis);
    let mut formats: Vec<&str> = ours().map(|point| point.format.as_str()).collect();
    formats.sort_unstable();
    formats.dedup();
    for (number, format) in formats.into_iter().enumerate() {
        let is_own = |point: &FrontPoint| !point.thesis && point.format == format;
        group(&format!("ours, {format}"), 3 + number, &is_own);
    }
    group("thesis, f32", 1, &|point| point.thesis);
    let answer = front.answer(place);
    let named = [
        ("thesis", answer.map(|answer| answer.thesis), 1),
        ("ours", answer.and_then(|answer| answer.best), 2),
    ];
    for (name, index, colour) in named {
        if let Some(mark) = index.and_then(mark) {
            let label = format!("{name} {}, {}", mark.x, exponential(mark.y));
            curves.push(Curve::points(label, colour, [mark]));
        }
    }
    let count = front.elements[place];
    Panel::curves(
        format!("{}, {count}+{count} elements", front.name),
        PlotAxis::new("schedule (cycles)", AxisScale::Decades),
        PlotAxis::new("worst normwise error", AxisScale::Decades),
        curves,
    )
}
