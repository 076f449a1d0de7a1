//! Tokens of rule files.

use logos::Logos;
use std::ops::Range;

/// A token of a rule file.
#[derive(Logos, Clone, Copy, PartialEq, Debug)]
#[logos(skip r"[ \t\r\n\f]+")]
#[logos(skip(r"#[^\n]*", allow_greedy = true))]
pub(crate) enum RuleToken<'text> {
    /// A name.
    #[regex(r"[\p{L}_][\p{L}\p{N}_]*")]
    Word(&'text str),
    /// Characters that are no token.
    Unknown,
    /// `rule`.
    #[token("rule")]
    Rule,
    /// `when`.
    #[token("when")]
    When,
    /// `class`.
    #[token("class")]
    Class,
    /// The name of a rule, which may have hyphens: words, numbers and minus
    /// signs without blanks between them after `rule`.
    RuleName(&'text str),
    /// The same after `class=`.
    ClassName(&'text str),
    /// A number without sign.
    #[regex(r"([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")]
    Number(&'text str),
    /// A text in double quotes, on one line.
    #[regex("\"[^\"\n]*\"")]
    Quoted(&'text str),
    /// `=>`.
    #[token("=>")]
    Becomes,
    /// `<=>`.
    #[token("<=>")]
    BothWays,
    /// `=`.
    #[token("=")]
    Equals,
    /// `:`.
    #[token(":")]
    Colon,
    /// `;`.
    #[token(";")]
    Semicolon,
    /// `,`.
    #[token(",")]
    Comma,
    /// `(`.
    #[token("(")]
    Open,
    /// `)`.
    #[token(")")]
    Close,
    /// `+`.
    #[token("+")]
    Plus,
    /// `-`.
    #[token("-")]
    Minus,
    /// `*`.
    #[token("*")]
    Times,
    /// `/`.
    #[token("/")]
    Over,
}

impl RuleToken<'_> {
    /// True for a first character of a name with hyphens.
    fn starts_name(self) -> bool {
        use RuleToken::{Class, Rule, When, Word};
        matches!(self, Word(_) | Rule | When | Class)
    }

    /// True for a further character of a name with hyphens.
    fn continues_name(self) -> bool {
        self.starts_name() || matches!(self, RuleToken::Number(_) | RuleToken::Minus)
    }
}

pub(super) type Placed<'text> = (RuleToken<'text>, Range<usize>);

/// The tokens of a text, names with hyphens in one piece.
pub(super) fn tokens(text: &str) -> Vec<Placed<'_>> {
    use RuleToken::{Class, ClassName, Equals, Rule, RuleName, Unknown};
    let mut tokens: Vec<Placed<'_>> = Vec::new();
    for (token, span) in RuleToken::lexer(text).spanned() {
        let token = match token {
            Ok(token) => token,
            Err(()) => Unknown,
        };
        if let [.., (RuleName(name) | ClassName(name), place)] = &mut tokens[..]
            && place.end == span.start
            && token.continues_name()
        {
            place.end = span.end;
            *name = &text[place.clone()];
            continue;
        }
        let token = match &tokens[..] {
            [.., (Rule, _)] if token.starts_name() => RuleName(&text[span.clone()]),
            [.., (Class, _), (Equals, _)] if token.starts_name() => ClassName(&text[span.clone()]),
            _ => token,
        };
        tokens.push((token, span));
    }
    tokens
}
