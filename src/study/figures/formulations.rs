//! Formulations of the same system, compared.

use super::super::figure::{Axis, Content, Curve, Figure, Mark, Paint, Panel, Scale, Stroke};
use super::super::results::Results;
use super::super::variants;
use super::{ladder, zone};

pub(super) fn figure(results: &Results) -> Option<Figure> {
    let (machine, pipeline) = (results.main_machine()?, variants::pipeline(results)?);
    let panel = |group: &Vec<usize>| {
        let curves = group.iter().enumerate().filter_map(|(index, &model)| {
            let facts = results.program(model, pipeline, machine)?;
            let placed = ladder(results, model, pipeline, machine);
            let marks = placed.iter().map(|&placed| Mark {
                zone: Some(zone(facts, placed)),
                ..Mark::at(f64::from(placed.elements()), f64::from(placed.point.cycles))
            });
            Some(Curve {
                label: variants::label(&results.plan.models[model]),
                paint: Paint::Distinct(index),
                stroke: Stroke::Marked,
                marks: marks.collect(),
            })
        });
        Panel {
            title: results.plan.models[group[0]].source.clone(),
            x: Axis::new(
                "processing elements, adders + multipliers",
                Scale::PowersOfTwo,
            ),
            y: Axis::new("cycles", Scale::Decades),
            content: Content::Curves(curves.filter(|curve| !curve.marks.is_empty()).collect()),
        }
    };
    let panels: Vec<Panel> = variants::groups(results).iter().map(panel).collect();
    (!panels.is_empty()).then(|| Figure {
        name: "formulations".to_owned(),
        title: "Formulations: cycles of the same system by other recursions".to_owned(),
        caption: format!(
            "All after the pipeline '{}'. With few elements the number of operations decides, \
             with many the longest chain. Markers are filled as in the figures of cycles.",
            results.plan.pipelines[pipeline].name
        ),
        columns: panels.len().min(2),
        panels,
    })
}
