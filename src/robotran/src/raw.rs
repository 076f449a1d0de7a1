//! The lexical surface of the three languages.
//!
//! One logos lexer per language; all give the same [`Raw`] tokens, so that the
//! rest of the reader does not depend on the language.

use logos::{Lexer, Logos, Skip};

/// A lexeme of any of the languages; its text is the lexer's slice.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Raw {
    Word,
    /// A word after a structure: `s->q`, `np.sin`.
    Member,
    /// A word with literal indices.
    Element,
    /// A member with literal indices.
    MemberElement,
    Zeros,
    Number,
    /// Lexeme that C or Python takes for one number, with its suffix: `0x1Fu`.
    Numeral,
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
    #[regex(r"\.?[0-9]([eEpP][+-]|[0-9A-Za-z_.])*", priority = 20)]
    Numeral,
    #[token("\"", quoted)]
    #[token("'", quoted, priority = 20)]
    Text,
    #[token("#", directive)]
    #[token("%:", directive)]
    Preprocessor,
} skip {
    #[regex(r"[ \t\r\n\f\v]+", logos::skip)]
    Blank,
    #[token("//", line_comment)]
    LineComment,
    #[token("/*", block_comment)]
    BlockComment,
    #[regex(r"\\[ \t\r\f\v]*\n", joined_lines, priority = 20)]
    Continuation,
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
    // Octave has escapes in a text in double quotes, Matlab has not.
    #[regex(r#""[^"\n\\]*"|'[^'\n]*'"#)]
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
    #[regex(r"\.?[0-9]([eE][+-]|[0-9A-Za-z_.])*", priority = 20)]
    Numeral,
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

/// Length of a line of C and those that a `\` joins, without the line end.
fn joined_length(text: &str) -> usize {
    let mut length = 0;
    for line in text.split_inclusive('\n') {
        let bare = line.trim_end_matches([' ', '\t', '\r', '\n', '\x0b', '\x0c']);
        if !bare.ends_with('\\') || !line.ends_with('\n') {
            return length + line.trim_end_matches('\n').len();
        }
        length += line.len();
    }
    length
}

/// Skips a comment of C to the end of its line, and of the lines joined to it.
/// The compiler's options decide if `??/` joins lines.
fn line_comment(lexer: &mut Lexer<'_, C>) -> Result<Skip, ()> {
    let length = joined_length(lexer.remainder());
    let trigraph = lexer.remainder()[..length].trim_end().ends_with("??/");
    lexer.bump(length);
    if trigraph { Err(()) } else { Ok(Skip) }
}

/// Skips a `\` at a line end; within a word or an operator it is refused.
fn joined_lines(lexer: &mut Lexer<'_, C>) -> Result<Skip, ()> {
    let before = lexer.source()[..lexer.span().start].chars().next_back();
    let behind = lexer.remainder().chars().next();
    let apart = |character: Option<char>| character.is_none_or(char::is_whitespace);
    if apart(before) || apart(behind) {
        Ok(Skip)
    } else {
        Err(())
    }
}

/// Takes a text or a character of C; an open one ends at the line, an error.
fn quoted(lexer: &mut Lexer<'_, C>) -> Result<(), ()> {
    let quote = lexer.slice().as_bytes()[0];
    let mut escaped = false;
    for (at, byte) in lexer.remainder().bytes().enumerate() {
        if byte == quote && !escaped {
            lexer.bump(at + 1);
            return Ok(());
        }
        if byte == b'\n' && !escaped {
            lexer.bump(at);
            return Err(());
        }
        escaped = match byte {
            b'\\' => !escaped,
            b'\r' => escaped,
            _ => false,
        };
    }
    lexer.bump(lexer.remainder().len());
    Err(())
}

fn line_start(text: &str) -> usize {
    text.rfind('\n').map_or(0, |at| at + 1)
}

/// Reads a line of the preprocessor, with the lines joined to it.
fn directive(lexer: &mut Lexer<'_, C>) -> Result<(), ()> {
    let before = &lexer.source()[..lexer.span().start];
    let line_start = line_start(before);
    let rest = lexer.remainder();
    if lexer.slice() != "#" || !before[line_start..].trim().is_empty() {
        lexer.bump(rest.find('\n').unwrap_or(rest.len()));
        return Err(());
    }
    let bytes = rest.as_bytes();
    let (mut at, mut joined, mut text) = (0, false, false);
    while at < bytes.len() && (bytes[at] != b'\n' || joined) {
        if !text && bytes[at..].starts_with(b"//") {
            at += joined_length(&rest[at..]);
            break;
        }
        if !text && bytes[at..].starts_with(b"/*") {
            let Some(length) = rest[at + 2..].find("*/") else {
                lexer.bump(rest.len());
                return Err(());
            };
            at += length + 4;
            joined = false;
            continue;
        }
        text ^= bytes[at] == b'"';
        joined = match bytes[at] {
            b'\\' => true,
            b' ' | b'\t' | b'\r' => joined,
            _ => false,
        };
        at += 1;
    }
    lexer.bump(at);
    Ok(())
}

/// Skips a Matlab comment: the rest of the line, or, when the line is exactly
/// `%{`, all lines up to the line `%}` that closes it.
fn matlab_comment(lexer: &mut Lexer<'_, Matlab>) -> Result<Skip, ()> {
    let before = &lexer.source()[..lexer.span().start];
    let line_start = line_start(before);
    if lexer.slice().trim_end() != "%{" || !before[line_start..].trim().is_empty() {
        return Ok(Skip);
    }
    let (mut length, mut open) = (0, 1);
    for line in lexer.remainder().split_inclusive('\n') {
        length += line.len();
        match line.trim() {
            "%{" => open += 1,
            "%}" => open -= 1,
            _ => {}
        }
        if open == 0 {
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
