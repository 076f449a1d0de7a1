//! Figure 3.14: the number Y against degrees of freedom, by topology.

use super::super::knee::Zone;
use super::super::plan::Printed;
use super::super::printed::{SystemTopology, thesis};
use super::super::results::{Results, StudiedProgram};
use crate::captions;
use robovec_present::number::round;
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};

/// End of the fitted lines, degrees of freedom.
const FURTHEST: f64 = 200.0;

/// The topologies the thesis fits.
const TOPOLOGIES: [SystemTopology; 3] = [
    SystemTopology::Serial,
    SystemTopology::SemiSerial,
    SystemTopology::Parallel,
];

/// Intercept and slope of the best line; `None` for fewer than two abscissae.
fn fit(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let square: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    let mixed = points.iter().map(|point| (point[0] - x) * (point[1] - y));
    let slope = mixed.sum::<f64>() / square;
    (square > 0.0).then_some([y - slope * x, slope])
}

/// Degrees of freedom and number Y of our programs of a topology.
fn numbers(results: &Results, topology: SystemTopology, pipeline: usize) -> Vec<[f64; 2]> {
    let programs = results.ordinary();
    let programs = programs.filter(|program| program.place[1] == pipeline);
    let point = |program: StudiedProgram<'_>| {
        let system = results.system(program.place[0]);
        let system = system.filter(|system| system.topology == topology)?;
        Some([f64::from(system.dof), program.facts.number_y()])
    };
    programs.filter_map(point).collect()
}

/// Those of the thesis that are consistent.
fn printed_numbers(topology: SystemTopology, printed: Printed) -> Vec<[f64; 2]> {
    let systems = thesis().systems.iter();
    let systems = systems.filter(|system| system.topology == topology);
    let rows = systems.filter_map(|system| Some((system, system.row(printed)?)));
    let sound = rows.filter(|(_, row)| row.is_sound("asap_cycle"));
    let y = sound.map(|(system, row)| {
        [
            f64::from(system.dof),
            f64::from(row.operations) / f64::from(row.asap_cycle),
        ]
    });
    y.collect()
}

pub(super) fn figure(results: &Results) -> Option<Figure> {
    let mut panels = Vec::new();
    for (printed, title) in [
        (Printed::Original, "equations as printed"),
        (Printed::Modified, "chains shortened"),
    ] {
        let Some(pipeline) = results.pipeline(printed) else {
            continue;
        };
        let mut curves = Vec::new();
        for (index, topology) in TOPOLOGIES.into_iter().enumerate() {
            curves.extend(topology_curves(results, topology, index, pipeline, printed));
        }
        let has_own = |curve: &Curve| curve.stroke == Stroke::Plain;
        if curves.iter().any(has_own) {
            panels.push(Panel::curves(
                title,
                PlotAxis::new("degrees of freedom", AxisScale::Linear).showing(0.0, FURTHEST),
                PlotAxis::new("number Y (operations per cycle)", AxisScale::Linear)
                    .showing(0.0, 1.0),
                curves,
            ));
        }
    }
    captions::figure("figure-3.14", "figure-3.14", &[], panels)
}

fn topology_curves(
    results: &Results,
    topology: SystemTopology,
    index: usize,
    pipeline: usize,
    printed: Printed,
) -> Vec<Curve> {
    let curve = |label: String, index: usize, stroke: Stroke, points: &[[f64; 2]]| {
        Curve::new(
            label,
            Paint::Distinct(index),
            stroke,
            points.iter().map(|&[x, y]| Mark::at(x, y)),
        )
    };
    let own = numbers(results, topology, pipeline);
    let Some([offset, slope]) = fit(&own) else {
        return Vec::new();
    };
    let line = [0.0, FURTHEST].map(|dof| [dof, (offset + slope * dof).max(0.0)]);
    let label = format!("{} {}", topology.name(), round(slope, 3));
    let mut thesis = curve(
        String::new(),
        index,
        Stroke::Points,
        &printed_numbers(topology, printed),
    );
    for mark in &mut thesis.marks {
        // Hollow, to be told from ours.
        mark.zone = Some(Zone::Saturation.mark());
    }
    vec![
        curve(label, index, Stroke::Plain, &line),
        curve(String::new(), index, Stroke::Points, &own),
        thesis,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_again() {
        let [offset, slope] = fit(&[[0.0, 1.0], [10.0, 3.0], [20.0, 5.0]]).expect("a line");
        assert!((offset - 1.0).abs() < 1e-12 && (slope - 0.2).abs() < 1e-12);
        assert_eq!(super::fit(&[[5.0, 1.0], [5.0, 2.0]]), None);
        assert_eq!(super::fit(&[]), None);
    }

    #[test]
    fn the_slopes_of_the_thesis_are_swapped() {
        let slope = |topology| {
            let [_, slope] = fit(&printed_numbers(topology, Printed::Original)).expect("systems");
            slope
        };
        let [serial, semi, parallel] = TOPOLOGIES.map(slope);
        assert!((0.19..0.22).contains(&serial), "{serial}");
        assert!((0.21..0.24).contains(&semi), "{semi}");
        assert!((0.07..0.09).contains(&parallel), "{parallel}");
    }
}
