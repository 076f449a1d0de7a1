//! Templates of generated files: text in which words are between two `@`.

use std::fmt::{Display, Write};

/// A template with values instead of its words. A `@` that is not part of a
/// word stays.
///
/// # Panics
///
/// Panics when the template has a word without a value.
pub fn fill(template: &str, words: &[(&str, &dyn Display)]) -> String {
    let mut parts = template.split('@');
    let text = parts.next().expect("a text has a first part");
    let mut text = text.to_owned();
    while let Some(part) = parts.next() {
        if let Some((_, value)) = words.iter().find(|(word, _)| *word == part) {
            // Writing to a string cannot fail.
            let _ = write!(text, "{value}");
            text += parts.next().expect("a word ends in '@'");
        } else {
            let is_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
            assert!(
                part.is_empty() || !part.chars().all(is_word),
                "the template has a value for '{part}'"
            );
            text.push('@');
            text += part;
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::fill;

    #[test]
    fn words_have_values_and_other_signs_stay() {
        let text = fill("@a@b@b@ always @(x) @* @a@", &[("a", &1), ("b", &"@a@")]);
        assert_eq!(text, "1b@a@ always @(x) @* 1");
    }

    #[test]
    #[should_panic(expected = "a value for 'missing'")]
    fn a_word_without_a_value_stops() {
        fill("@missing@", &[]);
    }
}
