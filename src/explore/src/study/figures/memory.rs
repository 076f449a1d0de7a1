//! Figures 2.4 to 2.7: words of memory and buffer by naive and other choice.

use super::super::printed::SystemTopology;
use super::super::results::{Results, StudyPlacement};
use super::elements;
use crate::captions;
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};
use robovec_schedule::{ElementChoice, PlaceOptions, Priority};

pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let Some(machine) = results.main_machine() else {
        return Vec::new();
    };
    let mut figures = Vec::new();
    for (model, subject) in results.plan.models.iter().enumerate() {
        let numbers = match results.system(model).map(|system| system.topology) {
            Some(SystemTopology::Bogie) => Some(["2.4", "2.5"]),
            Some(SystemTopology::Mixed) => Some(["2.6", "2.7"]),
            _ => None,
        };
        let place = [model, results.original(), machine];
        for (part, what) in ["memory", "buffer"].into_iter().enumerate() {
            let label = &subject.name;
            let number = numbers.map(|numbers| numbers[part]);
            let (name, prefix) = match number {
                Some(number) => (format!("figure-{number}"), format!("Figure {number}: ")),
                None => (format!("{what}-{label}"), String::new()),
            };
            let words = [
                ("number", prefix.as_str()),
                ("what", what),
                ("model", label),
            ];
            let panels = panels(results, place, part, what);
            figures.extend(captions::figure("memory", &name, &words, panels));
        }
    }
    figures.sort_by(|a, b| a.name.cmp(&b.name));
    figures
}

/// Words of memory (part 0) or of buffer, by kind; empty where incomplete.
fn panels(results: &Results, place: [usize; 3], part: usize, what: &str) -> Vec<Panel> {
    let points = |choice: ElementChoice| -> Vec<StudyPlacement<'_>> {
        let options = PlaceOptions {
            priority: Priority::Alap,
            choice,
        };
        let placed = results.placed().filter(|placed| {
            let request = placed.request;
            [request.model, request.pipeline, request.machine] == place
                && request.options == options
                && placed.is_equal()
        });
        placed.collect()
    };
    // The two stand a little apart.
    let choices = [
        (ElementChoice::First, "naive", Stroke::MarkedDashed, 0.96),
        (
            ElementChoice::Preferential,
            "preferential",
            Stroke::Marked,
            1.04,
        ),
    ]
    .map(|(choice, label, stroke, shift)| (points(choice), label, stroke, shift));
    if choices.iter().any(|(points, ..)| points.is_empty()) {
        return Vec::new();
    }
    let panel = |(kind, title): (usize, &str)| {
        let curves = choices.iter().enumerate().map(|(index, choice)| {
            let (points, label, stroke, shift) = choice;
            let marks = points.iter().map(|placed| {
                let kind = &placed.point.kinds[kind];
                let [least, mean, most] = [kind.memory, kind.buffer][part];
                Mark {
                    range: Some([least, most]),
                    ..Mark::at(f64::from(placed.elements()) * shift, mean)
                }
            });
            Curve::new(*label, Paint::Distinct(1 - index), *stroke, marks)
        });
        let y = PlotAxis::new(&format!("{what} (words)"), AxisScale::Linear).showing(0.0, 1.0);
        Panel::curves(title, elements(), y, curves)
    };
    let kinds = ["adders", "multipliers"].into_iter().enumerate();
    kinds.map(panel).collect()
}
