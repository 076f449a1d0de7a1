//! A run as a figure: positions above, energies below.

use super::{MotionSample, SimulationRun};
use robovec_model::Model;
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};

/// More curves than this cannot be distinguished.
const CURVES: usize = 10;

/// As many have their own colours; the others are dashed.
const COLOURS: usize = 7;

/// A quantity over the samples of a run, with its name.
struct RunQuantity<'a> {
    name: &'a str,
    values: Vec<f64>,
}

impl RunQuantity<'_> {
    fn new<'a>(
        name: &'a str,
        run: &SimulationRun,
        value: impl Fn(&MotionSample) -> f64,
    ) -> RunQuantity<'a> {
        RunQuantity {
            name,
            values: run.samples.iter().map(value).collect(),
        }
    }

    fn extent(&self) -> f64 {
        let values = || self.values.iter().copied();
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    }
}

/// The positions of the joints that move most, and the energies.
pub fn figure(model: &Model, run: &SimulationRun) -> Figure {
    let panels = [
        panel("position (m, rad)", run, &positions(model, run)),
        panel("energy (J)", run, &energies(run)),
    ];
    Figure::new(
        "run",
        "Positions and energies",
        "The positions of the joints that move most, and the energies.",
        1,
        panels
            .into_iter()
            .filter(|panel| !panel.is_empty())
            .collect(),
    )
}

/// The joints that move most, in their order.
fn positions<'a>(model: &'a Model, run: &SimulationRun) -> Vec<RunQuantity<'a>> {
    let joints = model.joints.iter().enumerate();
    let mut moving: Vec<(usize, RunQuantity<'a>)> = joints
        .map(|(index, joint)| {
            (
                index,
                RunQuantity::new(&joint.name, run, |sample| sample.state.q[index]),
            )
        })
        .collect();
    moving.sort_by(|(_, a), (_, b)| b.extent().total_cmp(&a.extent()));
    moving.truncate(CURVES);
    moving.sort_by_key(|(index, _)| *index);
    moving.into_iter().map(|(_, quantity)| quantity).collect()
}

/// The energies that are there, and the rest of them without work.
fn energies(run: &SimulationRun) -> Vec<RunQuantity<'static>> {
    let energies = [
        RunQuantity::new("kinetic", run, |sample| sample.energy.kinetic),
        RunQuantity::new("gravity", run, |sample| sample.energy.gravity),
        RunQuantity::new("springs", run, |sample| sample.energy.springs),
        RunQuantity::new("less work", run, |sample| {
            sample.energy.total() - sample.work
        }),
    ];
    let there = |energy: &RunQuantity<'_>| energy.values.iter().any(|&value| value != 0.0);
    energies.into_iter().filter(there).collect()
}

fn panel(title: &str, run: &SimulationRun, quantities: &[RunQuantity<'_>]) -> Panel {
    let curves = quantities.iter().enumerate().map(|(index, quantity)| {
        let stroke = if index < COLOURS {
            Stroke::Plain
        } else {
            Stroke::Dashed
        };
        let times = run.samples.iter().map(|sample| sample.state.time);
        let marks = times.zip(&quantity.values);
        let marks = marks.map(|(time, &value)| Mark::at(time, value));
        Curve::new(quantity.name, Paint::Distinct(index), stroke, marks)
    });
    Panel::curves(
        "",
        PlotAxis::new("time (s)", AxisScale::Linear).from(0.0),
        PlotAxis::new(title, AxisScale::Linear),
        curves,
    )
}
