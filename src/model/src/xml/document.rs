//! From bytes to a tree of elements: guards and messages of the XML library.
//!
//! The library neither recurses over nested elements nor expands entities
//! (document types are refused). It compares the attributes of one element with
//! each other, so their number is limited here.

use super::messages::diagnostic;
use robovec_ir::diagnostic::{Diagnostic, clip};
use roxmltree::{Document, Error, ParsingOptions, TextPos};
use std::borrow::Cow;
use std::ops::Range;

/// Files beyond this size are refused; the largest public model has 150 kB.
const LARGEST_FILE: usize = 16 << 20;

/// The maximum number of equals signs, hence attributes, of one tag.
const ATTRIBUTE_LIMIT: usize = 200;

/// Description of a kind of file, for messages.
pub(crate) struct DocumentKind {
    /// Last tag of a whole file.
    pub(crate) last: &'static str,
    /// Description of a file, as `a model is …`.
    pub(crate) what: &'static str,
    /// As short as it goes: `.mbs`.
    pub(crate) first: &'static str,
}

/// The text of a file: UTF-8, UTF-16 with its mark, or else Latin-1.
pub(crate) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, Diagnostic> {
    if bytes.len() > LARGEST_FILE {
        return Err(Diagnostic::error()
            .with_message("the file is larger than 16 MiB")
            .with_note("no model is this large; check that it is the right file"));
    }
    robovec_robotran::decode_text(bytes, "a model is XML", robovec_robotran::is_control)
}

pub(crate) fn parse<'t>(text: &'t str, kind: &DocumentKind) -> Result<Document<'t>, Diagnostic> {
    guard(text)?;
    let options = ParsingOptions {
        allow_dtd: false,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options).map_err(|error| explain(&error, text, kind))
}

/// Refuses tags with too many attributes, whose comparison would take long.
fn guard(text: &str) -> Result<(), Diagnostic> {
    let bytes = text.as_bytes();
    let (mut start, mut equals) = (None, 0);
    for (at, &byte) in bytes.iter().enumerate() {
        match byte {
            b'<' => {
                // Comments may hold any number of them.
                start = (bytes.get(at + 1) != Some(&b'!')).then_some(at);
                equals = 0;
            }
            b'>' => start = None,
            b'=' => equals += 1,
            _ => {}
        }
        if let Some(start) = start
            && equals > ATTRIBUTE_LIMIT
        {
            return Err(diagnostic(
                start..start + 1,
                "a tag has too many attributes",
                &format!("more than {ATTRIBUTE_LIMIT}"),
                "no element of a model has more than eight; check that it is the right file",
            ));
        }
    }
    Ok(())
}

fn explain(error: &Error, text: &str, kind: &DocumentKind) -> Diagnostic {
    let position = error.pos();
    let at = byte_at(text, position);
    let end = text.trim_end().len();
    let cut = |label: &str| {
        diagnostic(
            end..end,
            "the file is cut short",
            label,
            &format!("copy or save it again: a model ends with `{}`", kind.last),
        )
    };
    match error {
        Error::DtdDetected => {
            let start = text.find("<!DOCTYPE");
            let start = start.expect("a document type has its mark");
            diagnostic(
                start..(start + 9).min(text.len()),
                "a model has no document type",
                "refused, together with the entities it may define",
                "remove the declaration, and write out the entities it defines",
            )
        }
        Error::UnclosedRootNode | Error::UnexpectedEndOfStream => cut("an element is still open"),
        Error::NoRootNode => diagnostic(
            end..end,
            "there is no element in the file",
            "there is no XML before this place",
            kind.first,
        ),
        _ if at >= end => cut("it ends inside a tag"),
        Error::UnexpectedCloseTag(open, close, _) => diagnostic(
            close_tag(text, at),
            "an element is closed that is not the open one",
            &format!("closes `{}` where `{}` is open", clip(close), clip(open)),
            &format!("close `{}` first, or correct the name", clip(open)),
        ),
        Error::UnknownEntityReference(name, _) => diagnostic(
            at..at + 1,
            &format!("there is no entity '{}'", clip(name)),
            "not one of &lt; &gt; &amp; &quot; &apos;",
            "write `&amp;` where the sign & is meant",
        ),
        Error::MalformedEntityReference(_) => diagnostic(
            at..at + 1,
            "the sign & begins an entity, but none follows",
            "here",
            "write `&amp;` where the sign & is meant",
        ),
        other => {
            let reason = other.to_string();
            let reason = reason.split(" at ").next();
            let reason = reason.expect("a text has a first part");
            diagnostic(
                at..after(text, at),
                "this is not XML",
                &clip(reason),
                kind.what,
            )
        }
    }
}

/// The closing tag at or just before a byte.
fn close_tag(text: &str, at: usize) -> Range<usize> {
    let start = if text[at..].starts_with("</") {
        at
    } else {
        text[..at].rfind("</").unwrap_or(at)
    };
    let length = text[start..].find('>').map_or(1, |length| length + 1);
    start..start + length
}

/// The end of the character at a byte.
fn after(text: &str, at: usize) -> usize {
    text.ceil_char_boundary(at + 1)
}

/// The byte of a line and a column (in characters), both from 1.
fn byte_at(text: &str, position: TextPos) -> usize {
    let before = (position.row as usize).saturating_sub(1);
    let lines = text.split_inclusive('\n').take(before);
    let start: usize = lines.map(str::len).sum();
    let column = (position.col as usize).saturating_sub(1);
    let characters = text[start..].chars().take(column);
    start + characters.map(char::len_utf8).sum::<usize>()
}
