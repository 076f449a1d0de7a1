//! Which value bears a name, for the function being read.
//!
//! Names derived from one symbol are numbered almost without gaps, so their
//! values stand in a vector per symbol; only numbers far beyond the rest go
//! through a hash map. Entries carry the number of the function they were
//! made for, so that starting the next function costs nothing.

use crate::entity::Value;
use crate::symbol::{Name, Symbol};
use hashbrown::HashMap;
use rustc_hash::FxBuildHasher;

const ABSENT: u32 = u32::MAX;

#[derive(Clone, Default)]
struct Entry {
    function: u32,
    /// Values by number; `ABSENT` where no value bears the name.
    values: Vec<u32>,
}

/// The names of one function at a time.
#[derive(Default)]
pub(super) struct NameTable {
    function: u32,
    entries: Vec<Entry>,
    sparse: HashMap<Name, u32, FxBuildHasher>,
}

impl NameTable {
    /// Forgets all names.
    pub(super) fn clear(&mut self) {
        self.function += 1;
        self.sparse.clear();
    }

    /// The value that bears a name.
    pub(super) fn get(&self, name: Name) -> Option<Value> {
        let entry = self.entries.get(name.base.index())?;
        if entry.function != self.function {
            return None;
        }
        let value = match entry.values.get(name.suffix as usize) {
            Some(&value) if value != ABSENT => value,
            Some(_) | None => *self.sparse.get(&name)?,
        };
        Some(Value(value))
    }

    /// The last value, in program order, whose name derives from a symbol.
    pub(super) fn last_of(&self, base: Symbol) -> Option<Value> {
        let entry = self.entries.get(base.index())?;
        let values = entry.values.iter().filter(|&&value| value != ABSENT);
        let current = entry.function == self.function;
        values.max().filter(|_| current).map(|&value| Value(value))
    }

    /// Makes a value the bearer of a name.
    pub(super) fn set(&mut self, name: Name, value: Value) {
        let index = name.base.index();
        if index >= self.entries.len() {
            let grown = (index + 1).max(2 * self.entries.len());
            self.entries.resize(grown, Entry::default());
        }
        let entry = &mut self.entries[index];
        if entry.function != self.function {
            entry.function = self.function;
            entry.values.clear();
        }
        let suffix = name.suffix as usize;
        if suffix > 2 * entry.values.len() + 16 {
            self.sparse.insert(name, value.0);
            return;
        }
        if suffix >= entry.values.len() {
            entry.values.resize(suffix + 1, ABSENT);
        }
        entry.values[suffix] = value.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dense_and_sparse_names_are_found_and_forgotten() {
        let mut names = NameTable::default();
        names.clear();
        let base = Symbol(3);
        let numbers = [0, 5, 1_000_000, 2, 40, 999_999_999];
        for (value, suffix) in numbers.into_iter().enumerate() {
            names.set(Name { base, suffix }, Value(value as u32));
        }
        for (value, suffix) in numbers.into_iter().enumerate() {
            assert_eq!(names.get(Name { base, suffix }), Some(Value(value as u32)));
        }
        assert_eq!(names.get(Name { base, suffix: 1 }), None);
        names.clear();
        assert_eq!(names.get(Name::plain(base)), None);
        assert_eq!(names.last_of(base), None);
    }
}
