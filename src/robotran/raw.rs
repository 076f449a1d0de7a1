//! The lexical surface of the three languages.
//!
//! One logos lexer per language; all give the same [`Raw`] tokens, so that
//! the rest of the reader does not know which language it reads.

use logos::{Lexer, Logos, Skip};

/// A lexeme of any of the languages; its text is the lexer's slice.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Raw {
    Word,
    /// A word behind a structure: `s->q`, `np.sin`.
    Member,
    /// A word with literal indices.
    Element,
    /// A member with literal indices.
    MemberElement,
    Zeros,
    Number,
    Text,
    Preprocessor,
    LineEnd,
    Plus,
    Minus,
    Star,
    Slash,
    Equals,
    Open,
    Close,
    BracketOpen,
    BracketClose,
    BraceOpen,
    BraceClose,
    Comma,
    Semicolon,
    Colon,
    Ampersand,
    Other,
}

/// A lexer that gives [`Raw`] tokens.
pub(super) trait Surface<'s>:
    Logos<'s, Source = str, Extras = (), Error = ()> + Copy
{
    /// The shared token.
    fn raw(self) -> Raw;
}

macro_rules! surface {
    ($language:ident { $($(#[$attribute:meta])* $variant:ident,)* }
     skip { $($(#[$skip_attribute:meta])* $skipped:ident,)* }) => {
        #[derive(Logos, Clone, Copy, PartialEq, Eq, Debug)]
        pub(super) enum $language {
            #[token("+")] Plus,
            #[token("-")] Minus,
            #[token("*")] Star,
            #[token("/")] Slash,
            #[token("=")] Equals,
            #[token("(")] Open,
            #[token(")")] Close,
            #[token("[")] BracketOpen,
            #[token("]")] BracketClose,
            #[token("{")] BraceOpen,
            #[token("}")] BraceClose,
            #[token(",")] Comma,
            #[token(";")] Semicolon,
            #[token(":")] Colon,
            #[token("&")] Ampersand,
            #[regex(r"([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")] Number,
            #[regex(r"[A-Za-z_][A-Za-z0-9_]*")] Word,
            #[regex(r"==|!=|<=|>=|&&|\|\||\+\+|--|\+=|-=|\*=|/=|\*\*|\^|\.\*|\./|[<>!%|?~@'.\\]")] Other,
            $($(#[$attribute])* $variant,)*
            $($(#[$skip_attribute])* $skipped,)*
        }

        impl<'s> Surface<'s> for $language {
            fn raw(self) -> Raw {
                match self {
                    $language::Plus => Raw::Plus,
                    $language::Minus => Raw::Minus,
                    $language::Star => Raw::Star,
                    $language::Slash => Raw::Slash,
                    $language::Equals => Raw::Equals,
                    $language::Open => Raw::Open,
                    $language::Close => Raw::Close,
                    $language::BracketOpen => Raw::BracketOpen,
                    $language::BracketClose => Raw::BracketClose,
                    $language::BraceOpen => Raw::BraceOpen,
                    $language::BraceClose => Raw::BraceClose,
                    $language::Comma => Raw::Comma,
                    $language::Semicolon => Raw::Semicolon,
                    $language::Colon => Raw::Colon,
                    $language::Ampersand => Raw::Ampersand,
                    $language::Number => Raw::Number,
                    $language::Word => Raw::Word,
                    $language::Other => Raw::Other,
                    $($language::$variant => Raw::$variant,)*
                    // Skipped lexemes never leave the lexer.
                    $($language::$skipped => Raw::Other,)*
                }
            }
        }
    };
}

surface!(C {
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*->[A-Za-z_][A-Za-z0-9_]*")]
    Member,
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*[ \t]*\[[ \t]*[0-9]+[ \t]*\]([ \t]*\[[ \t]*[0-9]+[ \t]*\])?", priority = 20)]
    Element,
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*->[A-Za-z_][A-Za-z0-9_]*[ \t]*\[[ \t]*[0-9]+[ \t]*\]([ \t]*\[[ \t]*[0-9]+[ \t]*\])?", priority = 20)]
    MemberElement,
    #[regex(r#""([^"\\\n]|\\[^\n])*""#)]
    Text,
    #[regex(r"#[^\n]*", allow_greedy = true)]
    Preprocessor,
} skip {
    #[regex(r"[ \t\r\n\f\v]+", logos::skip)]
    Blank,
    #[regex(r"//[^\n]*", logos::skip, allow_greedy = true)]
    LineComment,
    #[token("/*", block_comment)]
    BlockComment,
});

surface!(Matlab {
    #[token("\n")]
    LineEnd,
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*\.[A-Za-z_][A-Za-z0-9_]*")]
    Member,
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*[ \t]*\([ \t]*[0-9]+[ \t]*(,[ \t]*[0-9]+[ \t]*)?\)", priority = 20)]
    Element,
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*\.[A-Za-z_][A-Za-z0-9_]*[ \t]*\([ \t]*[0-9]+[ \t]*(,[ \t]*[0-9]+[ \t]*)?\)", priority = 20)]
    MemberElement,
    #[regex(r#""[^"\n]*"|'[^'\n]*'"#)]
    Text,
} skip {
    #[regex(r"[ \t\r\f\v]+", logos::skip)]
    Blank,
    #[regex(r"%[^\n]*", matlab_comment, allow_greedy = true, priority = 30)]
    LineComment,
    #[regex(r"\.\.\.[^\n]*\n?", logos::skip, allow_greedy = true)]
    Continuation,
});

surface!(Python {
    #[token("\n")]
    LineEnd,
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*\.[A-Za-z_][A-Za-z0-9_]*")]
    Member,
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*[ \t]*\[[ \t]*[0-9]+[ \t]*(,[ \t]*[0-9]+[ \t]*)?\]([ \t]*\[[ \t]*[0-9]+[ \t]*\])?", priority = 20)]
    Element,
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*\.[A-Za-z_][A-Za-z0-9_]*[ \t]*\[[ \t]*[0-9]+[ \t]*(,[ \t]*[0-9]+[ \t]*)?\]([ \t]*\[[ \t]*[0-9]+[ \t]*\])?", priority = 20)]
    MemberElement,
    #[regex(r"((np|numpy)\.)?zeros[ \t]*\([ \t]*\(?[ \t]*[0-9]+[ \t]*(,[ \t]*[0-9]+[ \t]*)?\)?[ \t]*\)", priority = 40)]
    Zeros,
    #[regex(r#""([^"\\\n]|\\[^\n])*"|'([^'\\\n]|\\[^\n])*'"#)]
    #[token("\"\"\"", long_text)]
    #[token("'''", long_text)]
    Text,
} skip {
    #[regex(r"[ \t\r\f\v]+", logos::skip)]
    Blank,
    #[regex(r"#[^\n]*", logos::skip, allow_greedy = true)]
    LineComment,
    #[regex(r"\\[ \t]*\r?\n", logos::skip)]
    Continuation,
});

/// Skips to the end of a C comment; an open one is an error.
fn block_comment(lexer: &mut Lexer<'_, C>) -> Result<Skip, ()> {
    match lexer.remainder().find("*/") {
        Some(length) => {
            lexer.bump(length + 2);
            Ok(Skip)
        }
        None => Err(()),
    }
}

/// Skips a Matlab comment: the rest of the line, or, when the line is `%{`
/// and nothing else, everything to the line `%}`.
fn matlab_comment(lexer: &mut Lexer<'_, Matlab>) -> Result<Skip, ()> {
    let before = &lexer.source()[..lexer.span().start];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    if lexer.slice().trim_end() != "%{" || !before[line_start..].trim().is_empty() {
        return Ok(Skip);
    }
    let mut length = 0;
    for line in lexer.remainder().split_inclusive('\n') {
        length += line.len();
        if line.trim() == "%}" {
            lexer.bump(length);
            return Ok(Skip);
        }
    }
    Err(())
}

/// Takes a Python text in triple quotes.
fn long_text(lexer: &mut Lexer<'_, Python>) -> Result<(), ()> {
    let quotes = lexer.slice();
    match lexer.remainder().find(quotes) {
        Some(length) => {
            lexer.bump(length + 3);
            Ok(())
        }
        None => Err(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raws<'s, L: Surface<'s>>(text: &'s str) -> Vec<Option<Raw>>
    where
        L::Extras: Default,
    {
        L::lexer(text)
            .map(|token| token.ok().map(Surface::raw))
            .collect()
    }

    #[test]
    fn an_element_is_one_lexeme_in_every_language() {
        let element = [Some(Raw::MemberElement)];
        assert_eq!(raws::<C>("s->dpt[3] [ 12 ]"), element);
        assert_eq!(raws::<Matlab>("s.dpt(3, 12)"), element);
        assert_eq!(raws::<Python>("s.dpt[3,12]"), element);
    }

    #[test]
    fn comments_and_continuations_vanish() {
        assert_eq!(
            raws::<C>("a /* = */ = // b;\n b"),
            [Some(Raw::Word), Some(Raw::Equals), Some(Raw::Word)]
        );
        assert_eq!(
            raws::<Matlab>("%{\nx\n%}\na ... rest\n b"),
            [Some(Raw::Word), Some(Raw::Word)]
        );
        assert_eq!(
            raws::<Python>("a \\\r\n\tb # c"),
            [Some(Raw::Word), Some(Raw::Word)]
        );
    }

    #[test]
    fn open_comments_are_errors() {
        assert_eq!(raws::<C>("/* a")[0], None);
        assert_eq!(raws::<Matlab>("%{\n a")[0], None);
        assert_eq!(raws::<Python>("\"\"\" a")[0], None);
    }
}
