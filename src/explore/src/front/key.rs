//! The keys under which points of a front are kept: a hash of all that they
//! depend on.

use super::FrontQuestion;
use super::choice::FrontChoice;
use crate::store::PointKey;
use robovec_dynamics::generate::Formulation;
use robovec_ir::Module;

/// Data that the points of all choices depend on.
pub(super) struct ChoiceKeys {
    /// Of the function as it came, the machine and the states.
    common: Option<PointKey>,
    others: Vec<(Formulation, PointKey)>,
}

impl ChoiceKeys {
    /// The keys for a function and its formulations.
    pub(super) fn new(
        module: &Module,
        others: &[(Formulation, Module)],
        question: &FrontQuestion<'_>,
    ) -> ChoiceKeys {
        let common = question.work.key("front").map(|key| {
            let key = key.with_module(module).with_machine(question.machine);
            let (states, count, angle) = (question.states, question.count, question.angle);
            key.with(&format!(
                "{:?} {states:?} {count} {angle}",
                question.elements
            ))
        });
        let hashed = |(formulation, module): &(Formulation, Module)| {
            (*formulation, PointKey::new().with_module(module))
        };
        ChoiceKeys {
            common,
            // Hashing long equations in vain takes as long as reading them.
            others: match common {
                None => Vec::new(),
                Some(_) => others.iter().map(hashed).collect(),
            },
        }
    }

    /// The key of the points of a choice; `None` where nothing is kept.
    pub(super) fn of(&self, choice: &FrontChoice) -> Option<PointKey> {
        let key = self.common?;
        let is_its =
            |(formulation, _): &&(Formulation, PointKey)| choice.formulation == Some(*formulation);
        let equations = self.others.iter().find(is_its);
        let key = equations.map_or(key, |(_, equations)| key.with(&equations.file_name()));
        // What the points are called is kept with them.
        let formats: Vec<String> = choice.formats.iter().map(ToString::to_string).collect();
        let stages = choice.stages.join("\n");
        let key = key.with(&choice.name).with(&choice.thesis.to_string());
        Some(key.with(&stages).with(&formats.join(" ")))
    }
}
