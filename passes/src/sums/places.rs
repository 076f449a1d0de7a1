//! Places of items in a table, found by hash.

use hashbrown::HashTable;

/// The places of items that a caller stores and hashes: storing the hashes here
/// would nearly double the memory of a table of millions.
#[derive(Clone, Default)]
pub(crate) struct PlaceTable {
    places: HashTable<u32>,
}

impl PlaceTable {
    /// Reserves this number of places in one step: a table that grows
    /// recomputes the hashes of all its items, wherever they are in memory.
    pub(crate) fn reserve(&mut self, places: usize, hash_at: impl Fn(u32) -> u64) {
        let again = |&place: &u32| spread(hash_at(place));
        self.places.reserve(places, again);
    }

    /// The place of the equal item with this hash.
    #[inline]
    pub(crate) fn find(&self, hash: u64, equal: impl Fn(u32) -> bool) -> Option<u32> {
        let found = self.places.find(spread(hash), |&place| equal(place));
        found.copied()
    }

    /// Lets a place be found. No equal item may be in the table. The hashes of
    /// all places that are there are requested when the table grows.
    #[inline]
    pub(crate) fn insert(&mut self, hash: u64, place: u32, hash_at: impl Fn(u32) -> u64) {
        let again = |&place: &u32| spread(hash_at(place));
        self.places.insert_unique(spread(hash), place, again);
    }

    /// Removes the equal item with this hash from the index.
    pub(crate) fn remove(&mut self, hash: u64, equal: impl Fn(u32) -> bool) {
        if let Ok(entry) = self.places.find_entry(spread(hash), |&place| equal(place)) {
            entry.remove();
        }
    }

    /// Removes all items.
    pub(crate) fn clear(&mut self) {
        self.places.clear();
    }
}

/// A hash for the table, which takes the slot from the low bits and
/// distinguishes neighbours by the high ones.
fn spread(hash: u64) -> u64 {
    (hash ^ hash >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_hashes_do_not_make_things_equal() {
        let things = [7u64, 7 + (1 << 40), 9];
        let mut table = PlaceTable::default();
        for (place, _) in things.iter().enumerate() {
            // One hash for all of them.
            table.insert(5, place as u32, |_| 5);
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
