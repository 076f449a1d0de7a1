//! The errors found so far: a bounded list.

use super::parts::Span;
use crate::diagnostic::{Diagnostic, Label};

/// The largest number of errors that are shown.
const MAX_SHOWN: usize = 20;

/// The first errors of a text.
#[derive(Default)]
pub(super) struct Problems {
    list: Vec<Diagnostic>,
}

impl Problems {
    /// Adds an error unless there are enough.
    pub(super) fn push(&mut self, diagnostic: Diagnostic) {
        if !self.is_full() {
            self.list.push(diagnostic);
        }
    }

    /// True when there are no errors.
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// True when further errors would not be shown: costly advice is not
    /// worth computing.
    pub(super) fn is_full(&self) -> bool {
        self.list.len() >= MAX_SHOWN
    }

    /// Their number.
    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// All of them in order of their place.
    pub(super) fn into_sorted(mut self) -> Vec<Diagnostic> {
        let full = self.is_full();
        self.list.sort_by_key(|diagnostic| {
            let starts = diagnostic.labels.iter().map(|label| label.range.start);
            // The first label is the primary one.
            starts.take(1).next()
        });
        if full {
            self.list.push(
                Diagnostic::note()
                    .with_message(format!("only the first {MAX_SHOWN} errors are shown")),
            );
        }
        self.list
    }
}

/// An error about a range of the text.
pub(super) fn error(span: Span, message: impl Into<String>) -> Diagnostic {
    Diagnostic::error()
        .with_message(message.into())
        .with_label(Label::primary(0, span.range()))
}

/// A second place an error refers to.
pub(super) fn also(span: Span, message: impl Into<String>) -> Label {
    Label::secondary(0, span.range()).with_message(message.into())
}
