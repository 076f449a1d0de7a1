//! Tokens of the text form.
//!
//! A token is one byte and a range of the text; its content is read from the
//! text on demand, so nothing is copied or allocated here. Line ends are tokens
//! because they end statements, and recovery from an error continues there;
//! [`Tokens`] drops those between a line and its continuation.

use logos::{Lexer, Logos};

/// A kind of token.
#[derive(Logos, Clone, Copy, PartialEq, Eq, Debug)]
#[logos(skip r"[ \t\f]+")]
#[logos(skip(r"//[^\r\n]*", allow_greedy = true))]
pub(super) enum ModuleToken {
    /// End of a line.
    #[regex(r"\r\n?|\n")]
    Newline,
    /// `%OM16.1`: a value.
    #[regex(r"%[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z0-9_]+)*")]
    Value,
    /// `sens.P`, `add0.left`: an array, an element, a word of the language.
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z0-9_]+)*")]
    Word,
    /// `12`.
    #[regex(r"[0-9]+")]
    Integer,
    /// `1.5`, `2e-3`.
    #[regex(r"[0-9]+\.[0-9]+([eE][+-]?[0-9]+)?")]
    #[regex(r"[0-9]+[eE][+-]?[0-9]+")]
    Real,
    /// `"…"`.
    #[regex(r#""([^"\\\r\n]|\\[^\r\n])*""#)]
    String,
    /// A string whose end is not on its line.
    #[regex(r#""([^"\\\r\n]|\\[^\r\n])*"#)]
    OpenString,
    /// `@1/43:3-44:20`: a place.
    #[regex(r"@([0-9]+/)?[0-9]+:[0-9]+-([0-9]+:)?[0-9]+")]
    Place,
    /// `@!3`: a reference to a set of places.
    #[regex(r"@![0-9]+")]
    SetReference,
    /// `!3`: a set of places, at its declaration.
    #[regex(r"![0-9]+")]
    Set,
    #[token("source")]
    Source,
    #[token("function")]
    Function,
    #[token("meta")]
    Meta,
    #[token("in")]
    In,
    #[token("out")]
    Out,
    #[token("places")]
    Places,
    #[token("call")]
    Call,
    #[token("schedule")]
    Schedule,
    #[token("cycles")]
    Cycles,
    #[token("bound")]
    Bound,
    #[token("preload")]
    Preload,
    #[token("on")]
    On,
    #[token("at")]
    At,
    #[token("read")]
    Read,
    #[token("buffer")]
    Buffer,
    #[token("write")]
    Write,
    #[token("history")]
    History,
    #[token("as")]
    As,
    #[token("=")]
    Equals,
    #[token("+")]
    Plus,
    #[token("-")]
    Minus,
    #[token("*")]
    Star,
    #[token("/")]
    Slash,
    #[token(",")]
    Comma,
    #[token("..")]
    Dots,
    #[token("->")]
    Arrow,
    #[token("(")]
    OpenParenthesis,
    #[token(")")]
    CloseParenthesis,
    #[token("[")]
    OpenBracket,
    #[token("]")]
    CloseBracket,
    #[token("{")]
    OpenBrace,
    #[token("}")]
    CloseBrace,
    /// Characters that begin no token.
    Unknown,
}

impl ModuleToken {
    /// True when the statement continues after a line end after this token.
    fn goes_on(self) -> bool {
        matches!(
            self,
            ModuleToken::Equals
                | ModuleToken::Plus
                | ModuleToken::Minus
                | ModuleToken::Star
                | ModuleToken::Slash
                | ModuleToken::Comma
                | ModuleToken::Arrow
                | ModuleToken::OpenParenthesis
                | ModuleToken::OpenBracket
        )
    }

    /// True when a line that begins with this token continues the one before.
    fn continues(self) -> bool {
        let closes = matches!(
            self,
            ModuleToken::CloseParenthesis | ModuleToken::CloseBracket | ModuleToken::OpenBrace
        );
        let follows = matches!(self, ModuleToken::Place | ModuleToken::SetReference);
        closes || follows || (self.goes_on() && self != ModuleToken::OpenBracket)
    }
}

/// A token with the range of its bytes.
pub(super) type Spanned = (u32, ModuleToken, u32);

/// The tokens of a text; every statement ends with exactly one
/// [`ModuleToken::Newline`].
pub(super) struct Tokens<'t> {
    lexer: Lexer<'t, ModuleToken>,
    ahead: Option<Spanned>,
    previous: ModuleToken,
    /// The start of the statement of the last token.
    statement: u32,
    /// The last line end that did not end the statement.
    joined: Option<u32>,
}

