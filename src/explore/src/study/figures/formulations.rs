//! Formulations of the same system, compared.

use super::super::captions;
use super::super::results::Results;
use super::super::variants;
use super::super::zone::zone;
use super::ladder;
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};

pub(super) fn figure(results: &Results) -> Option<Figure> {
    let (machine, pipeline) = (results.main_machine()?, variants::pipeline(results)?);
    let panel = |group: &Vec<usize>| {
        let curves = group.iter().enumerate().filter_map(|(index, &model)| {
            let facts = results.program(model, pipeline, machine)?;
            let placed = ladder(results, model, pipeline, machine);
            let marks = placed.iter().map(|&placed| Mark {
                zone: Some(zone(facts, placed).mark()),
                ..Mark::at(f64::from(placed.elements()), f64::from(placed.point.cycles))
            });
            Some(Curve::new(
                variants::label(&results.plan.models[model]),
                Paint::Distinct(index),
                Stroke::Marked,
                marks,
            ))
        });
        Panel::curves(
            results.plan.models[group[0]].source.clone(),
            PlotAxis::new(
                "processing elements, adders + multipliers",
                AxisScale::PowersOfTwo,
            ),
            PlotAxis::new("cycles", AxisScale::Decades),
            curves.filter(|curve| !curve.marks.is_empty()),
        )
    };
    let panels: Vec<Panel> = variants::groups(results).iter().map(panel).collect();
    let words = [("pipeline", results.plan.pipelines[pipeline].name.as_str())];
    captions::figure("formulations", "formulations", &words, panels)
}
