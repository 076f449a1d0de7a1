//! Figures 1.9 to 1.12: pipelining variants; and all couples of Table 1.3.

use super::super::captions;
use super::super::results::{Results, StudyPlacement};
use super::{ladder, pipeline_label};
use crate::operators::{ADDERS, MEMORY_CAP_MHZ, MULTIPLIERS, couples};
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};

/// The couples that thesis 1.2.3 compares. It names adders of 3 and
/// multipliers of 2 stages with 72 MHz; by its Table 1.3 that is 63 MHz, and
/// 72 MHz belong to 3 and 3 stages.
const COMPARED: [[u32; 2]; 3] = [[3, 3], [6, 4], [10, 5]];

const ELEMENTS: &str = "processing elements, adders + multipliers";

/// Figure 1.9.
pub(super) fn operators() -> Option<Figure> {
    let curve = |label: &str, index: usize, operators: &[crate::operators::Operator]| {
        Curve::new(
            label,
            Paint::Distinct(index),
            Stroke::Marked,
            operators
                .iter()
                .map(|operator| Mark::at(f64::from(operator.stages), f64::from(operator.mhz))),
        )
    };
    captions::figure(
        "figure-1.9",
        "figure-1.9",
        &[],
        vec![Panel::curves(
            String::new(),
            PlotAxis::new("pipeline stages", AxisScale::Linear).showing(0.0, 15.0),
            PlotAxis::new("clock (MHz)", AxisScale::Linear).showing(0.0, 250.0),
            vec![
                curve("adder", 0, &ADDERS),
                curve("multiplier", 1, &MULTIPLIERS),
            ],
        )],
    )
}

/// Figures 1.10 (cycles), 1.11 (time) and 1.12 (rate).
pub(super) fn variants(results: &Results) -> Vec<Figure> {
    let figures = [
        ("1.10", "cycles", "cycles", AxisScale::Decades),
        ("1.11", "computing time", "time (µs)", AxisScale::Decades),
        (
            "1.12",
            "parallelisation rate",
            "parallelisation rate (%)",
            AxisScale::Linear,
        ),
    ];
    let figure = |(number, what, unit, scale): (&str, &str, &str, AxisScale)| {
        let quantity = |placed: StudyPlacement<'_>, mhz: f64| match number {
            "1.10" => f64::from(placed.point.cycles),
            "1.11" => f64::from(placed.point.cycles) / mhz,
            _ => 100.0 * placed.point.rate,
        };
        let panel = |pipeline: usize| {
            let curves = COMPARED.iter().enumerate().filter_map(|(index, couple)| {
                let machine = couple_machine(results, *couple)?;
                let mhz = results.plan.machines[machine].clock().mhz;
                let placed = ladder(results, results.plan.headline, pipeline, machine);
                let marks = placed
                    .iter()
                    .map(|&placed| Mark::at(f64::from(placed.elements()), quantity(placed, mhz)));
                Some(Curve::new(
                    format!("{}+{} at {mhz} MHz", couple[0], couple[1]),
                    Paint::Distinct(index),
                    Stroke::Marked,
                    marks,
                ))
            });
            let curves: Vec<Curve> = curves.filter(|curve| !curve.marks.is_empty()).collect();
            let y = PlotAxis::new(unit, scale);
            let y = if scale == AxisScale::Linear {
                y.showing(0.0, 100.0)
            } else {
                y
            };
            (!curves.is_empty()).then(|| {
                Panel::curves(
                    pipeline_label(results, pipeline),
                    PlotAxis::new(ELEMENTS, AxisScale::PowersOfTwo),
                    y,
                    curves,
                )
            })
        };
        let panels: Vec<Panel> = (0..results.plan.pipelines.len())
            .filter_map(panel)
            .collect();
        let words = [
            ("number", number),
            ("what", what),
            ("headline", captions::headline(results)),
        ];
        captions::figure("stages", &format!("figure-{number}"), &words, panels)
    };
    figures.into_iter().filter_map(figure).collect()
}

/// All couples of Table 1.3, with and without the cap of the memories.
pub(super) fn front(results: &Results) -> Option<Figure> {
    let mut panels = Vec::new();
    for pipeline in 0..results.plan.pipelines.len() {
        for cap in [None, Some(MEMORY_CAP_MHZ)] {
            let curves = couple_curves(results, pipeline, cap);
            if curves.len() > 1 {
                let limit = cap.map_or("own clocks".to_owned(), |mhz| format!("at most {mhz} MHz"));
                panels.push(Panel::curves(
                    format!("{}, {limit}", pipeline_label(results, pipeline)),
                    PlotAxis::new(ELEMENTS, AxisScale::PowersOfTwo),
                    PlotAxis::new("time (µs)", AxisScale::Decades),
                    curves,
                ));
            }
        }
    }
    let words = [("headline", captions::headline(results))];
    captions::figure("couples", "couples", &words, panels)
}

fn couple_curves(results: &Results, pipeline: usize, cap: Option<u32>) -> Vec<Curve> {
    let all = couples();
    let mut curves = Vec::new();
    // For each number of elements the least time and its couple.
    let mut best: Vec<(f64, f64, [u32; 2])> = Vec::new();
    for (index, couple) in all.iter().enumerate() {
        let Some(machine) = couple_machine(results, couple.stages()) else {
            continue;
        };
        let mhz = f64::from(cap.map_or(couple.mhz(), |cap| cap.min(couple.mhz())));
        let placed = ladder(results, results.plan.headline, pipeline, machine);
        let points: Vec<[f64; 2]> = placed
            .iter()
            .map(|placed| {
                [
                    f64::from(placed.elements()),
                    f64::from(placed.point.cycles) / mhz,
                ]
            })
            .collect();
        for &[elements, time] in &points {
            match best.iter_mut().find(|(known, ..)| *known == elements) {
                Some(known) if known.1 <= time => {}
                Some(known) => *known = (elements, time, couple.stages()),
                None => best.push((elements, time, couple.stages())),
            }
        }
        curves.push(Curve::new(
            "",
            Paint::Ordered(index, all.len()),
            Stroke::Plain,
            points.iter().map(|&[x, y]| Mark::at(x, y)),
        ));
    }
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut rest = &best[..];
    // A marked stretch for each couple that is best somewhere.
    while let Some(&(_, _, stages)) = rest.first() {
        let count = rest
            .iter()
            .take_while(|(_, _, other)| *other == stages)
            .count();
        let paint = Paint::Distinct(
            curves.len() - curves.iter().filter(|curve| curve.label.is_empty()).count(),
        );
        curves.push(Curve::new(
            format!("{}+{}", stages[0], stages[1]),
            paint,
            Stroke::Points,
            rest[..count].iter().map(|&(x, y, _)| Mark::at(x, y)),
        ));
        rest = &rest[count..];
    }
    curves
}

/// The machine with this many stages.
fn couple_machine(results: &Results, stages: [u32; 2]) -> Option<usize> {
    results
        .plan
        .machines
        .iter()
        .position(|machine| machine.couple == Some(stages))
}
