//! Texts of a page, each kept once.

use std::collections::BTreeMap;

/// Texts by number, in order of their first use.
#[derive(Default)]
pub(super) struct TextTable {
    numbers: BTreeMap<String, u32>,
}

impl TextTable {
    pub(super) fn number(&mut self, text: &str) -> u32 {
        if let Some(&number) = self.numbers.get(text) {
            return number;
        }
        let number = self.numbers.len() as u32;
        self.numbers.insert(text.to_owned(), number);
        number
    }

    /// All texts, by their numbers.
    pub(super) fn into_texts(self) -> Vec<String> {
        let mut texts = vec![String::new(); self.numbers.len()];
        for (text, number) in self.numbers {
            texts[number as usize] = text;
        }
        texts
    }
}
