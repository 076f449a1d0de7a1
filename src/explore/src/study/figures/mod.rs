//! The figures of a study, each named by its number in the thesis; what the
//! thesis has no figure for has a name of its own.
//!
//! Drawings of principle (figures 1.1 to 1.8, 2.1 to 2.3, 2.8 to 2.11, 3.1 to
//! 3.3 and those of the appendix) show no results and have no counterpart.

mod couples;
mod cycles;
mod formulations;
mod memory;
mod occupation;
mod projection;
mod split;

use super::results::{Results, StudyPlacement};
use robovec_present::Figure;

pub(super) use split::{best_splits, grid};

/// All figures for which the study has points.
pub fn all(results: &Results) -> Vec<Figure> {
    let mut figures = Vec::new();
    figures.extend(couples::operators());
    figures.extend(couples::variants(results));
    figures.extend(couples::front(results));
    figures.extend(memory::figures(results));
    figures.extend(cycles::figures(results));
    figures.extend(projection::figure(results));
    figures.extend(occupation::figures(results));
    figures.extend(formulations::figure(results));
    figures.extend(split::figure(results));
    figures
}

/// The placements the plan asks for with as many adders as multipliers, in
/// ascending number; of many, those whose number is a power of two.
pub fn ladder(
    results: &Results,
    model: usize,
    pipeline: usize,
    machine: usize,
) -> Vec<StudyPlacement<'_>> {
    let usual = results.usual(model, pipeline, machine);
    let asked = |placed: &StudyPlacement<'_>| {
        let found = results.plan.requests.binary_search(placed.request);
        placed.is_equal() && found.is_ok()
    };
    let mut equal: Vec<StudyPlacement<'_>> = usual.filter(asked).collect();
    equal.sort_by_key(StudyPlacement::elements);
    let is_power = |placed: &StudyPlacement<'_>| placed.request.n_add.is_power_of_two();
    if equal.len() > 8 && equal.iter().filter(|&placed| is_power(placed)).count() >= 4 {
        equal.retain(is_power);
    }
    equal
}

/// The name of a pipeline in labels.
fn pipeline_label(results: &Results, pipeline: usize) -> String {
    let name = &results.plan.pipelines[pipeline].name;
    match name.as_str() {
        "printed" => "as printed".to_owned(),
        other => other.to_owned(),
    }
}
