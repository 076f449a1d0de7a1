//! The tokens of a rule file, and where its reader stands in them.

use super::token::Token;
use logos::Logos;
use robovec_ir::diagnostic::{Diagnostic, Label};
use std::ops::Range;

/// Longest rule file, in bytes.
const LONGEST: usize = 4 << 20;

/// Most mistakes told of one file; after so many it is no rule file.
const MOST_MISTAKES: usize = 20;

/// A mistake that was told; what it stands in is not read further.
pub(super) struct Told;

pub(super) struct Cursor<'text> {
    pub(super) text: &'text str,
    /// `None` for characters that are no token; they were told.
    tokens: Vec<(Option<Token<'text>>, Range<usize>)>,
    at: usize,
    pub(super) diagnostics: Vec<Diagnostic>,
}

impl<'text> Cursor<'text> {
    pub(super) fn new(text: &'text str) -> Cursor<'text> {
        let mut cursor = Cursor {
            text,
            tokens: Vec::new(),
            at: 0,
            diagnostics: Vec::new(),
        };
        if text.len() > LONGEST {
            let message = "a file of rules of more than four megabytes is a mistake";
            cursor.error(0..0, message);
            return cursor;
        }
        for (token, span) in Token::lexer(text).spanned() {
            if token.is_err() {
                let message = match &text[span.clone()] {
                    unclosed if unclosed.starts_with('"') => {
                        "this text has no closing '\"' on its line"
                    }
                    _ => "this character has no place in a file of rules",
                };
                cursor.error(span.clone(), message);
            }
            cursor.tokens.push((token.ok(), span));
        }
        cursor
    }

    /// Tells a mistake.
    pub(super) fn error(&mut self, span: Range<usize>, message: impl Into<String>) -> Told {
        self.advise(span, message, Vec::new())
    }

    /// Tells a mistake, with advice.
    pub(super) fn advise(
        &mut self,
        span: Range<usize>,
        message: impl Into<String>,
        notes: Vec<String>,
    ) -> Told {
        if self.diagnostics.len() < MOST_MISTAKES {
            self.diagnostics.push(
                Diagnostic::error()
                    .with_message(message.into())
                    .with_labels(vec![Label::primary(0, span)])
                    .with_notes(notes),
            );
        }
        Told
    }

    /// True when more mistakes would not be told.
    pub(super) fn is_hopeless(&self) -> bool {
        self.diagnostics.len() >= MOST_MISTAKES
    }

    /// The next token; `None` at the end and before what is no token.
    pub(super) fn peek(&self) -> Option<Token<'text>> {
        self.peek_at(0)
    }

    /// The token some places ahead.
    pub(super) fn peek_at(&self, ahead: usize) -> Option<Token<'text>> {
        self.tokens
            .get(self.at + ahead)
            .and_then(|(token, _)| *token)
    }

    /// The place of the next token, or the end of the text.
    pub(super) fn span(&self) -> Range<usize> {
        match self.tokens.get(self.at) {
            Some((_, span)) => span.clone(),
            None => self.text.trim_end().len()..self.text.trim_end().len(),
        }
    }

    /// The end of the token before the next one.
    pub(super) fn end(&self) -> usize {
        match self
            .at
            .checked_sub(1)
            .and_then(|last| self.tokens.get(last))
        {
            Some((_, span)) => span.end,
            None => 0,
        }
    }

    pub(super) fn is_done(&self) -> bool {
        self.at >= self.tokens.len()
    }

    pub(super) fn advance(&mut self) {
        self.at += 1;
    }

    /// Steps over a token when it comes next.
    pub(super) fn accept(&mut self, token: Token<'_>) -> bool {
        let found = self.peek() == Some(token);
        if found {
            self.advance();
        }
        found
    }

    /// Steps over a token that must come next.
    pub(super) fn expect(&mut self, token: Token<'_>, name: &str) -> Result<(), Told> {
        if self.accept(token) {
            return Ok(());
        }
        Err(self.unexpected(name))
    }

    /// Tells that something else should stand here, unless the next
    /// characters are no token, which was told before.
    pub(super) fn unexpected(&mut self, wanted: &str) -> Told {
        if !self.is_done() && self.peek().is_none() {
            return Told;
        }
        let span = self.span();
        if self.is_done() {
            return self.error(span, format!("the file ends where {wanted} should stand"));
        }
        self.error(span, format!("here should stand {wanted}"))
    }

    /// A name with hyphens in it: words, numbers and minus signs without
    /// blanks between them.
    pub(super) fn hyphenated(&mut self, wanted: &str) -> Result<(&'text str, Range<usize>), Told> {
        let Some(Token::Word(_)) = self.peek() else {
            return Err(self.unexpected(wanted));
        };
        let mut span = self.span();
        self.advance();
        while self.span().start == span.end
            && matches!(
                self.peek(),
                Some(Token::Word(_) | Token::Number(_) | Token::Minus)
            )
        {
            span.end = self.span().end;
            self.advance();
        }
        Ok((&self.text[span.clone()], span))
    }

    /// Goes to the next rule: behind the next semicolon, or to the word
    /// `rule`.
    pub(super) fn recover(&mut self) {
        while !self.is_done() {
            match self.peek() {
                Some(Token::Semicolon) => {
                    self.advance();
                    return;
                }
                Some(Token::Word("rule")) => return,
                _ => self.advance(),
            }
        }
    }
}
