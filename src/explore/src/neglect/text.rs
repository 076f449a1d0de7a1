//! Findings as text and as a figure.

use super::search::{NeglectFindings, WatchedCurve};
use robovec_ir::Machine;
use robovec_ir::diagnostic::counted;
use robovec_present::number::{exponential, or_dash};
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke, text_table};
use std::fmt::Write;

/// The report: what was compared, speed, error and cost of the scenes, and
/// what everything was worth.
pub fn text(findings: &NeglectFindings, allowed: f64, time: f64, machine: &Machine) -> String {
    let mut text = String::from("watched over the motion\n");
    let rows: Vec<Vec<String>> = findings
        .watched
        .iter()
        .map(|(name, scale)| vec![name.clone(), exponential(*scale)])
        .collect();
    text += &text_table("joint | >largest displacement (m, rad)", &rows);
    text += "\n\n";
    text += &figures(findings);
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(
        text,
        "\noperations of the function, with its sines and cosines, and of the forces of links and \
         points; longest chain, cycles and rounding on {}, in {}; error of the motion: the largest \
         over {time} s, in parts of the largest displacement; error of the equations: of the \
         needed outputs at states of the full motion, in parts of the largest element of the array, \
         against the full equations in double-double arithmetic",
        machine.name, machine.number
    );
    text += "\n";
    text += &worth(findings);
    text += &verdict(findings, allowed);
    text
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

fn verdict(findings: &NeglectFindings, allowed: f64) -> String {
    let taken = findings
        .findings
        .iter()
        .filter(|finding| finding.taken.is_some());
    let [full, .., reduced] = findings.figures.as_slice() else {
        unreachable!("the full and the reduced scene were measured");
    };
    let (before, after) = (full.operations.total(), reduced.operations.total());
    let share = 100.0 * after as f64 / before.max(1) as f64;
    let mut text = format!(
        "\n{} of {} left out: {before} -> {} ({share:.0} %), error of the motion \
         {} of {} allowed\n",
        taken.count(),
        findings.findings.len(),
        counted(after, "operation"),
        exponential(reduced.motion),
        exponential(allowed),
    );
    if reduced.motion > allowed {
        text += "what the scene itself leaves out exceeds the error it allows\n";
    }
    if let Some(fresh) = findings.fresh {
        let verdict = if fresh <= allowed {
            "holds"
        } else {
            "does not hold"
        };
        let _ = writeln!(
            text,
            "from starts the search has not seen: {}, so that it {verdict} there",
            exponential(fresh)
        );
    }
    if findings.rest > 0.0 {
        let _ = writeln!(
            text,
            "{} is left for number formats and series: `robovec fit` of the reduced scene",
            exponential(findings.rest)
        );
    }
    let _ = writeln!(
        text,
        "the integrator adds {}; what holds for these motions need not hold for others",
        exponential(findings.integration)
    );
    text
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
