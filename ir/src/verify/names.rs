//! Invariant 4: names.

use super::{ViolationCollector, all_differ};
use crate::entity::Value;
use crate::symbol::{Name, Symbol};

/// Bits per node of the set of names in use: the size of the keys that would be
/// sorted instead. Names derived from one symbol are numbered almost without
/// gaps, so that only a text written by hand has more.
const BITS_PER_NODE: usize = 64;

pub(super) fn check(collector: &mut ViolationCollector<'_>) {
    let view = collector.view;
    let symbols = &view.tables.symbols;
    // For each symbol which of the first numbers behind it are borne.
    let mut borne = vec![0u64; symbols.len()];
    let mut differ = true;
    for (value, node) in view.function.values() {
        let name = node.name;
        if name.is_none() {
            continue;
        }
        let Some(borne) = borne.get_mut(name.base.index()) else {
            collector.value(value, || "has a name that is not in the table".to_owned());
            continue;
        };
        let bit = 1u64.unbounded_shl(name.suffix);
        differ &= bit & !*borne != 0;
        *borne |= bit;
        if !symbols.is_base(name.base) {
            collector.value(value, || {
                "has a name that is not a word, or that looks derived from another".to_owned()
            });
        }
        if name.suffix > Name::MAX_NUMBER {
            collector.value(value, || format!("has a number above {}", Name::MAX_NUMBER));
        }
    }
    // Two names are equal, or some number is larger.
    drop(borne);
    if !differ && !known_to_differ(collector) {
        duplicates(collector);
    }
}

/// The names of nodes that have one in the table.
fn names<'a>(collector: &ViolationCollector<'a>) -> impl Iterator<Item = (Value, Name)> + 'a {
    let symbols = collector.view.tables.symbols.len();
    let named = (collector.view.function.values()).map(|(value, node)| (value, node.name));
    named.filter(move |(_, name)| !name.is_none() && name.base.index() < symbols)
}

/// True when no two names are equal and their numbers lie close enough
/// together to show.
fn known_to_differ(collector: &ViolationCollector<'_>) -> bool {
    // For each symbol one more than the largest number behind it, and then
    // the place of its number 0 among the bits.
    let mut starts = vec![0u32; collector.view.tables.symbols.len()];
    for (_, name) in names(collector) {
        let count = &mut starts[name.base.index()];
        *count = (*count).max(name.suffix.saturating_add(1));
    }
    let limit = BITS_PER_NODE * (collector.view.function.nodes().len() + 1);
    let mut bits = 0usize;
    for start in &mut starts {
        let count = *start as usize;
        *start = bits as u32;
        bits += count;
        if bits > limit.min(u32::MAX as usize) {
            return false;
        }
    }
    let bit = |name: Name| (starts[name.base.index()] + name.suffix) as usize;
    all_differ(names(collector).map(|(_, name)| bit(name)), bits)
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
    let all: Vec<(Value, Name)> = if twice.is_empty() {
        return;
    } else {
        names(collector).collect()
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
