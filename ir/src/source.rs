//! The origins of values: places in the files of the user.
//!
//! Every node carries a [`SourceSet`]: the equations it was made from. Passes
//! that merge values take the union of their sets and never drop one, so any
//! message can point into the Robotran file. Sets are interned; the frequent
//! set with one place costs nothing beyond the place.

use hashbrown::HashMap;
use hashbrown::hash_table::{Entry, HashTable};
use rustc_hash::FxBuildHasher;
use smallvec::SmallVec;
use std::hash::BuildHasher;

/// A range of a source file. Lines and columns count from 1, columns in
/// characters; the end column is the last one of the range.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct SourcePlace {
    /// Index into [`Sources::files`].
    pub file: u32,
    /// First line.
    pub line: u32,
    /// First column.
    pub column: u32,
    /// Last line.
    pub end_line: u32,
    /// Last column, included.
    pub end_column: u32,
}

/// An interned set of places; see [`Sources`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct SourceSet(u32);

/// Bit that marks a set of several places. With it the other bits are an index
/// into [`Sources::ranges`], without it into [`Sources::places`].
const SEVERAL: u32 = 1 << 31;

impl SourceSet {
    /// The set of no place: the value's origin is unknown.
    pub const EMPTY: SourceSet = SourceSet(SEVERAL - 1);
}

/// The files, places and sets of a module.
#[derive(Clone, Default, Debug)]
pub struct Sources {
    /// Names of the files, as given by the user.
    pub files: Vec<String>,
    places: Vec<SourcePlace>,
    /// Places to their index; empty as long as the places come in increasing
    /// order, as they do from a file, and a binary search finds them.
    place_index: HashMap<SourcePlace, u32, FxBuildHasher>,
    /// For each set of several places, the range of its members.
    ranges: Vec<(u32, u32)>,
    /// Indices into the places, in order of the places within a set.
    members: Vec<u32>,
    /// Sets with several places, by their members.
    set_index: HashTable<u32>,
}

impl Sources {
    /// Adds a file and returns its index; a name already known keeps its own.
    pub fn add_file(&mut self, name: &str) -> u32 {
        match self.files.iter().position(|file| file == name) {
            Some(index) => index as u32,
            None => {
                self.files.push(name.to_owned());
                self.files.len() as u32 - 1
            }
        }
    }

    /// The set that holds one place; equal places give equal sets.
    pub fn single(&mut self, place: SourcePlace) -> SourceSet {
        if self.places.last() == Some(&place) {
            return SourceSet(self.places.len() as u32 - 1);
        }
        let next = self.places.len() as u32;
        if self.place_index.is_empty() {
            if self.places.last().is_none_or(|last| *last < place) {
                self.places.push(place);
                return SourceSet(next);
            }
            if let Ok(index) = self.places.binary_search(&place) {
                return SourceSet(index as u32);
            }
            self.place_index = self.places.iter().copied().zip(0..).collect();
        }
        let index = *self.place_index.entry(place).or_insert(next);
        if index == next {
            self.places.push(place);
        }
        SourceSet(index)
    }

    /// The union of sets; equal unions give equal sets.
    pub fn union(&mut self, sets: &[SourceSet]) -> SourceSet {
        let Some(&first) = sets.iter().find(|&&set| set != SourceSet::EMPTY) else {
            return SourceSet::EMPTY;
        };
        if sets
            .iter()
            .all(|&set| set == first || set == SourceSet::EMPTY)
        {
            return first;
        }
        let mut members: SmallVec<[u32; 16]> = SmallVec::new();
        for &set in sets {
            members.extend_from_slice(self.member_indices(&set));
        }
        members.sort_unstable_by_key(|&index| self.places[index as usize]);
        members.dedup();
        debug_assert!(
            members.is_sorted_by(|&a, &b| self.places[a as usize] < self.places[b as usize]),
            "the places of a set are in order, each once"
        );
        self.intern(&members)
    }

    fn member_indices<'a>(&'a self, set: &'a SourceSet) -> &'a [u32] {
        if *set == SourceSet::EMPTY {
            &[]
        } else if set.0 & SEVERAL == 0 {
            std::slice::from_ref(&set.0)
        } else {
            let (start, end) = self.ranges[(set.0 & !SEVERAL) as usize];
            &self.members[start as usize..end as usize]
        }
    }

