//! Figures 3.15 to 3.38: occupation of the elements over normalised time.

use super::super::captions;
use super::super::plan::Printed;
use super::super::printed::{PrintedSystem, SystemTopology};
use super::super::results::Results;
use super::super::variants;
use super::{ladder, pipeline_label};
use robovec_present::{AxisScale, Curve, Figure, Mark, Paint, Panel, PlotAxis, Stroke};

pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let Some(machine) = results.main_machine() else {
        return Vec::new();
    };
    let mut figures = Vec::new();
    for pipeline in 0..results.plan.pipelines.len() {
        let models = 0..results.plan.models.len();
        for model in models.filter(|&model| !variants::is_variant(results, model)) {
            figures.extend(figure(results, model, pipeline, machine));
        }
    }
    // In the order of the thesis, what it does not have behind.
    figures.sort_by_key(|(number, _)| number.unwrap_or(u32::MAX));
    figures.into_iter().map(|(_, figure)| figure).collect()
}

/// A figure, and the second half of its number in chapter 3.
fn figure(
    results: &Results,
    model: usize,
    pipeline: usize,
    machine: usize,
) -> Option<(Option<u32>, Figure)> {
    let placed = ladder(results, model, pipeline, machine);
    if placed.is_empty() {
        return None;
    }
    let number = number(results, model, pipeline);
    let count_of_curves = placed.len();
    let panel = |kind: usize, title: &str| {
        let curves = placed.iter().enumerate().map(|(index, placed)| {
            let request = placed.request;
            let count = [request.n_add, request.n_multi][kind];
            let curve = placed.point.kinds[kind].occupation.curve();
            Curve::new(
                count.to_string(),
                Paint::Ordered(index, count_of_curves),
                Stroke::Plain,
                curve.map(|[time, share]| Mark::at(100.0 * time, 100.0 * share)),
            )
        });
        Panel::curves(
            title,
            PlotAxis::new("share of the run (%)", AxisScale::Linear).showing(0.0, 100.0),
            PlotAxis::new("occupation (%)", AxisScale::Linear).showing(0.0, 100.0),
            curves,
        )
    };
    let (name, prefix) = match number {
        Some(number) => (format!("figure-3.{number}"), format!("Figure 3.{number}: ")),
        None => {
            let model = &results.plan.models[model].name;
            let pipeline = &results.plan.pipelines[pipeline].name;
            (format!("occupation-{model}-{pipeline}"), String::new())
        }
    };
    let words = [
        ("number", prefix.as_str()),
        ("model", &results.plan.models[model].name),
        ("pipeline", &pipeline_label(results, pipeline)),
    ];
    let panels = vec![panel(0, "adders"), panel(1, "multipliers")];
    Some((
        number,
        captions::figure("occupation", &name, &words, panels)?,
    ))
}

/// The number `n` of Figure 3.n that shows this program's counterpart.
fn number(results: &Results, model: usize, pipeline: usize) -> Option<u32> {
    number_of(
        results.system(model)?,
        results.plan.pipelines[pipeline].printed?,
    )
}

fn number_of(system: &PrintedSystem, printed: Printed) -> Option<u32> {
    let size = [23, 50, 70, 100, 130]
        .iter()
        .position(|&dof| dof == system.dof)? as u32;
    match printed {
        Printed::Original => Some(match system.topology {
            SystemTopology::Bogie => 15,
            SystemTopology::Mixed => 16,
            SystemTopology::Serial => 17 + size,
            SystemTopology::SemiSerial => 22 + size,
            SystemTopology::Parallel => 27 + size,
        }),
        Printed::Modified => {
            system.modified.as_ref()?;
            let first = if size == 0 { 33 } else { 36 };
            match system.topology {
                SystemTopology::Bogie => Some(32),
                SystemTopology::Mixed => None,
                SystemTopology::Serial => Some(first),
                SystemTopology::SemiSerial => Some(first + 1),
                SystemTopology::Parallel => Some(first + 2),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::printed::thesis;
    use super::*;

    #[test]
    fn every_figure_from_3_15_to_3_38_has_one_counterpart() {
        let mut numbers: Vec<u32> = thesis()
            .systems
            .iter()
            .flat_map(|system| [(system, Printed::Original), (system, Printed::Modified)])
            .filter_map(|(system, printed)| number_of(system, printed))
            .collect();
        numbers.sort_unstable();
        assert_eq!(numbers, (15..=38).collect::<Vec<u32>>());
    }
}
