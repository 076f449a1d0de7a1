//! Names that C accepts, each for one thing only.

use hashbrown::{HashMap, HashSet};
use rustc_hash::FxBuildHasher;

/// Words that C reserves, and functions that generated code calls or the
/// standard library would confuse with ours.
const RESERVED: [&str; 45] = [
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else",
    "enum", "extern", "float", "for", "goto", "if", "inline", "int", "long", "register",
    "restrict", "return", "short", "signed", "sizeof", "static", "struct", "switch", "typedef",
    "union", "unsigned", "void", "volatile", "while", "main", "sin", "cos", "sqrt", "sqrtf", "asm",
    "typeof", "INFINITY", "NAN", "bool", "NULL",
];

/// The names in use.
#[derive(Clone)]
pub(in crate::codegen) struct Names {
    taken: HashSet<String, FxBuildHasher>,
    /// For names asked for again the number that was tried last.
    numbers: HashMap<String, u32, FxBuildHasher>,
}

impl Names {
    pub(in crate::codegen) fn new() -> Names {
        Names {
            taken: RESERVED.iter().map(|&word| word.to_owned()).collect(),
            numbers: HashMap::default(),
        }
    }

    /// True for a word that C leaves to its users.
    pub(super) fn is_free(word: &str) -> bool {
        !RESERVED.contains(&word)
    }

    /// A name like the wanted one that nothing bears yet.
    pub(in crate::codegen) fn take(&mut self, wanted: &str) -> String {
        let mut name: String = wanted
            .chars()
            .map(|character| match character {
                'a'..='z' | 'A'..='Z' | '0'..='9' | '_' => character,
                _ => '_',
            })
            .collect();
        if !name.starts_with(|first: char| first.is_ascii_alphabetic()) {
            name.insert(0, 'v');
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_valid_and_new() {
        let mut names = Names::new();
        let taken = ["OM16.1", "OM16_1", "OM16_1", "int", "1a", "été", ""].map(|n| names.take(n));
        assert_eq!(
            taken,
            [
                "OM16_1", "OM16_1_1", "OM16_1_2", "int_1", "v1a", "v_t_", "v"
            ]
        );
    }
}
