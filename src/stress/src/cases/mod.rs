//! The cases: families in `cases.toml`, equations and models in `data`.

mod equations;
mod loops;
mod models;

use super::case::{CaseClass, StressCase, StressSubject, StressVerdict};
use serde::Deserialize;
use std::collections::BTreeMap;

#[cfg(test)]
pub(super) use loops::four_bar;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseFile {
    families: Vec<CaseFamily>,
}

/// Cases that differ in numbers.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseFamily {
    class: String,
    subject: String,
    name: String,
    construction: String,
    breaks: String,
    members: Vec<CaseMember>,
}

#[derive(Deserialize)]
struct CaseMember {
    expected: StressVerdict,
    #[serde(default)]
    long: bool,
    /// Numbers by name, in the format of texts.
    #[serde(flatten)]
    numbers: BTreeMap<String, String>,
}

impl CaseMember {
    fn number(&self, name: &str) -> f64 {
        self.numbers[name].parse().expect("a number of a case")
    }

    /// A text of the family with the numbers of the member.
    fn fill(&self, text: &str) -> String {
        let fill = |text: String, (name, number): (&String, &String)| {
            text.replace(&format!("{{{name}}}"), number)
        };
        self.numbers.iter().fold(text.to_owned(), fill)
    }

    fn case(&self, family: &CaseFamily) -> StressCase {
        let subject: Option<Box<dyn StressSubject>> = models::subject(&family.subject, self)
            .or_else(|| equations::subject(&family.subject, self))
            .or_else(|| loops::subject(&family.subject, self));
        StressCase {
            name: self.fill(&family.name),
            class: CaseClass::from_name(&family.class).expect("a class"),
            construction: self.fill(&family.construction),
            breaks: family.breaks.clone(),
            expected: Some(self.expected),
            long: self.long,
            subject: subject.expect("a known subject"),
        }
    }
}

/// All cases, in the order of their classes.
pub fn cases() -> Vec<StressCase> {
    let read: CaseFile = toml::from_str(include_str!("cases.toml")).expect("well-formed cases");
    let families = read.families.iter();
    let cases = families.flat_map(|family| family.members.iter().map(|at| at.case(family)));
    cases.collect()
}

#[cfg(test)]
mod tests;
