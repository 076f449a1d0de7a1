//! From lexemes to the tokens of the grammar.
//!
//! Handles the awkward parts of a grammar: keywords that only one language has,
//! line ends that may end a statement, conditions (never computed, so kept as
//! text), and words that the preprocessor replaces.

mod elements;
mod equations;
mod words;

pub(super) use self::equations::ExpressionStacks;
use super::preprocessor::Preprocessor;
use super::raw::{Raw, Surface};
use super::token::{LexicalError, RobotranToken, SourceSpan};

use crate::{Language, literal};
use logos::Lexer;
use robovec_ir::Symbols;

/// The largest index of an array element; more is taken for a slip.
pub(super) const LARGEST_INDEX: u32 = 1_000_000;

/// A token between its first byte and the byte after it.
pub(super) type SpannedToken = (u32, RobotranToken, u32);

/// Source of a parser of tokens, and its memory to explain an error.
pub(super) trait TokenSource: Iterator<Item = Result<SpannedToken, LexicalError>> {
    /// The last token and the one before it.
    fn recent(&self) -> [Option<SpannedToken>; 2];
    /// Goes on after the end of the statement that could not be read.
    fn skip_statement(&mut self);
}

pub(super) struct TokenStream<'s, 't, L: Surface<'s>> {
    lexer: Lexer<'s, L>,
    language: Language,
    symbols: &'t mut Symbols,
    /// Python and C let a statement continue while a parenthesis is open.
    open: Vec<u32>,
    pending: Vec<SpannedToken>,
    recent: [Option<SpannedToken>; 2],
    preprocessor: Preprocessor,
    buffer: String,
}

impl<'s, 't, L: Surface<'s>> TokenStream<'s, 't, L> {
    pub(super) fn new(
        text: &'s str,
        language: Language,
        symbols: &'t mut Symbols,
    ) -> TokenStream<'s, 't, L> {
        TokenStream {
            lexer: L::lexer(text),
            language,
            symbols,
            open: Vec::new(),
            pending: Vec::new(),
            recent: [None; 2],
            preprocessor: Preprocessor::default(),
            buffer: String::new(),
        }
    }

    fn span(&self) -> SourceSpan {
        let span = self.lexer.span();
        SourceSpan::new(span.start, span.end)
    }

    fn step(&mut self) -> Option<Result<SpannedToken, LexicalError>> {
        if let Some(token) = self.pending.pop() {
            return Some(Ok(token));
        }
        loop {
            let Some(raw) = self.lexer.next() else {
                return self.finish();
            };
            let span = self.span();
            let skipped = self.preprocessor.skips();
            let token = match raw.map(Surface::raw) {
                Ok(Raw::Preprocessor) => match self.preprocessor() {
                    Ok(()) => continue,
                    Err(error) => Err(error),
                },
                Err(()) if self.lexer.slice().starts_with("%:") => Err(self.unreadable(span)),
                _ if skipped => continue,
                Ok(raw) => match self.token(raw) {
                    Ok(None) => continue,
                    Ok(Some(token)) => Ok(token),
                    Err(error) => Err(error),
                },
                Err(()) => Err(self.unreadable(span)),
            };
            // A condition makes the token longer than its first lexeme; a
            // line end has no width, so that no statement includes it.
            let end = match raw {
                Ok(lexeme) if lexeme.raw() == Raw::LineEnd => span.start,
                Ok(_) | Err(()) => self.span().end,
            };
            return Some(token.map(|token| (span.start, token, end)));
        }
    }

    /// The end of the text: a line end where line ends count.
    fn finish(&mut self) -> Option<Result<SpannedToken, LexicalError>> {
        let end = self.lexer.source().len() as u32;
        if let Some(start) = self.open.pop() {
            self.open.clear();
            return Some(Err(LexicalError::new(
                SourceSpan {
                    start,
                    end: start + 1,
                },
                "this parenthesis is never closed",
                "close it, or check that the file is complete",
            )));
        }
        if self.preprocessor.end() {
            return Some(Err(LexicalError::new(
                SourceSpan { start: end, end },
                "the file ends inside an `#if`",
                "close it with `#endif`, or check that the file is complete",
            )));
        }
        let ended = matches!(self.recent[0], None | Some((_, RobotranToken::End, _)));
        (self.language != Language::C && !ended).then_some(Ok((end, RobotranToken::End, end)))
    }

    fn token(&mut self, raw: Raw) -> Result<Option<RobotranToken>, LexicalError> {
        Ok(Some(match raw {
            Raw::Word => return self.word(),
            Raw::Member => return self.member(self.lexer.slice()).map(Some),
            Raw::Element | Raw::MemberElement => return self.element(raw).map(Some),
            Raw::Zeros => {
                let (_, rows, columns) = self.indices()?;
                RobotranToken::Zeros((rows, columns))
            }
            Raw::Number | Raw::Numeral => RobotranToken::Number(self.number()?),
            Raw::Text => RobotranToken::Text,
            Raw::LineEnd => {
                let inside = self.language == Language::Python && !self.open.is_empty();
                if inside || matches!(self.recent[0], None | Some((_, RobotranToken::End, _))) {
                    return Ok(None);
                }
                RobotranToken::End
            }
            Raw::Plus => RobotranToken::Plus,
            Raw::Minus => return self.minus().map(Some),
            Raw::Star => RobotranToken::Star,
            Raw::Slash => RobotranToken::Slash,
            Raw::Equals => RobotranToken::Equals,
            Raw::Open => {
                self.open.push(self.lexer.span().start as u32);
                RobotranToken::Open
            }
            Raw::Close => {
                self.open.pop();
                RobotranToken::Close
            }
            Raw::BracketOpen => RobotranToken::BracketOpen,
            Raw::BracketClose => RobotranToken::BracketClose,
            Raw::BraceOpen => RobotranToken::BraceOpen,
            Raw::BraceClose => RobotranToken::BraceClose,
            Raw::Comma => RobotranToken::Comma,
            Raw::Semicolon => {
                self.open.clear();
                RobotranToken::End
            }
            Raw::Colon => RobotranToken::Colon,
            Raw::Ampersand => RobotranToken::Ampersand,
            Raw::Other if self.language == Language::C && self.lexer.slice() == "**" => {
                let SourceSpan { start, end } = self.span();
                self.pending.push((start + 1, RobotranToken::Star, end));
                RobotranToken::Star
            }
            Raw::Preprocessor | Raw::Other => RobotranToken::Other,
        }))
    }

    /// Obeys a line of the C preprocessor.
    fn preprocessor(&mut self) -> Result<(), LexicalError> {
        let line = self.lexer.slice();
        let obeyed = self.preprocessor.obey(&line[1..]);
        obeyed.map_err(|reason| self.refusal(reason))
    }
}

