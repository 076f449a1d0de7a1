//! Words: keywords, macros, imports and conditions.

use super::TokenStream;
use super::elements::function_named;
use crate::Language;
use crate::preprocessor::Expansion;
use crate::raw::{Raw, Surface};
use crate::token::LexicalError;
use crate::token::{RobotranName, RobotranToken, SourceSpan, TypeWords};

impl<'s, 't, L: Surface<'s>> TokenStream<'s, 't, L> {
    pub(super) fn word(&mut self) -> Result<Option<RobotranToken>, LexicalError> {
        let word = self.lexer.slice();
        if self.preprocessor.is_empty() {
            return self.plain_word(word);
        }
        let expansion = self.preprocessor.expand(word);
        match expansion.map_err(|reason| self.refusal(reason))? {
            None => self.plain_word(word),
            Some(Expansion::Nothing) => Ok(None),
            Some(Expansion::Number(number)) => Ok(Some(RobotranToken::Number(number))),
            Some(Expansion::Words(None, word)) => self.plain_word(&word),
            Some(Expansion::Words(Some(structure), member)) => Ok(Some(RobotranToken::Name(
                self.member_name(&structure, &member),
            ))),
        }
    }

    /// A word that is no macro.
    pub(super) fn plain_word(&mut self, word: &str) -> Result<Option<RobotranToken>, LexicalError> {
        if starts_as_keyword(word)
            && let Some(token) = self.keyword(word)
        {
            return token;
        }
        Ok(Some(RobotranToken::Name(self.local_name(word))))
    }

    /// The name that a word is which is neither macro nor keyword.
    #[inline]
    pub(super) fn local_name(&mut self, word: &str) -> RobotranName {
        RobotranName::local(self.symbols.intern(word))
    }

    /// The token of a reserved word, or the error of its construct; `None` for
    /// any other word, and `Some(Ok(None))` for one without meaning.
    fn keyword(&mut self, word: &str) -> Option<Result<Option<RobotranToken>, LexicalError>> {
        let language = self.language;
        if let Some(function) = function_named(word) {
            return Some(Ok(Some(RobotranToken::Function(function))));
        }
        let token = match (word, language) {
            ("double", Language::C) => RobotranToken::Type(TypeWords::DOUBLE),
            ("float", Language::C) => RobotranToken::Type(TypeWords::SINGLE),
            ("int" | "unsigned" | "signed" | "long" | "short" | "char", Language::C) => {
                RobotranToken::Type(TypeWords::WHOLE)
            }
            ("void", Language::C) => RobotranToken::Type(TypeWords::NOTHING),
            (
                "const" | "static" | "extern" | "inline" | "register" | "restrict" | "volatile",
                Language::C,
            ) => RobotranToken::Type(TypeWords::QUALIFIER),
            (
                "struct" | "MbsData" | "MBSdataStruct" | "MbsSensor" | "MBSsensorStruct",
                Language::C,
            ) => RobotranToken::Type(TypeWords::STRUCTURE),
            ("function", Language::Matlab) => RobotranToken::FunctionHead,
            ("end" | "endfunction" | "endswitch" | "endif", Language::Matlab) => {
                RobotranToken::BlockEnd
            }
            ("def", Language::Python) => RobotranToken::Def,
            ("from" | "import", Language::Python) => return Some(self.import()),
            ("pass", Language::Python) => return Some(Ok(None)),
            ("switch", Language::C | Language::Matlab) => RobotranToken::Switch,
            ("case", Language::C | Language::Matlab) => RobotranToken::Case,
            ("default", Language::C) | ("otherwise", Language::Matlab) => RobotranToken::Default,
            ("break", _) => RobotranToken::Break,
            ("return", _) => RobotranToken::Return,
            ("else", _) => RobotranToken::Else,
            ("while", _) => return Some(self.condition(RobotranToken::While)),
            ("if", _) => return Some(self.condition(RobotranToken::If)),
            ("elif", Language::Python) | ("elseif", Language::Matlab) => {
                return Some(self.condition(RobotranToken::ElseIf));
            }
            ("for", _) | ("do" | "goto", Language::C) => RobotranToken::Refused,
            _ => return None,
        };
        Some(Ok(Some(token)))
    }

    /// Skips an import, to the line end, which stays to be read; one that
    /// gives another meaning to sines, cosines, roots or `zeros` is refused.
    fn import(&mut self) -> Result<Option<RobotranToken>, LexicalError> {
        let rest = self.lexer.remainder();
        let line = rest.split('\n').next();
        let line = line.expect("a text has a first part");
        let statement = line.split('#').next();
        let statement = statement.expect("a text has a first part");
        let from = self.lexer.slice() == "from";
        self.lexer.bump(line.len());
        let mut words = statement
            .split(|c: char| c.is_whitespace() || c == ',')
            .filter(|word| !word.is_empty());
        let understood = if from {
            let known = matches!(words.next(), Some("math" | "numpy"));
            let ours = ["sin", "cos", "sqrt", "zeros", "*", "as"];
            known && !statement.contains(" as ") || !words.any(|word| ours.contains(&word))
        } else {
            let modules = statement.split(',').map(str::trim);
            let ours = ["np", "numpy", "math", "sin", "cos", "sqrt", "zeros"];
            modules
                .into_iter()
                .all(|module| match module.split_once(" as ") {
                    Some((module, name)) => {
                        let (module, name) = (module.trim(), name.trim());
                        !ours.contains(&name) || (module, name) == ("numpy", "np")
                    }
                    None => true,
                })
        };
        if understood && !statement.contains(';') {
            Ok(None)
        } else {
            Err(self.refusal((
                "an import that may change the meaning of a function",
                "import sin, cos, sqrt and zeros from math or numpy under their own names, on a separate line",
            )))
        }
    }

    /// Takes in the condition after `if` or `while`.
    pub(super) fn condition(
        &mut self,
        token: RobotranToken,
    ) -> Result<Option<RobotranToken>, LexicalError> {
        let start = self.span().start;
        let mut depth = 0u32;
        loop {
            let rest = self.lexer.clone();
            let raw = self.lexer.next().map(|raw| raw.map(Surface::raw));
            match (raw, self.language) {
                (Some(Ok(Raw::Open)), _) => depth += 1,
                (Some(Ok(Raw::Close)), _) => {
                    depth = depth.saturating_sub(1);
                    if depth == 0 && self.language == Language::C {
                        return Ok(Some(token));
                    }
                }
                (Some(Ok(Raw::Colon)), Language::Python) if depth == 0 => return Ok(Some(token)),
                (Some(Ok(Raw::LineEnd | Raw::Comma | Raw::Semicolon)), Language::Matlab)
                    if depth == 0 =>
                {
                    self.lexer = rest;
                    return Ok(Some(token));
                }
                (Some(Ok(Raw::BraceOpen | Raw::Semicolon)), Language::C)
                | (Some(Ok(Raw::LineEnd)), Language::Matlab)
                | (Some(Err(())) | None, _) => {
                    return Err(LexicalError::new(
                        SourceSpan {
                            start,
                            end: self.span().end,
                        },
                        "this condition is not complete",
                        "close its parentheses, or check that the file is complete",
                    ));
                }
                (Some(Ok(_)), _) => {}
            }
        }
    }
}

/// True for a word that may be a keyword or a type, unlike most names.
#[inline]
pub(super) fn starts_as_keyword(word: &str) -> bool {
    match word.as_bytes() {
        [b'a'..=b'z', _, ..] => true,
        [b'M', rest @ ..] => rest.starts_with(b"bs") || rest.starts_with(b"BS"),
        _ => false,
    }
}
