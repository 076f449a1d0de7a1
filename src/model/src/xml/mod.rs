//! Common parts of the readers of models in XML: from bytes to a tree of
//! elements ([`document`]), and messages about places in it ([`messages`]).

mod document;
mod messages;
mod number;

pub(crate) use document::{DocumentKind, decode, parse};
pub(crate) use messages::{Messages, content, diagnostic, place, second};
pub(crate) use number::{NUMBER, parse_number};
