//! Unequal numbers of adders and multipliers: a map of cycles, and the best
//! split of every total.

use super::super::captions;
use super::super::results::{Results, StudyPlacement};
use super::pipeline_label;
use robovec_present::{AxisScale, Figure, Panel, PlotAxis, TileMap};

/// The best split of a total: fewest cycles, then nearest to equal numbers,
/// then more multipliers.
pub(in super::super) fn best_splits<'a>(placed: &[StudyPlacement<'a>]) -> Vec<StudyPlacement<'a>> {
    let merit = |placed: &StudyPlacement<'_>| {
        let request = placed.request;
        (
            placed.elements(),
            placed.point.cycles,
            request.n_add.abs_diff(request.n_multi),
            request.n_add,
        )
    };
    let mut sorted = placed.to_vec();
    sorted.sort_by_key(merit);
    sorted.dedup_by_key(|placed| placed.elements());
    sorted
}

/// The placements of the headline model on all pairs of numbers: those of a
/// full grid.
pub(in super::super) fn grid<'a>(
    results: &'a Results,
    model: usize,
    pipeline: usize,
) -> Vec<StudyPlacement<'a>> {
    let Some(machine) = results.main_machine() else {
        return Vec::new();
    };
    let all: Vec<StudyPlacement<'a>> = results.usual(model, pipeline, machine).collect();
    let unequal = all.iter().filter(|placed| !placed.is_equal());
    let largest = unequal
        .map(|placed| placed.request.n_add.max(placed.request.n_multi))
        .max();
    let within = |placed: &StudyPlacement<'_>| {
        largest.is_some_and(|largest| placed.request.n_add.max(placed.request.n_multi) <= largest)
    };
    all.into_iter().filter(within).collect()
}

pub(super) fn figure(results: &Results) -> Option<Figure> {
    let model = results.plan.headline;
    let mut panels = Vec::new();
    for pipeline in 0..results.plan.pipelines.len() {
        let placed = grid(results, model, pipeline);
        if placed.is_empty() {
            continue;
        }
        let numbers = |pick: fn(&StudyPlacement<'_>) -> u32| {
            let mut numbers: Vec<u32> = placed.iter().map(pick).collect();
            numbers.sort_unstable();
            numbers.dedup();
            numbers
        };
        let columns = numbers(|placed| placed.request.n_add);
        let rows = numbers(|placed| placed.request.n_multi);
        let pairs = rows
            .iter()
            .flat_map(|&row| columns.iter().map(move |&column| [column, row]));
        let value = |[column, row]: [u32; 2]| {
            let found = placed
                .iter()
                .find(|placed| [placed.request.n_add, placed.request.n_multi] == [column, row]);
            found.map(|placed| f64::from(placed.point.cycles))
        };
        let largest = columns.last().copied().unwrap_or(0);
        let best = best_splits(&placed).into_iter();
        // Beyond it the grid does not hold all splits of a total.
        let complete = best.filter(|placed| placed.elements() <= largest + 1);
        panels.push(Panel::map(
            pipeline_label(results, pipeline),
            PlotAxis::new("adders", AxisScale::Linear),
            PlotAxis::new("multipliers", AxisScale::Linear),
            TileMap {
                values: pairs.map(value).collect(),
                columns,
                rows,
                quantity: "cycles".to_owned(),
                framed: complete
                    .map(|placed| [placed.request.n_add, placed.request.n_multi])
                    .collect(),
            },
        ));
    }
    let words = [("headline", captions::headline(results))];
    captions::figure("split", "split", &words, panels)
}
