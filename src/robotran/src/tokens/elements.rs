//! Members of structures (`s->q`, `s.q`, `np.sin`), and elements of arrays
//! with literal indices (`q[3]`, `s.frc(2,1)`).
//!
//! **Index base.** Rows and columns count from 1, as they are written in every
//! language; column 0 means that there is no second index.

use super::{LARGEST_INDEX, TokenStream};
use crate::Language;
use crate::literal::{self, Literal};
use crate::preprocessor::Expansion;
use crate::raw::{Raw, Surface};
use crate::token::{LexicalError, RobotranElement, RobotranName, RobotranToken, SourceSpan};
use robovec_ir::Operation;

impl<'s, 't, L: Surface<'s>> TokenStream<'s, 't, L> {
    /// The token of a member without index: a name, or a function of Python.
    pub(super) fn member(&mut self, text: &str) -> Result<RobotranToken, LexicalError> {
        let (structure, name) = split_member(text);
        self.refuse_macros([structure, name])?;
        if matches!(structure, "np" | "numpy" | "math")
            && let Some(function) = function_named(name)
        {
            return Ok(RobotranToken::Function(function));
        }
        Ok(RobotranToken::Name(self.member_name(structure, name)))
    }

    /// Refuses a member whose structure or name is a macro.
    fn refuse_macros(&self, words: [&str; 2]) -> Result<(), LexicalError> {
        if words.iter().any(|word| self.preprocessor.defines(word)) {
            return Err(self.refusal((
                "a macro within the name of a member",
                "run the file through the preprocessor first (`cpp -P`), or give the macro another name",
            )));
        }
        Ok(())
    }

    /// The name of a member: that of Robotran's data structure is dropped
    /// (`s->q` is `q`), any other stays, as the sensor's in `sens.P`.
    pub(super) fn member_name(&mut self, structure: &str, name: &str) -> RobotranName {
        if matches!(structure, "s" | "mbs_data" | "mbs") {
            return RobotranName::of_data(self.symbols.intern(name));
        }
        self.buffer.clear();
        self.buffer.push_str(structure);
        self.buffer.push('.');
        self.buffer.push_str(name);
        RobotranName::local(self.symbols.intern(&self.buffer))
    }

    /// The token of a word or member ([`Raw::Element`], [`Raw::MemberElement`])
    /// with its indices. Matlab calls functions with the same parentheses, so
    /// that `sin(2)` and `zeros(3,6)` are such lexemes too.
    pub(super) fn element(&mut self, raw: Raw) -> Result<RobotranToken, LexicalError> {
        let (word, row, column) = self.indices()?;
        if self.language == Language::Matlab && word == "zeros" {
            return Ok(RobotranToken::Zeros((row, column)));
        }
        if let Some(function) = function_named(word) {
            if self.language == Language::Matlab && column == 0 {
                return Ok(self.function_of_integer(function, row));
            }
            return Err(self.refusal((
                "an index, or two arguments, after a function of one number",
                "write its argument in parentheses: sin(x)",
            )));
        }
        let name = if raw == Raw::MemberElement {
            let (structure, name) = split_member(word);
            self.refuse_macros([structure, name])?;
            self.member_name(structure, name)
        } else if self.preprocessor.is_empty() {
            RobotranName::local(self.symbols.intern(word))
        } else {
            self.expanded_name(word)?
        };
        if row == 0 || (column == 0 && self.has_second_index()) {
            return Err(LexicalError::new(
                self.span(),
                "index 0",
                "Robotran counts from 1 in all languages; element 0 of its arrays is never used",
            ));
        }
        Ok(RobotranToken::Element(RobotranElement {
            name,
            row,
            column,
        }))
    }

    /// The array that a word before an index means once macros are replaced.
    fn expanded_name(&mut self, word: &str) -> Result<RobotranName, LexicalError> {
        let expansion = self.preprocessor.expand(word);
        match expansion.map_err(|reason| self.refusal(reason))? {
            None => Ok(RobotranName::local(self.symbols.intern(word))),
            Some(Expansion::Words(None, word)) => {
                Ok(RobotranName::local(self.symbols.intern(&word)))
            }
            Some(Expansion::Words(Some(structure), member)) => {
                Ok(self.member_name(&structure, &member))
            }
            Some(Expansion::Nothing | Expansion::Number(_)) => Err(self.refusal((
                "a macro before an index that is not the name of an array",
                "write out the text of the macro",
            ))),
        }
    }

    /// The tokens of Matlab's `sin(2)`, one lexeme that looks like an element:
    /// returns the first and leaves the others pending. `pending` is a stack,
    /// pushed from the last; `end - 1` is the place of the closing parenthesis.
    fn function_of_integer(&mut self, function: Operation, argument: u32) -> RobotranToken {
        let SourceSpan { start, end } = self.span();
        self.pending.push((end - 1, RobotranToken::Close, end));
        let number = RobotranToken::Number(Literal::Double(f64::from(argument)));
        self.pending.push((start, number, end - 1));
        self.pending.push((start, RobotranToken::Open, end - 1));
        RobotranToken::Function(function)
    }

    /// Tests whether a second index is written in the current lexeme
    /// (`a[1][2]`, `a(1,2)`): distinguishes a written 0 from an absent index.
    fn has_second_index(&self) -> bool {
        let slice = self.lexer.slice().as_bytes();
        slice.contains(&b',') || slice.iter().filter(|&&byte| byte == b'[').count() > 1
    }

    /// The word of the current lexeme and its one or two indices, row before
    /// column, as written; column 0 when there is no second one.
    pub(super) fn indices(&self) -> Result<(&'s str, u32, u32), LexicalError> {
        let slice = self.lexer.slice();
        let bytes = slice.as_bytes();
        let bracket = |byte: &u8| matches!(byte, b'[' | b'(');
        let word_end = bytes
            .iter()
            .position(bracket)
            .expect("the pattern of the lexeme has a bracket after the word");
        let mut indices = [0u32; 2];
        // Numbers that have begun; the last of them is being read.
        let mut begun = 0;
        let mut in_number = false;
        for &byte in &bytes[word_end..] {
            if byte.is_ascii_digit() {
                if !in_number {
                    begun += 1;
                }
                // Patterns allow three numbers at most, of which Python's
                // `a[1,2][3]` has one too many.
                let Some(index) = indices.get_mut(begun - 1) else {
                    return Err(self.index_error("too many indices"));
                };
                // A digit behind a leading 0: C would take the number for an
                // octal one, Python refuses it.
                if in_number && *index == 0 && self.language != Language::Matlab {
                    return Err(self.index_error("an index that begins with 0"));
                }
                *index = index
                    .saturating_mul(10)
                    .saturating_add(u32::from(byte - b'0'));
            }
            in_number = byte.is_ascii_digit();
        }
        if indices.iter().any(|&index| index > LARGEST_INDEX) {
            return Err(self.index_error("an index above 1000000 is not allowed"));
        }
        Ok((slice[..word_end].trim_end(), indices[0], indices[1]))
    }

    fn index_error(&self, message: &'static str) -> LexicalError {
        LexicalError::new(
            self.span(),
            message,
            "no multibody model has arrays like this; correct the index",
        )
    }
}

/// `s->q` or `s.q` as structure and member.
fn split_member(text: &str) -> (&str, &str) {
    text.split_once("->")
        .or_else(|| text.split_once('.'))
        .expect("the pattern of a member has an arrow or a point")
}

/// The function of one number that has this name in every language.
pub(super) fn function_named(word: &str) -> Option<Operation> {
    match word {
        "sin" => Some(Operation::Sin),
        "cos" => Some(Operation::Cos),
        "sqrt" => Some(Operation::Sqrt),
        _ => None,
    }
}

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
