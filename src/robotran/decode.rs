//! From bytes to text, and the language of a text.

use super::Language;
use encoding_rs::{Encoding, WINDOWS_1252};
use robovec_ir::diagnostic::Diagnostic;
use std::borrow::Cow;

/// Files beyond this size are refused: offsets into them would not fit.
const LARGEST_FILE: usize = 1 << 30;

/// The text of a file: UTF-8, UTF-16 with its mark, or else Latin-1, in which
/// old headers are written.
pub(super) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, Diagnostic> {
    if bytes.len() > LARGEST_FILE {
        return Err(Diagnostic::error()
            .with_message("the file is larger than 1 GiB")
            .with_note("no generated file comes near this; check that it is the right one"));
    }
    decode_text(
        bytes,
        "a Robotran file is plain text in C, Matlab or Python",
    )
}

/// The text of bytes of any number, decoded as [`decode`] does; `kind` says
/// what kind of text is expected, for the message about one that is none.
pub(crate) fn decode_text<'a>(bytes: &'a [u8], kind: &str) -> Result<Cow<'a, str>, Diagnostic> {
    if let Some((encoding, mark)) = Encoding::for_bom(bytes) {
        let text = encoding.decode_without_bom_handling(&bytes[mark..]).0;
        return reject_binary(text, kind);
    }
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => WINDOWS_1252.decode_without_bom_handling(bytes).0,
    };
    reject_binary(text, kind)
}

fn reject_binary<'a>(text: Cow<'a, str>, kind: &str) -> Result<Cow<'a, str>, Diagnostic> {
    // Only control characters of ASCII: C1 controls occur in mangled Latin-1
    // headers.
    let binary = |&byte: &u8| byte < b' ' && !matches!(byte, b'\n' | b'\r' | b'\t' | 0xb | 0xc);
    let bytes = text.as_bytes();
    // A piece is looked at without a branch for every byte.
    let piece_is_text =
        |piece: &[u8]| !piece.iter().fold(false, |found, byte| found | binary(byte));
    if bytes.chunks(256).all(piece_is_text) {
        return Ok(text);
    }
    let at = bytes.iter().position(binary);
    let at = at.expect("one of the pieces is no text");
    let line = text[..at].matches('\n').count() + 1;
    Err(Diagnostic::error()
        .with_message("the file is not text")
        .with_note(format!(
            "line {line} holds the byte {:#04x}; {kind}",
            bytes[at]
        )))
}

/// The language of a text: what the text shows beyond doubt, else what the
/// name's extension says, else the style of its comments.
pub(super) fn detect(name: &str, text: &str) -> Option<Language> {
    let by_extension = Language::from_extension(name.rsplit('.').next().unwrap_or_default());
    // Almost no line is a head, and its first byte tells.
    let breaks = memchr::memchr_iter(b'\n', text.as_bytes());
    let starts = std::iter::once(0).chain(breaks.map(|at| at + 1));
    let mut heads = starts.filter_map(|start| language_of_head(&text[start..]));
    if let Some(first) = heads.next()
        && heads.all(|other| other == first)
    {
        return Some(first);
    }
    by_extension.or_else(|| text.lines().find_map(language_of_comment))
}

/// The language whose head the first line of a text is.
fn language_of_head(text: &str) -> Option<Language> {
    let first = *text.as_bytes().first()?;
    if !matches!(first, b'f' | b'd' | b'v' | b'i' | b'#') {
        return None;
    }
    let line = text.lines().next()?;
    match first {
        b'f' if line.starts_with("function ") && line.contains('(') => Some(Language::Matlab),
        b'd' if line.starts_with("def ") && line.contains('(') => Some(Language::Python),
        b'v' | b'i' => {
            let after = line.strip_prefix("void ").or(line.strip_prefix("int "))?;
            after.contains('(').then_some(Language::C)
        }
        b'#' if line.starts_with("#include") => Some(Language::C),
        _ => None,
    }
}

fn language_of_comment(line: &str) -> Option<Language> {
    match line.trim_start().as_bytes() {
        [b'%', ..] => Some(Language::Matlab),
        [b'/', b'/' | b'*', ..] => Some(Language::C),
        [b'#', ..] => Some(Language::Python),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latin_1_and_marks_are_read_and_binary_is_not() {
        assert_eq!(
            decode(b"Universit\xe9").expect("Latin-1"),
            "Universit\u{e9}"
        );
        assert_eq!(decode(b"\xef\xbb\xbfa").expect("UTF-8"), "a");
        assert_eq!(decode(b"\xff\xfea\0").expect("UTF-16"), "a");
        assert!(decode(b"a\n\0").is_err());
    }

    #[test]
    fn content_overrules_the_extension() {
        let c = "// x\nvoid dirdyna(double **M)\n";
        assert_eq!(detect("a.m", c), Some(Language::C));
        assert_eq!(detect("a.m", "A = B;"), Some(Language::Matlab));
        assert_eq!(detect("a", "% x\nA = B;"), Some(Language::Matlab));
        assert_eq!(detect("a", "def f(x):\n"), Some(Language::Python));
        assert_eq!(detect("a", "A = B"), None);
    }
}
