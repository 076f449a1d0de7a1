//! Figures 2.4 to 2.7: words of memory and of buffer by the naive and by the
//! preferential choice of elements.

use super::super::captions::{self, Words};
use super::super::plan::{ChoiceKey, PriorityKey};
use super::super::point::KindPoint;
use super::super::printed::SystemTopology;
use super::super::results::{Results, StudyPlacement};
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};

pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let pipeline = results.original();
    let Some(machine) = results.main_machine() else {
        return Vec::new();
    };
    let mut figures = Vec::new();
    for model in 0..results.plan.models.len() {
        let numbers = match results.system(model).map(|system| system.topology) {
            Some(SystemTopology::Bogie) => Some(["2.4", "2.5"]),
            Some(SystemTopology::Mixed) => Some(["2.6", "2.7"]),
            _ => None,
        };
        for (part, what) in [(0, "memory"), (1, "buffer")] {
            let label = &results.plan.models[model].name;
            let (name, prefix) = match numbers {
                Some(numbers) => (
                    format!("figure-{}", numbers[part]),
                    format!("Figure {}: ", numbers[part]),
                ),
                None => (format!("{what}-{label}"), String::new()),
            };
            let words = [
                ("number", prefix.as_str()),
                ("what", what),
                ("model", label),
            ];
            let subject = [model, pipeline, machine];
            figures.extend(figure(results, subject, part, &name, &words));
        }
    }
    figures.sort_by(|a, b| a.name.cmp(&b.name));
    figures
}

fn figure(
    results: &Results,
    [model, pipeline, machine]: [usize; 3],
    part: usize,
    name: &str,
    words: &Words<'_>,
) -> Option<Figure> {
    let points = |choice: ChoiceKey| -> Vec<StudyPlacement<'_>> {
        let placed = results.placed().filter(|placed| {
            let request = placed.request;
            (request.model, request.pipeline, request.machine) == (model, pipeline, machine)
                && (request.priority, request.choice) == (PriorityKey::Alap, choice)
                && placed.is_equal()
        });
        placed.collect()
    };
    let choices = [
        (ChoiceKey::First, "naive", 0.96),
        (ChoiceKey::Preferential, "preferential", 1.04),
    ];
    if choices
        .iter()
        .any(|(choice, ..)| points(*choice).is_empty())
    {
        return None;
    }
    let panel = |kind: usize, title: &str| {
        let curve = |(index, (choice, label, shift)): (usize, (ChoiceKey, &str, f64))| {
            Curve::new(
                label,
                Paint::Distinct(1 - index),
                if index == 0 {
                    Stroke::MarkedDashed
                } else {
                    Stroke::Marked
                },
                points(choice)
                    .iter()
                    .map(|placed| mark(*placed, &placed.point.kinds[kind], part, shift)),
            )
        };
        Panel::curves(
            title,
            PlotAxis::new(
                "processing elements, adders + multipliers",
                AxisScale::PowersOfTwo,
            ),
            PlotAxis::new(
                ["memory (words)", "buffer (words)"][part],
                AxisScale::Linear,
            )
            .showing(0.0, 1.0),
            choices.into_iter().enumerate().map(curve),
        )
    };
    let panels = vec![panel(0, "adders"), panel(1, "multipliers")];
    captions::figure("memory", name, words, panels)
}

/// A bar; the two choices stand a little apart.
fn mark(placed: StudyPlacement<'_>, kind: &KindPoint, part: usize, shift: f64) -> Mark {
    let [least, mean, most] = if part == 0 { kind.memory } else { kind.buffer };
    let at = Mark::at(f64::from(placed.elements()) * shift, mean);
    Mark {
        range: Some([least, most]),
        ..at
    }
}
