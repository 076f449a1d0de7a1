//! The notes of a pass about the values it makes, while it runs.

use hashbrown::HashMap;
use robovec_ir::Name;
use rustc_hash::FxBuildHasher;

/// The rules a running pass applied, value by value.
///
/// Notes are kept only if they were [wanted](Notes::wanted) from the start;
/// otherwise a note costs one comparison.
#[derive(Clone, Default, Debug)]
pub struct Notes {
    wanted: bool,
    rules: Vec<String>,
    rule_index: HashMap<String, u32, FxBuildHasher>,
    /// The rules that made a value, in order of the notes.
    made_by: HashMap<Name, Vec<u32>, FxBuildHasher>,
}

impl Notes {
    /// Notes that are thrown away.
    pub fn unwanted() -> Notes {
        Notes::default()
    }

    /// Notes that are kept.
    pub fn wanted() -> Notes {
        Notes {
            wanted: true,
            ..Notes::default()
        }
    }

    /// Tests whether notes are read: call it before making a text only for a
    /// note.
    #[inline]
    pub fn are_wanted(&self) -> bool {
        self.wanted
    }

    /// The value that has this name after the pass was made by this rule.
    /// Several rules are kept in the order of the notes, each once.
    #[inline]
    pub fn note(&mut self, name: Name, rule: &str) {
        if self.wanted {
            self.keep(name, rule);
        }
    }

    fn keep(&mut self, name: Name, rule: &str) {
        let number = match self.rule_index.get(rule) {
            Some(&number) => number,
            None => {
                let number = self.rules.len() as u32;
                self.rules.push(rule.to_owned());
                self.rule_index.insert(rule.to_owned(), number);
                number
            }
        };
        let made_by = self.made_by.entry(name).or_default();
        if !made_by.contains(&number) {
            made_by.push(number);
        }
    }

    /// The rules noted for a value, in order.
    pub fn rules(&self, name: Name) -> impl Iterator<Item = &str> + '_ {
        let numbers = self.made_by.get(&name).map_or(&[][..], Vec::as_slice);
        numbers
            .iter()
            .map(|&number| self.rules[number as usize].as_str())
    }

    /// The first value, by its name, for which this rule was noted.
    pub(super) fn noted_with(&self, rule: &str) -> Option<Name> {
        let number = self.rule_index.get(rule)?;
        let noted = self.made_by.iter();
        let noted = noted.filter(|(_, rules)| rules.contains(number));
        noted.map(|(name, _)| *name).min()
    }
}

/// The rule noted for a value that took over another of this name (`%OM16`).
pub fn equal_to(name: &str) -> String {
    format!("equal to {name}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::Symbol;

    #[test]
    fn rules_are_kept_in_order_and_once_and_only_when_wanted() {
        let name = Name::plain(Symbol(3));
        let other = Name {
            base: Symbol(3),
            suffix: 1,
        };
        for (mut notes, expected) in [
            (Notes::wanted(), &["factor", "negate"][..]),
            (Notes::unwanted(), &[]),
        ] {
            for rule in ["factor", "negate", "factor"] {
                notes.note(name, rule);
            }
            assert_eq!(notes.rules(name).collect::<Vec<_>>(), expected);
            assert_eq!(notes.rules(other).count(), 0);
        }
    }
}
