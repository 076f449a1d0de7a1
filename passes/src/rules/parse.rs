//! Reading rule files, with a caret for each mistake.

use super::cursor::{Cursor, Told};
use super::expression::{RESERVED, Side, expression};
use super::rule::{Condition, Requirement, Rule, RulePlaces};
use super::token::Token;
use super::{RuleFile, RuleSet};
use crate::NumericClass;
use hashbrown::HashMap;
use robovec_ir::diagnostic::{Diagnostic, Label, Report, clip, did_you_mean};
use std::ops::Range;

/// The classes a rule may declare.
const CLASSES: [NumericClass; 3] = [
    NumericClass::Exact,
    NumericClass::Real,
    NumericClass::RealTrig,
];

/// Reads a file of rules; what is wrong in it is told all at once.
pub(super) fn parse(text: &str, file_name: &str) -> Result<RuleSet, Report> {
    let mut reader = Reader {
        cursor: Cursor::new(text),
        group: super::group_of(file_name),
        rules: Vec::new(),
        names: HashMap::default(),
    };
    while !reader.cursor.is_done() && !reader.cursor.is_hopeless() {
        match reader.rule() {
            Ok(rule) => reader.rules.push(rule),
            Err(Told) => reader.cursor.recover(),
        }
    }
    if reader.cursor.diagnostics.is_empty() {
        return Ok(RuleSet {
            rules: reader.rules,
            files: vec![RuleFile {
                name: file_name.to_owned(),
                text: text.to_owned(),
            }],
        });
    }
    Err(Report::of(file_name, text, reader.cursor.diagnostics))
}

struct Reader<'text> {
    cursor: Cursor<'text>,
    group: String,
    rules: Vec<Rule>,
    names: HashMap<&'text str, Range<usize>>,
}

/// What follows the right side, as far as it was written.
#[derive(Default)]
struct Clauses {
    conditions: Option<Vec<Condition>>,
    class: Option<(NumericClass, Range<usize>)>,
    reason: Option<String>,
}

