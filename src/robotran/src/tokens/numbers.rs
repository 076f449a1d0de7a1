//! Numbers, and a minus before one.

use super::TokenStream;
use crate::Language;
use crate::literal::{self, Literal};
use crate::raw::{Raw, Surface};
use crate::token::LexicalError;
use crate::token::RobotranToken;

impl<'s, 't, L: Surface<'s>> TokenStream<'s, 't, L> {
    /// A minus; but `(-2.0)` is a negative number, where `-(2.0)`, as Robotran
    /// writes it, is the operation on a positive one.
    pub(super) fn minus(&mut self) -> Result<RobotranToken, LexicalError> {
        if !matches!(self.recent[0], Some((_, RobotranToken::Open, _))) {
            return Ok(RobotranToken::Minus);
        }
        let mut ahead = self.lexer.clone();
        let mut next = || ahead.next().map(|raw| raw.map(Surface::raw));
        if !matches!(next(), Some(Ok(Raw::Number | Raw::Numeral))) || next() != Some(Ok(Raw::Close))
        {
            return Ok(RobotranToken::Minus);
        }
        self.lexer.next();
        let number = self.number()?;
        let negative = number.negative().map_err(|error| self.unkept(error))?;
        // A 64-bit float is left to here.
        Ok(RobotranToken::Number(
            negative.unwrap_or_else(|| Literal::Double(-number.number())),
        ))
    }

    pub(super) fn number(&self) -> Result<Literal, LexicalError> {
        let text = self.lexer.slice();
        let number = match self.language {
            Language::C => literal::c(text),
            Language::Matlab => literal::matlab(text),
            Language::Python => literal::python(text),
        };
        number.map_err(|error| self.unkept(error))
    }
}
