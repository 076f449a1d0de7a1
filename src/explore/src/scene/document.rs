//! A scene file as TOML with the places of keys and values, and its messages.

use robovec_ir::diagnostic::{Diagnostic, Label, clip, suggestion};
use robovec_num::decimal;
use robovec_num::limits::{Amount, NumberLimit};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// A range of bytes of the file.
pub(super) type DocumentRange = Range<usize>;

pub(super) type DocumentTable<'t> = DeTable<'t>;

/// A value with its place.
pub(super) type DocumentValue<'t> = Spanned<DeValue<'t>>;

/// The maximum number of messages about one file.
const MAX_PROBLEMS: usize = 20;

/// Message and advice about a word that is not allowed at its place.
pub(super) struct WordProblem {
    pub(super) message: String,
    pub(super) notes: Vec<String>,
}

impl WordProblem {
    /// A word that is none of those allowed at its place.
    pub(super) fn unknown(what: &str, word: &str, known: &[&str]) -> WordProblem {
        let near = suggestion(word, known.iter().copied());
        let mut problem = WordProblem {
            message: format!("{what} '{}'", clip(word)),
            notes: near.into_iter().collect(),
        };
        if !known.is_empty() && known.len() <= 40 {
            problem.notes.push(format!("known: {}", known.join(", ")));
        }
        problem
    }
}

impl From<String> for WordProblem {
    fn from(message: String) -> WordProblem {
        let notes = Vec::new();
        WordProblem { message, notes }
    }
}

/// Collects the faults of a file.
#[derive(Default)]
pub(super) struct DocumentProblems {
    list: Vec<Diagnostic>,
}

impl DocumentProblems {
    /// Adds an error at a place.
    pub(super) fn add(&mut self, span: DocumentRange, message: impl Into<String>) {
        self.advise(span, message, None);
    }

    /// As [`DocumentProblems::add`]; there is no value then.
    pub(super) fn refuse<T>(
        &mut self,
        span: DocumentRange,
        message: impl Into<String>,
    ) -> Option<T> {
        self.add(span, message);
        None
    }

    /// As [`DocumentProblems::add`], with a remedy.
    pub(super) fn advise(
        &mut self,
        span: DocumentRange,
        message: impl Into<String>,
        note: Option<String>,
    ) {
        self.point(span, message, note, None);
    }

    /// As [`DocumentProblems::advise`], with a related earlier place.
    pub(super) fn point(
        &mut self,
        span: DocumentRange,
        message: impl Into<String>,
        note: Option<String>,
        other: Option<(DocumentRange, &str)>,
    ) {
        let mut labels = vec![Label::primary(0, span)];
        labels.extend(other.map(|(span, text)| Label::secondary(0, span).with_message(text)));
        self.list.push(
            Diagnostic::error()
                .with_message(message.into())
                .with_labels(labels)
                .with_notes(note.into_iter().collect()),
        );
    }

    /// A word that is none of those allowed at its place.
    pub(super) fn unknown(&mut self, span: DocumentRange, what: &str, word: &str, known: &[&str]) {
        let problem = WordProblem::unknown(what, word, known);
        self.take::<()>(&span, Err(problem));
    }

    /// The value of a word, or none and a message.
    pub(super) fn take<T>(
        &mut self,
        span: &DocumentRange,
        read: Result<T, WordProblem>,
    ) -> Option<T> {
        let report = |WordProblem { message, notes }| {
            let error = Diagnostic::error().with_message(message);
            let labels = vec![Label::primary(0, span.clone())];
            self.list.push(error.with_labels(labels).with_notes(notes));
        };
        read.map_err(report).ok()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The messages, in the order of the file.
    pub(super) fn into_diagnostics(mut self) -> Vec<Diagnostic> {
        self.list
            .sort_by_key(|diagnostic| diagnostic.labels.first().map(|label| label.range.start));
        self.list.truncate(MAX_PROBLEMS);
        self.list
    }
}

pub(super) fn parse(text: &str) -> Result<Spanned<DocumentTable<'_>>, Diagnostic> {
    DeTable::parse(text).map_err(|error| {
        Diagnostic::error()
            .with_message(error.message().to_owned())
            .with_labels(vec![Label::primary(0, error.span().unwrap_or(0..0))])
            .with_note("a scene is a TOML file; see docs/scenes.md")
    })
}

