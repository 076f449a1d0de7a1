//! Reading parenthesised text (egglog, Herbie, FPCore) into trees.
//!
//! Trees live in an arena and are built with a separate stack: no nesting
//! is too deep.

use crate::diagnostic::{Diagnostic, Label};
use logos::Logos;
use std::ops::Range;

#[derive(Logos, Clone, Copy, PartialEq, Debug)]
#[logos(skip r"[ \t\r\n\f]+")]
#[logos(skip(r";[^\n]*", allow_greedy = true))]
#[logos(skip(r"#\|([^|]|\|+[^|#])*\|+#"))]
enum TreeToken {
    #[token("(")]
    #[token("[")]
    Open,
    #[token(")")]
    #[token("]")]
    Close,
    #[regex("\"([^\"\\\\]|\\\\[\\s\\S])*\"")]
    Text,
    #[regex(r#"[^\s()\[\]";]+"#)]
    Atom,
}

/// A node of a tree.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum TreeKind {
    /// A word, a number or a text in quotes.
    Atom,
    /// The trees between parentheses.
    List(Vec<u32>),
}

/// A tree with its place.
#[derive(Clone, Debug)]
pub struct TextTree {
    /// An atom, or a list of trees.
    pub kind: TreeKind,
    /// Its bytes in the text.
    pub span: Range<usize>,
}

/// The trees of a text.
#[derive(Clone, Debug)]
pub struct Forest<'text> {
    /// The text.
    pub text: &'text str,
    trees: Vec<TextTree>,
    /// The trees between no parentheses, in order.
    pub roots: Vec<u32>,
}

impl<'text> Forest<'text> {
    /// A tree by its number.
    ///
    /// # Panics
    ///
    /// Panics when the forest has no tree of that number.
    pub fn get(&self, index: u32) -> &TextTree {
        &self.trees[index as usize]
    }

    /// The elements of a list; none of an atom.
    pub fn elements(&self, index: u32) -> &[u32] {
        match &self.get(index).kind {
            TreeKind::List(elements) => elements,
            TreeKind::Atom => &[],
        }
    }

    /// The text of an atom.
    pub fn atom(&self, index: u32) -> Option<&'text str> {
        let tree = self.get(index);
        (tree.kind == TreeKind::Atom).then(|| &self.text[tree.span.clone()])
    }

    /// The word a list starts with.
    pub fn head(&self, index: u32) -> Option<&'text str> {
        self.elements(index)
            .first()
            .and_then(|&head| self.atom(head))
    }

    /// The comment before a tree, when it is on the line before or on its
    /// own line.
    pub fn comment(&self, index: u32) -> Option<&'text str> {
        let before = self.text[..self.get(index).span.start].trim_end();
        let line = before.rsplit('\n').next()?.trim();
        let comment = line.strip_prefix(';')?.trim_start_matches(';').trim();
        (!comment.is_empty()).then_some(comment)
    }
}

/// An error at a place of a text that is the only file of its report.
pub fn error(span: Range<usize>, message: impl Into<String>) -> Diagnostic {
    Diagnostic::error()
        .with_message(message.into())
        .with_labels(vec![Label::primary(0, span)])
}

/// Reads all trees of a text.
///
/// # Errors
///
/// Fails at an unmatched parenthesis or quote.
pub fn read(text: &str) -> Result<Forest<'_>, Diagnostic> {
    let mut forest = Forest {
        text,
        trees: Vec::new(),
        roots: Vec::new(),
    };
    let mut open: Vec<(Range<usize>, Vec<u32>)> = Vec::new();
    for (token, span) in TreeToken::lexer(text).spanned() {
        let tree = match token {
            Err(()) if text[span.clone()].starts_with('"') => {
                return Err(error(span, "this text has no closing '\"'"));
            }
            Err(()) => return Err(error(span, "this character is not allowed here")),
            Ok(TreeToken::Open) => {
                open.push((span, Vec::new()));
                continue;
            }
            Ok(TreeToken::Close) => {
                let Some((start, elements)) = open.pop() else {
                    return Err(error(span, "no parenthesis is open here"));
                };
                if (&text[start.clone()] == "(") != (&text[span.clone()] == ")") {
                    let label = Label::secondary(0, start).with_message("opened here");
                    let message = "this parenthesis is not of the kind that was opened";
                    let mut diagnostic = error(span, message);
                    diagnostic.labels.push(label);
                    return Err(diagnostic);
                }
                TextTree {
                    kind: TreeKind::List(elements),
                    span: start.start..span.end,
                }
            }
            Ok(TreeToken::Text | TreeToken::Atom) => TextTree {
                kind: TreeKind::Atom,
                span,
            },
        };
        let index = forest.trees.len() as u32;
        forest.trees.push(tree);
        match open.last_mut() {
            Some((_, elements)) => elements.push(index),
            None => forest.roots.push(index),
        }
    }
    match open.pop() {
        Some((start, _)) => Err(error(start, "this parenthesis is not closed")),
        None => Ok(forest),
    }
}
