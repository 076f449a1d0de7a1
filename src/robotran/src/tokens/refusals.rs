//! Reasons why a lexeme is no token.

use super::TokenStream;
use crate::Language;
use crate::literal;
use crate::raw::Surface;
use crate::token::LexicalError;
use crate::token::SourceSpan;

impl<'s, 't, L: Surface<'s>> TokenStream<'s, 't, L> {
    pub(super) fn unreadable(&mut self, span: SourceSpan) -> LexicalError {
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

    pub(super) fn unkept(
        &self,
        literal::Unkept { message, note }: literal::Unkept,
    ) -> LexicalError {
        self.refusal((message, note))
    }

    pub(super) fn refusal(&self, (message, note): (&'static str, &'static str)) -> LexicalError {
        LexicalError::new(self.span(), message, note)
    }
}
