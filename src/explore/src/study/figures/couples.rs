//! Figures 1.9 to 1.12: pipelining variants; and all couples of Table 1.3.

use super::super::plan::NamedPipeline;
use super::super::results::{Results, StudyPlacement};
use super::{elements, label, percentage};
use crate::captions;
use crate::operators::{ADDERS, MEMORY_CAP_MHZ, MULTIPLIERS, Operator, couples};
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};

/// The couples that thesis 1.2.3 compares. It names 3 and 2 stages with 72 MHz;
/// by its Table 1.3 these have 63 MHz, and 3 and 3 stages 72 MHz.
const COMPARED: [[u32; 2]; 3] = [[3, 3], [6, 4], [10, 5]];

/// Figure 1.9.
pub(super) fn operators() -> Option<Figure> {
    let mark = |operator: &Operator| Mark::at(operator.stages.into(), operator.mhz.into());
    let curve = |label: &str, index: usize, operators: &[Operator]| {
        let marks = operators.iter().map(mark);
        Curve::new(label, Paint::Distinct(index), Stroke::Marked, marks)
    };
    let axis = |title: &str, to: f64| PlotAxis::new(title, AxisScale::Linear).showing(0.0, to);
    let curves = [
        curve("adder", 0, &ADDERS),
        curve("multiplier", 1, &MULTIPLIERS),
    ];
    let (x, y) = (axis("pipeline stages", 15.0), axis("clock (MHz)", 250.0));
    let panels = vec![Panel::curves("", x, y, curves)];
    captions::figure("figure-1.9", "figure-1.9", &[], panels)
}

/// A figure of placements at a clock: number, quantity, axis and values.
type VariantFigure = (
    &'static str,
    &'static str,
    PlotAxis,
    fn(&StudyPlacement<'_>) -> f64,
);

/// Figures 1.10 (cycles), 1.11 (time) and 1.12 (rate).
pub(super) fn variants(results: &Results) -> Vec<Figure> {
    let decades = |title: &str| PlotAxis::new(title, AxisScale::Decades);
    let rate = "parallelisation rate";
    let figures: [VariantFigure; 3] = [
        ("1.10", "cycles", decades("cycles"), |placed| {
            f64::from(placed.point.cycles)
        }),
        ("1.11", "computing time", decades("time (µs)"), |placed| {
            placed.time_us()
        }),
        ("1.12", rate, percentage(&format!("{rate} (%)")), |placed| {
            100.0 * placed.point.rate
        }),
    ];
    let headline = results.headline();
    let figure = |(number, what, axis, value): VariantFigure| {
        let panel = |(pipeline, named): (usize, &NamedPipeline)| {
            let curves = COMPARED.iter().enumerate().filter_map(|(index, couple)| {
                let machine = results.couple_machine(*couple)?;
                let program = results.program([results.plan.headline, pipeline, machine])?;
                let placed = program.ladder().into_iter();
                let marks = placed.map(|one| Mark::at(f64::from(one.elements()), value(&one)));
                let [add, multi] = couple;
                let label = format!("{add}+{multi} at {} MHz", program.clock().mhz);
                let paint = Paint::Distinct(index);
                Some(Curve::new(label, paint, Stroke::Marked, marks))
            });
            let curves: Vec<Curve> = curves.filter(|curve| !curve.marks.is_empty()).collect();
            let drawn = !curves.is_empty();
            drawn.then(|| Panel::curves(label(named), elements(), axis.clone(), curves))
        };
        let pipelines = results.plan.pipelines.iter().enumerate();
        let panels: Vec<Panel> = pipelines.filter_map(panel).collect();
        let words = [("number", number), ("what", what), ("headline", headline)];
        captions::figure("stages", &format!("figure-{number}"), &words, panels)
    };
    figures.into_iter().filter_map(figure).collect()
}

/// All couples of Table 1.3, with and without the cap of the memories.
pub(super) fn front(results: &Results) -> Option<Figure> {
    let mut panels = Vec::new();
    for (pipeline, named) in results.plan.pipelines.iter().enumerate() {
        for cap in [None, Some(MEMORY_CAP_MHZ)] {
            let curves = couple_curves(results, pipeline, cap);
            if curves.len() > 1 {
                let limit = cap.map_or("own clocks".to_owned(), |mhz| format!("at most {mhz} MHz"));
                panels.push(Panel::curves(
                    format!("{}, {limit}", label(named)),
                    elements(),
                    PlotAxis::new("time (µs)", AxisScale::Decades),
                    curves,
                ));
            }
        }
    }
    let words = [("headline", results.headline())];
    captions::figure("couples", "couples", &words, panels)
}

fn couple_curves(results: &Results, pipeline: usize, cap: Option<u32>) -> Vec<Curve> {
    let all = couples();
    let mut curves = Vec::new();
    // For each number of elements the least time and its couple.
    let mut best: Vec<(f64, f64, [u32; 2])> = Vec::new();
    for (index, couple) in all.iter().enumerate() {
        let Some(machine) = results.couple_machine(couple.stages()) else {
            continue;
        };
        let program = results.program([results.plan.headline, pipeline, machine]);
        let placed = program.map_or(Vec::new(), |program| program.ladder());
        let mhz = f64::from(cap.map_or(couple.mhz(), |cap| cap.min(couple.mhz())));
        let mark = |placed: &StudyPlacement<'_>| {
            let time = f64::from(placed.point.cycles) / mhz;
            Mark::at(f64::from(placed.elements()), time)
        };
        let marks: Vec<Mark> = placed.iter().map(mark).collect();
        for &Mark { x, y, .. } in &marks {
            match best.iter_mut().find(|(known, ..)| *known == x) {
                Some(known) if known.1 <= y => {}
                Some(known) => *known = (x, y, couple.stages()),
                None => best.push((x, y, couple.stages())),
            }
        }
        let paint = Paint::Ordered(index, all.len());
        curves.push(Curve::new("", paint, Stroke::Plain, marks));
    }
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    // A marked stretch for each couple that is best somewhere.
    let stretches = best.chunk_by(|(.., a), (.., b)| a == b).enumerate();
    curves.extend(stretches.map(|(place, stretch)| {
        let [add, multi] = stretch[0].2;
        let marks = stretch.iter().map(|&(x, y, _)| Mark::at(x, y));
        Curve::points(format!("{add}+{multi}"), place, marks)
    }));
    curves
}
