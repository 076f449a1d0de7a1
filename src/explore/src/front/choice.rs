//! Choices that are compared: those the thesis could make, and ours.
//!
//! The thesis takes Robotran's equations as printed, or with the trees of the
//! longest path balanced by hand (2.4.3); computes in binary32 (1.1); and puts
//! `sin x = x`, `cos x = 1` into the memories before the run (Taylor order 1,
//! 1.2.2), or true sines and cosines from a host. All others are those of
//! robovec.

use robovec_dynamics::generate::Formulation;
use robovec_ir::Format;
use robovec_passes::optimise::steps;
use serde::Deserialize;

/// A way to compute a function.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct FrontChoice {
    pub(super) name: String,
    /// True for a choice of the thesis.
    pub(super) thesis: bool,
    /// Another formulation of the equations; `None` for those that came.
    pub(super) formulation: Option<Formulation>,
    /// Passes, in stages that other choices may share from the start on.
    pub(super) stages: Vec<String>,
    /// The formats of its measurements.
    pub(super) formats: Vec<Format>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ChoiceFile {
    thesis: Vec<ChoiceEntry>,
    ours: Vec<ChoiceEntry>,
    formulation: Vec<ChoiceEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ChoiceEntry {
    name: String,
    stages: Vec<String>,
    /// True for choices that take long, false for those in their place.
    slow: Option<bool>,
}

/// Functions with more operations get the choices that are not slow.
const LARGE: usize = 30_000;

/// A format with 27 bits of significand: the multipliers of Cyclone V are 27
/// bits wide, so that it costs no more of them than binary32.
const FULL_MULTIPLIER: &str = "float(8,26)";

/// Binary32, and [`FULL_MULTIPLIER`].
fn wide() -> Vec<Format> {
    let full = FULL_MULTIPLIER.parse().expect("it is a format");
    vec![Format::BINARY32, full]
}

/// A stage of passes with its words filled in.
fn stage(text: &str, angle: f64) -> String {
    let words = [
        (
            "{balanced}",
            "atomise,zero-removal,balance,cse,dce".to_owned(),
        ),
        ("{composite}", format!("atomise,{}", steps::COMPOSITE)),
        (
            "{order 1}",
            "trigonometry{method=taylor order=1}".to_owned(),
        ),
        (
            "{series}",
            format!("atomise,trigonometry{{method=minimax order=7 range={angle}}}"),
        ),
    ];
    let ahead = text.strip_prefix("{ahead ");
    if let Some(growth) = ahead.and_then(|rest| rest.strip_suffix('}')) {
        return format!("lookahead{{growth={growth}}},balance,cse,dce");
    }
    let found = words.into_iter().find(|(word, _)| *word == text);
    found.map_or(text.to_owned(), |(_, passes)| passes)
}

/// All choices of a list for a function of this number of operations: the
/// thesis', ours from the equations, and from other formulations. Angles up to
/// `angle` (rad) are covered by the series that the elements compute.
pub(super) fn listed(
    operations: usize,
    formulations: &[Formulation],
    angle: f64,
) -> Vec<FrontChoice> {
    let file: ChoiceFile = toml::from_str(include_str!("choices.toml")).expect("sound choices");
    let choice = |entry: &ChoiceEntry, formulation: Option<Formulation>| {
        let taken = entry.slow.is_none_or(|slow| slow == (operations <= LARGE));
        let word = formulation.map_or("", Formulation::name);
        taken.then(|| FrontChoice {
            name: entry.name.replace("{formulation}", word),
            thesis: false,
            formulation,
            stages: entry.stages.iter().map(|text| stage(text, angle)).collect(),
            formats: wide(),
        })
    };
    let thesis = file.thesis.iter().filter_map(|entry| choice(entry, None));
    let thesis = thesis.map(|choice| FrontChoice {
        thesis: true,
        formats: vec![Format::BINARY32],
        ..choice
    });
    let ours = file.ours.iter().filter_map(|entry| choice(entry, None));
    let others = formulations.iter().flat_map(|&formulation| {
        let entries = file.formulation.iter();
        entries.filter_map(move |entry| choice(entry, Some(formulation)))
    });
    thesis.chain(ours).chain(others).collect()
}

/// Choice that a search found for the numbers of elements requested.
pub(super) fn found(name: &str, formulation: Option<Formulation>, passes: &str) -> FrontChoice {
    FrontChoice {
        name: format!("found: {name}"),
        thesis: false,
        formulation,
        stages: vec![passes.to_owned()],
        formats: wide(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_passes::registry::REGISTRY;

    #[test]
    fn all_stages_are_pipelines_of_this_build() {
        for operations in [1000, 2 * LARGE] {
            for choice in listed(operations, &Formulation::ALL, 0.1) {
                for stage in &choice.stages {
                    assert!(REGISTRY.pipeline(stage).is_ok(), "{}: {stage}", choice.name);
                }
            }
        }
    }
}
