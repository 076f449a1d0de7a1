//! Tokens of rule files.

use logos::Logos;

/// A token of a rule file.
#[derive(Logos, Clone, Copy, PartialEq, Debug)]
#[logos(skip r"[ \t\r\n\f]+")]
#[logos(skip(r"#[^\n]*", allow_greedy = true))]
pub(super) enum Token<'text> {
    /// A name or a word of the language.
    #[regex(r"[\p{L}_][\p{L}\p{N}_]*")]
    Word(&'text str),
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
