//! The reader and the writer of `.mbs` files, the XML in which Robotran's
//! editor keeps a model.
//!
//! A file passes through [`super::xml`] (bytes to a tree, with guards against
//! hostile files), [`fields`] (the fields of an element, and messages about
//! others), [`bodies`] with [`joints`], [`points`] and [`tree`], [`ends`] (cuts
//! and links) and [`user`] (user models); [`scope`] resolves the names.
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
mod number;
mod points;
mod scope;
mod tree;
mod user;
mod write;

use super::{Model, physics, xml};
use robovec_ir::diagnostic::{Diagnostic, Report};
use robovec_num::limits::NumberLimit;
use robovec_robotran::FunctionKind;
use robovec_robotran::conventions::JOINTS;
use std::fmt;

pub use write::{unsayable, write_mbs};

/// The limits of a model: name, limit, and what it is when the model does not
/// state.
pub const FIELDS: &[(&str, NumberLimit, &str)] =
    &[("joint", JOINTS, ""), ("any number", xml::NUMBER, "0")];

/// Description of a `.mbs` file, for messages.
const KIND: xml::DocumentKind = xml::DocumentKind {
    last: "</mbsDescR7>",
    what: "a model is a `.mbs` file as Robotran's editor saves it",
    first: "a model is a `.mbs` file, whose first element is `<mbsDescR7>`",
};

/// A model that was read.
#[derive(Debug)]
pub struct ReadModel {
    /// The model.
    pub model: Model,
    /// Warnings, with the text they are about.
    pub warnings: Report,
    /// Warnings about elements of the model that no generated function
    /// contains: one for each `link3D`, with its place. They concern the
    /// generation of equations, not the inspection of a model.
    pub left_out: Report,
}

impl ReadModel {
    /// All warnings that concern this function of the model: those about the
    /// model, and those about forces that the function's result lacks.
    pub fn warnings_for(&self, function: FunctionKind) -> Report {
        let mut warnings = self.warnings.clone();
        if function.depends_on_link_forces() && !self.left_out.is_empty() {
            // Both point into the same text; without warnings it is not kept.
            if warnings.is_empty() {
                warnings = self.left_out.clone();
            } else {
                warnings.extend(self.left_out.diagnostics().iter().cloned());
            }
        }
        if function.depends_on_link_forces() {
            warnings.extend(self.losses());
        }
        warnings
    }

    /// A warning about joints whose own forces are in no equation.
    fn losses(&self) -> Option<Diagnostic> {
        let joints = self.model.joints.iter();
        let losing: Vec<&str> = joints
            .filter(|joint| joint.law.are_there())
            .map(|joint| joint.name.as_str())
            .collect();
        let first = losing.first()?;
        let message = format!(
            "damping, friction and springs of {} joint(s), including '{first}', are in no equation",
            losing.len()
        );
        let note = "'robovec sim' uses them as laws; in equations, add them to the forces of \
                    joints";
        Some(Diagnostic::warning().with_message(message).with_note(note))
    }
}

/// A file that could not be read: the reasons, and the text they point into.
#[derive(Debug)]
pub struct ModelError {
    /// One to twenty errors, perhaps with warnings.
    pub report: Report,
}

impl fmt::Display for ModelError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.report.summary())
    }
}

impl std::error::Error for ModelError {}

/// Reads a `.mbs` file. The name serves messages, and names a model that has
/// no name.
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
    let text = xml::decode(bytes).map_err(|mut error| {
        // There is no text to point into, so the message names the file.
        error.message = format!("{name}: {}", error.message);
        ModelError {
            report: Report::of(name, "", vec![error]),
        }
    })?;
    let mut messages = fields::Messages::default();
    let model = xml::parse(&text, &KIND)
        .map_err(|error| messages.push_error(error))
        .ok()
        .and_then(|document| read_document(name, &document, &mut messages));
    match model {
        Some(model) if !messages.has_errors() => {
            let left_out = messages.take_left_out();
            let warnings = messages.into_diagnostics();
            let report = |diagnostics: Vec<_>| {
                let shown = if diagnostics.is_empty() { "" } else { &text };
                Report::of(name, shown, diagnostics)
            };
            Ok(ReadModel {
                model,
                warnings: report(warnings),
                left_out: report(left_out),
            })
        }
        _ => Err(ModelError {
            report: Report::of(name, text.as_ref(), messages.into_diagnostics()),
        }),
    }
}

/// The model of a document; `None`, with errors among the messages, when
/// there is none.
fn read_document(
    name: &str,
    document: &roxmltree::Document<'_>,
    messages: &mut fields::Messages,
) -> Option<Model> {
    let root = fields::ElementFields::of_root(document.root_element(), messages)?;
    let mut model = Model::new(&fields::project_name(&root, name, messages));
    let scope = bodies::read(&root, &mut model, messages)?;
    ends::read(&root, &scope, &mut model, messages);
    user::read(&root, &mut model, messages);
    if messages.has_errors() {
        return None;
    }
    physics::remark(&model, &scope.body_places, messages);
    debug_assert!(model.check(), "the reader upholds the invariants");
    Some(model)
}

#[cfg(test)]
mod tests;
