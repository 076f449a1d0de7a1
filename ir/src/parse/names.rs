//! The values by name, for the function being read.
//!
//! Names derived from one symbol are numbered almost without gaps, so their
//! values are in a vector per symbol; only numbers far beyond the rest go
//! through a hash map. Entries have the number of their function, so that
//! starting the next function costs nothing.

use crate::entity::{Operand, Value};
use crate::symbol::{Name, Symbol};
use hashbrown::HashMap;
use rustc_hash::FxBuildHasher;
use std::hash::BuildHasher;

/// Places of [`Recent`]; a power of two.
const RECENT: usize = 4096;

/// The values whose names were met last, by the text of the name: most
/// operands were defined a few lines above, and finding them here costs no
/// walk through tables that have outgrown the cache of the processor.
pub(super) struct Recent<'t> {
    function: u32,
    entries: Vec<RecentEntry<'t>>,
}

#[derive(Clone, Copy)]
struct RecentEntry<'t> {
    text: &'t str,
    value: Value,
    function: u32,
}

impl<'t> Recent<'t> {
    pub(super) fn new() -> Recent<'t> {
        let nothing = RecentEntry {
            text: "",
            value: Value(0),
            function: 0,
        };
        Recent {
            function: 0,
            entries: vec![nothing; RECENT],
        }
    }

    fn slot(text: &str) -> usize {
        FxBuildHasher.hash_one(text) as usize & (RECENT - 1)
    }

    /// Forgets all names.
    pub(super) fn clear(&mut self) {
        self.function += 1;
    }

    /// The value that has a name, if it was met not long ago.
    pub(super) fn get(&self, text: &str) -> Option<Value> {
        let entry = self.entries[Recent::slot(text)];
        (entry.function == self.function && entry.text == text).then_some(entry.value)
    }

    /// Makes a value the bearer of a name.
    pub(super) fn set(&mut self, text: &'t str, value: Value) {
        self.entries[Recent::slot(text)] = RecentEntry {
            text,
            value,
            function: self.function,
        };
    }
}

#[derive(Clone)]
struct NameEntry {
    function: u32,
    /// The value that has the symbol itself. Operands here are values or none,
    /// in half the memory of an `Option`.
    plain: Operand,
    /// Values by number, from 1.
    numbered: Vec<Operand>,
}

impl Default for NameEntry {
    fn default() -> NameEntry {
        NameEntry {
            function: 0,
            plain: Operand::NONE,
            numbered: Vec::new(),
        }
    }
}

/// The names of one function at a time.
#[derive(Default)]
pub(super) struct NameTable {
    function: u32,
    entries: Vec<NameEntry>,
    sparse: HashMap<Name, Value, FxBuildHasher>,
}

impl NameTable {
    /// Forgets all names.
    pub(super) fn clear(&mut self) {
        self.function += 1;
        self.sparse.clear();
    }

    /// The value that has a name.
    pub(super) fn get(&self, name: Name) -> Option<Value> {
        let entry = self.entries.get(name.base.index())?;
        if entry.function != self.function {
            return None;
        }
        let dense = match name.suffix {
            0 => entry.plain.value(),
            suffix => {
                let value = entry.numbered.get(suffix as usize - 1);
                value.and_then(|value| value.value())
            }
        };
        dense.or_else(|| self.sparse.get(&name).copied())
    }

    /// The last value, in program order, whose name derives from a symbol.
    pub(super) fn last_of(&self, base: Symbol) -> Option<Value> {
        let entry = self.entries.get(base.index())?;
        if entry.function != self.function {
            return None;
        }
        let all = entry.numbered.iter().chain([&entry.plain]);
        all.filter_map(|value| value.value()).max()
    }

    /// Makes a value the bearer of a name.
    pub(super) fn set(&mut self, name: Name, value: Value) {
        let index = name.base.index();
        if index >= self.entries.len() {
            let grown = (index + 1).max(2 * self.entries.len());
            self.entries.resize(grown, NameEntry::default());
        }
        let entry = &mut self.entries[index];
        if entry.function != self.function {
            entry.function = self.function;
            entry.plain = Operand::NONE;
            entry.numbered.clear();
        }
        let suffix = name.suffix as usize;
        if suffix == 0 {
            entry.plain = value.into();
        } else if suffix > 2 * entry.numbered.len() + 16 {
            self.sparse.insert(name, value);
        } else {
            if suffix > entry.numbered.len() {
                entry.numbered.resize(suffix, Operand::NONE);
            }
            entry.numbered[suffix - 1] = value.into();
        }
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
