//! Findings as text and as a figure.

use super::search::{NeglectFindings, WatchedCurve};
use robovec_ir::Machine;
use robovec_ir::diagnostic::counted;
use robovec_present::number::{exponential, or_dash};
use robovec_present::text::{headed, labelled};
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke, text_table};

/// The report: how much shorter and how exact the scene becomes, then speed,
/// error and cost of the scenes, and what everything was worth.
pub fn text(
    scene: &str,
    findings: &NeglectFindings,
    allowed: f64,
    time: f64,
    machine: &Machine,
) -> String {
    let mut lines = verdict(findings, allowed);
    let watched = findings.watched.iter();
    let watched = watched.map(|(name, scale)| format!("{name} {}", exponential(*scale)));
    let watched: Vec<String> = watched.collect();
    lines.push((
        "watched",
        format!("{} (largest displacement, m, rad)", watched.join(", ")),
    ));
    lines.push((
        "measured",
        format!(
            "operations of the function, with its sines and cosines, and of forces; cycles and \
             rounding on {}, in {}; error of the motion: the largest over {time} s, in parts of \
             the largest displacement; error of the equations: at states of the full motion, in \
             parts of the largest element of the array, against double-double",
            machine.name, machine.number
        ),
    ));
    format!(
        "{}{}\n{}\n\n{}",
        headed(scene, &headline(findings)),
        labelled(&lines),
        figures(findings),
        worth(findings)
    )
}

fn figures(findings: &NeglectFindings) -> String {
    let rows: Vec<Vec<String>> = findings
        .figures
        .iter()
        .map(|figures| {
            let effect = &figures.effect;
            vec![
                figures.what.to_owned(),
                (figures.operations.function + figures.operations.sin_cos).to_string(),
                figures.operations.forces.to_string(),
                effect.path.to_string(),
                or_dash(effect.placed, |(cycles, _)| cycles.to_string()),
                or_dash(effect.placed, |(_, share)| {
                    format!("{:.2} %", 100.0 * share)
                }),
                exponential(effect.normwise.worst),
                exponential(figures.equations.median),
                exponential(figures.equations.worst),
                exponential(figures.motion),
            ]
        })
        .collect();
    let head = "scene | >operations | >of forces | >longest chain | >cycles | >of device | \
                >rounding, worst | >equations, median | >worst | >motion";
    text_table(head, &rows)
}

fn worth(findings: &NeglectFindings) -> String {
    let shown = findings.findings.iter().filter(|finding| !finding.within);
    let mut order: Vec<_> = shown.collect();
    order.sort_by_key(|finding| finding.taken.map_or(usize::MAX, |(place, _)| place));
    let rows: Vec<Vec<String>> = order
        .into_iter()
        .map(|finding| {
            let alone = match &finding.alone {
                Ok(error) => exponential(*error),
                Err(reason) => reason.clone(),
            };
            vec![
                finding.what.clone(),
                or_dash(finding.saved, |saved| saved.to_string()),
                alone,
                or_dash(finding.taken, |(place, _)| place.to_string()),
                or_dash(finding.taken, |(_, error)| exponential(error)),
            ]
        })
        .collect();
    let head = "left out | >saves alone | >error alone | >order | >error of all so far";
    text_table(head, &rows) + "\n"
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

/// Errors of the reduced scene, with their labels.
fn verdict(findings: &NeglectFindings, allowed: f64) -> Vec<(&'static str, String)> {
    let reduced = findings.figures.last();
    let reduced = reduced.expect("the reduced scene was measured");
    let excess = if reduced.motion > allowed {
        "; the parts that the scene itself leaves out exceed the allowed error"
    } else {
        ""
    };
    let error = exponential(reduced.motion);
    let mut lines = vec![(
        "error",
        format!(
            "{error} of the motion, {} allowed{excess}",
            exponential(allowed)
        ),
    )];
    if let Some(fresh) = findings.fresh {
        let holds = if fresh <= allowed {
            "holds"
        } else {
            "does not hold"
        };
        let fresh = exponential(fresh);
        lines.push((
            "fresh",
            format!("{fresh} from starts the search has not seen: it {holds} there"),
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
    lines
}

/// The watched joints in the first motion, full and reduced.
pub fn figure(findings: &NeglectFindings) -> Figure {
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
    Figure::new(
        "neglect",
        "Full and reduced model",
        "The watched joints over the first motion, in the full model and with things left out.",
        1,
        panels.collect(),
    )
}
