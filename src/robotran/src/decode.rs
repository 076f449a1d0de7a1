//! From bytes to text, and the language of a text.

use super::Language;
use encoding_rs::{Encoding, WINDOWS_1252};
use robovec_ir::diagnostic::Diagnostic;
use std::borrow::Cow;

/// Files beyond this size are refused: offsets into them would not fit.
const LARGEST_FILE: usize = 1 << 30;

/// The text of a file: UTF-8, UTF-16 with its mark, or else Latin-1.
pub(super) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, Diagnostic> {
    if bytes.len() > LARGEST_FILE {
        return Err(Diagnostic::error()
            .with_message("the file is larger than 1 GiB")
            .with_note("no generated file is this large; check that it is the right one"));
    }
    // Compilers of C take control characters in comments alone.
    decode_text(
        bytes,
        "a Robotran file is plain text in C, Matlab or Python",
        |byte| byte == 0,
    )
}

/// True for the control characters of ASCII that do not occur in text files. C1
/// controls occur in mangled Latin-1 headers.
pub fn is_control(byte: u8) -> bool {
    byte < b' ' && !matches!(byte, b'\n' | b'\r' | b'\t' | 0xb | 0xc)
}

/// The text of bytes of any number, decoded as [`decode`] does; `kind` names
/// the text expected, for the message about one that is none.
pub fn decode_text<'a>(
    bytes: &'a [u8],
    kind: &str,
    is_binary: impl Fn(u8) -> bool,
) -> Result<Cow<'a, str>, Diagnostic> {
    let text = match Encoding::for_bom(bytes) {
        Some((encoding, mark)) => encoding.decode_without_bom_handling(&bytes[mark..]).0,
        None => match std::str::from_utf8(bytes) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) => WINDOWS_1252.decode_without_bom_handling(bytes).0,
        },
    };
    Ok(with_line_feeds(reject_binary(text, kind, is_binary)?))
}

/// The text with a line feed for every single carriage return, which ended
/// lines on old systems and ends comments here.
pub fn with_line_feeds(text: Cow<'_, str>) -> Cow<'_, str> {
    if !text.contains('\r') {
        return text;
    }
    let mut bytes = text.into_owned().into_bytes();
    for at in 0..bytes.len() {
        if bytes[at] == b'\r' && bytes.get(at + 1) != Some(&b'\n') {
            bytes[at] = b'\n';
        }
    }
    Cow::Owned(String::from_utf8(bytes).expect("ASCII took the place of ASCII"))
}

fn reject_binary<'a>(
    text: Cow<'a, str>,
    kind: &str,
    is_binary: impl Fn(u8) -> bool,
) -> Result<Cow<'a, str>, Diagnostic> {
    let binary = |&byte: &u8| is_binary(byte);
    let bytes = text.as_bytes();
    // A piece is looked at without a branch for every byte.
    let piece_is_text =
        |piece: &[u8]| !piece.iter().fold(false, |found, byte| found | binary(byte));
    if bytes.chunks(256).all(piece_is_text) {
        return Ok(text);
    }
    let at = bytes.iter().position(binary);
    let at = at.expect("one of the pieces is not text");
    let line = text[..at].matches('\n').count() + 1;
    Err(Diagnostic::error()
        .with_message("the file is not text")
        .with_note(format!(
            "line {line} holds the byte {:#04x}; {kind}",
            bytes[at]
        )))
}

/// The part of a name after its last dot.
fn extension(name: &str) -> &str {
    let mut parts = name.rsplit('.');
    parts.next().expect("a text has a last part")
}

/// The language of a text: from the text if it is certain, else from the name's
/// extension, else from the style of its comments.
pub(super) fn detect(name: &str, text: &str) -> Option<Language> {
    let by_extension = Language::from_extension(extension(name));
    let mut shown = Language::ALL
        .into_iter()
        .filter(|&language| shows(text, language));
    if let (Some(only), None) = (shown.next(), shown.next()) {
        return Some(only);
    }
    by_extension.or_else(|| text.lines().find_map(language_of_comment))
}

/// True for the beginning of a text of equations, by its name or head.
pub fn is_equations(name: &str, text: &str) -> bool {
    let extension = extension(name);
    ["rvir", "fpcore"].contains(&extension)
        || Language::from_extension(extension).is_some()
        || Language::ALL.iter().any(|&language| shows(text, language))
}

/// Tests whether a line of the text is the head of a function in the language.
fn shows(text: &str, language: Language) -> bool {
    let heads: &[(&str, &str)] = match language {
        Language::C => &[("#include", ""), ("void ", "("), ("int ", "(")],
        Language::Matlab => &[("function ", "(")],
        Language::Python => &[("def ", "(")],
    };
    heads.iter().any(|&(head, within)| {
        let starts = memchr::memmem::find_iter(text.as_bytes(), head);
        starts
            .filter(|&at| at == 0 || text.as_bytes()[at - 1] == b'\n')
            .any(|at| {
                text[at..]
                    .lines()
                    .next()
                    .is_some_and(|line| line.contains(within))
            })
    })
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
        // Two heads or none settle nothing.
        let both = "function f(x)\nint g(double x)\n";
        assert_eq!(detect("a.m", both), Some(Language::Matlab));
        assert_eq!(detect("a.c", both), Some(Language::C));
        assert_eq!(detect("a", "A = void (1)\nint a;\ndef b\n"), None);
    }
}
