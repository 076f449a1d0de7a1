//! Figures 3.4 to 3.8 (cycles) and 3.9 to 3.13 (parallelisation rate)
//! against the number of elements; formulations and unequal numbers.

use super::super::program::ProgramFacts;
use super::super::results;
use super::super::results::{Results, StudiedProgram, StudyPlacement};
use super::{elements, label, percentage};
use crate::captions::{self, Words};
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke, TileMap};

/// Degrees of freedom, and the figures of cycles and of rates in the thesis.
const NUMBERS: [(u32, [&str; 2]); 5] = [
    (23, ["3.4", "3.9"]),
    (50, ["3.5", "3.10"]),
    (70, ["3.6", "3.11"]),
    (100, ["3.7", "3.12"]),
    (130, ["3.8", "3.13"]),
];

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

    fn axis(self) -> PlotAxis {
        match self {
            Quantity::Cycles => PlotAxis::new("cycles", AxisScale::Decades),
            Quantity::Rate => percentage("parallelisation rate (%)"),
        }
    }

    /// Placements as marks, filled by zones.
    fn marks(self, placed: &[StudyPlacement<'_>]) -> Vec<Mark> {
        let mark = |placed: &StudyPlacement<'_>| {
            let y = match self {
                Quantity::Cycles => f64::from(placed.point.cycles),
                Quantity::Rate => 100.0 * placed.point.rate,
            };
            Mark {
                zone: placed.zone().map(|zone| zone.mark()),
                ..Mark::at(f64::from(placed.elements()), y)
            }
        };
        placed.iter().map(mark).collect()
    }
}

pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let mut figures = Vec::new();
    let models = || 0..results.plan.models.len();
    for (place, quantity) in [Quantity::Cycles, Quantity::Rate].into_iter().enumerate() {
        for (dof, numbers) in NUMBERS {
            let number = numbers[place];
            let of = |model: &usize| {
                results
                    .system(*model)
                    .is_some_and(|system| system.dof == dof)
            };
            let words = [
                ("number", &*format!("Figure {number}: ")),
                ("subject", &format!("the {dof}-dof systems")),
            ];
            let name = format!("figure-{number}");
            let members = models().filter(of).collect();
            figures.extend(figure(results, members, quantity, &name, &words));
        }
        let own = |model: &usize| {
            results.system(*model).is_none() && !results::is_variant(results, *model)
        };
        for model in models().filter(own) {
            let label = &results.plan.models[model].name;
            let words = [("number", ""), ("subject", label.as_str())];
            let name = format!("{}-{label}", quantity.name());
            figures.extend(figure(results, vec![model], quantity, &name, &words));
        }
    }
    figures
}

fn figure(
    results: &Results,
    models: Vec<usize>,
    quantity: Quantity,
    name: &str,
    words: &Words<'_>,
) -> Option<Figure> {
    let panel = |model: usize| {
        let own = results
            .ordinary()
            .filter(|program| program.place[0] == model);
        let curves: Vec<Curve> = own.flat_map(|program| curves(program, quantity)).collect();
        let title = results.plan.models[model].name.clone();
        (!curves.is_empty()).then(|| Panel::curves(title, elements(), quantity.axis(), curves))
    };
    let panels = models.into_iter().filter_map(panel).collect();
    captions::figure(quantity.name(), name, words, panels)
}

/// The placements of a program, and its guidance curve.
fn curves(program: StudiedProgram<'_>, quantity: Quantity) -> Vec<Curve> {
    let placed = program.ladder();
    let (Some(first), Some(last)) = (placed.first(), placed.last()) else {
        return Vec::new();
    };
    let paint = Paint::Distinct(program.place[1]);
    let guidance = guidance(
        program.facts,
        [first, last].map(|placed| placed.elements()),
        quantity,
    );
    let label = label(program.pipeline());
    vec![
        Curve::new(label, paint, Stroke::Marked, quantity.marks(&placed)),
        Curve::new("", paint, Stroke::Dashed, guidance),
    ]
}

/// The guidance curve between two numbers of elements, with its corner.
fn guidance(facts: &ProgramFacts, ends: [u32; 2], quantity: Quantity) -> Vec<Mark> {
    let [low, high] = ends.map(f64::from);
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
    let marks = places.into_iter();
    marks
        .map(|elements| Mark::at(elements, value(elements)))
        .collect()
}

/// Formulations of the same system, compared.
pub(super) fn formulations(results: &Results) -> Option<Figure> {
    let (machine, pipeline) = (results.main_machine()?, results::pipeline(results)?);
    let panel = |group: &Vec<usize>| {
        let curves = group.iter().enumerate().filter_map(|(index, &model)| {
            let program = results.program([model, pipeline, machine])?;
            let marks = Quantity::Cycles.marks(&program.ladder());
            let label = results::label(program.subject());
            Some(Curve::new(
                label,
                Paint::Distinct(index),
                Stroke::Marked,
                marks,
            ))
        });
        let curves = curves.filter(|curve| !curve.marks.is_empty());
        let title = results.plan.models[group[0]].source.clone();
        Panel::curves(title, elements(), Quantity::Cycles.axis(), curves)
    };
    let panels: Vec<Panel> = results::groups(results).iter().map(panel).collect();
    let words = [("pipeline", results.plan.pipelines[pipeline].name.as_str())];
    captions::figure("formulations", "formulations", &words, panels)
}

/// Unequal numbers of adders and multipliers: a map of cycles, and best splits.
pub(super) fn splits(results: &Results) -> Option<Figure> {
    let panel = |program: StudiedProgram<'_>| {
        let placed = program.grid();
        let numbers = |kind: usize| {
            let mut numbers: Vec<u32> = placed.iter().map(|placed| placed.counts()[kind]).collect();
            numbers.sort_unstable();
            numbers.dedup();
            numbers
        };
        let (columns, rows) = (numbers(0), numbers(1));
        let pairs = (rows.iter()).flat_map(|&row| columns.iter().map(move |&column| [column, row]));
        let value = |pair: [u32; 2]| {
            let found = placed.iter().find(|placed| placed.counts() == pair);
            found.map(|placed| f64::from(placed.point.cycles))
        };
        let best = program.best_splits();
        let map = TileMap {
            values: pairs.map(value).collect(),
            quantity: "cycles".to_owned(),
            framed: best.iter().map(StudyPlacement::counts).collect(),
            columns,
            rows,
        };
        let [x, y] = ["adders", "multipliers"].map(|kind| PlotAxis::new(kind, AxisScale::Linear));
        (!placed.is_empty()).then(|| Panel::map(label(program.pipeline()), x, y, map))
    };
    let panels = results.of_headline().filter_map(panel).collect();
    let words = [("headline", results.headline())];
    captions::figure("split", "split", &words, panels)
}
