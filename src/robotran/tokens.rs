//! From lexemes to the tokens of the grammar.
//!
//! What happens here is what a grammar says badly: keywords that only one
//! language has, line ends that end a statement or not, conditions (never
//! computed by a straight-line function, so they travel as text), and the
//! preprocessor, where a macro counts as defined when the file defines it.

use super::Language;
use super::raw::{Raw, Surface};
use super::token::{Element, Name, Span, Token};
use hashbrown::{HashMap, HashSet};
use logos::Lexer;
use robovec_ir::{Operation, Symbol, Symbols};
use rustc_hash::FxBuildHasher;

/// The largest index of an array element; more is taken for a slip.
pub(super) const LARGEST_INDEX: u32 = 1_000_000;

/// A lexeme that is no token, with the reason.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct LexicalError {
    pub(super) span: Span,
    pub(super) message: &'static str,
    pub(super) note: &'static str,
}

/// A token between its first byte and the byte after it.
pub(super) type Spanned = (u32, Token, u32);

/// What a parser of tokens reads from, and what it must remember to explain
/// an error.
pub(super) trait TokenSource: Iterator<Item = Result<Spanned, LexicalError>> {
    /// The token given last and the one before it.
    fn recent(&self) -> [Option<Spanned>; 2];
    /// Goes on behind the end of the statement that could not be read.
    fn skip_statement(&mut self);
}

/// The tokens of a text.
pub(super) struct Tokens<'s, 't, L: Surface<'s>> {
    lexer: Lexer<'s, L>,
    language: Language,
    symbols: &'t mut Symbols,
    /// Python and C let a statement go on while a parenthesis is open.
    open: Vec<u32>,
    pending: Vec<Spanned>,
    recent: [Option<Spanned>; 2],
    /// For every `#if` that is open: whether its text counts.
    conditions: Vec<bool>,
    /// How many of them are false.
    skipping: usize,
    macros: HashMap<Symbol, Symbol, FxBuildHasher>,
    defined: HashSet<&'s str, FxBuildHasher>,
    buffer: String,
}