/// Reports keys that a table does not have.
pub(super) fn only_keys(
    table: &DocumentTable<'_>,
    known: &[&str],
    problems: &mut DocumentProblems,
) {
    for key in table.keys() {
        let word = key.get_ref().as_ref();
        if !known.contains(&word) {
            problems.unknown(key.span(), "there is no key", word, known);
        }
    }
}

pub(super) fn get<'a, 't>(
    table: &'a DocumentTable<'t>,
    key: &str,
) -> Option<&'a DocumentValue<'t>> {
    let found = table
        .iter()
        .find(|(name, _)| name.get_ref().as_ref() == key);
    found.map(|(_, value)| value)
}

/// A finite number.
pub(super) fn number(value: &DocumentValue<'_>, problems: &mut DocumentProblems) -> Option<f64> {
    let number = match value.get_ref() {
        DeValue::Integer(integer) => match integer.radix() {
            10 => integer.as_str().parse::<f64>().ok(),
            radix => i64::from_str_radix(integer.as_str(), radix)
                .ok()
                .map(|integer| integer as f64),
        },
        DeValue::Float(float) => {
            let text = float.as_str();
            let number = text.parse().ok();
            if number.is_some_and(|number| decimal::is_lost(text, number)) {
                let message = format!("{text} is too small: {}", decimal::LOST);
                return problems.refuse(value.span(), message);
            }
            number
        }
        other => {
            let found = other.type_str();
            return problems.refuse(value.span(), format!("expected a number, not a {found}"));
        }
    };
    let finite = number.filter(|number| number.is_finite());
    if finite.is_none() {
        problems.add(value.span(), "this is not a finite number");
    }
    finite
}

pub(super) fn limited(
    value: &DocumentValue<'_>,
    (name, limit): (&str, NumberLimit),
    problems: &mut DocumentProblems,
) -> Option<f64> {
    let number = number(value, problems)?;
    match limit.check(Amount::Real(number)) {
        Ok(()) => Some(number),
        Err(reason) => problems.refuse(value.span(), format!("'{name}': {reason}")),
    }
}

pub(super) fn string<'a>(
    value: &'a DocumentValue<'_>,
    problems: &mut DocumentProblems,
) -> Option<&'a str> {
    if let DeValue::String(text) = value.get_ref() {
        return Some(text.as_ref());
    }
    let found = value.get_ref().type_str();
    problems.refuse(value.span(), format!("expected a text, not a {found}"))
}

pub(super) fn table<'a, 't>(
    value: &'a DocumentValue<'t>,
    problems: &mut DocumentProblems,
) -> Option<&'a DocumentTable<'t>> {
    if let DeValue::Table(table) = value.get_ref() {
        return Some(table);
    }
    let found = value.get_ref().type_str();
    problems.refuse(value.span(), format!("expected a table, not a {found}"))
}

pub(super) fn array<'a, 't>(
    value: &'a DocumentValue<'t>,
    problems: &mut DocumentProblems,
) -> Option<&'a DeArray<'t>> {
    if let DeValue::Array(list) = value.get_ref() {
        return Some(list);
    }
    let found = value.get_ref().type_str();
    problems.refuse(value.span(), format!("expected a list, not a {found}"))
}

/// A list of texts, or a single one.
pub(super) fn strings<'a>(
    value: &'a DocumentValue<'_>,
    problems: &mut DocumentProblems,
) -> Vec<(&'a str, DocumentRange)> {
    if let DeValue::String(text) = value.get_ref() {
        return vec![(text.as_ref(), value.span())];
    }
    let list = array(value, problems).map_or(&[][..], |list| list.as_ref());
    list.iter()
        .filter_map(|item| Some((string(item, problems)?, item.span())))
        .collect()
}
