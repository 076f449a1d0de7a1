//! Tokens and grammar of pipelines.

use logos::Logos;

/// A token of a pipeline's text.
#[derive(Logos, Clone, Copy, PartialEq, Debug)]
#[logos(skip r"[ \t\r\n]+")]
#[logos(skip(r"//[^\n]*", allow_greedy = true))]
pub(crate) enum PipelineToken<'text> {
    /// A name or a value.
    #[regex(r"[A-Za-z0-9_.+\-]+")]
    Word(&'text str),
    /// A value that contains other characters.
    #[regex("\"[^\"\n]*\"")]
    Quoted(&'text str),
    /// `{`.
    #[token("{")]
    OpenOptions,
    /// `}`.
    #[token("}")]
    CloseOptions,
    /// `(`.
    #[token("(")]
    OpenGroup,
    /// `)`.
    #[token(")")]
    CloseGroup,
    /// `,`.
    #[token(",")]
    Comma,
    /// `=`.
    #[token("=")]
    Equals,
    /// `$`.
    #[token("$")]
    Dollar,
}
