//! Members of structures, and elements of arrays with their indices.

use super::{LARGEST_INDEX, LexicalError, TokenStream};
use crate::robotran::Language;
use crate::robotran::literal::Literal;
use crate::robotran::preprocessor::Expansion;
use crate::robotran::raw::{Raw, Surface};
use crate::robotran::token::{RobotranElement, RobotranName, RobotranToken, SourceSpan};
use robovec_ir::Operation;

impl<'s, 't, L: Surface<'s>> TokenStream<'s, 't, L> {
    pub(super) fn member(&mut self, text: &str) -> Result<RobotranToken, LexicalError> {
        let (structure, name) = split_member(text);
        self.refuse_macros([structure, name])?;
        Ok(match (structure, name) {
            ("np" | "numpy" | "math", "sin") => RobotranToken::Function(Operation::Sin),
            ("np" | "numpy" | "math", "cos") => RobotranToken::Function(Operation::Cos),
            ("np" | "numpy" | "math", "sqrt") => RobotranToken::Function(Operation::Sqrt),
            _ => RobotranToken::Name(self.member_name(structure, name)),
        })
    }

    /// Within `s->q` no macro is replaced here.
    fn refuse_macros(&self, words: [&str; 2]) -> Result<(), LexicalError> {
        if words.iter().any(|word| self.preprocessor.defines(word)) {
            return Err(self.refusal((
                "a macro within the name of a member",
                "run the file through the preprocessor first (`cpp -P`), or give the macro another name",
            )));
        }
        Ok(())
    }

    /// The name of a member: the data structure `s` is dropped, that of a
    /// sensor stays as `sens.P`.
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

    pub(super) fn element(&mut self, raw: Raw) -> Result<RobotranToken, LexicalError> {
        let (word, row, column) = self.indices()?;
        if self.language == Language::Matlab && column == 0 {
            let function = match word {
                "sin" => Some(Operation::Sin),
                "cos" => Some(Operation::Cos),
                "sqrt" => Some(Operation::Sqrt),
                _ => None,
            };
            if let Some(function) = function {
                return Ok(self.function_of_integer(function, row));
            }
        }
        if self.language == Language::Matlab && word == "zeros" {
            return Ok(RobotranToken::Zeros((row, column)));
        }
        if matches!(word, "sin" | "cos" | "sqrt") {
            return Err(self.refusal((
                "an index, or two arguments, behind a function of one number",
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
            self.expanded(word)?
        };
        if row == 0 || (column == 0 && self.has_second_index()) {
            return Err(LexicalError {
                span: self.span(),
                message: "index 0",
                note: "Robotran counts from 1 in all languages; element 0 of its arrays is never used",
            });
        }
        Ok(RobotranToken::Element(RobotranElement {
            name,
            row,
            column,
        }))
    }

    /// The array that a word before an index means.
    fn expanded(&mut self, word: &str) -> Result<RobotranName, LexicalError> {
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
                "write out what the macro stands for",
            ))),
        }
    }

    /// `sin(2)` of Matlab looks like an element; its parts come one by one.
    fn function_of_integer(&mut self, function: Operation, argument: u32) -> RobotranToken {
        let SourceSpan { start, end } = self.span();
        self.pending.push((end - 1, RobotranToken::Close, end));
        let number = RobotranToken::Number(Literal::Double(f64::from(argument)));
        self.pending.push((start, number, end - 1));
        self.pending.push((start, RobotranToken::Open, end - 1));
        RobotranToken::Function(function)
    }

    fn has_second_index(&self) -> bool {
        let slice = self.lexer.slice().as_bytes();
        slice.contains(&b',') || slice.iter().filter(|&&byte| byte == b'[').count() > 1
    }

    /// The word of the current lexeme and its one or two indices, 0 for an
    /// absent second one.
    pub(super) fn indices(&self) -> Result<(&'s str, u32, u32), LexicalError> {
        let slice = self.lexer.slice();
        let bytes = slice.as_bytes();
        let bracket = |byte: &u8| matches!(byte, b'[' | b'(');
        // The pattern of these lexemes has a bracket behind the word.
        let at = bytes.iter().position(bracket).unwrap_or(bytes.len());
        let mut indices = [0u32; 2];
        let mut which = usize::MAX;
        let mut inside = false;
        for &byte in &bytes[at..] {
            if byte.is_ascii_digit() {
                if !inside {
                    which = which.wrapping_add(1);
                }
                // Patterns allow three numbers at most, of which Python's
                // `a[1,2][3]` has one too many.
                let Some(index) = indices.get_mut(which) else {
                    return Err(self.index_error("too many indices"));
                };
                // C would take it for an octal number.
                if inside && *index == 0 && self.language != Language::Matlab {
                    return Err(self.index_error("an index that begins with 0"));
                }
                *index = index
                    .saturating_mul(10)
                    .saturating_add(u32::from(byte - b'0'));
            }
            inside = byte.is_ascii_digit();
        }
        if indices.iter().any(|&index| index > LARGEST_INDEX) {
            return Err(self.index_error("an index above 1000000 is not allowed"));
        }
        Ok((slice[..at].trim_end(), indices[0], indices[1]))
    }

    fn index_error(&self, message: &'static str) -> LexicalError {
        LexicalError {
            span: self.span(),
            message,
            note: "no multibody model has arrays like this; correct the index",
        }
    }
}

/// `s->q` or `s.q` as structure and member.
fn split_member(text: &str) -> (&str, &str) {
    let parts = text.split_once("->").or_else(|| text.split_once('.'));
    parts.unwrap_or(("", text))
}