impl Reader<'_> {
    fn rule(&mut self) -> Result<Rule, Told> {
        if self.cursor.peek() != Some(Token::Word("rule")) {
            return Err(self.cursor.unexpected("'rule'"));
        }
        self.cursor.advance();
        let (name, name_span) = self.name()?;
        self.cursor.expect(Token::Colon, "':'")?;
        let mut variables = Vec::new();
        let left = expression(&mut self.cursor, &mut variables)?;
        let both_ways = match self.cursor.peek() {
            Some(Token::Becomes) => false,
            Some(Token::BothWays) => true,
            _ => return Err(self.cursor.unexpected("an operator, '=>' or '<=>'")),
        };
        self.cursor.advance();
        let right = expression(&mut self.cursor, &mut variables)?;
        let clauses = self.clauses(&variables, &left)?;
        if !self.cursor.accept(Token::Semicolon) {
            let wanted = "an operator, 'when', 'class', a reason in quotes or ';'";
            return Err(self.cursor.unexpected(wanted));
        }
        self.sides(&left, &right, both_ways, &variables)?;
        let (class, class_span) = clauses
            .class
            .unwrap_or((NumericClass::Real, name_span.clone()));
        Ok(Rule {
            name,
            group: self.group.clone(),
            variables,
            left: left.pattern,
            right: right.pattern,
            both_ways,
            conditions: clauses.conditions.unwrap_or_default(),
            class,
            reason: clauses.reason.unwrap_or_default(),
            places: RulePlaces {
                file: 0,
                name: name_span,
                left: left.span,
                right: right.span,
                class: class_span,
            },
        })
    }

    fn name(&mut self) -> Result<(String, Range<usize>), Told> {
        let (name, span) = self.cursor.hyphenated("the name of the rule")?;
        if RESERVED.contains(&name) {
            let message = format!("'{name}' is a word of the language, not the name of a rule");
            return Err(self.cursor.error(span, message));
        }
        if let Some(first) = self.names.get(name) {
            let labels = vec![
                Label::primary(0, span),
                Label::secondary(0, first.clone()).with_message("the first one"),
            ];
            self.cursor.diagnostics.push(
                Diagnostic::error()
                    .with_message(format!("there are two rules '{}'", clip(name)))
                    .with_labels(labels),
            );
            return Err(Told);
        }
        self.names.insert(name, span.clone());
        Ok((name.to_owned(), span))
    }

    fn clauses(&mut self, variables: &[String], left: &Side) -> Result<Clauses, Told> {
        let mut clauses = Clauses::default();
        loop {
            let span = self.cursor.span();
            let twice = match self.cursor.peek() {
                Some(Token::Word("when")) => {
                    self.cursor.advance();
                    let conditions = self.conditions(variables, left)?;
                    clauses.conditions.replace(conditions).is_some()
                }
                Some(Token::Word("class")) => {
                    self.cursor.advance();
                    self.cursor.expect(Token::Equals, "'='")?;
                    let class = self.class()?;
                    clauses.class.replace(class).is_some()
                }
                Some(Token::Quoted(reason)) => {
                    self.cursor.advance();
                    let reason = reason.trim_matches('"').to_owned();
                    clauses.reason.replace(reason).is_some()
                }
                _ => return Ok(clauses),
            };
            if twice {
                return Err(self.cursor.error(span, "this stands in the rule twice"));
            }
        }
    }

    fn class(&mut self) -> Result<(NumericClass, Range<usize>), Told> {
        let (word, span) = self.cursor.hyphenated("a class")?;
        if let Some(class) = CLASSES.iter().find(|class| class.name() == word) {
            return Ok((*class, span));
        }
        let mut notes: Vec<String> = did_you_mean(word, CLASSES.map(NumericClass::name))
            .map(|near| format!("did you mean '{near}'?"))
            .into_iter()
            .collect();
        notes.push(
            "classes: exact (not a bit changes), real (equal over the reals), \
             real-trig (equal when sin^2+cos^2=1)"
                .to_owned(),
        );
        let message = format!("there is no class '{}'", clip(word));
        Err(self.cursor.advise(span, message, notes))
    }

    fn conditions(&mut self, variables: &[String], left: &Side) -> Result<Vec<Condition>, Told> {
        let mut conditions = Vec::new();
        loop {
            conditions.push(self.condition(variables, left)?);
            if !self.cursor.accept(Token::Comma) {
                return Ok(conditions);
            }
        }
    }

    fn condition(&mut self, variables: &[String], left: &Side) -> Result<Condition, Told> {
        let span = self.cursor.span();
        let Some(Token::Word(word)) = self.cursor.peek() else {
            return Err(self.cursor.unexpected("a condition"));
        };
        let known = Requirement::ALL.iter().find(|known| known.name() == word);
        let Some(&requirement) = known else {
            let names = Requirement::ALL.map(Requirement::name);
            let mut notes: Vec<String> = did_you_mean(word, names)
                .map(|near| format!("did you mean '{near}'?"))
                .into_iter()
                .collect();
            notes.push(format!("conditions: {}", names.join(", ")));
            let message = format!("there is no condition '{}'", clip(word));
            return Err(self.cursor.advise(span, message, notes));
        };
        self.cursor.advance();
        self.cursor.expect(Token::Open, "'('")?;
        let span = self.cursor.span();
        let Some(Token::Word(word)) = self.cursor.peek() else {
            return Err(self.cursor.unexpected("a variable of the left side"));
        };
        let number = variables.iter().position(|name| name == word);
        let bound = |number: &usize| left.pattern.variables().contains(&(*number as u32));
        let Some(variable) = number.filter(bound) else {
            let message = format!("the left side has no variable '{}'", clip(word));
            return Err(self.cursor.error(span, message));
        };
        self.cursor.advance();
        self.cursor.expect(Token::Close, "')'")?;
        Ok(Condition {
            requirement,
            variable: variable as u32,
        })
    }

    /// What the two sides must be for the rule to make sense.
    fn sides(
        &mut self,
        left: &Side,
        right: &Side,
        both_ways: bool,
        variables: &[String],
    ) -> Result<(), Told> {
        if left.pattern == right.pattern {
            let span = left.span.start..right.span.end;
            return Err(self.cursor.error(span, "both sides are the same"));
        }
        if left.pattern.is_variable() {
            let message = "a single variable matches every value of a program";
            let notes = vec!["let the left side have an operation".to_owned()];
            return Err(self.cursor.advise(left.span.clone(), message, notes));
        }
        if both_ways && right.pattern.is_variable() {
            let message = "backwards, a single variable matches every value of a program";
            let notes = vec!["write '=>' for one direction only".to_owned()];
            return Err(self.cursor.advise(right.span.clone(), message, notes));
        }
        self.bound(left, right, "left", variables)?;
        if both_ways {
            self.bound(right, left, "right", variables)?;
        }
        Ok(())
    }

    /// Every variable of `to` must occur in `from`.
    fn bound(
        &mut self,
        from: &Side,
        to: &Side,
        name: &str,
        variables: &[String],
    ) -> Result<(), Told> {
        let known = from.pattern.variables();
        let unknown = to
            .occurrences
            .iter()
            .find(|(variable, _)| !known.contains(variable));
        let Some((variable, span)) = unknown else {
            return Ok(());
        };
        let word = clip(&variables[*variable as usize]).into_owned();
        let message = format!("the variable '{word}' does not occur on the {name} side");
        let notes = vec!["nothing says what it should stand for".to_owned()];
        Err(self.cursor.advise(span.clone(), message, notes))
    }
}
