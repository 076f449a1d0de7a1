//! Rules of other tools.

use super::super::rule::{Condition, Requirement, Rule, RulePlaces};
use super::super::{RuleFile, RuleSet, group_of};
use super::Syntax;
use super::term::{PatternProblem, RuleSides, number};
use hashbrown::HashSet;
use robovec_ir::diagnostic::{Diagnostic, Report, Severity, clip};
use robovec_ir::parenthesised::{Forest, error, read};

/// Maximum number of remarks on rules that were left out or changed.
const MAX_REMARKS: usize = 50;

/// Commands of egglog that define terms or run a program, and hold no rule.
const WITHOUT_RULES: &str = "datatype datatype* sort constructor function relation ruleset let \
    union set set-option run run-schedule push pop check fail extract print-function \
    print-size print-stats query-extract";

/// Reads a text; rules that robovec cannot express are left out with a
/// warning.
pub(super) fn import(
    text: &str,
    file_name: &str,
    syntax: Syntax,
) -> Result<(RuleSet, Report), Report> {
    let fail = |diagnostics| Report::of(file_name, text, diagnostics);
    let forest = read(text).map_err(|diagnostic| fail(vec![diagnostic]))?;
    let mut importer = Importer {
        forest: &forest,
        group: group_of(file_name),
        rules: Vec::new(),
        names: HashSet::new(),
        rulesets: HashSet::new(),
        warnings: Vec::new(),
        errors: Vec::new(),
    };
    for &root in &forest.roots {
        match syntax {
            Syntax::Egglog => importer.egglog(root),
            Syntax::Herbie => importer.herbie(root),
        }
    }
    if !importer.errors.is_empty() {
        return Err(fail(importer.errors));
    }
    let more = importer.warnings.len().saturating_sub(MAX_REMARKS);
    importer.warnings.truncate(MAX_REMARKS);
    if more > 0 {
        let message = format!("{more} more such remarks were left out");
        let diagnostic = Diagnostic::new(Severity::Warning).with_message(message);
        importer.warnings.push(diagnostic);
    }
    let set = RuleSet {
        rules: importer.rules,
        files: vec![RuleFile {
            name: file_name.to_owned(),
            text: text.to_owned(),
        }],
    };
    Ok((set, Report::of(file_name, text, importer.warnings)))
}

struct Importer<'a> {
    forest: &'a Forest<'a>,
    group: String,
    rules: Vec<Rule>,
    names: HashSet<String>,
    /// Rulesets that were remarked on.
    rulesets: HashSet<String>,
    warnings: Vec<Diagnostic>,
    errors: Vec<Diagnostic>,
}