impl<'s, L: Surface<'s>> Iterator for TokenStream<'s, '_, L> {
    type Item = Result<SpannedToken, LexicalError>;

    fn next(&mut self) -> Option<Self::Item> {
        let item = self.step()?;
        // A lexeme that is no token is one here: the statement has begun.
        let token = match &item {
            Ok(token) => *token,
            Err(error) => (error.span.start, RobotranToken::Other, error.span.end),
        };
        self.recent = [Some(token), self.recent[0]];
        Some(item)
    }
}

impl<'s, L: Surface<'s>> TokenSource for TokenStream<'s, '_, L> {
    fn recent(&self) -> [Option<SpannedToken>; 2] {
        self.recent
    }

    fn skip_statement(&mut self) {
        self.open.clear();
        let in_head = match self.recent[0] {
            Some((_, RobotranToken::End, _)) => return,
            // The head of C's `for` has semicolons of its own.
            Some((_, RobotranToken::Refused, _)) => self.language == Language::C,
            _ => false,
        };
        let mut depth = 0u32;
        while let Some(item) = self.next() {
            if self.language != Language::C {
                self.open.clear();
            }
            match item {
                Ok((_, RobotranToken::Open, _)) if in_head => depth += 1,
                Ok((_, RobotranToken::Close, _)) if in_head => depth = depth.saturating_sub(1),
                Ok((_, RobotranToken::End, _)) if depth == 0 => break,
                Ok((_, RobotranToken::BraceClose, _)) => break,
                Ok(_) | Err(_) => {}
            }
        }
    }
}

impl<'s, 't, L: Surface<'s>> TokenStream<'s, 't, L> {
    fn unreadable(&mut self, span: SourceSpan) -> LexicalError {
        let text = &self.lexer.source()[span.range()];
        let (message, note) = if self.language == Language::C && text.starts_with("//") {
            (
                "a comment that ends with `??/`",
                "some compilers take it for a line joined to the next one; remove it",
            )
        } else if self.language == Language::C && text.starts_with('\\') {
            (
                "a line is joined to the next one within a word",
                "write the word on one line",
            )
        } else if self.language == Language::C && text.starts_with(['#', '%']) {
            (
                "this line of the preprocessor is not understood",
                "its `#` must be the first character of a line, and its comments must be closed",
            )
        } else if text.starts_with("/*") || text.starts_with("%{") {
            self.lexer.bump(self.lexer.remainder().len());
            (
                "this comment is never closed",
                "close it, or check that the file is complete",
            )
        } else if text.starts_with(['"', '\'']) {
            (
                "this text is never closed",
                "close it on the same line, or check that the file is complete",
            )
        } else {
            (
                "this character has no meaning here",
                "outside comments Robotran writes ASCII only; check the encoding of the file",
            )
        };
        LexicalError::new(span, message, note)
    }

    fn unkept(&self, literal::Unkept { message, note }: literal::Unkept) -> LexicalError {
        self.refusal((message, note))
    }

    fn refusal(&self, (message, note): (&'static str, &'static str)) -> LexicalError {
        LexicalError::new(self.span(), message, note)
    }
}
