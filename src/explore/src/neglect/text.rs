//! Findings as text, tables, a figure and a page.

use super::search::{NeglectFinding, NeglectFindings, NeglectTask, SceneFigures, WatchedCurve};
use crate::captions;
use crate::exploration::scene_subtitle;
use robovec_ir::diagnostic::counted;
use robovec_present::json::{json_script, json_text};
use robovec_present::number::{exponential, share_percent};
use robovec_present::page::{self, PointsPage};
use robovec_present::text::{headed, labelled};
use robovec_present::{
    AxisScale, ColumnList, Curve, DataTable, Figure, Mark, Paint, Panel, PlotAxis, Stroke, columns,
    plot,
};

/// Maximum number of parts and of joints that the terminal lists.
const SHOWN: usize = 6;

/// The report for the terminal: the answer and scenes; all on request.
pub fn text(task: &NeglectTask<'_>, findings: &NeglectFindings, is_verbose: bool) -> String {
    let most = if is_verbose { usize::MAX } else { SHOWN };
    let mut lines = lines(task, findings, most);
    let mut parts = String::new();
    if is_verbose {
        lines.push(("measured", scenes_table(task, findings).caption));
        parts = format!("\n{}", part_columns().text(&by_order(findings)));
    }
    let head = headed(&task.file.scene.name, &headline(findings)) + &labelled(&lines);
    let scenes = scene_columns().text(&findings.figures);
    format!("{head}\n{scenes}{parts}")
}

/// The page, the parts as tables, and the figure, by name.
pub fn report(task: &NeglectTask<'_>, findings: &NeglectFindings) -> Vec<(String, String)> {
    let scenes = scenes_table(task, findings);
    let parts = captions::table("reduce", &[], &part_columns(), &by_order(findings));
    let figure = figure(findings);
    let page = PointsPage {
        title: format!("Reduced scene {}", task.file.scene.name),
        subtitle: scene_subtitle(&task.file.scene, task.machine),
        figures: page::card(&headline(findings), &lines(task, findings, usize::MAX))
            + &page::figure(&figure),
        points: "Scenes and parts",
        tables: page::table(&scenes, "") + &page::table(&parts, "reduce.csv"),
        method: include_str!("method.html"),
        data: json_script(&parts),
    };
    let files = [
        ("reduce.html", page.to_html()),
        ("reduce.csv", parts.to_csv()),
        ("reduce.json", json_text(&[scenes, parts])),
        ("reduce.svg", plot::draw(&figure)),
    ];
    files.map(|(name, text)| (name.to_owned(), text)).to_vec()
}

fn scene_columns<'a>() -> ColumnList<'a, SceneFigures> {
    columns! { SceneFigures;
        "scene", [All, All], |row| row.what;
        "operations", [All, All], |row| row.operations.total();
        "of forces", [Hidden, All], |row| row.operations.forces;
        "longest chain", [Hidden, All], |row| row.effect.path;
        "cycles", [All, All], |row| row.effect.placed.map(|(cycles, _)| cycles);
        "of device", [Words(share_percent), Words(share_percent)],
            |row| row.effect.placed.map(|(_, share)| share);
        "rounding", [Exponent(1), Exponent(1)], |row| row.effect.normwise.worst;
        "equations, median", [Hidden, Exponent(1)], |row| row.equations.median;
        "equations, worst", [Hidden, Exponent(1)], |row| row.equations.worst;
        "motion", [Exponent(1), Exponent(1)], |row| row.motion;
    }
}

fn scenes_table(task: &NeglectTask<'_>, findings: &NeglectFindings) -> DataTable {
    let time = (task.file.motion.as_ref()).map_or(0.0, |motion| motion.time);
    let (machine, number) = (&task.machine.name, task.machine.number.to_string());
    let words = [
        ("time", &*time.to_string()),
        ("machine", machine),
        ("number", &number),
    ];
    captions::table(
        "reduced-scenes",
        &words,
        &scene_columns(),
        &findings.figures,
    )
}

fn part_columns<'a>() -> ColumnList<'a, &'a NeglectFinding> {
    columns! { &NeglectFinding;
        "left out", [All, All], |part| part.what.as_str();
        "saves alone", [Decimals(0), Decimals(0)], |part| part.saved.map(|saved| saved as f64);
        "error alone", [All, All], |part| match &part.alone {
            Ok(error) => exponential(*error),
            Err(reason) => reason.clone(),
        };
        "order", [All, All], |part| part.taken.map(|(place, _)| place);
        "error of all so far", [Exponent(1), Exponent(1)],
            |part| part.taken.map(|(_, error)| error);
    }
}

