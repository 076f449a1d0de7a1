//! Errors of the grammar, stated for users.

use super::builder::{ModuleBuilder, Open};
use super::lexer::{ModuleToken, Spanned, Tokens};
use super::parts::{Head, Span};
use super::problems::{also, error};
use crate::diagnostic::clip;
use crate::function::Level;
use lalrpop_util::ParseError;
use logos::Logos;
use robovec_num::operation::Operation;

/// The largest number of expected tokens that are listed.
const MAX_EXPECTED: usize = 6;

impl ModuleBuilder<'_> {
    /// Records an error of the grammar and gives the unfinished statement an
    /// end that causes no further errors.
    pub(super) fn syntax_error(
        &mut self,
        error: ParseError<u32, ModuleToken, std::convert::Infallible>,
        tokens: &Tokens<'_>,
    ) {
        match error {
            ParseError::UnrecognizedToken { token, expected } => {
                self.unexpected(token, &expected, tokens.joined());
            }
            ParseError::ExtraToken { token } => self.unexpected(token, &[], tokens.joined()),
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
        self.abandon(tokens.statement());
    }

    fn unexpected(&mut self, token: Spanned, expected: &[String], joined: Option<u32>) {
        if self.is_full() {
            return;
        }
        let (start, token, end) = token;
        let span = Span::new(start, end);
        let text = self.slice(span);
        let mut diagnostic = match token {
            ModuleToken::Newline => error(Span::new(start, start), "the line ends too early"),
            ModuleToken::OpenString => error(span, "the quotes are not closed on this line"),
            ModuleToken::Unknown => error(span, format!("'{}' has no meaning here", clip(text))),
            _ => error(span, format!("'{}' is not expected here", clip(text))),
        };
        if let Some(joined) = joined {
            let label = also(
                Span::new(joined, joined),
                "the statement goes on after this line",
            );
            diagnostic = diagnostic.with_label(label);
        }
        let note = match token {
            ModuleToken::OpenString => None,
            ModuleToken::Unknown if text.starts_with('%') => {
                Some("help: a value is a % and a name, like %OM16.1".to_owned())
            }
            ModuleToken::Unknown if text.starts_with('.') => {
                Some("help: a number has digits before and after its point".to_owned())
            }
            _ => expected_list(expected).map(|list| format!("expected {list}")),
        };
        self.problems.push(match note {
            Some(note) => diagnostic.with_note(note),
            None => diagnostic,
        });
    }

    /// Ends a statement that could not be read: its definitions and
    /// declarations count as known, so that their uses are no errors.
    fn abandon(&mut self, statement: u32) {
        let first = self.token_at(statement);
        let second = first.and_then(|(_, _, end)| self.token_at(end));
        match (first, second) {
            (Some((start, ModuleToken::Value, end)), Some((_, ModuleToken::Equals, _))) => {
                self.begin_definition(Span::new(start, end));
                let nothing = self.nothing();
                let value = self.unary(Operation::Copy, nothing, Span::new(start, end));
                if let (Head::Definition(name, _), Some(value)) = (self.head, value.value())
                    && self.names.get(name).is_none()
                {
                    self.names.set(name, value);
                }
            }
            (Some((_, ModuleToken::In | ModuleToken::Out, _)), Some((start, _, end))) => {
                let name = self.slice(Span::new(start, end));
                self.open.broken.insert(name, ());
            }
            (Some((_, ModuleToken::Function, _)), Some((start, _, end))) => {
                self.close_function();
                self.open = Open::new("", Level::Equations, Some(Span::new(start, end)));
            }
            _ => {}
        }
        self.next_statement();
    }

    /// The token that starts at a byte or after the blanks there.
    fn token_at(&self, start: u32) -> Option<Spanned> {
        let mut lexer = ModuleToken::lexer(&self.text[start as usize..]);
        let token = lexer.next()?.ok()?;
        let span = lexer.span();
        Some((start + span.start as u32, token, start + span.end as u32))
    }
}

const OPERATORS: [&str; 4] = ["+", "-", "*", "/"];

const ATTRIBUTES: [&str; 10] = [
    "as",
    "on",
    "read",
    "buffer",
    "write",
    "in",
    "history",
    "{",
    "a place (@LINE:COLUMN-COLUMN)",
    "a set of places (@!NUMBER)",
];

/// The expected tokens as part of a sentence. The grammar names them in
/// words; signs and fixed words are put in quotes, and the two large groups
/// get one word.
fn expected_list(expected: &[String]) -> Option<String> {
    let mut plain: Vec<&str> = expected.iter().map(|name| name.trim_matches('"')).collect();
    let mut names: Vec<String> = Vec::new();
    for (group, name) in [
        (&OPERATORS[..], "an operator"),
        (&ATTRIBUTES[..], "an attribute such as a place"),
    ] {
        if group.iter().all(|member| plain.contains(member)) {
            plain.retain(|name| !group.contains(name));
            names.push(name.to_owned());
        }
    }
    if plain.contains(&"a name") {
        // Every fixed word is also a name.
        plain.retain(|name| name.contains(' ') || !name.starts_with(char::is_alphabetic));
    }
    names.extend(plain.iter().map(|name| {
        if name.contains(' ') {
            (*name).to_owned()
        } else {
            format!("'{name}'")
        }
    }));
    if names.is_empty() || names.len() > MAX_EXPECTED {
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
