//! Messages about a file of a model, and their places.

use robovec_ir::diagnostic::{Diagnostic, Label, clip};
use robovec_num::decimal::is_lost;
use robovec_num::limits::{Amount, NumberLimit};
use roxmltree::Node;
use std::ops::Range;

/// No more errors, and no more warnings, than this are reported for one file.
const LIMIT: usize = 20;

#[derive(Default)]
pub(crate) struct Messages {
    errors: Vec<Diagnostic>,
    warnings: Vec<Diagnostic>,
    more_warnings: usize,
    more_errors: bool,
    left_out: Vec<Diagnostic>,
    more_left_out: usize,
}

/// An error about a place of the text.
pub(crate) fn diagnostic(
    range: Range<usize>,
    message: &str,
    label: &str,
    help: &str,
) -> Diagnostic {
    Diagnostic::error()
        .with_message(message)
        .with_labels(vec![Label::primary(0, range).with_message(label)])
        .with_note(format!("help: {help}"))
}

/// An error about a repeated item.
pub(crate) fn second(
    message: &str,
    second: Range<usize>,
    first: Range<usize>,
    help: &str,
) -> Diagnostic {
    diagnostic(second, message, "the second one", help)
        .with_label(Label::secondary(0, first).with_message("the first one"))
}

impl Messages {
    pub(crate) fn push_error(&mut self, error: Diagnostic) {
        if self.errors.len() < LIMIT {
            self.errors.push(error);
        } else {
            self.more_errors = true;
        }
    }

    pub(crate) fn error(&mut self, range: Range<usize>, message: &str, label: &str, help: &str) {
        self.push_error(diagnostic(range, message, label, help));
    }

    pub(crate) fn warn(&mut self, range: Range<usize>, message: &str, label: &str, help: &str) {
        if self.warnings.len() < LIMIT {
            let mut warning = diagnostic(range, message, label, help);
            warning.severity = robovec_ir::diagnostic::Severity::Warning;
            self.warnings.push(warning);
        } else {
            self.more_warnings += 1;
        }
    }

    /// Adds a warning about an element that is read but is in no equation. Only
    /// a command that makes equations has reason to show it.
    pub(crate) fn leave_out(
        &mut self,
        range: Range<usize>,
        message: &str,
        label: &str,
        help: &str,
    ) {
        if self.left_out.len() < LIMIT {
            let mut warning = diagnostic(range, message, label, help);
            warning.severity = robovec_ir::diagnostic::Severity::Warning;
            self.left_out.push(warning);
        } else {
            self.more_left_out += 1;
        }
    }

    /// Separates the warnings about elements that no equation contains.
    pub(crate) fn take_left_out(&mut self) -> Vec<Diagnostic> {
        let mut all = std::mem::take(&mut self.left_out);
        if self.more_left_out > 0 {
            all.push(Diagnostic::note().with_message(format!(
                "{} more are left out and not shown",
                self.more_left_out
            )));
        }
        all
    }

    /// False when further errors are only counted, so that advice is useless.
    pub(crate) fn has_room(&self) -> bool {
        self.errors.len() < LIMIT
    }

    /// Counts an error beyond the limit of messages.
    pub(crate) fn count_error(&mut self) {
        self.more_errors = true;
    }

    pub(crate) fn has_errors(&self) -> bool {
        !self.errors.is_empty()
    }

    /// The errors, then the warnings.
    pub(crate) fn into_diagnostics(self) -> Vec<Diagnostic> {
        let mut all = self.errors;
        if self.more_errors {
            all.push(Diagnostic::note().with_message(format!(
                "reading stopped after {LIMIT} errors; there are more"
            )));
        }
        all.extend(self.warnings);
        if self.more_warnings > 0 {
            all.push(Diagnostic::note().with_message(format!(
                "{} more warnings are not shown",
                self.more_warnings
            )));
        }
        all
    }
}

/// Place of an element for a message: its text, or its opening tag.
pub(crate) fn place(node: Node<'_, '_>) -> Range<usize> {
    let text = node.children().find(|child| child.is_text());
    if let Some(text) = text
        && !node.children().any(|child| child.is_element())
        && let Some(content) = text.text().map(str::trim)
        && !content.is_empty()
    {
        let range = text.range();
        let source = &node.document().input_text()[range.clone()];
        let start = range.start + (source.len() - source.trim_start().len());
        return start..start + source.trim().len();
    }
    let start = node.range().start;
    let source = &node.document().input_text()[start..];
    let length = source.find(['>', ' ', '\n', '\r', '\t', '/']);
    start..start + length.expect("the tag of an element ends")
}

/// The text of an element, without the blanks around it.
pub(crate) fn content(node: Node<'_, '_>) -> String {
    let mut text = String::new();
    for piece in node.children().filter(|child| child.is_text()) {
        text.push_str(piece.text().expect("a text node has a text"));
    }
    text.trim().to_owned()
}

/// The numbers of a model, in SI units.
pub(crate) const NUMBER: NumberLimit = NumberLimit::real(
    -1e30,
    1e30,
    "products of such numbers must be numbers of binary64",
);

/// Reason why a text is no number of a model.
pub(crate) struct NumberRefusal {
    /// Fault, to follow the name of its subject.
    pub(crate) message: String,
    /// Label of the place.
    pub(crate) label: &'static str,
    /// Advice.
    pub(crate) help: &'static str,
}

/// The number that a text without surrounding blanks represents.
pub(crate) fn parse_number(text: &str) -> Result<f64, NumberRefusal> {
    let refused = |message: String, label, help| {
        Err(NumberRefusal {
            message,
            label,
            help,
        })
    };
    match text.parse::<f64>() {
        Ok(value) if is_lost(text, value) => refused(
            format!(" is too small: {}", clip(text)),
            "this value",
            "it would be read as 0",
        ),
        Ok(value) if NUMBER.admits(Amount::Real(value)) => Ok(value),
        Ok(value) if value.is_finite() => refused(
            format!(": {}", NUMBER.refusal(text)),
            "this value",
            "models are in SI units",
        ),
        Ok(value) => {
            let kind = if value.is_nan() {
                "not a number"
            } else {
                "not finite"
            };
            refused(
                format!(" is {kind}"),
                "this value",
                "write a finite number below 1.8e308",
            )
        }
        Err(_) if text.is_empty() => refused(
            " is empty".to_owned(),
            "no number",
            "write a number between the tags, or remove the element where it is zero",
        ),
        Err(_) => {
            let help = if text.replace(',', ".").parse::<f64>().is_ok() {
                "write a point instead of the comma"
            } else {
                "write a number such as 0.5 or -1.2e-3"
            };
            refused(
                format!(" is not a number: '{}'", clip(text)),
                "this value",
                help,
            )
        }
    }
}
