//! The reader and the writer of `.mbs` files, the XML of Robotran's editor.
//!
//! A file passes through [`super::xml`] (bytes to a tree, with guards against
//! hostile files), [`fields`] (the fields of an element, and messages about
//! others), [`bodies`] with [`joints`] and [`points`], and [`ends`] (cuts,
//! links and user models); [`scope`] resolves the names.
//! Drawings are passed over. [`write_mbs`] gives the canonical text.
//!
//! **Invariants.** A model that is returned upholds
//! [`Model::check`](super::Model::check); a file with any error returns none.
//! Elements that the reader skips without a request get a warning: a misspelt
//! one would otherwise be a parameter that silently remains zero.

mod bodies;
mod ends;
mod fields;
mod joints;
mod points;
mod scope;
mod write;

use super::{Model, physics, reading, xml};
use robovec_num::limits::NumberLimit;
use robovec_robotran::conventions::JOINTS;

pub use super::reading::{ModelError, ReadModel};
pub use write::{unsayable, write_mbs};

/// The limits of a model: name, limit, and the default.
pub const FIELDS: &[(&str, NumberLimit, &str)] =
    &[("joint", JOINTS, ""), ("any number", xml::NUMBER, "0")];

/// Description of a `.mbs` file, for messages.
const KIND: xml::DocumentKind = xml::DocumentKind {
    last: "</mbsDescR7>",
    what: "a model is a `.mbs` file as Robotran's editor saves it",
    first: "a model is a `.mbs` file, whose first element is `<mbsDescR7>`",
};

/// Reads a `.mbs` file; `name` is for messages and for a model without one.
///
/// # Errors
///
/// Everything that keeps the file from being a model, each with its place and
/// the body, joint and point it is about: text that is not XML or is cut
/// short, document types and entities, unknown or repeated names, a parent
/// that is declared later or on a cycle, numbers that are none, a body without
/// joint or without the mass its inertia needs, more than
/// [`JOINT_LIMIT`](robovec_robotran::conventions::JOINT_LIMIT) joints.
pub fn read_mbs(name: &str, bytes: &[u8]) -> Result<ReadModel, ModelError> {
    reading::read_model((name, bytes), &KIND, |document, messages| {
        read_document(name, document, messages)
    })
}

/// The model of a document; `None` with errors among the messages.
fn read_document(
    name: &str,
    document: &roxmltree::Document<'_>,
    messages: &mut fields::Messages,
) -> Option<Model> {
    let root = fields::ElementFields::of_root(document.root_element(), messages)?;
    let mut model = Model::new(&fields::project_name(&root, name, messages));
    let scope = bodies::read(&root, &mut model, messages)?;
    ends::read(&root, &scope, &mut model, messages);
    ends::read_user_models(&root, &mut model, messages);
    if messages.has_errors() {
        return None;
    }
    physics::remark(&model, &scope.body_places, messages);
    debug_assert!(model.check(), "the reader upholds the invariants");
    Some(model)
}

#[cfg(test)]
mod tests;