impl<'t> Tokens<'t> {
    /// Starts at the beginning of a text shorter than 4 GiB.
    pub(super) fn new(text: &'t str) -> Tokens<'t> {
        let mut lexer = ModuleToken::lexer(text);
        if text.starts_with('\u{feff}') {
            lexer.bump('\u{feff}'.len_utf8());
        }
        Tokens {
            lexer,
            ahead: None,
            previous: ModuleToken::Newline,
            statement: 0,
            joined: None,
        }
    }

    /// The start of the statement of the last token.
    pub(super) fn statement(&self) -> u32 {
        self.statement
    }

    /// The last line end inside the statement of the last token.
    pub(super) fn joined(&self) -> Option<u32> {
        self.joined
    }

    /// Drops the rest of the statement of the last token.
    pub(super) fn skip_statement(&mut self) {
        while self.previous != ModuleToken::Newline && self.next().is_some() {}
    }

    fn raw(&mut self) -> Option<Spanned> {
        let token = self.lexer.next()?.unwrap_or(ModuleToken::Unknown);
        let span = self.lexer.span();
        Some((span.start as u32, token, span.end as u32))
    }

    /// True when the token and the text after it begin a new definition, as
    /// after a line that breaks off.
    fn is_head(&self, token: ModuleToken, end: u32) -> bool {
        let rest = self.lexer.source()[end as usize..].trim_start_matches([' ', '\t']);
        matches!(token, ModuleToken::Value | ModuleToken::Word) && rest.starts_with('=')
    }

    /// The token after a line end: the line end itself, or, when the statement
    /// continues, the token after it.
    fn after_newline(&mut self, newline: Spanned) -> Option<Spanned> {
        let following = loop {
            match self.raw() {
                Some((_, ModuleToken::Newline, _)) => {}
                other => break other,
            }
        };
        let ends = match following {
            None => self.previous != ModuleToken::Newline,
            Some((_, token, end)) => {
                self.previous != ModuleToken::Newline
                    && (!self.previous.goes_on() || self.is_head(token, end))
                    && !token.continues()
            }
        };
        if !ends {
            self.joined = (self.previous != ModuleToken::Newline).then_some(newline.0);
            return following;
        }
        self.ahead = following;
        Some(newline)
    }
}

impl Iterator for Tokens<'_> {
    type Item = Spanned;

    fn next(&mut self) -> Option<Spanned> {
        let token = match self.ahead.take().or_else(|| self.raw()) {
            Some(newline @ (_, ModuleToken::Newline, _)) => self.after_newline(newline),
            None if self.previous != ModuleToken::Newline => {
                let end = self.lexer.source().len() as u32;
                Some((end, ModuleToken::Newline, end))
            }
            other => other,
        }?;
        if self.previous == ModuleToken::Newline {
            self.statement = token.0;
            self.joined = None;
        }
        self.previous = token.1;
        Some(token)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Vec<(ModuleToken, &str)> {
        Tokens::new(text)
            .map(|(start, token, end)| (token, &text[start as usize..end as usize]))
            .collect()
    }

    #[test]
    fn ranges_reals_and_names_are_told_apart() {
        use ModuleToken::*;
        assert_eq!(
            tokens("q[1..6] 1.5e-3 2e7 %OM16.1 sens.P"),
            [
                (Word, "q"),
                (OpenBracket, "["),
                (Integer, "1"),
                (Dots, ".."),
                (Integer, "6"),
                (CloseBracket, "]"),
                (Real, "1.5e-3"),
                (Real, "2e7"),
                (Value, "%OM16.1"),
                (Word, "sens.P"),
                (Newline, ""),
            ]
        );
    }

    #[test]
    fn a_place_is_one_token_and_comments_are_none() {
        use ModuleToken::*;
        assert_eq!(
            tokens("@43:3-20 @1/43:3-44:20 // @1:1-1\n\n@!2 !2"),
            [
                (Place, "@43:3-20"),
                (Place, "@1/43:3-44:20"),
                (SetReference, "@!2"),
                (Set, "!2"),
                (Newline, ""),
            ]
        );
    }

    #[test]
    fn line_ends_inside_a_statement_vanish() {
        use ModuleToken::*;
        let kinds: Vec<ModuleToken> = tokens("\n\n%x = 1 +\n2\n  * 3 // why\n\n%y = 4\n")
            .into_iter()
            .map(|(token, _)| token)
            .collect();
        assert_eq!(
            kinds,
            [
                Value, Equals, Integer, Plus, Integer, Star, Integer, Newline, Value, Equals,
                Integer, Newline
            ]
        );
    }

    #[test]
    fn a_carriage_return_alone_ends_a_line() {
        let one = tokens("// a\n%x = 1\n%y = 2\n");
        for ends in ["\r", "\r\n"] {
            let text = "// a\n%x = 1\n%y = 2\n".replace('\n', ends);
            let kinds = |tokens: &[(ModuleToken, &str)]| -> Vec<ModuleToken> {
                tokens.iter().map(|(kind, _)| *kind).collect()
            };
            assert_eq!(kinds(&tokens(&text)), kinds(&one), "{ends:?}");
        }
    }

    #[test]
    fn unfinished_and_unknown_characters_are_tokens_too() {
        let found = tokens("\"abc\n§ \"a\\\"b\"");
        assert_eq!(found[0], (ModuleToken::OpenString, "\"abc"));
        assert_eq!(found[2].0, ModuleToken::Unknown);
        assert_eq!(found[3], (ModuleToken::String, "\"a\\\"b\""));
    }
}
