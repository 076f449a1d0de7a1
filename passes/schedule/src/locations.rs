//! The places of the data: which memories hold them, from when to when.

use super::graph::Datum;
use robovec_ir::index_types;
use robovec_ir::placement::Element;

index_types! {
    /// A memory of an element: the element's number times banks plus bank.
    pub(super) struct Memory;

    /// A datum in a memory: an index into [`Locations::entries`].
    pub(super) struct Entry;

    /// A cycle as entries keep it, of which there are more than operations.
    struct StoredCycle;
}

/// Time at which a word travels.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Travel {
    /// The cycle in which it leaves its producer or the producer's buffer.
    pub(super) departs: u32,
    /// The cycle at whose end it is written.
    pub(super) arrives: u32,
}

/// A datum in a memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct StoredDatum {
    pub(super) memory: Memory,
    written: Option<StoredCycle>,
    last_read: Option<StoredCycle>,
    departed: Option<StoredCycle>,
    /// The next entry of the same datum.
    next: Option<Entry>,
}

impl StoredDatum {
    /// The cycle at whose end the word is written; `None` for initial data,
    /// which are there before the run.
    pub(super) fn written(&self) -> Option<u32> {
        self.written.map(StoredCycle::number)
    }

    /// The last cycle in which an issue reads it; `None` for a word that stays
    /// to the end.
    pub(super) fn last_read(&self) -> Option<u32> {
        self.last_read.map(StoredCycle::number)
    }

    /// The cycle in which the word left its producer or the producer's
    /// buffer, over a crossbar that of the write; `None` for initial data.
    pub(super) fn departed(&self) -> Option<u32> {
        self.departed.map(StoredCycle::number)
    }

    /// Time at which the word travels; `None` for initial data.
    pub(super) fn travel(&self) -> Option<Travel> {
        Some(Travel {
            departs: self.departed()?,
            arrives: self.written()?,
        })
    }

    pub(super) fn set_last_read(&mut self, cycle: Option<u32>) {
        self.last_read = cycle.map(StoredCycle::new);
    }

    /// True for a reserved word without a reader so far: its last read is still
    /// the cycle in which it is written.
    pub(super) fn is_unread(&self) -> bool {
        self.last_read == self.written
    }

    fn clear(&mut self) {
        (self.written, self.last_read) = (None, None);
    }
}

/// Time and place at which a result appears.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct WriteBack {
    /// The cycle in which it is on the crossbar.
    pub(super) cycle: u32,
    /// The element that computes it.
    pub(super) element: Element,
}

/// The state of a datum; all in one place, because operands come from anywhere
/// in a large program and each look at one is a cache miss.
#[derive(Clone, Copy, Debug)]
pub(super) struct DatumState {
    /// `None` for a datum the machine does not compute, or has not computed
    /// yet.
    pub(super) result: Option<WriteBack>,
    /// Reads still to come; an output has one that never comes.
    pub(super) readers_left: u32,
    first: Option<Entry>,
}

/// All data, and their entries as one list per datum in a common vector.
#[derive(Clone, Debug)]
pub(super) struct Locations {
    pub(super) data: Vec<DatumState>,
    /// The entries, in the order in which they were reserved.
    pub(super) entries: Vec<StoredDatum>,
}

impl Locations {
    /// No datum is anywhere.
    pub(super) fn new(readers: impl Iterator<Item = u32>) -> Locations {
        let data: Vec<DatumState> = readers
            .map(|readers_left| DatumState {
                result: None,
                readers_left,
                first: None,
            })
            .collect();
        Locations {
            // Most are read on two elements; room that is not used costs nothing.
            entries: Vec::with_capacity(2 * data.len()),
            data,
        }
    }

    /// Time and place at which a datum appears, if it has been computed.
    pub(super) fn result(&self, datum: Datum) -> Option<WriteBack> {
        self.data[datum.index()].result
    }

    /// Time and place at which a datum that was computed appears.
    pub(super) fn computed(&self, datum: Datum) -> WriteBack {
        self.result(datum).expect("the datum was computed")
    }

    /// Adds a word that travels as given, or that is there before the run,
    /// and its last read as far as known.
    pub(super) fn add(
        &mut self,
        datum: Datum,
        memory: Memory,
        travel: Option<Travel>,
        read: Option<u32>,
    ) -> Entry {
        let entry = Entry::new(self.entries.len() as u32);
        let first = &mut self.data[datum.index()].first;
        self.entries.push(StoredDatum {
            memory,
            written: travel.map(|travel| StoredCycle::new(travel.arrives)),
            last_read: read.map(StoredCycle::new),
            departed: travel.map(|travel| StoredCycle::new(travel.departs)),
            next: *first,
        });
        *first = Some(entry);
        entry
    }

    /// The entries of a datum, latest reservation first.
    pub(super) fn of(&self, datum: Datum) -> impl Iterator<Item = (Entry, &StoredDatum)> + '_ {
        let mut next = self.data[datum.index()].first;
        std::iter::from_fn(move || {
            let entry = next?;
            let stored = &self.entries[entry.index()];
            next = stored.next;
            Some((entry, stored))
        })
    }

    /// The entry of a datum in a memory, if it has one.
    pub(super) fn find(&self, datum: Datum, memory: Memory) -> Option<Entry> {
        let mut entries = self.of(datum);
        let found = entries.find(|(_, stored)| stored.memory == memory);
        found.map(|(entry, _)| entry)
    }

    /// Takes back the entry that was added last, which is the datum's.
    pub(super) fn remove_last(&mut self, datum: Datum) {
        let stored = self.entries.pop().expect("an entry was added");
        let first = &mut self.data[datum.index()].first;
        assert_eq!(
            first.map(Entry::index),
            Some(self.entries.len()),
            "the entry that was added last is the datum's"
        );
        *first = stored.next;
    }

    pub(super) fn forget(&mut self, datum: Datum, entry: Entry) {
        let next = self.entries[entry.index()].next;
        let first = &mut self.data[datum.index()].first;
        let mut link = *first;
        if link == Some(entry) {
            *first = next;
        }
        while let Some(at) = link {
            let stored = &mut self.entries[at.index()];
            if stored.next == Some(entry) {
                stored.next = next;
            }
            link = stored.next;
        }
        self.entries[entry.index()].clear();
    }

    /// Forgets the words that were booked and are never read.
    pub(super) fn drop_unread(&mut self) {
        if !self.entries.iter().any(StoredDatum::is_unread) {
            return;
        }
        for datum in &mut self.data {
            let mut link: Option<Entry> = None;
            let mut next = datum.first;
            while let Some(entry) = next {
                let stored = self.entries[entry.index()];
                if !stored.is_unread() {
                    link = next;
                } else if let Some(before) = link {
                    self.entries[before.index()].next = stored.next;
                } else {
                    datum.first = stored.next;
                }
                next = stored.next;
            }
        }
        for stored in self.entries.iter_mut().filter(|stored| stored.is_unread()) {
            stored.clear();
        }
    }

    /// The last cycle in which the datum is read from its producer's buffer,
    /// if it is in the buffer at all.
    pub(super) fn buffered_until(&self, datum: Datum) -> Option<u32> {
        let back = self.result(datum)?.cycle;
        self.of(datum)
            .filter_map(|(_, stored)| stored.departed())
            .filter(|&departed| departed > back)
            .max()
    }
}
