//! Invariant 4: names.

use super::{ViolationCollector, is_word};
use crate::entity::Value;
use crate::symbol::{Name, Symbol};

pub(super) fn check(collector: &mut ViolationCollector<'_>) {
    let view = collector.view;
    let symbols = &view.tables.symbols;
    // What is wrong with a symbol is found out once.
    let mut known: Vec<Option<bool>> = vec![None; symbols.len()];
    let mut keys: Vec<u64> = Vec::with_capacity(view.function.nodes().len());
    for (value, node) in view.function.values() {
        let name = node.name;
        if name.is_none() {
            continue;
        }
        let Some(fits) = known.get_mut(name.base.index()) else {
            collector.value(value, || "bears a name that is not in the table".to_owned());
            continue;
        };
        let fits = *fits.get_or_insert_with(|| {
            let text = symbols.text(name.base);
            is_word(text) && Name::split(text).1 == 0
        });
        if !fits {
            collector.value(value, || {
                "bears a name that is no word, or reads as derived from another".to_owned()
            });
        }
        if name.suffix > Name::MAX_NUMBER {
            collector.value(value, || {
                format!("bears a number above {}", Name::MAX_NUMBER)
            });
        }
        keys.push(u64::from(name.base.0) << 32 | u64::from(name.suffix));
    }
    keys.sort_unstable();
    if keys.windows(2).any(|pair| pair[0] == pair[1]) {
        duplicates(collector, &keys);
    }
}

/// Names the later bearers of names that occur twice.
fn duplicates(collector: &mut ViolationCollector<'_>, keys: &[u64]) {
    let view = collector.view;
    let mut twice: Vec<u64> = keys
        .windows(2)
        .filter(|pair| pair[0] == pair[1])
        .map(|pair| pair[0])
        .collect();
    twice.dedup();
    let mut first: Vec<Option<Value>> = vec![None; twice.len()];
    for (value, node) in view.function.values() {
        let Name {
            base: Symbol(base),
            suffix,
        } = node.name;
        let key = u64::from(base) << 32 | u64::from(suffix);
        let Ok(at) = twice.binary_search(&key) else {
            continue;
        };
        match first[at] {
            None => first[at] = Some(value),
            Some(_) => collector.value(value, || "is defined twice".to_owned()),
        }
    }
}
