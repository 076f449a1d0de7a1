//! A run as a drawing: positions above, energies below.

use super::{Run, Sample};
use crate::model::Model;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;

/// Why a drawing failed.
pub type DrawingError = DrawingAreaErrorKind<std::io::Error>;

/// More curves than this cannot be told apart.
const CURVES: usize = 10;

/// Colours that colour-blind readers tell apart too (Okabe and Ito).
const COLOURS: [RGBColor; CURVES] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(120, 94, 240),
    RGBColor(128, 128, 128),
    RGBColor(120, 60, 20),
];

/// A curve with its name.
struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
}

impl Curve {
    fn new(name: &str, run: &Run, value: impl Fn(&Sample) -> f64) -> Curve {
        let point = |sample: &Sample| (sample.state.time, value(sample));
        Curve {
            name: name.to_owned(),
            points: run.samples.iter().map(point).collect(),
        }
    }

    fn range(&self) -> (f64, f64) {
        let values = self.points.iter().map(|point| point.1);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        })
    }
}

/// Draws the positions of the joints that move most and the energies.
///
/// # Errors
///
/// Those of the drawing library.
pub fn svg(model: &Model, run: &Run) -> Result<String, DrawingError> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (900, 800)).into_drawing_area();
        area.fill(&WHITE)?;
        let (upper, lower) = area.split_vertically(420);
        chart(&upper, "position (m, rad)", &positions(model, run))?;
        chart(&lower, "energy (J)", &energies(run))?;
        area.present()?;
    }
    Ok(text)
}

/// The joints that move most, in their order.
fn positions(model: &Model, run: &Run) -> Vec<Curve> {
    let joints = model.joints.iter().enumerate();
    let curves: Vec<Curve> = joints
        .map(|(index, joint)| Curve::new(&joint.name, run, |sample| sample.state.q[index]))
        .collect();
    let mut order: Vec<usize> = (0..curves.len()).collect();
    let extent = |&index: &usize| {
        let (low, high) = curves[index].range();
        high - low
    };
    order.sort_by(|a, b| extent(b).total_cmp(&extent(a)));
    order.truncate(CURVES);
    let curves = curves.into_iter().enumerate();
    curves
        .filter(|(index, _)| order.contains(index))
        .map(|(_, curve)| curve)
        .collect()
}

/// The energies that are there, and what is left of them without work.
fn energies(run: &Run) -> Vec<Curve> {
    let curves = [
        Curve::new("kinetic", run, |sample| sample.energy.kinetic),
        Curve::new("gravity", run, |sample| sample.energy.gravity),
        Curve::new("springs", run, |sample| sample.energy.springs),
        Curve::new("less work", run, |sample| {
            sample.energy.total() - sample.work
        }),
    ];
    let there = |curve: &Curve| curve.range() != (0.0, 0.0);
    curves.into_iter().filter(there).collect()
}

/// A range with a margin, never empty.
fn axis(low: f64, high: f64) -> Range<f64> {
    let margin = (0.05 * (high - low))
        .max(1e-6 * high.abs().max(low.abs()))
        .max(1e-9);
    low - margin..high + margin
}

fn chart(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    label: &str,
    curves: &[Curve],
) -> Result<(), DrawingError> {
    let times = curves.iter().flat_map(|curve| &curve.points).map(|p| p.0);
    let end = times.fold(0.0, f64::max);
    let ranges = curves.iter().map(Curve::range);
    let (low, high) = ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |all, range| {
        (all.0.min(range.0), all.1.max(range.1))
    });
    if low > high {
        return Ok(());
    }
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(76)
        .build_cartesian_2d(0.0..end, axis(low, high))?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("time (s)")
        .y_desc(label)
        .label_style(("sans-serif", 16))
        .axis_desc_style(("sans-serif", 18))
        .draw()?;
    for (index, curve) in curves.iter().enumerate() {
        let colour = COLOURS[index % CURVES];
        let line = LineSeries::new(curve.points.iter().copied(), colour.stroke_width(2));
        chart
            .draw_series(line)?
            .label(curve.name.as_str())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .label_font(("sans-serif", 16))
        .position(SeriesLabelPosition::UpperRight)
        .border_style(BLACK.mix(0.3))
        .background_style(WHITE.mix(0.8))
        .draw()?;
    Ok(())
}
