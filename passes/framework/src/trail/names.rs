//! Values by their names, without hashing.
//!
//! Names are dense: symbols are numbered, and the names derived from one are
//! too. So the values are sorted by symbol and number, and a name is found by
//! its symbol's place in a table and a search among few numbers. Several
//! times faster than a hash table on a function of 600,000 operations.

use robovec_ir::{Function, Name, Symbol, Value};

/// The values of a function by their names.
pub(super) struct ValueNames {
    /// For every symbol the start of its names in `entries`; one more for the
    /// end.
    starts: Vec<u32>,
    /// Numbers after the dot, ascending for each symbol, with the values.
    entries: Vec<(u32, Value)>,
}

impl ValueNames {
    pub(super) fn of(function: &Function) -> ValueNames {
        let named = || {
            let values = function.values();
            values.filter(|(_, node)| !node.name.is_none())
        };
        let symbols = named().map(|(_, node)| node.name.base.index() + 1);
        let symbols = symbols.fold(0, usize::max);
        let mut starts = vec![0u32; symbols + 1];
        for (_, node) in named() {
            starts[node.name.base.index() + 1] += 1;
        }
        for index in 0..symbols {
            starts[index + 1] += starts[index];
        }
        let mut next = starts.clone();
        let mut entries = vec![(0, Value(0)); starts[symbols] as usize];
        for (value, node) in named() {
            let place = &mut next[node.name.base.index()];
            entries[*place as usize] = (node.name.suffix, value);
            *place += 1;
        }
        for index in 0..symbols {
            let own = &mut entries[starts[index] as usize..starts[index + 1] as usize];
            own.sort_unstable();
            debug_assert!(
                own.is_sorted_by(|one, next| one.0 < next.0),
                "no two values have the same name"
            );
        }
        ValueNames { starts, entries }
    }

    fn derived(&self, symbol: Symbol) -> &[(u32, Value)] {
        match self.starts.get(symbol.index()..symbol.index() + 2) {
            Some(&[start, end]) => &self.entries[start as usize..end as usize],
            Some(_) | None => &[],
        }
    }

    pub(super) fn find(&self, name: Name) -> Option<Value> {
        if name.is_none() {
            return None;
        }
        let entries = self.derived(name.base);
        let found = entries.binary_search_by_key(&name.suffix, |(suffix, _)| *suffix);
        found.ok().map(|index| entries[index].1)
    }

    /// The value of the smallest number derived from a symbol, the symbol
    /// itself first of all.
    pub(super) fn first(&self, symbol: Symbol) -> Option<Value> {
        self.derived(symbol).first().map(|(_, value)| *value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::parse::parse_module;

    #[test]
    fn every_name_is_found_and_no_other() {
        let text = "function f equations {\n  in q\n  out c\n  %B.7 = q\n  %A = q\n  %B.2 = q\n  c = %A*%B.2\n}\n";
        let module = parse_module("f", text).expect("it is sound");
        let names = ValueNames::of(&module.functions[0]);
        let value = |text: &str| {
            let (base, suffix) = Name::split(text);
            let base = module.tables.symbols.find(base)?;
            names.find(Name { base, suffix })
        };
        let found = ["B.7", "A", "B.2", "B", "A.1", "c"].map(value);
        let expected = [
            Some(Value(0)),
            Some(Value(1)),
            Some(Value(2)),
            None,
            None,
            None,
        ];
        assert_eq!(found, expected);
        let base = module.tables.symbols.find("B").expect("it is in the text");
        assert_eq!(names.first(base), Some(Value(2)));
        assert_eq!(names.find(Name::NONE), None);
        assert_eq!(names.first(Symbol(99)), None);
    }
}
