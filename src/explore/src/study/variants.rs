//! Models of a study that are one system with equations by several
//! formulations.

use super::plan::{Printed, StudySubject};
use super::results::Results;

/// Models with the same source, in the plan's order; groups of one are left
/// out.
pub(super) fn groups(results: &Results) -> Vec<Vec<usize>> {
    let models = &results.plan.models;
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (index, subject) in models.iter().enumerate() {
        let same = |group: &&mut Vec<usize>| {
            let first = &models[group[0]];
            (&first.source, &first.function) == (&subject.source, &subject.function)
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    groups.retain(|group| group.len() > 1);
    groups
}

/// True for a model that is another formulation of one before it: it is
/// compared with that one and gets no separate figures.
pub(super) fn is_variant(results: &Results, model: usize) -> bool {
    let groups = groups(results);
    groups.iter().any(|group| group[1..].contains(&model))
}

/// Label that distinguishes a model from others of its group.
pub(super) fn label(subject: &StudySubject) -> String {
    let style = &subject.style;
    match (
        style.formulation.as_str(),
        style.expanded,
        style.child_first,
    ) {
        ("recursive", true, _) => "recursive, as Robotran".to_owned(),
        ("recursive", false, true) => "recursive, children first".to_owned(),
        (formulation, ..) => formulation.to_owned(),
    }
}

/// The pipeline in which formulations are compared: the one that shortens
/// chains, or the last.
pub(super) fn pipeline(results: &Results) -> Option<usize> {
    let shortened = results.pipeline(Printed::Modified);
    shortened.or(results.plan.pipelines.len().checked_sub(1))
}
