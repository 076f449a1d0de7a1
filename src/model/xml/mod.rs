//! What the readers of models in XML have in common: from bytes to a tree of
//! elements ([`document`]), and messages about places in it ([`messages`]).

mod document;
mod messages;
mod number;

pub(in crate::model) use document::{DocumentKind, decode, parse};
pub(in crate::model) use messages::{Messages, content, diagnostic, place, second};
pub(in crate::model) use number::parse_number;
