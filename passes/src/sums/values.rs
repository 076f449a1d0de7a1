//! Values known by their fingerprints, each up to its sign.

use super::places::PlaceTable;
use robovec_framework::fingerprint::{Fingerprint, Images};
use robovec_num::arithmetic::Arithmetic;
use rustc_hash::FxBuildHasher;
use std::hash::BuildHasher;

/// Values by their places, counted from 0, and the places of those that may be
/// found again. A value has the sign with which it was first met, so that no
/// sign depends on the primes.
#[derive(Clone)]
pub(crate) struct ValueTable {
    /// The images in which values are identified.
    pub(crate) images: Images,
    values: Vec<Fingerprint>,
    places: PlaceTable,
}

impl ValueTable {
    /// An empty table.
    pub(crate) fn new(images: Images) -> ValueTable {
        ValueTable {
            images,
            values: Vec::new(),
            places: PlaceTable::default(),
        }
    }

    /// Reserves memory for this number of values.
    pub(crate) fn reserve(&mut self, values: usize) {
        self.values.reserve(values);
        let hash_at = hash_at(&self.images, &self.values);
        self.places.reserve(values, hash_at);
    }

    pub(crate) fn value(&self, place: usize) -> Fingerprint {
        self.values[place]
    }

    /// Adds a value that is not found again, unless it is
    /// [remembered](ValueTable::remember).
    pub(crate) fn push(&mut self, value: Fingerprint) -> u32 {
        self.values.push(value);
        self.values.len() as u32 - 1
    }

    /// The place of a value, and a flag: true when the stored value is its
    /// negation.
    pub(crate) fn find(&self, value: Fingerprint) -> Option<(u32, bool)> {
        self.find_hashed(value, hash(&self.images, value))
    }

    fn find_hashed(&self, value: Fingerprint, hash: u64) -> Option<(u32, bool)> {
        let equal = is_equal(&self.images, &self.values, value);
        let place = self.places.find(hash, equal)?;
        Some((place, value.is_negation_of(&self.values[place as usize])))
    }

    /// As [`ValueTable::find`]; a new value gets the next place.
    pub(crate) fn place(&mut self, value: Fingerprint) -> (u32, bool) {
        let hash = hash(&self.images, value);
        self.find_hashed(value, hash).unwrap_or_else(|| {
            let place = self.push(value);
            self.insert(hash, place);
            (place, false)
        })
    }

    /// Adds the value at a place to the index, unless an equal one is in it.
    pub(crate) fn remember(&mut self, place: u32) {
        let value = self.values[place as usize];
        let hash = hash(&self.images, value);
        if self.find_hashed(value, hash).is_none() {
            self.insert(hash, place);
        }
    }

    fn insert(&mut self, hash: u64, place: u32) {
        let hash_at = hash_at(&self.images, &self.values);
        self.places.insert(hash, place, hash_at);
    }

    /// Lets the value at a place not be found any more.
    pub(crate) fn forget(&mut self, place: u32) {
        let value = self.values[place as usize];
        let equal = is_equal(&self.images, &self.values, value);
        self.places.remove(hash(&self.images, value), equal);
    }

    /// Lets no value be found any more.
    pub(crate) fn forget_all(&mut self) {
        self.places.clear();
    }
}

fn hash(images: &Images, value: Fingerprint) -> u64 {
    FxBuildHasher.hash_one(images.without_sign(value).0)
}

/// The hash of the value at a place.
fn hash_at(images: &Images, values: &[Fingerprint]) -> impl Fn(u32) -> u64 {
    |place| hash(images, values[place as usize])
}

/// Tests whether the value at a place is equal to another or to its negation.
fn is_equal(images: &Images, values: &[Fingerprint], value: Fingerprint) -> impl Fn(u32) -> bool {
    let negation = images.neg(value);
    move |place| [value, negation].contains(&values[place as usize])
}