impl<'s, 't, L: Surface<'s>> Tokens<'s, 't, L> {
    pub(super) fn new(
        text: &'s str,
        language: Language,
        symbols: &'t mut Symbols,
    ) -> Tokens<'s, 't, L> {
        Tokens {
            lexer: L::lexer(text),
            language,
            symbols,
            open: Vec::new(),
            pending: Vec::new(),
            recent: [None; 2],
            conditions: Vec::new(),
            skipping: 0,
            macros: HashMap::default(),
            defined: HashSet::default(),
            buffer: String::new(),
        }
    }

    fn span(&self) -> Span {
        let span = self.lexer.span();
        Span::new(span.start, span.end)
    }

    fn step(&mut self) -> Option<Result<Spanned, LexicalError>> {
        if let Some(token) = self.pending.pop() {
            return Some(Ok(token));
        }
        loop {
            let Some(raw) = self.lexer.next() else {
                return self.finish();
            };
            let span = self.span();
            let skipped = self.skipping > 0;
            let token = match raw.map(Surface::raw) {
                Ok(Raw::Preprocessor) => match self.preprocessor() {
                    Ok(()) => continue,
                    Err(error) => Err(error),
                },
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

    fn unreadable(&mut self, span: Span) -> LexicalError {
        let text = &self.lexer.source()[span.range()];
        let (message, note) = if text.starts_with("/*") || text.starts_with("%{") {
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
    fn finish(&mut self) -> Option<Result<Spanned, LexicalError>> {
        let end = self.lexer.source().len() as u32;
        if let Some(start) = self.open.pop() {
            self.open.clear();
            return Some(Err(LexicalError {
                span: Span {
                    start,
                    end: start + 1,
                },
                message: "this parenthesis is never closed",
                note: "close it, or check that the file is complete",
            }));
        }
        if !self.conditions.is_empty() {
            self.conditions.clear();
            self.skipping = 0;
            return Some(Err(LexicalError {
                span: Span { start: end, end },
                message: "the file ends inside an `#if`",
                note: "close it with `#endif`, or check that the file is complete",
            }));
        }
        let ended = matches!(self.recent[0], None | Some((_, Token::End, _)));
        (self.language != Language::C && !ended).then_some(Ok((end, Token::End, end)))
    }

    fn token(&mut self, raw: Raw) -> Result<Option<Token>, LexicalError> {
        Ok(Some(match raw {
            Raw::Word => return self.word(),
            Raw::Member => self.member(self.lexer.slice()),
            Raw::Element | Raw::MemberElement => return self.element(raw).map(Some),
            Raw::Zeros => {
                let (_, rows, columns) = self.indices()?;
                Token::Zeros((rows, columns))
            }
            Raw::Number => self.number()?,
            Raw::Text => Token::Text,
            Raw::LineEnd => {
                let inside = self.language == Language::Python && !self.open.is_empty();
                if inside || matches!(self.recent[0], None | Some((_, Token::End, _))) {
                    return Ok(None);
                }
                Token::End
            }
            Raw::Plus => Token::Plus,
            Raw::Minus => return self.minus().map(Some),
            Raw::Star => Token::Star,
            Raw::Slash => Token::Slash,
            Raw::Equals => Token::Equals,
            Raw::Open => {
                self.open.push(self.lexer.span().start as u32);
                Token::Open
            }
            Raw::Close => {
                self.open.pop();
                Token::Close
            }
            Raw::BracketOpen => Token::BracketOpen,
            Raw::BracketClose => Token::BracketClose,
            Raw::BraceOpen => Token::BraceOpen,
            Raw::BraceClose => Token::BraceClose,
            Raw::Comma => Token::Comma,
            Raw::Semicolon => {
                self.open.clear();
                Token::End
            }
            Raw::Colon => Token::Colon,
            Raw::Ampersand => Token::Ampersand,
            Raw::Other if self.language == Language::C && self.lexer.slice() == "**" => {
                let Span { start, end } = self.span();
                self.pending.push((start + 1, Token::Star, end));
                Token::Star
            }
            Raw::Preprocessor | Raw::Other => Token::Other,
        }))
    }

    /// A minus; but `(-2.0)` is a negative number, where `-(2.0)`, as Robotran
    /// writes it, is the operation on a positive one.
    fn minus(&mut self) -> Result<Token, LexicalError> {
        if !matches!(self.recent[0], Some((_, Token::Open, _))) {
            return Ok(Token::Minus);
        }
        let mut ahead = self.lexer.clone();
        let mut next = || ahead.next().map(|raw| raw.map(Surface::raw));
        if next() != Some(Ok(Raw::Number)) || next() != Some(Ok(Raw::Close)) {
            return Ok(Token::Minus);
        }
        self.lexer.next();
        Ok(match self.number()? {
            Token::Number(number) => Token::Number(-number),
            other => other,
        })
    }

    fn number(&self) -> Result<Token, LexicalError> {
        match self.lexer.slice().parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Token::Number(number)),
            Ok(_) | Err(_) => Err(LexicalError {
                span: self.span(),
                message: "this number is too large for a 64-bit float",
                note: "it would be read as infinity",
            }),
        }
    }

    fn word(&mut self) -> Result<Option<Token>, LexicalError> {
        let word = self.lexer.slice();
        // Keywords and types start like this, hardly any name of Robotran's
        // does.
        let candidate = word.len() > 1 && (word.as_bytes()[0].is_ascii_lowercase())
            || word.starts_with("Mbs")
            || word.starts_with("MBS");
        if candidate && let Some(token) = self.keyword(word) {
            return token;
        }
        let symbol = self.symbols.intern(word);
        Ok(Some(Token::Name(Name::local(self.expanded(symbol)))))
    }

    fn expanded(&self, symbol: Symbol) -> Symbol {
        if self.macros.is_empty() {
            return symbol;
        }
        self.macros.get(&symbol).copied().unwrap_or(symbol)
    }

    fn keyword(&mut self, word: &str) -> Option<Result<Option<Token>, LexicalError>> {
        let language = self.language;
        let token = match (word, language) {
            ("sin", _) => Token::Function(Operation::Sin),
            ("cos", _) => Token::Function(Operation::Cos),
            ("sqrt", _) => Token::Function(Operation::Sqrt),
            ("double" | "float", Language::C) => Token::Type(true),
            (
                "int" | "void" | "const" | "static" | "extern" | "inline" | "struct" | "unsigned"
                | "long" | "char" | "MbsData" | "MBSdataStruct" | "MbsSensor" | "MBSsensorStruct",
                Language::C,
            ) => Token::Type(false),
            ("function", Language::Matlab) => Token::FunctionHead,
            ("end" | "endfunction" | "endswitch" | "endif", Language::Matlab) => Token::BlockEnd,
            ("def", Language::Python) => Token::Def,
            ("from" | "import", Language::Python) => {
                self.skip_line();
                return Some(Ok(None));
            }
            ("pass", Language::Python) => return Some(Ok(None)),
            ("switch", Language::C | Language::Matlab) => Token::Switch,
            ("case", Language::C | Language::Matlab) => Token::Case,
            ("default", Language::C) | ("otherwise", Language::Matlab) => Token::Default,
            ("break", _) => Token::Break,
            ("return", _) => Token::Return,
            ("else", _) => Token::Else,
            ("while", _) => return Some(self.condition(Token::While)),
            ("if", _) => return Some(self.condition(Token::If)),
            ("elif", Language::Python) | ("elseif", Language::Matlab) => {
                return Some(self.condition(Token::ElseIf));
            }
            ("for", _) | ("do" | "goto", Language::C) => Token::Refused,
            _ => return None,
        };
        Some(Ok(Some(token)))
    }

    /// Skips to the line end, which stays to be read.
    fn skip_line(&mut self) {
        let rest = self.lexer.remainder();
        self.lexer.bump(rest.find('\n').unwrap_or(rest.len()));
    }

    /// Takes in the condition behind `if` or `while`.
    fn condition(&mut self, token: Token) -> Result<Option<Token>, LexicalError> {
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
                        span: Span {
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

    fn member(&mut self, text: &str) -> Token {
        let (structure, name) = split_member(text);
        match (structure, name) {
            ("np" | "numpy" | "math", "sin") => Token::Function(Operation::Sin),
            ("np" | "numpy" | "math", "cos") => Token::Function(Operation::Cos),
            ("np" | "numpy" | "math", "sqrt") => Token::Function(Operation::Sqrt),
            _ => Token::Name(self.member_name(structure, name)),
        }
    }

    /// The name of a member: the data structure `s` is dropped, that of a
    /// sensor stays as `sens.P`.
    fn member_name(&mut self, structure: &str, name: &str) -> Name {
        if matches!(structure, "s" | "mbs_data" | "mbs") {
            return Name::of_data(self.symbols.intern(name));
        }
        self.buffer.clear();
        self.buffer.push_str(structure);
        self.buffer.push('.');
        self.buffer.push_str(name);
        Name::local(self.symbols.intern(&self.buffer))
    }

    fn element(&mut self, raw: Raw) -> Result<Token, LexicalError> {
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
            return Ok(Token::Zeros((row, column)));
        }
        let name = if raw == Raw::MemberElement {
            let (structure, name) = split_member(word);
            self.member_name(structure, name)
        } else {
            let symbol = self.symbols.intern(word);
            Name::local(self.expanded(symbol))
        };
        if row == 0 || (column == 0 && self.has_second_index()) {
            return Err(LexicalError {
                span: self.span(),
                message: "index 0",
                note: "Robotran counts from 1 in all languages; element 0 of its arrays is never used",
            });
        }
        Ok(Token::Element(Element { name, row, column }))
    }

    /// `sin(2)` of Matlab looks like an element; its parts come one by one.
    fn function_of_integer(&mut self, function: Operation, argument: u32) -> Token {
        let Span { start, end } = self.span();
        self.pending.push((end - 1, Token::Close, end));
        let number = Token::Number(f64::from(argument));
        self.pending.push((start, number, end - 1));
        self.pending.push((start, Token::Open, end - 1));
        Token::Function(function)
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

    fn begin_condition(&mut self, condition: bool) {
        self.conditions.push(condition);
        self.skipping += usize::from(!condition);
    }

    /// Obeys a line of the C preprocessor.
    fn preprocessor(&mut self) -> Result<(), LexicalError> {
        let line = self.lexer.slice()[1..].trim();
        let line = line.split("//").next().unwrap_or_default();
        let mut words = line.split_whitespace();
        let skipped = self.skipping > 0;
        let span = self.span();
        let refuse = |message| {
            Err(LexicalError {
                span,
                message,
                note: "run the file through the preprocessor first (`cpp -P`), or remove the line",
            })
        };
        match (words.next().unwrap_or_default(), words.next()) {
            ("include" | "pragma" | "undef" | "line" | "", _) => {}
            ("ifdef", Some(name)) => self.begin_condition(self.defined.contains(name)),
            ("ifndef", Some(name)) => self.begin_condition(!self.defined.contains(name)),
            ("if", Some("0")) => self.begin_condition(false),
            ("if", Some("1")) => self.begin_condition(true),
            ("if", _) if skipped => self.begin_condition(false),
            ("else", _) => match self.conditions.last_mut() {
                Some(condition) => {
                    *condition = !*condition;
                    let was_skipped = *condition;
                    self.skipping = if was_skipped {
                        self.skipping - 1
                    } else {
                        self.skipping + 1
                    };
                }
                None => return refuse("`#else` without `#if`"),
            },
            ("endif", _) => {
                let Some(condition) = self.conditions.pop() else {
                    return refuse("`#endif` without `#if`");
                };
                self.skipping -= usize::from(!condition);
            }
            _ if skipped => {}
            ("define", Some(name)) => {
                self.defined.insert(name);
                match (words.next(), words.next()) {
                    (None, _) => {}
                    (Some(text), None) if is_reference(text) => {
                        let target = text.rsplit("->").next().unwrap_or(text);
                        let pair = (self.symbols.intern(name), self.symbols.intern(target));
                        if pair.0 != pair.1 {
                            self.macros.insert(pair.0, pair.1);
                        }
                    }
                    // Constants of the solver's loops; a use in an equation
                    // is an undefined name.
                    (Some(_), _) => {}
                }
            }
            _ => return refuse("this line of the preprocessor is not understood"),
        }
        Ok(())
    }
}

/// True for `s->q` and plain words.
fn is_reference(text: &str) -> bool {
    text.split("->").all(|word| {
        word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    })
}

/// `s->q` or `s.q` as structure and member.
fn split_member(text: &str) -> (&str, &str) {
    let parts = text.split_once("->").or_else(|| text.split_once('.'));
    parts.unwrap_or(("", text))
}

impl<'s, L: Surface<'s>> Iterator for Tokens<'s, '_, L> {
    type Item = Result<Spanned, LexicalError>;

    fn next(&mut self) -> Option<Self::Item> {
        let item = self.step()?;
        // A lexeme that is no token stands for one, so that the statement it
        // is part of is known to have begun.
        let token = match &item {
            Ok(token) => *token,
            Err(error) => (error.span.start, Token::Other, error.span.end),
        };
        self.recent = [Some(token), self.recent[0]];
        Some(item)
    }
}

impl<'s, L: Surface<'s>> TokenSource for Tokens<'s, '_, L> {
    fn recent(&self) -> [Option<Spanned>; 2] {
        self.recent
    }

    fn skip_statement(&mut self) {
        self.open.clear();
        let in_head = match self.recent[0] {
            Some((_, Token::End, _)) => return,
            // The head of C's `for` has semicolons of its own.
            Some((_, Token::Refused, _)) => self.language == Language::C,
            _ => false,
        };
        let mut depth = 0u32;
        while let Some(item) = self.next() {
            if self.language != Language::C {
                self.open.clear();
            }
            match item {
                Ok((_, Token::Open, _)) if in_head => depth += 1,
                Ok((_, Token::Close, _)) if in_head => depth = depth.saturating_sub(1),
                Ok((_, Token::End, _)) if depth == 0 => break,
                Ok((_, Token::BraceClose, _)) => break,
                Ok(_) | Err(_) => {}
            }
        }
    }
}
