//! Figures 3.4 to 3.8 (cycles) and 3.9 to 3.13 (parallelisation rate)
//! against the number of elements.

use super::super::captions::{self, Words};
use super::super::program::ProgramFacts;
use super::super::results::{Results, StudyPlacement};
use super::super::variants;
use super::super::zone::zone;
use super::{ladder, pipeline_label};
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};

/// Degrees of freedom and the numbers of their figures in the thesis.
const NUMBERS: [(u32, &str, &str); 5] = [
    (23, "3.4", "3.9"),
    (50, "3.5", "3.10"),
    (70, "3.6", "3.11"),
    (100, "3.7", "3.12"),
    (130, "3.8", "3.13"),
];

/// Quantity of a figure.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Cycles,
    Rate,
}

impl Quantity {
    /// The name of its figures and their texts.
    fn name(self) -> &'static str {
        match self {
            Quantity::Cycles => "cycles",
            Quantity::Rate => "rate",
        }
    }
}

pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let mut figures = Vec::new();
    for quantity in [Quantity::Cycles, Quantity::Rate] {
        for (dof, cycles, rate) in NUMBERS {
            let number = if quantity == Quantity::Cycles {
                cycles
            } else {
                rate
            };
            let members = |model: &usize| {
                results
                    .system(*model)
                    .is_some_and(|system| system.dof == dof)
            };
            let models: Vec<usize> = (0..results.plan.models.len()).filter(members).collect();
            let subject = format!("the {dof}-dof systems");
            figures.extend(figure(
                results,
                &models,
                quantity,
                &format!("figure-{number}"),
                &[
                    ("number", &format!("Figure {number}: ")),
                    ("subject", &subject),
                ],
            ));
        }
        for model in 0..results.plan.models.len() {
            if results.system(model).is_none() && !variants::is_variant(results, model) {
                let label = &results.plan.models[model].name;
                let name = format!("{}-{label}", quantity.name());
                let words = [("number", ""), ("subject", label.as_str())];
                figures.extend(figure(results, &[model], quantity, &name, &words));
            }
        }
    }
    figures
}

fn figure(
    results: &Results,
    models: &[usize],
    quantity: Quantity,
    name: &str,
    words: &Words<'_>,
) -> Option<Figure> {
    let machine = results.main_machine()?;
    let panels: Vec<Panel> = models
        .iter()
        .filter_map(|&model| panel(results, model, machine, quantity))
        .collect();
    captions::figure(quantity.name(), name, words, panels)
}

fn panel(results: &Results, model: usize, machine: usize, quantity: Quantity) -> Option<Panel> {
    let mut curves = Vec::new();
    for pipeline in 0..results.plan.pipelines.len() {
        let placed = ladder(results, model, pipeline, machine);
        let (Some(facts), Some(first), Some(last)) = (
            results.program(model, pipeline, machine),
            placed.first(),
            placed.last(),
        ) else {
            continue;
        };
        let paint = Paint::Distinct(pipeline);
        let marks = placed.iter().map(|placed| mark(facts, *placed, quantity));
        curves.push(Curve::new(
            pipeline_label(results, pipeline),
            paint,
            Stroke::Marked,
            marks,
        ));
        curves.push(Curve::new(
            "",
            paint,
            Stroke::Dashed,
            guidance(facts, first.elements(), last.elements(), quantity),
        ));
    }
    let title = results.plan.models[model].name.clone();
    let elements = PlotAxis::new(
        "processing elements, adders + multipliers",
        AxisScale::PowersOfTwo,
    );
    let y = match quantity {
        Quantity::Cycles => PlotAxis::new("cycles", AxisScale::Decades),
        Quantity::Rate => {
            PlotAxis::new("parallelisation rate (%)", AxisScale::Linear).showing(0.0, 100.0)
        }
    };
    (!curves.is_empty()).then_some(Panel::curves(title, elements, y, curves))
}

fn mark(facts: &ProgramFacts, placed: StudyPlacement<'_>, quantity: Quantity) -> Mark {
    let y = match quantity {
        Quantity::Cycles => f64::from(placed.point.cycles),
        Quantity::Rate => 100.0 * placed.point.rate,
    };
    Mark {
        zone: Some(zone(facts, placed).mark()),
        ..Mark::at(f64::from(placed.elements()), y)
    }
}

/// The guidance curve between two numbers of elements, with its corner.
fn guidance(facts: &ProgramFacts, from: u32, to: u32, quantity: Quantity) -> Vec<Mark> {
    let (low, high) = (f64::from(from), f64::from(to));
    let steps = (0..=32).map(|step| low * (high / low).powf(f64::from(step) / 32.0));
    let corner = Some(facts.number_y()).filter(|y| (low..high).contains(y));
    let mut places: Vec<f64> = steps.chain(corner).collect();
    places.sort_by(f64::total_cmp);
    let value = |elements: f64| {
        let cycles = (facts.operations as f64 / elements).max(f64::from(facts.asap_cycle));
        match quantity {
            Quantity::Cycles => cycles,
            // Rounding may lead over full use.
            Quantity::Rate => (100.0 * facts.operations as f64 / (elements * cycles)).min(100.0),
        }
    };
    places
        .into_iter()
        .map(|elements| Mark::at(elements, value(elements)))
        .collect()
}
