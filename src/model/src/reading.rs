//! From a file to a model with its warnings, or to the errors in it.

use super::Model;
use super::xml::{DocumentKind, Messages, decode, parse};
use robovec_ir::diagnostic::{Diagnostic, Report};
use robovec_robotran::FunctionKind;
use roxmltree::Document;
use std::fmt;

/// A model that was read.
#[derive(Debug)]
pub struct ReadModel {
    /// The model.
    pub model: Model,
    /// Warnings, with the text they are about.
    pub warnings: Report,
    /// Warnings about elements that no generated function contains: each
    /// `link3D`, or force of a robot, with its place.
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

/// Reads a file of a kind; `model` makes a model of it, or none and errors.
pub(crate) fn read_model(
    (name, bytes): (&str, &[u8]),
    kind: &DocumentKind,
    model: impl FnOnce(&Document<'_>, &mut Messages) -> Option<Model>,
) -> Result<ReadModel, ModelError> {
    let text = decode(bytes).map_err(|mut error| {
        // There is no text to point into, so the message names the file.
        error.message = format!("{name}: {}", error.message);
        ModelError {
            report: Report::of(name, "", vec![error]),
        }
    })?;
    let mut messages = Messages::default();
    let model = parse(&text, kind)
        .map_err(|error| messages.push_error(error))
        .ok()
        .and_then(|document| model(&document, &mut messages));
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
