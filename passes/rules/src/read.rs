//! Reading rule files: the grammar of one rule after the other, and a caret
//! for each mistake.

use super::builder::{RuleBuilder, Told};
use super::rule::Requirement;
use super::token::{Placed, RuleToken, tokens};
use super::{RuleFile, RuleSet};
use lalrpop_util::{ParseError, lalrpop_mod};
use robovec_ir::diagnostic::Report;
use std::cell::Cell;
use std::ops::Range;

lalrpop_mod!(
    #[allow(
        clippy::all,
        clippy::restriction,
        missing_docs,
        unreachable_pub,
        unused
    )]
    grammar,
    "/grammar.rs"
);

/// Longest rule file, in bytes.
const LONGEST: usize = 4 << 20;

/// Reads a file of rules; all its mistakes are reported together.
pub(super) fn parse(text: &str, file_name: &str) -> Result<RuleSet, Report> {
    let mut reader = RuleReader {
        text,
        tokens: Vec::new(),
        builder: RuleBuilder::new(super::group_of(file_name)),
    };
    reader.file();
    let RuleBuilder {
        rules, diagnostics, ..
    } = reader.builder;
    if diagnostics.is_empty() {
        return Ok(RuleSet {
            rules,
            files: vec![RuleFile {
                name: file_name.to_owned(),
                text: text.to_owned(),
            }],
        });
    }
    Err(Report::of(file_name, text, diagnostics))
}

/// Tokens that can follow, with their names in the grammar: of each place in a
/// rule one.
const EXPECTED: [(&str, RuleToken<'_>); 8] = [
    ("a number", RuleToken::Number("0")),
    ("'+'", RuleToken::Plus),
    ("';'", RuleToken::Semicolon),
    ("a word", RuleToken::Word("a")),
    ("'('", RuleToken::Open),
    ("')'", RuleToken::Close),
    ("':'", RuleToken::Colon),
    ("'='", RuleToken::Equals),
];

/// A token in the form of the parser.
fn located<'text>((token, span): &Placed<'text>) -> Result<(usize, RuleToken<'text>, usize), Told> {
    Ok((span.start, *token, span.end))
}

struct RuleReader<'text> {
    text: &'text str,
    tokens: Vec<Placed<'text>>,
    builder: RuleBuilder<'text>,
}

