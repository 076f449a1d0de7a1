//! From lexemes to the tokens of the grammar.
//!
//! What happens here is what a grammar says badly: keywords that only one
//! language has, line ends that end a statement or not, conditions (never
//! computed by a straight-line function, so they travel as text), and what
//! the preprocessor makes of a word.

use super::Language;
use super::literal::{self, Literal};
use super::preprocessor::{Expansion, Preprocessor};
use super::raw::{Raw, Surface};
use super::token::{RobotranElement, RobotranName, RobotranToken, SourceSpan, TypeWords};
use logos::Lexer;
use robovec_ir::{Operation, Symbols};

/// The largest index of an array element; more is taken for a slip.
pub(super) const LARGEST_INDEX: u32 = 1_000_000;

/// A lexeme that is no token, with the reason.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct LexicalError {
    pub(super) span: SourceSpan,
    pub(super) message: &'static str,
    pub(super) note: &'static str,
}

/// A token between its first byte and the byte after it.
pub(super) type SpannedToken = (u32, RobotranToken, u32);

/// What a parser of tokens reads from, and what it must remember to explain
/// an error.
pub(super) trait TokenSource: Iterator<Item = Result<SpannedToken, LexicalError>> {
    /// The token given last and the one before it.
    fn recent(&self) -> [Option<SpannedToken>; 2];
    /// Goes on behind the end of the statement that could not be read.
    fn skip_statement(&mut self);
}

/// The tokens of a text.
pub(super) struct TokenStream<'s, 't, L: Surface<'s>> {
    lexer: Lexer<'s, L>,
    language: Language,
    symbols: &'t mut Symbols,
    /// Python and C let a statement go on while a parenthesis is open.
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
        LexicalError {
            span,
            message,
            note,
        }
    }

    /// The end of the text: a line end where line ends count.
    fn finish(&mut self) -> Option<Result<SpannedToken, LexicalError>> {
        let end = self.lexer.source().len() as u32;
        if let Some(start) = self.open.pop() {
            self.open.clear();
            return Some(Err(LexicalError {
                span: SourceSpan {
                    start,
                    end: start + 1,
                },
                message: "this parenthesis is never closed",
                note: "close it, or check that the file is complete",
            }));
        }
        if self.preprocessor.end() {
            return Some(Err(LexicalError {
                span: SourceSpan { start: end, end },
                message: "the file ends inside an `#if`",
                note: "close it with `#endif`, or check that the file is complete",
            }));
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

    /// A minus; but `(-2.0)` is a negative number, where `-(2.0)`, as Robotran
    /// writes it, is the operation on a positive one.
    fn minus(&mut self) -> Result<RobotranToken, LexicalError> {
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

    fn number(&self) -> Result<Literal, LexicalError> {
        let text = self.lexer.slice();
        let number = match self.language {
            Language::C => literal::c(text),
            Language::Matlab => literal::matlab(text),
            Language::Python => literal::python(text),
        };
        number.map_err(|error| self.unkept(error))
    }

    fn unkept(&self, literal::Unkept { message, note }: literal::Unkept) -> LexicalError {
        self.refusal((message, note))
    }

    fn refusal(&self, (message, note): (&'static str, &'static str)) -> LexicalError {
        LexicalError {
            span: self.span(),
            message,
            note,
        }
    }

    fn word(&mut self) -> Result<Option<RobotranToken>, LexicalError> {
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
    fn plain_word(&mut self, word: &str) -> Result<Option<RobotranToken>, LexicalError> {
        // Keywords and types start like this, hardly any name of Robotran's
        // does.
        let candidate = word.len() > 1 && (word.as_bytes()[0].is_ascii_lowercase())
            || word.starts_with("Mbs")
            || word.starts_with("MBS");
        if candidate && let Some(token) = self.keyword(word) {
            return token;
        }
        Ok(Some(RobotranToken::Name(RobotranName::local(
            self.symbols.intern(word),
        ))))
    }

    fn keyword(&mut self, word: &str) -> Option<Result<Option<RobotranToken>, LexicalError>> {
        let language = self.language;
        let token = match (word, language) {
            ("sin", _) => RobotranToken::Function(Operation::Sin),
            ("cos", _) => RobotranToken::Function(Operation::Cos),
            ("sqrt", _) => RobotranToken::Function(Operation::Sqrt),
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
        let line = &rest[..rest.find('\n').unwrap_or(rest.len())];
        let statement = line.split('#').next().unwrap_or_default();
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
                "an import that may give another meaning to a function",
                "import sin, cos, sqrt and zeros from math or numpy under their own names, on a line of its own",
            )))
        }
    }

    /// Takes in the condition behind `if` or `while`.
    fn condition(&mut self, token: RobotranToken) -> Result<Option<RobotranToken>, LexicalError> {
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
                    return Err(LexicalError {
                        span: SourceSpan {
                            start,
                            end: self.span().end,
                        },
                        message: "this condition has no end",
                        note: "close its parentheses, or check that the file is complete",
                    });
                }
                (Some(Ok(_)), _) => {}
            }
        }
    }

    fn member(&mut self, text: &str) -> Result<RobotranToken, LexicalError> {
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
    fn member_name(&mut self, structure: &str, name: &str) -> RobotranName {
        if matches!(structure, "s" | "mbs_data" | "mbs") {
            return RobotranName::of_data(self.symbols.intern(name));
        }
        self.buffer.clear();
        self.buffer.push_str(structure);
        self.buffer.push('.');
        self.buffer.push_str(name);
        RobotranName::local(self.symbols.intern(&self.buffer))
    }

    fn element(&mut self, raw: Raw) -> Result<RobotranToken, LexicalError> {
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
    fn indices(&self) -> Result<(&'s str, u32, u32), LexicalError> {
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

    /// Obeys a line of the C preprocessor.
    fn preprocessor(&mut self) -> Result<(), LexicalError> {
        let line = self.lexer.slice();
        let obeyed = self.preprocessor.obey(&line[1..]);
        obeyed.map_err(|reason| self.refusal(reason))
    }
}

/// `s->q` or `s.q` as structure and member.
fn split_member(text: &str) -> (&str, &str) {
    let parts = text.split_once("->").or_else(|| text.split_once('.'));
    parts.unwrap_or(("", text))
}

impl<'s, L: Surface<'s>> Iterator for TokenStream<'s, '_, L> {
    type Item = Result<SpannedToken, LexicalError>;

    fn next(&mut self) -> Option<Self::Item> {
        let item = self.step()?;
        // A lexeme that is no token stands for one, so that the statement it
        // is part of is known to have begun.
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
