//! Putting rules together while their text is read.
//!
//! Every action of the grammar calls the builder immediately; no tree is built.
//! A mistake is reported where it is found, and the rest of its rule is
//! skipped.

use super::pattern::{Pattern, PatternNode};
use super::rule::{Condition, Requirement, Rule, RulePlaces};
use super::token::RuleToken;
use hashbrown::HashMap;
use lalrpop_util::ParseError;
use robovec_analysis::class::NumericClass;
use robovec_ir::Operation;
use robovec_ir::diagnostic::{Diagnostic, Label, clip, suggestion};
use robovec_num::decimal;
use std::ops::Range;

/// Maximum number of mistakes reported of one file; with more it is probably no
/// rule file.
const MAX_MISTAKES: usize = 20;

/// Words that cannot be the name of a rule.
const RESERVED: [&str; 3] = ["rule", "when", "class"];

/// The operations written as calls.
const CALLS: [(&str, Operation); 4] = [
    ("neg", Operation::Neg),
    ("sin", Operation::Sin),
    ("cos", Operation::Cos),
    ("sqrt", Operation::Sqrt),
];

/// The classes a rule may declare.
const CLASSES: [NumericClass; 3] = [
    NumericClass::Exact,
    NumericClass::Real,
    NumericClass::RealTrig,
];

/// A mistake that was reported.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Told;

/// The result of an action: a mistake ends the reading of its rule.
type Action<'text, T = ()> = Result<T, ParseError<usize, RuleToken<'text>, Told>>;

/// One side of a rule as read.
#[derive(Default)]
struct Side {
    pattern: Pattern,
    span: Range<usize>,
    /// The places of the variables, in order of reading.
    occurrences: Vec<(u32, Range<usize>)>,
}

/// The parts of the present rule that were read.
#[derive(Default)]
struct RuleDraft {
    name: Option<(String, Range<usize>)>,
    variables: Vec<String>,
    left: Option<Side>,
    right: Option<Side>,
    both_ways: bool,
    /// The side that is read, its operands without an operation so far, and
    /// its open parentheses.
    side: Side,
    operands: Vec<u32>,
    open: Vec<Range<usize>>,
    /// The condition that is read, and those before it in its list.
    requirement: Option<Requirement>,
    list: Vec<Condition>,
    conditions: Option<Vec<Condition>>,
    class: Option<(NumericClass, Range<usize>)>,
    reason: Option<String>,
}

/// Puts the rules of a file together.
pub(crate) struct RuleBuilder<'text> {
    group: String,
    pub(super) rules: Vec<Rule>,
    pub(super) diagnostics: Vec<Diagnostic>,
    names: HashMap<&'text str, Range<usize>>,
    draft: RuleDraft,
}

