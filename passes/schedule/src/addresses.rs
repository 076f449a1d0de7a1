//! Addresses in memories and buffers.
//!
//! The lifetimes of the words of one memory are intervals of cycles, so
//! handing out a freed address whenever there is one needs exactly as many
//! addresses as words are ever alive at once: no allocation needs fewer.

use super::graph::DependenceGraph;
use super::locations::{FOREVER, PRELOADED, StoredDatum};
use super::sweep::ScheduleDraft;
use robovec_ir::placement::{Address, BufferWord};

/// An address for each entry, and how many each memory uses.
#[derive(Clone, Debug)]
pub(super) struct Addresses {
    /// Per entry; `None` for entries that were forgotten.
    pub(super) of_entry: Vec<Option<Address>>,
    /// Per memory.
    pub(super) used: Vec<u32>,
    /// The entries of initial data with their data, by memory and address.
    pub(super) preloads: Vec<(u32, u32)>,
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
        debug_assert!(address < self.used, "only what was taken is given back");
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
        let memory = entries[entry as usize].memory as usize;
        of_entry[entry as usize] = Some(Address::new(pools[memory].take()));
    }
    let written = |entry: &StoredDatum| (entry.written != PRELOADED).then_some(entry.written);
    let dies = |entry: &StoredDatum| (entry.last_read != FOREVER).then_some(entry.last_read);
    let mut dying = sorted_by(entries, draft.cycles, dies)
        .into_iter()
        .peekable();
    for index in sorted_by(entries, draft.cycles, written) {
        let entry = &entries[index as usize];
        while let Some(dead) =
            dying.next_if(|&dead| entries[dead as usize].last_read < entry.written)
        {
            let memory = entries[dead as usize].memory as usize;
            let address = of_entry[dead as usize].expect("it was written before");
            pools[memory].give_back(address.number());
        }
        let address = pools[entry.memory as usize].take();
        of_entry[index as usize] = Some(Address::new(address));
    }
    Addresses {
        of_entry,
        used: pools.iter().map(|pool| pool.used).collect(),
        preloads,
    }
}

/// The indices of the entries that have a key, by key and then index. Keys
/// are cycles, so that counting them beats comparing them unless the
/// schedule is mostly waiting.
fn sorted_by(
    entries: &[StoredDatum],
    cycles: u32,
    key: impl Fn(&StoredDatum) -> Option<u32>,
) -> Vec<u32> {
    let with_key = entries
        .iter()
        .enumerate()
        .filter_map(|(index, entry)| Some((key(entry)?, index as u32)));
    if cycles as usize > 4 * entries.len() + 1024 {
        let mut keyed: Vec<(u32, u32)> = with_key.collect();
        keyed.sort_unstable();
        return keyed.into_iter().map(|(_, index)| index).collect();
    }
    let mut starts = vec![0_u32; cycles as usize + 2];
    for (key, _) in with_key.clone() {
        starts[key as usize + 1] += 1;
    }
    for index in 1..starts.len() {
        starts[index] += starts[index - 1];
    }
    let mut sorted = vec![0; starts.last().map_or(0, |&end| end as usize)];
    for (key, index) in with_key {
        let place = &mut starts[key as usize];
        sorted[*place as usize] = index;
        *place += 1;
    }
    sorted
}

/// The entries of initial data with their data, by memory and datum.
fn preloads(graph: &DependenceGraph, draft: &ScheduleDraft) -> Vec<(u32, u32)> {
    let mut found: Vec<(u32, u32, u32)> = (0..graph.data_len() as u32)
        .filter(|&datum| !graph.is_computed(datum))
        .flat_map(|datum| {
            let entries = draft.locations.of(datum);
            entries.map(move |(index, entry)| (entry.memory, datum, index))
        })
        .collect();
    found.sort_unstable();
    found
        .into_iter()
        .map(|(_, datum, index)| (index, datum))
        .collect()
}

/// The buffer word of each node whose result is read from the buffer. A word
/// is taken in the write-back cycle and can be taken anew in a cycle after its
/// last read.
pub(super) fn allocate_buffers(
    graph: &DependenceGraph,
    draft: &ScheduleDraft,
) -> Vec<Option<BufferWord>> {
    let mut words: Vec<Option<BufferWord>> = vec![None; graph.kind.len()];
    let mut stays: Vec<(u32, u32, u32)> = Vec::new();
    for node in 0..graph.kind.len() as u32 {
        if !graph.is_computed(node) {
            continue;
        }
        if let Some(until) = draft.locations.buffered_until(node) {
            stays.push((draft.locations.data[node as usize].back, until, node));
        }
    }
    stays.sort_unstable();
    let mut leaving: Vec<(u32, u32)> = stays
        .iter()
        .map(|&(_, until, node)| (until, node))
        .collect();
    leaving.sort_unstable();
    let mut leaving = leaving.into_iter().peekable();
    let elements = graph.kinds.iter().map(|kind| kind.count as usize).sum();
    let mut pools = vec![Pool::default(); elements];
    for (back, _, node) in stays {
        while let Some((_, gone)) = leaving.next_if(|&(until, _)| until < back) {
            let element = draft.locations.data[gone as usize].element as usize;
            let word = words[gone as usize].expect("it was taken before");
            pools[element].give_back(word.number());
        }
        let element = draft.locations.data[node as usize].element as usize;
        words[node as usize] = Some(BufferWord::new(pools[element].take()));
    }
    words
}