    fn intern(&mut self, members: &[u32]) -> SourceSet {
        if let [only] = *members {
            return SourceSet(only);
        }
        assert!(!members.is_empty(), "only the empty set has no places");
        let (all, ranges) = (&self.members, &self.ranges);
        let known = |set: u32| {
            let (start, end) = ranges[set as usize];
            &all[start as usize..end as usize]
        };
        let hash = |members: &[u32]| FxBuildHasher.hash_one(members);
        let (same, rehash) = (
            |&set: &u32| known(set) == members,
            |&set: &u32| hash(known(set)),
        );
        let set = match self.set_index.entry(hash(members), same, rehash) {
            Entry::Occupied(found) => return SourceSet(*found.get() | SEVERAL),
            Entry::Vacant(place) => *place.insert(ranges.len() as u32).get(),
        };
        let start = self.members.len() as u32;
        self.members.extend_from_slice(members);
        self.ranges.push((start, self.members.len() as u32));
        SourceSet(set | SEVERAL)
    }

    /// The places of a set, in order of file, line and column.
    pub fn places(&self, set: SourceSet) -> impl ExactSizeIterator<Item = SourcePlace> + '_ {
        let range = if set == SourceSet::EMPTY {
            Members::Range(0..0)
        } else if set.0 & SEVERAL == 0 {
            Members::One(Some(set.0))
        } else {
            let (start, end) = self.ranges[(set.0 & !SEVERAL) as usize];
            Members::Range(start as usize..end as usize)
        };
        PlaceIter {
            sources: self,
            members: range,
        }
    }

    /// The number of a set with several places, counted from 0 in order of
    /// their making; `None` for a node with at most one place.
    #[inline]
    pub(crate) fn number_of_several(&self, set: SourceSet) -> Option<usize> {
        let several = set.0 & SEVERAL != 0;
        several.then_some((set.0 & !SEVERAL) as usize)
    }

    /// The number of sets with several places.
    pub(crate) fn several(&self) -> usize {
        self.ranges.len()
    }

    /// The first place of a set.
    pub fn first(&self, set: SourceSet) -> Option<SourcePlace> {
        self.places(set).next()
    }
}

enum Members {
    One(Option<u32>),
    Range(std::ops::Range<usize>),
}

struct PlaceIter<'a> {
    sources: &'a Sources,
    members: Members,
}

impl Iterator for PlaceIter<'_> {
    type Item = SourcePlace;

    fn next(&mut self) -> Option<SourcePlace> {
        let index = match &mut self.members {
            Members::One(one) => one.take()?,
            Members::Range(range) => self.sources.members[range.next()?],
        };
        Some(self.sources.places[index as usize])
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let length = match &self.members {
            Members::One(one) => usize::from(one.is_some()),
            Members::Range(range) => range.len(),
        };
        (length, Some(length))
    }
}

impl ExactSizeIterator for PlaceIter<'_> {}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(line: u32) -> SourcePlace {
        SourcePlace {
            file: 0,
            line,
            column: 1,
            end_line: line,
            end_column: 9,
        }
    }

    #[test]
    fn unions_are_interned_sorted_and_without_duplicates() {
        let mut sources = Sources::default();
        let a = sources.single(place(1));
        let b = sources.single(place(2));
        assert_eq!(sources.single(place(1)), a);
        let both = sources.union(&[b, a, SourceSet::EMPTY]);
        assert_eq!(both, sources.union(&[a, b]));
        assert_eq!(sources.union(&[both, a]), both);
        assert_eq!(sources.union(&[a, a]), a);
        assert_eq!(sources.union(&[]), SourceSet::EMPTY);
        let lines: Vec<u32> = sources.places(both).map(|place| place.line).collect();
        assert_eq!(lines, [1, 2]);
    }

    #[test]
    fn places_keep_their_number_when_order_breaks() {
        let mut sources = Sources::default();
        let order = [2, 4, 6, 4, 3, 8, 6, 3, 1];
        let sets: Vec<SourceSet> = order.map(|line| sources.single(place(line))).into();
        for (line, set) in order.into_iter().zip(&sets) {
            assert_eq!(sources.single(place(line)), *set);
            assert_eq!(sources.first(*set), Some(place(line)));
        }
        assert_eq!(sources.places.len(), 6);
    }
}