impl<'text> RuleBuilder<'text> {
    pub(super) fn new(group: String) -> RuleBuilder<'text> {
        RuleBuilder {
            group,
            rules: Vec::new(),
            diagnostics: Vec::new(),
            names: HashMap::default(),
            draft: RuleDraft::default(),
        }
    }

    pub(super) fn begin(&mut self) {
        self.draft = RuleDraft::default();
    }

    /// Begins the rule available once more.
    pub(super) fn begin_again(&mut self) {
        if let Some((name, _)) = &self.draft.name {
            self.names.remove(name.as_str());
        }
        self.begin();
    }

    /// True when more mistakes would not be reported.
    pub(super) fn is_hopeless(&self) -> bool {
        self.diagnostics.len() >= MAX_MISTAKES
    }

    /// Reports a mistake.
    pub(super) fn error(&mut self, span: Range<usize>, message: impl Into<String>) -> Told {
        self.advise(span, message, Vec::new())
    }

    /// Reports a mistake, with advice.
    fn advise(
        &mut self,
        span: Range<usize>,
        message: impl Into<String>,
        notes: Vec<String>,
    ) -> Told {
        let label = Label::primary(0, span);
        self.tell(
            Diagnostic::error()
                .with_message(message.into())
                .with_labels(vec![label])
                .with_notes(notes),
        )
    }

    fn tell(&mut self, diagnostic: Diagnostic) -> Told {
        if !self.is_hopeless() {
            self.diagnostics.push(diagnostic);
        }
        Told
    }

    /// The innermost parenthesis that is open.
    pub(super) fn innermost(&self) -> Option<Range<usize>> {
        self.draft.open.last().cloned()
    }

    /// True between a condition and its variable.
    pub(super) fn awaits_subject(&self) -> bool {
        self.draft.requirement.is_some()
    }

    pub(super) fn name(&mut self, name: &'text str, span: Range<usize>) -> Action<'text> {
        if RESERVED.contains(&name) {
            let message = format!("'{name}' is a word of the language, not the name of a rule");
            return Err(self.error(span, message).into());
        }
        if let Some(first) = self.names.get(name) {
            let labels = vec![
                Label::primary(0, span),
                Label::secondary(0, first.clone()).with_message("the first one"),
            ];
            let message = format!("there are two rules '{}'", clip(name));
            let diagnostic = Diagnostic::error().with_message(message);
            return Err(self.tell(diagnostic.with_labels(labels)).into());
        }
        self.names.insert(name, span.clone());
        self.draft.name = Some((name.to_owned(), span));
        Ok(())
    }

    pub(super) fn end_left(&mut self, span: Range<usize>) {
        self.draft.left = Some(self.end_side(span));
    }

    pub(super) fn end_right(&mut self, span: Range<usize>) {
        self.draft.right = Some(self.end_side(span));
    }

    fn end_side(&mut self, span: Range<usize>) -> Side {
        self.draft.operands.clear();
        let mut side = std::mem::take(&mut self.draft.side);
        side.span = span;
        side
    }

    pub(super) fn direction(&mut self, both_ways: bool) {
        self.draft.both_ways = both_ways;
    }

    pub(super) fn open(&mut self, span: Range<usize>) {
        self.draft.open.push(span);
    }

    pub(super) fn close(&mut self) {
        let open = self.draft.open.pop();
        open.expect("the grammar closes only what is open");
    }

    pub(super) fn called(&mut self, word: &str, span: Range<usize>) -> Action<'text, Operation> {
        if let Some((_, operation)) = CALLS.iter().find(|(name, _)| *name == word) {
            self.open(span);
            return Ok(*operation);
        }
        let names = CALLS.map(|(name, _)| name);
        let known = format!("operations: +, -, *, /, {}", names.join(", "));
        Err(self.unknown("operation", word, span, &names, known).into())
    }

    /// Reports that nothing has a word as its name.
    fn unknown(
        &mut self,
        what: &str,
        word: &str,
        span: Range<usize>,
        names: &[&str],
        known: String,
    ) -> Told {
        let near = suggestion(word, names.iter().copied());
        let notes = near.into_iter().chain([known]).collect();
        let message = format!("there is no {what} '{}'", clip(word));
        self.advise(span, message, notes)
    }

    pub(super) fn number(&mut self, text: &str, sign: f64, span: Range<usize>) -> Action<'text> {
        match text.parse::<f64>() {
            Ok(number) if decimal::is_lost(text, number) => {
                let message = format!("the number {} is too small", clip(text));
                Err(self
                    .advise(span, message, vec![decimal::LOST.to_owned()])
                    .into())
            }
            // One zero is enough: over the reals they are the same.
            Ok(number) if number.is_finite() => {
                self.push(PatternNode::Number(sign * number + 0.0), span)
            }
            Ok(_) | Err(_) => {
                let message = format!("the number {} is too large", clip(text));
                Err(self.error(span, message).into())
            }
        }
    }

    pub(super) fn variable(&mut self, word: &str, span: Range<usize>) -> Action<'text> {
        if CALLS.iter().any(|(name, _)| *name == word) {
            let message = format!("write the operand of '{word}' in parentheses: {word}(a)");
            return Err(self.error(span, message).into());
        }
        let variables = &mut self.draft.variables;
        let known = variables.iter().position(|name| name == word);
        let variable = known.unwrap_or_else(|| {
            variables.push(word.to_owned());
            variables.len() - 1
        }) as u32;
        self.draft.side.occurrences.push((variable, span.clone()));
        self.push(PatternNode::Variable(variable), span)
    }

    fn push(&mut self, node: PatternNode, span: Range<usize>) -> Action<'text> {
        if self.draft.side.pattern.nodes.len() >= Pattern::LARGEST {
            let most = Pattern::LARGEST;
            let message = format!("a side of a rule has at most {most} operations and values");
            return Err(self.error(span, message).into());
        }
        let index = self.draft.side.pattern.push(node);
        self.draft.operands.push(index);
        Ok(())
    }

    /// Applies an operation to the last operands; it ends at a place.
    pub(super) fn apply(&mut self, operation: Operation, end: usize) -> Action<'text> {
        let operands = &mut self.draft.operands;
        let taken = operands.split_off(operands.len() - operation.arity());
        let node = PatternNode::of(operation, &taken);
        self.push(node, end - 1..end)
    }

    pub(super) fn requirement(&mut self, word: &str, span: Range<usize>) -> Action<'text> {
        let Some(requirement) = Requirement::from_name(word) else {
            let names = Requirement::ALL.map(Requirement::name);
            let known = format!("conditions: {}", names.join(", "));
            return Err(self.unknown("condition", word, span, &names, known).into());
        };
        self.draft.requirement = Some(requirement);
        Ok(())
    }

    /// The variable that a condition is about.
    pub(super) fn subject(&mut self, word: &str, span: Range<usize>) -> Action<'text> {
        let draft = &mut self.draft;
        let left = draft.left.as_ref().expect("conditions follow both sides");
        let number = draft.variables.iter().position(|name| name == word);
        let bound = |number: &u32| left.pattern.variables().contains(number);
        let Some(variable) = number.map(|number| number as u32).filter(bound) else {
            let message = format!("the left side has no variable '{}'", clip(word));
            return Err(self.error(span, message).into());
        };
        let requirement = draft.requirement.take();
        draft.list.push(Condition {
            requirement: requirement.expect("a variable follows its condition"),
            variable,
        });
        Ok(())
    }

    pub(super) fn end_conditions(&mut self, span: Range<usize>) -> Action<'text> {
        let list = std::mem::take(&mut self.draft.list);
        let twice = self.draft.conditions.replace(list).is_some();
        self.once(twice, span)
    }

    /// Reads a class; `clause` is the start of its clause.
    pub(super) fn class(
        &mut self,
        clause: Range<usize>,
        word: &str,
        span: Range<usize>,
    ) -> Action<'text> {
        let Some(&class) = CLASSES.iter().find(|class| class.name() == word) else {
            let known = "classes: exact (not a bit changes), real (equal over the reals), \
                         real-trig (equal when sin^2+cos^2=1)";
            let names = CLASSES.map(NumericClass::name);
            let told = self.unknown("class", word, span, &names, known.to_owned());
            return Err(told.into());
        };
        let twice = self.draft.class.replace((class, span)).is_some();
        self.once(twice, clause)
    }

    pub(super) fn reason(&mut self, quoted: &str, span: Range<usize>) -> Action<'text> {
        let reason = quoted.trim_matches('"').to_owned();
        let twice = self.draft.reason.replace(reason).is_some();
        self.once(twice, span)
    }

    fn once(&mut self, twice: bool, span: Range<usize>) -> Action<'text> {
        if twice {
            return Err(self.error(span, "this occurs in the rule twice").into());
        }
        Ok(())
    }

    /// Ends a rule that was read to its semicolon.
    pub(super) fn end_rule(&mut self) -> Result<(), Told> {
        let draft = std::mem::take(&mut self.draft);
        let (name, name_span) = draft.name.expect("a rule that was read has a name");
        let left = draft.left.expect("a rule that was read has a left side");
        let right = draft.right.expect("a rule that was read has a right side");
        self.sides(&left, &right, draft.both_ways, &draft.variables)?;
        let undeclared = || (NumericClass::Real, name_span.clone());
        let (class, class_span) = draft.class.unwrap_or_else(undeclared);
        self.rules.push(Rule {
            name,
            group: self.group.clone(),
            variables: draft.variables,
            left: left.pattern,
            right: right.pattern,
            both_ways: draft.both_ways,
            conditions: draft.conditions.unwrap_or_default(),
            class,
            reason: draft.reason.unwrap_or_default(),
            places: RulePlaces {
                file: 0,
                name: name_span,
                left: left.span,
                right: right.span,
                class: class_span,
            },
        });
        Ok(())
    }

    /// Checks the conditions on the two sides under which the rule makes sense.
    fn sides(
        &mut self,
        left: &Side,
        right: &Side,
        both_ways: bool,
        variables: &[String],
    ) -> Result<(), Told> {
        if left.pattern == right.pattern {
            let span = left.span.start..right.span.end;
            return Err(self.error(span, "both sides are the same"));
        }
        if left.pattern.is_variable() {
            let message = "a single variable matches every value of a program";
            let notes = vec!["let the left side have an operation".to_owned()];
            return Err(self.advise(left.span.clone(), message, notes));
        }
        if both_ways && right.pattern.is_variable() {
            let message = "backwards, a single variable matches every value of a program";
            let notes = vec!["write '=>' for one direction only".to_owned()];
            return Err(self.advise(right.span.clone(), message, notes));
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
        let notes = vec!["no side gives it a value".to_owned()];
        Err(self.advise(span.clone(), message, notes))
    }
}
