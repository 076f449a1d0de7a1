//! Common parts of the readers of models in XML: from bytes to a tree of
//! elements ([`document`]), and messages about places in it ([`messages`]).

mod document;
mod messages;

pub(crate) use document::{DocumentKind, decode, parse};
pub(crate) use messages::{Messages, NUMBER, content, diagnostic, parse_number, place, second};

/// True for a valid name of a model: it becomes part of file names.
pub(crate) fn is_usable(name: &str) -> bool {
    !name.is_empty() && !name.contains(|c: char| matches!(c, '/' | '\\') || c.is_control())
}

/// The name of a model that has none: that of its file, without its ending.
pub(crate) fn stem<'a>(file: &'a str, ending: &str, otherwise: &'a str) -> &'a str {
    let stem = file.strip_suffix(ending).unwrap_or(file).trim();
    if is_usable(stem) { stem } else { otherwise }
}
