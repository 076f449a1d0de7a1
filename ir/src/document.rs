//! TOML documents as values.

use robovec_num::decimal;
use serde::de::DeserializeOwned;
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// The reason why a text is no document of a kind.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct DocumentError {
    /// The message for the user.
    pub message: String,
    /// Its place in the text, when it has one.
    pub span: Option<Range<usize>>,
}

/// Reads a document.
///
/// # Errors
///
/// The first place that is no TOML, does not fit the type, or is a number that
/// binary64 would make 0.
pub fn read<T: DeserializeOwned>(text: &str) -> Result<T, DocumentError> {
    let value = toml::from_str(text).map_err(|error| DocumentError {
        message: error.message().to_owned(),
        span: error.span(),
    })?;
    match lost_number(text) {
        None => Ok(value),
        Some(span) => Err(DocumentError {
            message: format!("{} is too small: {}", &text[span.clone()], decimal::LOST),
            span: Some(span),
        }),
    }
}

/// The first number of a text that is lost in binary64.
fn lost_number(text: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let mut lost: Option<Range<usize>> = None;
    let mut tables = vec![document.get_ref()];
    let mut lists = Vec::new();
    loop {
        let values: Vec<_> = match (tables.pop(), lists.pop()) {
            (None, None) => return lost,
            (table, list) => {
                let table = table
                    .into_iter()
                    .flat_map(|table: &DeTable<'_>| table.values());
                let list: Option<&toml::de::DeArray<'_>> = list;
                table
                    .chain(list.into_iter().flat_map(|list| list.iter()))
                    .collect()
            }
        };
        for value in values {
            match value.get_ref() {
                DeValue::Table(table) => tables.push(table),
                DeValue::Array(list) => lists.push(list),
                DeValue::Float(float) => {
                    let text = float.as_str();
                    let number = text.parse().unwrap_or(f64::NAN);
                    let is_first = lost
                        .as_ref()
                        .is_none_or(|lost| value.span().start < lost.start);
                    if decimal::is_lost(text, number) && is_first {
                        lost = Some(value.span());
                    }
                }
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_vanish_are_refused_wherever_they_are() {
        for text in [
            "a = 1e-400",
            "b = [0.0, [1e-999]]",
            "[[c]]\nd = { e = -1e-400 }",
        ] {
            let error = read::<toml::Table>(text).expect_err("it is lost");
            let span = error.span.expect("it has a place");
            assert!(text[span].contains("e-"), "{text}");
        }
        assert!(read::<toml::Table>("a = 0.0e-400\nb = 1e-300\nc = \"1e-400\"").is_ok());
    }
}
