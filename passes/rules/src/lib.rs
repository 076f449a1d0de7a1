//! Rewriting rules as data.
//!
//! A rule states that a term that matches its left side may be replaced by its
//! right side. Rules live in files (`rules/*.rules`) that are read at run time,
//! so that trying a new one takes no compiler: the format is described in
//! docs/rules.md. The files that ship are embedded, as machine files are.
//!
//! Invariant: a set that was read is well formed (every variable of a right
//! side is bound, no side is empty, names are unique), but it need not be
//! *true*; [`check`] proves or refutes each rule, and
//! A pass may use [`RuleSet::sound`].

mod builder;
mod built_in;
pub mod check;
pub mod find;
mod graph;
mod pattern;
mod print;
pub mod profile;
mod read;
mod rule;
pub mod syntax;
mod token;

pub use built_in::{BUILT_IN, DEFAULT};
pub use pattern::{Pattern, PatternNode};
pub use rule::{Condition, Requirement, Rule, RulePlaces};

use hashbrown::HashMap;
use robovec_ir::diagnostic::{Diagnostic, Label, Report};

/// A file that rules were read from.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RuleFile {
    /// Its name in messages.
    pub name: String,
    /// Its whole text.
    pub text: String,
}

/// Rules, in the order in which they were read.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct RuleSet {
    /// The rules; names are unique.
    pub rules: Vec<Rule>,
    /// The files they come from.
    pub files: Vec<RuleFile>,
}

impl RuleSet {
    /// Reads the text of a rule file.
    ///
    /// # Errors
    ///
    /// All mistakes of the text (at most twenty), each with its place.
    pub fn parse(text: &str, file_name: &str) -> Result<RuleSet, Report> {
        read::parse(text, file_name)
    }

    /// The rule of a name.
    pub fn get(&self, name: &str) -> Option<&Rule> {
        self.rules.iter().find(|rule| rule.name == name)
    }

    /// Adds the rules of another set.
    ///
    /// # Errors
    ///
    /// Fails when a name is taken; this set is then unchanged.
    pub fn extend(&mut self, other: RuleSet) -> Result<(), Report> {
        let places = self
            .rules
            .iter()
            .map(|rule| (rule.name.as_str(), &rule.places));
        let known: HashMap<&str, &RulePlaces> = places.collect();
        let mut report = Report::new();
        for file in self.files.iter().chain(&other.files) {
            report.add_file(&file.name, file.text.clone());
        }
        let shift = self.files.len();
        for rule in &other.rules {
            let Some(first) = known.get(rule.name.as_str()) else {
                continue;
            };
            let label = Label::primary(shift + rule.places.file, rule.places.name.clone());
            let before = Label::secondary(first.file, first.name.clone());
            report.push(
                Diagnostic::error()
                    .with_message(format!("there is a rule '{}' already", rule.name))
                    .with_labels(vec![label, before.with_message("the first one")])
                    .with_note("give one of them another name"),
            );
        }
        if report.has_errors() {
            return Err(report);
        }
        drop(known);
        self.files.extend(other.files);
        self.rules.extend(other.rules.into_iter().map(|mut rule| {
            rule.places.file += shift;
            rule
        }));
        Ok(())
    }

    /// A report on the files of the set, to which messages about
    /// [`Rule::places`] can be added.
    pub fn report(&self) -> Report {
        let mut report = Report::new();
        for file in &self.files {
            report.add_file(&file.name, file.text.clone());
        }
        report
    }

    /// All rules with one direction each: see [`Rule::directed`].
    pub fn directed(&self) -> Vec<Rule> {
        self.rules.iter().flat_map(Rule::directed).collect()
    }

    /// The set as the text of a rule file.
    pub fn to_text(&self) -> String {
        self.rules.iter().map(|rule| format!("{rule}\n")).collect()
    }
}

/// The group of the rules of a file: its name without folder and ending.
fn group_of(file_name: &str) -> String {
    let mut parts = file_name.rsplit(['/', '\\']);
    let base = parts.next().expect("a text has a last part");
    base.strip_suffix(".rules").unwrap_or(base).to_owned()
}

#[cfg(test)]
mod tests;
