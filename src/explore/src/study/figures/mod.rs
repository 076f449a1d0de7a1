//! The figures of a study, each named by its number in the thesis, if any.
//!
//! Drawings of principle (figures 1.1 to 1.8, 2.1 to 2.3, 2.8 to 2.11, 3.1 to
//! 3.3 and those of the appendix) show no results and have no counterpart.

mod couples;
mod elements;
mod memory;
mod occupation;
mod projection;

use super::plan::NamedPipeline;
use super::results::Results;
use robovec_present::{AxisScale, Figure, PlotAxis};

/// All figures for which the study has points.
pub(super) fn all(results: &Results) -> Vec<Figure> {
    let mut figures = Vec::new();
    figures.extend(couples::operators());
    figures.extend(couples::variants(results));
    figures.extend(couples::front(results));
    figures.extend(memory::figures(results));
    figures.extend(elements::figures(results));
    figures.extend(projection::figure(results));
    figures.extend(occupation::figures(results));
    figures.extend(elements::formulations(results));
    figures.extend(elements::splits(results));
    figures
}

fn elements() -> PlotAxis {
    let title = "processing elements, adders + multipliers";
    PlotAxis::new(title, AxisScale::PowersOfTwo)
}

fn percentage(title: &str) -> PlotAxis {
    PlotAxis::new(title, AxisScale::Linear).showing(0.0, 100.0)
}

fn label(pipeline: &NamedPipeline) -> String {
    match pipeline.name.as_str() {
        "printed" => "as printed".to_owned(),
        other => other.to_owned(),
    }
}
