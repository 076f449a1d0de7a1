//! Addresses in memories and buffers.
//!
//! The lifetimes of the words of one memory are intervals of cycles, so reusing
//! freed addresses needs exactly as many addresses as words are ever alive at
//! once, the minimum.

use super::graph::{Datum, DependenceGraph};
use super::locations::{Entry, Memory, StoredDatum};
use super::state::ScheduleDraft;
use robovec_ir::placement::{Address, BufferWord};

/// An address for each entry, and the number used in each memory.
#[derive(Clone, Debug)]
pub(super) struct Addresses {
    /// Per entry; `None` for entries that were forgotten.
    pub(super) of_entry: Vec<Option<Address>>,
    /// Per memory.
    pub(super) used: Vec<u32>,
    /// The entries of initial data with their data, by memory and address.
    pub(super) preloads: Vec<(Entry, Datum)>,
}

/// Free addresses of one memory, or words of one buffer.
#[derive(Clone, Default, Debug)]
struct Pool {
    freed: Vec<u32>,
    used: u32,
}

impl Pool {
    fn take(&mut self) -> u32 {
        self.freed.pop().unwrap_or_else(|| {
            self.used += 1;
            self.used - 1
        })
    }

    fn give_back(&mut self, address: u32) {
        assert!(address < self.used, "only what was taken is given back");
        self.freed.push(address);
    }
}

/// Addresses for all entries. A word may be rewritten in a cycle after the
/// one in which it is last read.
pub(super) fn allocate(graph: &DependenceGraph, draft: &ScheduleDraft) -> Addresses {
    let entries = &draft.locations.entries;
    let mut pools = vec![Pool::default(); draft.live.len()];
    let mut of_entry = vec![None; entries.len()];
    let preloads = preloads(graph, draft);
    for &(entry, _) in &preloads {
        let memory = entries[entry.index()].memory;
        of_entry[entry.index()] = Some(Address::new(pools[memory.index()].take()));
    }
    let dying = sorted_by(entries, draft.cycles, StoredDatum::last_read);
    let mut dying = dying.iter().map(|&entry| (entry, &entries[entry.index()]));
    let mut next = dying.next();
    for entry in sorted_by(entries, draft.cycles, StoredDatum::written) {
        let stored = &entries[entry.index()];
        while let Some((dead, gone)) = next
            && gone.last_read() < stored.written()
        {
            let address = of_entry[dead.index()].expect("it was written before");
            pools[gone.memory.index()].give_back(address.number());
            next = dying.next();
        }
        let address = pools[stored.memory.index()].take();
        of_entry[entry.index()] = Some(Address::new(address));
    }
    Addresses {
        of_entry,
        used: pools.iter().map(|pool| pool.used).collect(),
        preloads,
    }
}

/// The entries that have a key, by key and then in order. Keys
/// are cycles, so that counting them beats comparing them unless the
/// schedule is mostly waiting.
fn sorted_by(
    entries: &[StoredDatum],
    cycles: u32,
    key: impl Fn(&StoredDatum) -> Option<u32>,
) -> Vec<Entry> {
    let with_key = (0..)
        .zip(entries)
        .filter_map(|(number, stored)| Some((key(stored)?, Entry::new(number))));
    if cycles as usize > 4 * entries.len() + 1024 {
        let mut keyed: Vec<(u32, Entry)> = with_key.collect();
        keyed.sort_unstable();
        return keyed.into_iter().map(|(_, entry)| entry).collect();
    }
    let mut starts = vec![0_u32; cycles as usize + 2];
    for (key, _) in with_key.clone() {
        starts[key as usize + 1] += 1;
    }
    for index in 1..starts.len() {
        starts[index] += starts[index - 1];
    }
    let count = *starts.last().expect("there is a start after the last key") as usize;
    let mut sorted = vec![Entry::new(0); count];
    for (key, entry) in with_key {
        let place = &mut starts[key as usize];
        sorted[*place as usize] = entry;
        *place += 1;
    }
    sorted
}

/// The entries of initial data with their data, by memory and datum.
fn preloads(graph: &DependenceGraph, draft: &ScheduleDraft) -> Vec<(Entry, Datum)> {
    let mut found: Vec<(Memory, Datum, Entry)> = (0..graph.data_len() as u32)
        .map(Datum::new)
        .filter(|&datum| !graph.is_computed(datum))
        .flat_map(|datum| {
            let entries = draft.locations.of(datum);
            entries.map(move |(entry, stored)| (stored.memory, datum, entry))
        })
        .collect();
    found.sort_unstable();
    found
        .into_iter()
        .map(|(_, datum, entry)| (entry, datum))
        .collect()
}

/// The buffer word of each node whose result is read from the buffer. A word is
/// taken in the write-back cycle and can be taken again in a cycle after its
/// last read.
pub(super) fn allocate_buffers(
    graph: &DependenceGraph,
    draft: &ScheduleDraft,
) -> Vec<Option<BufferWord>> {
    let mut words: Vec<Option<BufferWord>> = vec![None; graph.kind.len()];
    let result = |node: Datum| draft.locations.computed(node);
    let mut stays: Vec<(u32, u32, Datum)> = Vec::new();
    for node in (0..graph.kind.len() as u32).map(Datum::new) {
        if let Some(until) = draft.locations.buffered_until(node) {
            stays.push((result(node).cycle, until, node));
        }
    }
    stays.sort_unstable();
    let mut leaving: Vec<(u32, Datum)> = stays
        .iter()
        .map(|&(_, until, node)| (until, node))
        .collect();
    leaving.sort_unstable();
    let mut leaving = leaving.into_iter().peekable();
    let elements = graph.kinds.iter().map(|kind| kind.count as usize).sum();
    let mut pools = vec![Pool::default(); elements];
    for (back, _, node) in stays {
        while let Some((_, gone)) = leaving.next_if(|&(until, _)| until < back) {
            let word = words[gone.index()].expect("it was taken before");
            pools[result(gone).element.index()].give_back(word.number());
        }
        let pool = &mut pools[result(node).element.index()];
        words[node.index()] = Some(BufferWord::new(pool.take()));
    }
    words
}
