//! Which memories hold which data, from when to when.

/// The index no entry has.
pub(super) const NO_ENTRY: u32 = u32::MAX;

/// The write cycle of initial data, which are there before the run.
pub(super) const PRELOADED: u32 = u32::MAX;

/// The last read of a word that stays to the end.
pub(super) const FOREVER: u32 = u32::MAX;

/// A datum in a memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// The memory: element times banks plus bank.
    pub(super) memory: u32,
    /// The cycle at whose end the word is written, or [`PRELOADED`].
    pub(super) written: u32,
    /// The last cycle in which an issue reads it, or [`FOREVER`].
    pub(super) last_read: u32,
    /// The next entry of the same datum, or [`NO_ENTRY`].
    next: u32,
}

/// All entries, as one list per datum in a common vector.
#[derive(Clone, Debug)]
pub(super) struct Locations {
    first: Vec<u32>,
    /// The entries, in the order in which they were reserved.
    pub(super) entries: Vec<Entry>,
}

impl Locations {
    /// No datum is anywhere.
    pub(super) fn new(data: usize) -> Locations {
        Locations {
            first: vec![NO_ENTRY; data],
            entries: Vec::with_capacity(data + data / 2),
        }
    }

    /// Adds a word that is read in the same breath.
    pub(super) fn add(&mut self, datum: u32, memory: usize, written: u32, read: u32) -> u32 {
        let index = self.entries.len() as u32;
        self.entries.push(Entry {
            memory: memory as u32,
            written,
            last_read: read,
            next: self.first[datum as usize],
        });
        self.first[datum as usize] = index;
        index
    }

    /// The entries of a datum with their indices, latest reservation first.
    pub(super) fn of(&self, datum: u32) -> impl Iterator<Item = (u32, &Entry)> + '_ {
        let mut next = self.first[datum as usize];
        std::iter::from_fn(move || {
            let index = next;
            let entry = self.entries.get(index as usize)?;
            next = entry.next;
            Some((index, entry))
        })
    }
}
