//! Figures 3.15 to 3.38: occupation of the elements over normalised time.

use super::super::plan::Printed;
use super::super::printed::{PrintedSystem, SystemTopology};
use super::super::results;
use super::super::results::{Results, StudiedProgram};
use super::{label, percentage};
use crate::captions;
use robovec_present::{Curve, Figure, Mark, Paint, Panel, Stroke};

pub(super) fn figures(results: &Results) -> Vec<Figure> {
    let shown = |program: &StudiedProgram<'_>| !results::is_variant(results, program.place[0]);
    let mut programs: Vec<StudiedProgram<'_>> = results.ordinary().filter(shown).collect();
    // In the order of the thesis, then what it does not have.
    programs.sort_by_key(|program| {
        let [model, pipeline, _] = program.place;
        (number(program).unwrap_or(u32::MAX), pipeline, model)
    });
    programs.into_iter().filter_map(figure).collect()
}

fn figure(program: StudiedProgram<'_>) -> Option<Figure> {
    let placed = program.ladder();
    let count = placed.len();
    let panel = |(kind, title): (usize, &str)| {
        let curves = placed.iter().enumerate().map(|(index, placed)| {
            let curve = placed.point.kinds[kind].occupation.curve();
            let marks = curve.map(|[time, share]| Mark::at(100.0 * time, 100.0 * share));
            let label = placed.counts()[kind].to_string();
            let paint = Paint::Ordered(index, count);
            Curve::new(label, paint, Stroke::Plain, marks)
        });
        let [x, y] = ["share of the run (%)", "occupation (%)"].map(percentage);
        Panel::curves(title, x, y, curves)
    };
    let kinds = ["adders", "multipliers"].into_iter().enumerate();
    let panels: Vec<Panel> = kinds.filter(|_| !placed.is_empty()).map(panel).collect();
    let (model, pipeline) = (&program.subject().name, program.pipeline());
    let (name, prefix) = match number(&program) {
        Some(number) => (format!("figure-3.{number}"), format!("Figure 3.{number}: ")),
        None => (
            format!("occupation-{model}-{}", pipeline.name),
            String::new(),
        ),
    };
    let words = [
        ("number", prefix.as_str()),
        ("model", model),
        ("pipeline", &label(pipeline)),
    ];
    captions::figure("occupation", &name, &words, panels)
}

/// The number `n` of Figure 3.n that shows this program's counterpart.
fn number(program: &StudiedProgram<'_>) -> Option<u32> {
    let system = program.results.system(program.place[0])?;
    number_of(system, program.pipeline().printed?)
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