impl Importer<'_> {
    /// `(rewrite left right :when (…))`, `(birewrite left right)`; other
    /// commands that may hold rules are left out with a warning.
    fn egglog(&mut self, root: u32) {
        let forest = self.forest;
        let both_ways = match forest.head(root) {
            Some("rewrite") => false,
            Some("birewrite") => true,
            Some(command) => {
                if !WITHOUT_RULES.split(' ').any(|known| known == command) {
                    let message = format!("'{}' is not a rewrite", clip(command));
                    self.leave_out(error(forest.get(root).span.clone(), message));
                }
                return;
            }
            None => {
                let span = forest.get(root).span.clone();
                self.errors.push(error(span, "expected a command"));
                return;
            }
        };
        let elements = forest.elements(root);
        let [_, left, right, rest @ ..] = elements else {
            let message = "a rewrite has a left side and a right side";
            self.errors
                .push(error(forest.get(root).span.clone(), message));
            return;
        };
        let (name, reason) = match forest.comment(root).and_then(|text| text.split_once(": ")) {
            Some((name, reason)) if is_name(name) => (name.to_owned(), reason.to_owned()),
            _ => {
                let comment = forest.comment(root).unwrap_or_default();
                (
                    format!("egglog-{}", self.rules.len() + 1),
                    comment.to_owned(),
                )
            }
        };
        let mut terms = RuleSides::default();
        let Some(mut rule) = self.rule((root, *left, *right), &mut terms) else {
            return;
        };
        rule.both_ways = both_ways;
        rule.reason = reason.replace('"', "'");
        let mut rest = rest.iter().copied();
        while let Some(option) = rest.next() {
            // What a rule subsumes is a matter of the engine that applies it.
            if forest.atom(option) == Some(":subsume") {
                continue;
            }
            let value = rest.next();
            let span = forest.get(option).span.clone();
            let Some(value) = value else {
                self.errors.push(error(span, "an option has a value"));
                return;
            };
            match forest.atom(option) {
                Some(":when") => {
                    for &condition in forest.elements(value) {
                        match self.condition(condition, &mut terms) {
                            Some(condition) => rule.conditions.push(condition),
                            None => {
                                let span = forest.get(condition).span.clone();
                                let message = "robovec has no such condition";
                                self.leave_out(error(span, message));
                                return;
                            }
                        }
                    }
                }
                Some(":ruleset") => self.without_ruleset(value),
                _ => {
                    self.leave_out(error(span, "robovec has no such option of a rewrite"));
                    return;
                }
            }
        }
        for &variable in &terms.constants {
            // What is known not to be zero is known to be a number.
            if rule.requirements(variable).next().is_none() {
                rule.conditions.push(Condition {
                    requirement: Requirement::Constant,
                    variable,
                });
            }
        }
        self.add(rule, name);
    }

    /// Warns once of a ruleset, which its rules lose.
    fn without_ruleset(&mut self, name: u32) {
        let forest = self.forest;
        let text = forest.atom(name).unwrap_or_default();
        if self.rulesets.insert(text.to_owned()) {
            let message = format!("the ruleset '{}' is not kept", clip(text));
            let mut diagnostic = error(forest.get(name).span.clone(), message);
            diagnostic.severity = Severity::Warning;
            let note = "its rules are read as all others; write them into a separate file";
            diagnostic.notes.push(note.to_owned());
            self.warnings.push(diagnostic);
        }
    }

    /// `(!= a 0.0)` or `(> a 0.0)`.
    fn condition(&self, tree: u32, terms: &mut RuleSides) -> Option<Condition> {
        let forest = self.forest;
        let [relation, variable, zero] = forest.elements(tree) else {
            return None;
        };
        let zero = match forest.elements(*zero) {
            [_, inner] => forest.atom(*inner),
            _ => forest.atom(*zero),
        };
        let name = forest.atom(*variable)?;
        let known = terms.variables.iter().any(|known| known == name);
        if number(zero?)? != 0.0 || !known {
            return None;
        }
        let requirement = match forest.atom(*relation)? {
            "!=" => Requirement::Nonzero,
            ">" => Requirement::Positive,
            _ => return None,
        };
        Some(Condition {
            requirement,
            variable: terms.variable(name),
        })
    }

    /// `(define-rules group [name left right] …)` and its older spellings.
    fn herbie(&mut self, root: u32) {
        let forest = self.forest;
        if !forest
            .head(root)
            .is_some_and(|head| head.starts_with("define-rule"))
        {
            return;
        }
        let mut after_keyword = false;
        for &element in &forest.elements(root)[1..] {
            let keyword = forest
                .atom(element)
                .is_some_and(|atom| atom.starts_with("#:"));
            // A keyword has a value: #:type ([a real] [b real]).
            let is_rule =
                !after_keyword && forest.text[forest.get(element).span.clone()].starts_with('[');
            after_keyword = keyword;
            if is_rule {
                self.herbie_rule(element);
            }
        }
    }

    fn herbie_rule(&mut self, tree: u32) {
        let forest = self.forest;
        let [name, left, right, ..] = forest.elements(tree) else {
            let message = "a rule has a name, a left side and a right side";
            self.errors
                .push(error(forest.get(tree).span.clone(), message));
            return;
        };
        let Some(name) = forest.atom(*name) else {
            let message = "expected the name of a rule";
            self.errors
                .push(error(forest.get(*name).span.clone(), message));
            return;
        };
        let mut terms = RuleSides::default();
        let Some(mut rule) = self.rule((tree, *left, *right), &mut terms) else {
            return;
        };
        rule.reason = forest.comment(tree).unwrap_or_default().replace('"', "'");
        self.add(rule, name.to_owned());
    }

    fn leave_out(&mut self, mut diagnostic: Diagnostic) {
        diagnostic.severity = Severity::Warning;
        diagnostic.notes.push("the rule is left out".to_owned());
        self.warnings.push(diagnostic);
    }

    /// A rule from its sides; `None` when that was reported as impossible.
    fn rule(&mut self, (all, left, right): (u32, u32, u32), terms: &mut RuleSides) -> Option<Rule> {
        let forest = self.forest;
        let mut sides = Vec::new();
        for side in [left, right] {
            match terms.pattern(forest, side) {
                Ok(pattern) => sides.push(pattern),
                Err(PatternProblem::Unsupported(diagnostic)) => {
                    self.leave_out(diagnostic);
                    return None;
                }
                Err(PatternProblem::Wrong(diagnostic)) => {
                    self.errors.push(diagnostic);
                    return None;
                }
            }
        }
        let (to, from) = (sides.pop()?, sides.pop()?);
        let span = |tree: u32| forest.get(tree).span.clone();
        if from.is_variable() {
            let message = "a single variable matches every value of a program";
            self.leave_out(error(span(left), message));
            return None;
        }
        if from == to {
            self.leave_out(error(span(all), "both sides are the same"));
            return None;
        }
        let bound = from.variables();
        if let Some(free) = to
            .variables()
            .into_iter()
            .find(|free| !bound.contains(free))
        {
            let name = clip(&terms.variables[free as usize]).into_owned();
            let message = format!("the variable '{name}' does not occur on the left side");
            self.errors.push(error(span(right), message));
            return None;
        }
        Some(Rule {
            group: self.group.clone(),
            places: RulePlaces {
                file: 0,
                name: span(all),
                left: span(left),
                right: span(right),
                class: span(all),
            },
            ..Rule::new(terms.variables.clone(), from, to)
        })
    }

    fn add(&mut self, mut rule: Rule, name: String) {
        if rule.both_ways
            && (rule.right.is_variable() || rule.left.variables() != rule.right.variables())
        {
            rule.both_ways = false;
        }
        // Names of robovec are words with hyphens.
        let mut clean: String = name
            .chars()
            .map(|letter| {
                if letter.is_alphanumeric() {
                    letter
                } else {
                    '-'
                }
            })
            .collect();
        clean = clean.trim_matches('-').to_owned();
        if !clean.starts_with(char::is_alphabetic) {
            clean = format!("rule-{clean}");
        }
        let mut name = clean.clone();
        let mut number = 2;
        while !self.names.insert(name.clone()) {
            name = format!("{clean}-{number}");
            number += 1;
        }
        rule.name = name;
        self.rules.push(rule);
    }
}

fn is_name(name: &str) -> bool {
    name.starts_with(char::is_alphabetic)
        && name
            .chars()
            .all(|letter| letter.is_alphanumeric() || letter == '-' || letter == '_')
}
