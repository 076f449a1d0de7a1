//! Names that C accepts, each for one thing only.

use hashbrown::{HashMap, HashSet};
use robovec_ir::{Array, Value, View};
use rustc_hash::FxBuildHasher;

/// Words that C reserves, and functions that generated code calls or the
/// standard library would confuse with ours.
const RESERVED: [&str; 44] = [
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else",
    "enum", "extern", "float", "for", "goto", "if", "inline", "int", "long", "register",
    "restrict", "return", "short", "signed", "sizeof", "static", "struct", "switch", "typedef",
    "union", "unsigned", "void", "volatile", "while", "main", "sin", "cos", "sqrt", "asm",
    "typeof", "INFINITY", "NAN", "bool", "NULL",
];

/// Further words of text that calls `sqrtf`.
const ROOT: [&str; 1] = ["sqrtf"];

/// The prefix of the names of the library that generated files bring.
const OWN_PREFIX: &str = "robovec_";

/// The names in use.
#[derive(Clone)]
pub(crate) struct CNames {
    taken: HashSet<String, FxBuildHasher>,
    /// For names requested again the number that was tried last.
    numbers: HashMap<String, u32, FxBuildHasher>,
    /// Prefix of names that do not begin with a letter.
    first: &'static str,
    /// True when names with [`OWN_PREFIX`] are left to the text itself.
    keeps_prefix: bool,
}

impl CNames {
    /// The names of text that has no words but those of C.
    pub(crate) fn new() -> CNames {
        CNames::without(&ROOT, "v", false)
    }

    /// The names of text that has its own words, and types and functions
    /// that begin with `robovec_`.
    pub(crate) fn beside(words: &[&str]) -> CNames {
        CNames::without(words, "v_", true)
    }

    /// The names of another language with some reserved words, which is not
    /// given words of C either.
    pub(crate) fn reserving(words: &[String]) -> CNames {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        CNames::without(&words, "v", false)
    }

    fn without(words: &[&str], first: &'static str, keeps_prefix: bool) -> CNames {
        let taken = RESERVED.iter().chain(words);
        CNames {
            taken: taken.map(|&word| word.to_owned()).collect(),
            numbers: HashMap::default(),
            first,
            keeps_prefix,
        }
    }

    /// True for a word that C does not reserve.
    pub(crate) fn is_free(word: &str) -> bool {
        !RESERVED.contains(&word) && !ROOT.contains(&word)
    }

    /// A free name similar to the wanted one.
    pub(crate) fn take(&mut self, wanted: &str) -> String {
        let mut name = wanted.replace(|letter: char| !is_word_letter(letter), "_");
        let is_ours = self.keeps_prefix && name.starts_with(OWN_PREFIX);
        if is_ours || !name.starts_with(|first: char| first.is_ascii_alphabetic()) {
            name.insert_str(0, self.first);
        }
        if self.taken.contains(&name) {
            let number = self.numbers.entry(name.clone()).or_default();
            loop {
                *number += 1;
                let numbered = format!("{name}_{number}");
                if !self.taken.contains(&numbered) {
                    name = numbered;
                    break;
                }
            }
        }
        self.taken.insert(name.clone());
        name
    }
}

impl CNames {
    /// Names of arrays, in order.
    pub(crate) fn take_arrays(&mut self, view: View<'_>, arrays: &[Array]) -> Vec<String> {
        let names = arrays
            .iter()
            .map(|array| view.tables.symbols.text(array.name));
        names.map(|name| self.take(name)).collect()
    }

    /// The name of the variable of a value.
    pub(crate) fn take_value(&mut self, view: View<'_>, value: Value) -> String {
        self.take(&CNames::value(view, value))
    }

    /// The name that is wanted for a value.
    pub(crate) fn value(view: View<'_>, value: Value) -> String {
        let name = view.function.node(value).name;
        if name.is_none() {
            format!("inner_{}", value.0)
        } else {
            name.display(&view.tables.symbols).to_string()
        }
    }
}

/// True for letters, digits and `_`.
pub(crate) fn is_word_letter(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || letter == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_valid_and_new() {
        let mut names = CNames::new();
        let taken = ["OM16.1", "OM16_1", "OM16_1", "int", "1a", "été", ""].map(|n| names.take(n));
        assert_eq!(
            taken,
            [
                "OM16_1", "OM16_1_1", "OM16_1_2", "int_1", "v1a", "v_t_", "v"
            ]
        );
    }

    #[test]
    fn words_of_the_text_are_left_to_it() {
        let mut names = CNames::beside(&["work"]);
        let taken = ["OM16.1", "OM16_1", "work", "1a", "robovec_d8", ""].map(|n| names.take(n));
        let expected = ["OM16_1", "OM16_1_1", "work_1", "v_1a", "v_robovec_d8", "v_"];
        assert_eq!(taken, expected);
    }
}