/// The parts in the order in which they were left out, then the others.
fn by_order(findings: &NeglectFindings) -> Vec<&NeglectFinding> {
    let shown = findings.findings.iter().filter(|finding| !finding.within);
    let mut order: Vec<_> = shown.collect();
    order.sort_by_key(|finding| finding.taken.map_or(usize::MAX, |(place, _)| place));
    order
}

/// A list of at most this number of texts.
fn list(all: &[String], most: usize) -> String {
    if all.is_empty() {
        return "nothing".to_owned();
    }
    let shown = all[..all.len().min(most)].join(", ");
    match all.len().saturating_sub(most) {
        0 => shown,
        more => format!("{shown} and {more} more (-v)"),
    }
}

/// Operations of the full and of the reduced scene, in one line.
fn headline(findings: &NeglectFindings) -> String {
    let taken = findings.findings.iter();
    let taken = taken.filter(|finding| finding.taken.is_some()).count();
    let [full, .., reduced] = findings.figures.as_slice() else {
        unreachable!("the full and the reduced scene were measured");
    };
    let (before, after) = (full.operations.total(), reduced.operations.total());
    format!(
        "{:.2} times fewer operations: {before} -> {after}, {taken} of {} left out",
        before as f64 / after.max(1) as f64,
        counted(findings.findings.len(), "part")
    )
}

/// Lines after the headline, with their labels; of lists at most this number.
fn lines(
    task: &NeglectTask<'_>,
    findings: &NeglectFindings,
    most: usize,
) -> Vec<(&'static str, String)> {
    let allowed = (task.file.motion.as_ref()).map_or(0.0, |motion| motion.error);
    let parts = by_order(findings).into_iter();
    let parts = parts.filter(|part| part.taken.is_some());
    let parts: Vec<String> = parts.map(|part| part.what.clone()).collect();
    let reduced = findings.figures.last();
    let reduced = reduced.expect("the reduced scene was measured");
    let excess = if reduced.motion > allowed {
        "; the parts that the scene itself leaves out exceed the allowed error"
    } else {
        ""
    };
    let error = exponential(reduced.motion);
    let allowed_text = exponential(allowed);
    let mut lines = vec![
        ("left out", list(&parts, most)),
        (
            "error",
            format!("{error} of the motion, {allowed_text} allowed{excess}"),
        ),
    ];
    if let Some(searched) = findings.searched {
        let (starts, steps) = (searched.starts, searched.steps);
        let worst = exponential(searched.worst);
        lines.push((
            "searched",
            format!("{starts} starts: at most {worst} of {allowed_text} allowed ({steps} steps)"),
        ));
    }
    if findings.rest > 0.0 {
        let rest = exponential(findings.rest);
        lines.push((
            "remaining",
            format!("{rest} for number formats and series: 'robovec fit' of the reduced scene"),
        ));
    }
    let integration = exponential(findings.integration);
    lines.push((
        "integrator",
        format!("adds {integration}; other motions may need more"),
    ));
    let watched = findings.watched.iter();
    let watched: Vec<String> = watched
        .map(|(name, scale)| format!("{name} {}", exponential(*scale)))
        .collect();
    let watched = list(&watched, most / 2);
    lines.push((
        "watched",
        format!("{watched} (largest displacement, m, rad)"),
    ));
    lines
}

/// The watched joints in the first motion, full and reduced.
fn figure(findings: &NeglectFindings) -> Figure {
    let panels = findings.watched.iter().zip(&findings.curves);
    let panels = panels.map(|((name, _), WatchedCurve { full, reduced })| {
        let marks = |curve: &[(f64, f64)]| {
            let marks = curve
                .iter()
                .map(|&(time, position)| Mark::at(time, position));
            marks.collect::<Vec<_>>()
        };
        let curves = [
            Curve::new("full", Paint::Distinct(0), Stroke::Plain, marks(full)),
            Curve::new(
                "reduced",
                Paint::Distinct(1),
                Stroke::Dashed,
                marks(reduced),
            ),
        ];
        Panel::curves(
            name.as_str(),
            PlotAxis::new("time (s)", AxisScale::Linear).from(0.0),
            PlotAxis::new("position (m, rad)", AxisScale::Linear),
            curves,
        )
    });
    captions::figure("reduce", "reduce", &[], panels.collect()).expect("a joint is watched")
}
