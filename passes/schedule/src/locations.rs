//! The places of the data: which memories hold them, from when to when.

/// The index no entry has.
pub(super) const NO_ENTRY: u32 = u32::MAX;

/// The write cycle of initial data, which are there before the run.
pub(super) const PRELOADED: u32 = u32::MAX;

/// The last read of a word that stays to the end.
pub(super) const FOREVER: u32 = u32::MAX;

/// When a word travels.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Travel {
    /// The cycle in which it leaves its producer or the producer's buffer.
    pub(super) departs: u32,
    /// The cycle at whose end it is written.
    pub(super) arrives: u32,
}

impl Travel {
    /// Initial data, there before the run.
    pub(super) const PRELOADED: Travel = Travel {
        departs: PRELOADED,
        arrives: PRELOADED,
    };
}

/// A datum in a memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct StoredDatum {
    /// The memory: element times banks plus bank.
    pub(super) memory: u32,
    /// The cycle at whose end the word is written, or [`PRELOADED`].
    pub(super) written: u32,
    /// The last cycle in which an issue reads it, or [`FOREVER`].
    pub(super) last_read: u32,
    /// The cycle in which the word left its producer or the producer's
    /// buffer, or [`PRELOADED`]; over a crossbar that of the write.
    pub(super) departed: u32,
    /// The next entry of the same datum, or [`NO_ENTRY`].
    next: u32,
}

/// The write-back cycle of a datum the machine does not compute, or has not
/// computed yet.
pub(super) const NOT_COMPUTED: u32 = u32::MAX;

/// The state of a datum; all in one place, because operands come from anywhere
/// in a large program and each look at one is a cache miss.
#[derive(Clone, Copy, Debug)]
pub(super) struct Datum {
    /// The cycle in which it is on the crossbar, or [`NOT_COMPUTED`].
    pub(super) back: u32,
    /// The element that computes it.
    pub(super) element: u32,
    /// Reads still to come; an output has one that never comes.
    pub(super) readers_left: u32,
    /// Its first entry, or [`NO_ENTRY`].
    first: u32,
}

/// All data, and their entries as one list per datum in a common vector.
#[derive(Clone, Debug)]
pub(super) struct Locations {
    /// The data.
    pub(super) data: Vec<Datum>,
    /// The entries, in the order in which they were reserved.
    pub(super) entries: Vec<StoredDatum>,
}

impl Locations {
    /// No datum is anywhere.
    pub(super) fn new(readers: impl Iterator<Item = u32>) -> Locations {
        let data: Vec<Datum> = readers
            .map(|readers_left| Datum {
                back: NOT_COMPUTED,
                element: 0,
                readers_left,
                first: NO_ENTRY,
            })
            .collect();
        Locations {
            entries: Vec::with_capacity(data.len() + data.len() / 2),
            data,
        }
    }

    /// Adds a word that travels as given, and its last read as far as known.
    pub(super) fn add(&mut self, datum: u32, memory: usize, travel: Travel, read: u32) -> u32 {
        let index = self.entries.len() as u32;
        let first = &mut self.data[datum as usize].first;
        self.entries.push(StoredDatum {
            memory: memory as u32,
            written: travel.arrives,
            last_read: read,
            departed: travel.departs,
            next: *first,
        });
        *first = index;
        index
    }

    /// The entries of a datum with their indices, latest reservation first.
    pub(super) fn of(&self, datum: u32) -> impl Iterator<Item = (u32, &StoredDatum)> + '_ {
        let mut next = self.data[datum as usize].first;
        std::iter::from_fn(move || {
            let index = next;
            let entry = self.entries.get(index as usize)?;
            next = entry.next;
            Some((index, entry))
        })
    }

    /// The entry of a datum in a memory, if it has one.
    pub(super) fn find(&self, datum: u32, memory: usize) -> Option<u32> {
        let mut entries = self.of(datum);
        let found = entries.find(|(_, entry)| entry.memory as usize == memory);
        found.map(|(index, _)| index)
    }

    /// Takes back the entry that was added last, which is the datum's.
    pub(super) fn remove_last(&mut self, datum: u32) {
        let entry = self.entries.pop().expect("an entry was added");
        let first = &mut self.data[datum as usize].first;
        debug_assert_eq!(
            *first as usize,
            self.entries.len(),
            "the entry that was added last is the datum's"
        );
        *first = entry.next;
    }

    /// Forgets one entry of a datum.
    pub(super) fn forget(&mut self, datum: u32, index: u32) {
        let next = self.entries[index as usize].next;
        let mut link = self.data[datum as usize].first;
        if link == index {
            self.data[datum as usize].first = next;
        }
        while let Some(entry) = self.entries.get_mut(link as usize) {
            if entry.next == index {
                entry.next = next;
            }
            link = entry.next;
        }
        let entry = &mut self.entries[index as usize];
        (entry.written, entry.last_read) = (PRELOADED, FOREVER);
    }

    /// Forgets the words that were booked and are never read: those whose
    /// last read is still the cycle in which they are written.
    pub(super) fn drop_unread(&mut self) {
        let unread = |entry: &StoredDatum| entry.last_read == entry.written;
        if !self.entries.iter().any(unread) {
            return;
        }
        for datum in &mut self.data {
            let mut link: Option<usize> = None;
            let mut next = datum.first;
            while let Some(&entry) = self.entries.get(next as usize) {
                if unread(&entry) {
                    match link {
                        None => datum.first = entry.next,
                        Some(before) => self.entries[before].next = entry.next,
                    }
                } else {
                    link = Some(next as usize);
                }
                next = entry.next;
            }
        }
        for entry in self.entries.iter_mut().filter(|entry| unread(entry)) {
            (entry.written, entry.last_read) = (PRELOADED, FOREVER);
        }
    }

    /// The last cycle in which the datum is read from its producer's buffer,
    /// if it is in the buffer at all.
    pub(super) fn buffered_until(&self, datum: u32) -> Option<u32> {
        let back = self.data[datum as usize].back;
        self.of(datum)
            .map(|(_, entry)| entry.departed)
            .filter(|&departed| departed > back && departed != PRELOADED)
            .max()
    }
}