impl RuleReader<'_> {
    fn file(&mut self) {
        if self.text.len() > LONGEST {
            let message = "a file of rules of more than four megabytes is a mistake";
            self.builder.error(0..0, message);
            return;
        }
        self.tokens = tokens(self.text);
        let unknown = self
            .tokens
            .iter()
            .filter(|(token, _)| *token == RuleToken::Unknown);
        for (_, span) in unknown {
            let message = if self.text[span.clone()].starts_with('"') {
                "this text has no closing '\"' on its line"
            } else {
                "this character is not allowed in a file of rules"
            };
            self.builder.error(span.clone(), message);
        }
        let mut at = 0;
        while at < self.tokens.len() && !self.builder.is_hopeless() {
            at = self.rule(at);
        }
    }

    /// Reads a rule; where the next one begins.
    fn rule(&mut self, at: usize) -> usize {
        let rest = &self.tokens[at..];
        let is_end = |(token, _): &Placed<'_>| *token == RuleToken::Semicolon;
        let length = rest.iter().position(is_end).map(|last| last + 1);
        let rule = &rest[..length.unwrap_or(rest.len())];
        let (end, begins) = (at + rule.len(), rule[0].0 == RuleToken::Rule);
        let taken = Cell::new(0);
        let stream = rule.iter().inspect(|_| taken.set(taken.get() + 1));
        self.builder.begin();
        match grammar::RuleParser::new().parse(&mut self.builder, stream.map(located)) {
            Ok(()) => match self.builder.end_rule() {
                Ok(()) => end,
                Err(Told) => self.recover(end),
            },
            Err(error) => {
                // What was taken last was looked at, or is the mistake; the
                // word a rule begins with is neither.
                let last = at + taken.get() - 1;
                self.explain(&error, at..last);
                self.recover(last.max(at + usize::from(begins)))
            }
        }
    }

    /// The next rule: after the next semicolon, or at the word `rule`.
    fn recover(&self, from: usize) -> usize {
        for (at, (token, _)) in self.tokens.iter().enumerate().skip(from) {
            match token {
                RuleToken::Semicolon => return at + 1,
                RuleToken::Rule => return at,
                _ => {}
            }
        }
        self.tokens.len()
    }

    /// Reports a mistake; `rule` are the tokens of its rule before the last that
    /// was taken.
    fn explain(&mut self, error: &ParseError<usize, RuleToken<'_>, Told>, rule: Range<usize>) {
        let (found, expected) = match error {
            ParseError::User { error: Told } => return,
            ParseError::UnrecognizedToken {
                token: (start, token, end),
                expected,
            } => (Some((*token, *start..*end)), expected),
            ParseError::UnrecognizedEof { expected, .. } => (None, expected),
            ParseError::InvalidToken { .. } | ParseError::ExtraToken { .. } => {
                unreachable!("a rule ends at its semicolon, and its tokens are valid")
            }
        };
        let expected: Vec<&str> = expected.iter().map(|name| name.trim_matches('"')).collect();
        let end = if found.is_some() {
            rule.end
        } else {
            rule.end + 1
        };
        if self.settle(rule.start..end, &expected).is_ok() {
            self.unexpected(found, &expected);
        }
    }

    /// Completes the actions that the parser delays until the next token, by
    /// reading the tokens before a mistake once more with an expected one after
    /// them: earlier mistakes are reported first.
    fn settle(&mut self, before: Range<usize>, expected: &[&str]) -> Result<(), Told> {
        let next = EXPECTED.iter().find(|(name, _)| expected.contains(name));
        let next = next.map(|&(_, token)| (token, 0..0));
        let stream = self.tokens[before].iter().chain(&next).map(located);
        self.builder.begin_again();
        match grammar::RuleParser::new().parse(&mut self.builder, stream) {
            Err(ParseError::User { error }) => Err(error),
            Ok(()) | Err(_) => Ok(()),
        }
    }

    /// Reports an unexpected token, or an unexpected end.
    fn unexpected(&mut self, found: Option<(RuleToken<'_>, Range<usize>)>, expected: &[&str]) {
        if let Some((RuleToken::Unknown, _)) = found {
            return; // It was told before.
        }
        let is_inside = expected.contains(&"'+'");
        if is_inside && let Some(open) = self.builder.innermost() {
            self.builder.error(open, "this parenthesis is not closed");
            return;
        }
        let wanted = self.wanted(expected);
        let end = self.text.trim_end().len();
        match found {
            Some((RuleToken::Close, span)) if is_inside => {
                self.builder.error(span, "no '(' is open here")
            }
            Some((_, span)) => self.builder.error(span, format!("expected {wanted}")),
            None => self
                .builder
                .error(end..end, format!("the file ends early: expected {wanted}")),
        };
    }

    /// The tokens that the grammar expects, in words.
    fn wanted(&self, expected: &[&str]) -> String {
        let expects = |name: &str| expected.contains(&name);
        let wanted = if expects("a number") {
            "a number, a variable or '('"
        } else if expects("'=>'") {
            "an operator, '=>' or '<=>'"
        } else if expects("';'") {
            "an operator, 'when', 'class', a reason in quotes or ';'"
        } else if expects("a word") && self.builder.awaits_subject() {
            "a variable of the left side"
        } else if expects("a word") {
            let names = Requirement::ALL.map(Requirement::name);
            return format!("a condition ({})", names.join(", "));
        } else {
            expected.first().expect("the grammar expects something")
        };
        wanted.to_owned()
    }
}
