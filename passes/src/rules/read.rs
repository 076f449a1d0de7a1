//! Reading rule files: the grammar of one rule after the other, and a caret
//! for each mistake.

use super::builder::{RuleBuilder, Told};
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
    "/rules/grammar.rs"
);

/// Longest rule file, in bytes.
const LONGEST: usize = 4 << 20;

/// Reads a file of rules; what is wrong in it is told all at once.
pub(super) fn parse(text: &str, file_name: &str) -> Result<RuleSet, Report> {
    let mut reader = Reader {
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

struct Reader<'text> {
    text: &'text str,
    tokens: Vec<Placed<'text>>,
    builder: RuleBuilder<'text>,
}

impl Reader<'_> {
    fn file(&mut self) {
        if self.text.len() > LONGEST {
            let message = "a file of rules of more than four megabytes is a mistake";
            self.builder.error(0..0, message);
            return;
        }
        self.tokens = tokens(self.text);
        let unknown = self.tokens.iter().filter(|(token, _)| token.is_none());
        for (_, span) in unknown {
            let message = match self.text[span.clone()].starts_with('"') {
                true => "this text has no closing '\"' on its line",
                false => "this character has no place in a file of rules",
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
        let is_end = |(token, _): &Placed<'_>| *token == Some(RuleToken::Semicolon);
        let length = rest.iter().position(is_end).map(|last| last + 1);
        let rule = &rest[..length.unwrap_or(rest.len())];
        let taken = Cell::new(0);
        let stream = rule.iter().map(|(token, span)| {
            taken.set(taken.get() + 1);
            let token = token.ok_or(Told)?;
            Ok((span.start, token, span.end))
        });
        self.builder.begin();
        let end = at + rule.len();
        match grammar::RuleParser::new().parse(&mut self.builder, stream) {
            Ok(()) => match self.builder.end_rule() {
                Ok(()) => end,
                Err(Told) => self.recover(end),
            },
            Err(error) => {
                // What was taken last was looked at, or is the mistake; the
                // word a rule begins with is neither.
                let last = at + taken.get() - 1;
                let begins = self.tokens[at].0 == Some(RuleToken::Rule);
                self.explain(&error);
                self.recover(last.max(at + usize::from(begins)))
            }
        }
    }

    /// The next rule: behind the next semicolon, or at the word `rule`.
    fn recover(&self, from: usize) -> usize {
        for (at, (token, _)) in self.tokens.iter().enumerate().skip(from) {
            match token {
                Some(RuleToken::Semicolon) => return at + 1,
                Some(RuleToken::Rule) => return at,
                _ => {}
            }
        }
        self.tokens.len()
    }

    fn explain(&mut self, error: &ParseError<usize, RuleToken<'_>, Told>) {
        match error {
            ParseError::User { error: Told } => {}
            ParseError::UnrecognizedToken {
                token: (start, token, end),
                expected,
            } => self.unexpected(Some((*token, *start..*end)), expected),
            ParseError::UnrecognizedEof { expected, .. } => self.unexpected(None, expected),
            ParseError::InvalidToken { .. } | ParseError::ExtraToken { .. } => {
                unreachable!("a rule ends at its semicolon, and its tokens are valid")
            }
        }
    }

    /// Tells that something else should stand at a token, or at the end.
    fn unexpected(&mut self, found: Option<(RuleToken<'_>, Range<usize>)>, expected: &[String]) {
        let expected: Vec<&str> = expected.iter().map(|name| name.trim_matches('"')).collect();
        let is_inside = expected.contains(&"'+'");
        if is_inside && let Some(open) = self.builder.innermost() {
            self.builder.error(open, "this parenthesis is not closed");
            return;
        }
        let wanted = self.wanted(&expected);
        let end = self.text.trim_end().len();
        match found {
            Some((RuleToken::Close, span)) if is_inside => {
                self.builder.error(span, "no '(' is open here")
            }
            Some((_, span)) => self
                .builder
                .error(span, format!("here should stand {wanted}")),
            None => self.builder.error(
                end..end,
                format!("the file ends where {wanted} should stand"),
            ),
        };
    }

    /// What the grammar expects, in words.
    fn wanted<'a>(&self, expected: &[&'a str]) -> &'a str {
        let expects = |name: &str| expected.contains(&name);
        if expects("a number") {
            "a number, a variable or '('"
        } else if expects("'=>'") {
            "an operator, '=>' or '<=>'"
        } else if expects("';'") {
            "an operator, 'when', 'class', a reason in quotes or ';'"
        } else if expects("a word") && self.builder.awaits_subject() {
            "a variable of the left side"
        } else if expects("a word") {
            "a condition"
        } else {
            expected.first().expect("the grammar expects something")
        }
    }
}
