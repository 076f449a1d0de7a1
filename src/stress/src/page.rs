//! Findings as a figure and as a self-contained page.

use super::view::{by_class, headline, lines, short};
use super::{CaseFinding, Findings};
use robovec_ir::diagnostic::counted;
use robovec_present::escape::{Escaped, EscapedContent};
use robovec_present::number::or_nothing;
use robovec_present::page::{self, PointsPage};
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};
use std::fmt::Write;

/// Smallest error that is drawn.
const LEAST: f64 = 1e-17;

/// An error of the findings.
type Chosen = fn(&Findings) -> f64;

/// Error against condition, and against the step of long simulations.
pub fn figure(findings: &[CaseFinding<'_>]) -> Figure {
    let errors: [(&str, Chosen); 3] = [
        ("f32", |found| found.short.error),
        ("f64", |found| found.long.error),
        ("cured", |found| {
            found.cure().map_or(f64::NAN, |trial| trial.measured.error)
        }),
    ];
    let panel = |title: &str, axis: &str, stroke, at: &dyn Fn(&Findings) -> Option<f64>| {
        let curve = |(index, &(label, error)): (usize, &(&str, Chosen))| {
            let mark = |(_, found): &CaseFinding<'_>| {
                let (x, y) = (at(found)?, error(found));
                // What is exact, and what is no result, ends at the edges.
                let drawable = x > 0.0 && x.is_finite() && !y.is_nan();
                drawable.then(|| Mark::at(x.log10(), y.clamp(LEAST, 1e3).log10()))
            };
            Curve::new(
                label,
                Paint::Distinct(index),
                stroke,
                findings.iter().filter_map(mark),
            )
        };
        let curves: Vec<Curve> = errors.iter().enumerate().map(curve).collect();
        Panel::curves(
            title,
            PlotAxis::new(axis, AxisScale::Linear),
            PlotAxis::new("relative error (log10)", AxisScale::Linear),
            curves,
        )
    };
    let of_condition = panel("All cases", "condition (log10)", Stroke::Points, &|found| {
        Some(found.condition)
    });
    let of_step = panel(
        "Energy drift",
        "step (s, log10)",
        Stroke::Marked,
        &|found| {
            found
                .untreated
                .step
                .filter(|_| found.metric == "energy drift")
        },
    );
    let panels: Vec<Panel> = [of_condition, of_step]
        .into_iter()
        .filter(|panel| !panel.is_empty())
        .collect();
    let mut all = findings
        .iter()
        .flat_map(|(_, found)| errors.map(|(_, error)| error(found)));
    let exact = if all.any(|error| error < LEAST) {
        "; smaller errors than 1e-17 are drawn there"
    } else {
        ""
    };
    let tried = findings.iter().any(|(_, found)| found.cure.is_some());
    let kinds = if tried {
        "binary32, in binary64 and with the cheapest cure"
    } else {
        "binary32 and in binary64"
    };
    let title = match panels.as_slice() {
        [_, _] => "Error against condition, and against the step",
        [only] if only.title == "Energy drift" => "Error against the step",
        _ => "Error against condition",
    };
    Figure::new(
        "stress",
        title,
        format!("Every case: its error in {kinds}{exact}."),
        panels.len().max(1),
        panels,
    )
}

/// The findings as a page.
pub fn page(findings: &[CaseFinding<'_>]) -> String {
    let figure = figure(findings);
    let mut tables = String::new();
    for (class, of_class) in by_class(findings) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            tables,
            "<h3>{}</h3>\n<p class=\"soft\">{}</p>",
            class.name,
            EscapedContent(class.description)
        );
        for finding in of_class {
            section(&mut tables, finding);
        }
    }
    let page = PointsPage {
        title: "Hard cases and their cures".to_owned(),
        subtitle: format!(
            "{}, computed by robovec {}",
            counted(findings.len(), "case"),
            env!("CARGO_PKG_VERSION")
        ),
        figures: page::card(&headline(findings), &lines(findings))
            + &if figure.panels.is_empty() {
                String::new()
            } else {
                page::figure(&figure)
            },
        points: "Cases",
        tables,
        method: "<p>Errors are relative, compared with double-double numbers; costs are the cells of \
                 the operations, those of a product the square of its bits, relative to the \
                 untreated program in binary32. The chosen cure is set in bold. Treatments that \
                 another beats in cost and error are in stress.csv.</p>",
        data: "null".to_owned(),
    };
    page.to_html()
}

/// Treatments that none beats in cost and error, cheapest first, and the cure.
fn kept(found: &Findings) -> Vec<usize> {
    let mut order: Vec<usize> = (0..found.trials.len()).collect();
    let measures = |index: usize| {
        let trial = &found.trials[index];
        (trial.cost, trial.measured.error)
    };
    order.sort_by(|&a, &b| {
        let (a, b) = (measures(a), measures(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut least = f64::INFINITY;
    order.retain(|&index| {
        let error = measures(index).1;
        let is_kept = error < least || found.cure == Some(index);
        least = least.min(error);
        is_kept
    });
    order
}

/// A case with the treatments that matter.
fn section(text: &mut String, (case, found): &CaseFinding<'_>) {
    let colour = match found.verdict.name() {
        "fine" => "fine",
        "hard problem" => "hard",
        _ => "bad",
    };
    let breaks = match case.breaks.as_str() {
        "" => String::new(),
        breaks => format!(" Breaks {}.", EscapedContent(breaks)),
    };
    // As above, writing cannot fail.
    let _ = writeln!(
        text,
        "<details id=\"{}\"><summary><b>{}</b>: <span class=\"{colour}\">{}</span>, {} {} in f32, {} in \
         f64{}</summary>\n<p>{}.{} Condition {}; rounding the data once causes an error of {}.</p>",
        Escaped(&case.name),
        EscapedContent(&case.name),
        found.verdict,
        EscapedContent(found.metric),
        short(found.short.error),
        short(found.long.error),
        or_nothing(found.cure(), |trial| format!(
            "; cured by {} at {:.2} times the cost",
            EscapedContent(&trial.label),
            trial.cost
        )),
        EscapedContent(&case.construction),
        breaks,
        short(found.condition),
        short(found.floor),
    );
    text.push_str("<div class=\"scroll tall\"><table class=\"data\"><thead><tr><th>treatment</th><th class=\"n\">cost</th><th class=\"n\">error</th>");
    for (name, _) in &found.short.others {
        let _ = write!(text, "<th class=\"n\">{}</th>", EscapedContent(name));
    }
    text.push_str("<th class=\"n\">out of range</th></tr></thead><tbody>\n");
    let untreated = ("as it is", 1.0, &found.short, false);
    let trials = kept(found).into_iter().map(|index| {
        let trial = &found.trials[index];
        let chosen = found.cure == Some(index);
        (trial.label.as_str(), trial.cost, &trial.measured, chosen)
    });
    for (label, cost, measured, chosen) in std::iter::once(untreated).chain(trials) {
        let _ = write!(
            text,
            "<tr{}><td>{}</td><td class=\"n\">{cost:.2}</td><td class=\"n\">{}</td>",
            if chosen { " class=\"chosen\"" } else { "" },
            EscapedContent(label),
            short(measured.error)
        );
        for (_, number) in &measured.others {
            let _ = write!(text, "<td class=\"n\">{}</td>", short(*number));
        }
        let _ = writeln!(
            text,
            "<td class=\"n\">{:.1} %</td></tr>",
            100.0 * measured.outside
        );
    }
    text.push_str("</tbody></table></div></details>\n");
}
