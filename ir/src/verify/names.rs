//! Invariant 4: names.

use super::ViolationCollector;
use crate::entity::Value;
use crate::symbol::{Name, Symbol};

/// Names derived from one symbol are numbered almost without gaps, so a bit
/// for each number up to the largest costs little, unless a text written by
/// hand has numbers far apart: then names are sorted.
const BITS_PER_NAME: usize = 16;

pub(super) fn check(collector: &mut ViolationCollector<'_>) {
    let view = collector.view;
    let symbols = &view.tables.symbols;
    for (value, node) in view.function.values() {
        let name = node.name;
        if name.is_none() {
            continue;
        }
        if name.base.index() >= symbols.len() {
            collector.value(value, || "bears a name that is not in the table".to_owned());
            continue;
        }
        if !symbols.is_base(name.base) {
            collector.value(value, || {
                "bears a name that is no word, or reads as derived from another".to_owned()
            });
        }
        if name.suffix > Name::MAX_NUMBER {
            collector.value(value, || {
                format!("bears a number above {}", Name::MAX_NUMBER)
            });
        }
    }
    if all_differ(collector) != Some(true) {
        duplicates(collector);
    }
}

/// The names of nodes that have one in the table.
fn names<'a>(collector: &ViolationCollector<'a>) -> impl Iterator<Item = (Value, Name)> + 'a {
    let symbols = collector.view.tables.symbols.len();
    let named = (collector.view.function.values()).map(|(value, node)| (value, node.name));
    named.filter(move |(_, name)| !name.is_none() && name.base.index() < symbols)
}

/// True when no two names are equal; `None` when numbers lie too far apart to
/// find out without sorting.
fn all_differ(collector: &ViolationCollector<'_>) -> Option<bool> {
    // For each symbol first one more than its largest number, then the place
    // of its number 0 among the bits.
    let mut starts = vec![0u32; collector.view.tables.symbols.len()];
    for (_, name) in names(collector) {
        let start = &mut starts[name.base.index()];
        *start = (*start).max(name.suffix.saturating_add(1));
    }
    let mut bits = 0usize;
    let limit = BITS_PER_NAME * (collector.view.function.nodes().len() + 1);
    for start in &mut starts {
        let count = *start as usize;
        *start = bits as u32;
        bits = bits.saturating_add(count);
        if bits > limit {
            return None;
        }
    }
    let mut borne = vec![0u64; bits.div_ceil(64)];
    for (_, name) in names(collector) {
        let place = (starts[name.base.index()] + name.suffix) as usize;
        let word = &mut borne[place / 64];
        let bit = 1 << (place % 64);
        if *word & bit != 0 {
            return Some(false);
        }
        *word |= bit;
    }
    Some(true)
}

fn key(name: Name) -> u64 {
    let Symbol(base) = name.base;
    u64::from(base) << 32 | u64::from(name.suffix)
}

/// Names the later bearers of names that occur twice.
fn duplicates(collector: &mut ViolationCollector<'_>) {
    let mut keys: Vec<u64> = names(collector).map(|(_, name)| key(name)).collect();
    keys.sort_unstable();
    let mut twice: Vec<u64> = keys
        .windows(2)
        .filter(|pair| pair[0] == pair[1])
        .map(|pair| pair[0])
        .collect();
    twice.dedup();
    let mut first: Vec<Option<Value>> = vec![None; twice.len()];
    let all: Vec<(Value, Name)> = match twice.is_empty() {
        true => return,
        false => names(collector).collect(),
    };
    for (value, name) in all {
        let Ok(at) = twice.binary_search(&key(name)) else {
            continue;
        };
        match first[at] {
            None => first[at] = Some(value),
            Some(_) => collector.value(value, || "is defined twice".to_owned()),
        }
    }
}
