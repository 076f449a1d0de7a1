//! Places of things that lie in a table, found by hash.

use hashbrown::HashTable;

/// A place and half of the hash of what is there.
#[derive(Clone, Copy, Debug)]
struct PlaceEntry {
    place: u32,
    tag: u32,
}

/// The places of things that a caller keeps. Half of each hash is kept beside
/// the place: when the table grows, and where hashes only meet in their slot,
/// nothing need be looked at that lies far away.
#[derive(Clone, Default)]
pub(crate) struct PlaceTable {
    entries: HashTable<PlaceEntry>,
}

impl PlaceTable {
    /// The place of what has this hash and is equal.
    #[inline]
    pub(crate) fn find(&self, hash: u64, equal: impl Fn(u32) -> bool) -> Option<u32> {
        let tag = tag(hash);
        let is_it = |entry: &PlaceEntry| entry.tag == tag && equal(entry.place);
        self.entries.find(spread(tag), is_it).map(|it| it.place)
    }

    /// Lets a place be found. Nothing equal must be there.
    #[inline]
    pub(crate) fn insert(&mut self, hash: u64, place: u32) {
        let tag = tag(hash);
        let entry = PlaceEntry { place, tag };
        self.entries
            .insert_unique(spread(tag), entry, |entry| spread(entry.tag));
    }

    /// Lets what has this hash and is equal not be found any more.
    pub(crate) fn remove(&mut self, hash: u64, equal: impl Fn(u32) -> bool) {
        let tag = tag(hash);
        let is_it = |entry: &PlaceEntry| entry.tag == tag && equal(entry.place);
        if let Ok(entry) = self.entries.find_entry(spread(tag), is_it) {
            entry.remove();
        }
    }

    /// Lets nothing be found any more.
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
    }
}

fn tag(hash: u64) -> u32 {
    (hash ^ hash >> 32) as u32
}

/// The hash that a tag stands for: the table takes the slot from its low bits
/// and tells neighbours apart by the high ones.
fn spread(tag: u32) -> u64 {
    u64::from(tag).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_tags_do_not_make_things_equal() {
        let things = [7u64, 7 + (1 << 40), 9];
        let mut table = PlaceTable::default();
        for (place, _) in things.iter().enumerate() {
            // One hash for all of them.
            table.insert(5, place as u32);
        }
        let find =
            |table: &PlaceTable, thing: u64| table.find(5, |place| things[place as usize] == thing);
        assert_eq!(things.map(|thing| find(&table, thing)), [0, 1, 2].map(Some));
        table.remove(5, |place| things[place as usize] == 9);
        assert_eq!(find(&table, 9), None);
        assert_eq!(table.find(6, |_| true), None);
        table.clear();
        assert_eq!(find(&table, 7), None);
    }
}
