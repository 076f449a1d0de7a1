//! Errors of the grammar, said for people.

use super::builder::{Builder, Head, Span};
use super::lexer::Token;
use super::problems::error;
use crate::diagnostic::clip;
use crate::operation::Operation;
use lalrpop_util::ParseError;

/// How many of the expected tokens are listed.
const MOST_EXPECTED: usize = 6;

impl Builder<'_> {
    /// Records an error of the grammar and gives the unfinished statement an
    /// end that causes no further errors.
    pub(super) fn syntax_error(&mut self, error: ParseError<u32, Token, std::convert::Infallible>) {
        match error {
            ParseError::UnrecognizedToken { token, expected } => {
                self.unexpected(token.1, Span::new(token.0, token.2), &expected);
            }
            ParseError::ExtraToken { token } => {
                self.unexpected(token.1, Span::new(token.0, token.2), &[]);
            }
            ParseError::InvalidToken { location } => {
                self.error(Span::new(location, location), "this is not understood");
            }
            ParseError::UnrecognizedEof { location, .. } => {
                self.error(
                    Span::new(location, location),
                    "the text ends inside a statement",
                );
            }
            ParseError::User { error } => match error {},
        }
        self.abandon();
    }

    fn unexpected(&mut self, token: Token, span: Span, expected: &[String]) {
        if self.is_full() {
            return;
        }
        let text = self.slice(span);
        let mut diagnostic = match token {
            Token::Newline => error(Span::new(span.start, span.start), "the line ends too early"),
            Token::OpenString => error(span, "the quotes are not closed on this line"),
            Token::Unknown => error(span, format!("'{}' has no meaning here", clip(text))),
            _ => error(span, format!("'{}' is not expected here", clip(text))),
        };
        match token {
            Token::OpenString => {}
            Token::Unknown if text.starts_with('%') => {
                diagnostic = diagnostic.with_note("help: a value is a % and a name, like %OM16.1");
            }
            _ => {
                if let Some(list) = expected_list(expected) {
                    diagnostic = diagnostic.with_note(format!("expected {list}"));
                }
            }
        }
        self.problems.push(diagnostic);
    }

    /// Ends a statement that could not be read: what it defines counts as
    /// defined, so that its uses are no errors.
    fn abandon(&mut self) {
        if let Head::Definition(name, span) = self.head {
            let nothing = self.nothing();
            let value = self.unary(Operation::Copy, nothing, span);
            if let Some(value) = value.value()
                && self.names.get(name).is_none()
            {
                self.names.set(name, value);
            }
        }
        self.next_statement();
    }
}

/// The expected tokens as part of a sentence; the grammar names them in
/// words, the signs and fixed words stand in quotes.
fn expected_list(expected: &[String]) -> Option<String> {
    let operators = ["+", "-", "*", "/"];
    let mut names: Vec<String> = Vec::new();
    let mut any_word = false;
    let plain = expected.iter().map(|name| name.trim_matches('"'));
    let operator_count = plain
        .clone()
        .filter(|name| operators.contains(name))
        .count();
    for name in plain {
        any_word |= name == "a name";
        if name.contains(' ') {
            names.push(name.to_owned());
        } else if operator_count < operators.len() || !operators.contains(&name) {
            names.push(format!("'{name}'"));
        }
    }
    if any_word {
        // Every fixed word is also a name.
        names.retain(|name| !name.starts_with('\'') || !name[1..].starts_with(char::is_alphabetic));
    }
    if operator_count == operators.len() {
        names.push("an operator".to_owned());
    }
    if names.is_empty() || names.len() > MOST_EXPECTED {
        return None;
    }
    names.sort_by_key(|name| name.starts_with('\''));
    let last = names.pop()?;
    Some(if names.is_empty() {
        last
    } else {
        format!("{} or {last}", names.join(", "))
    })
}
