//! A direct-mapped cache of the sums requested last.

use super::term::{ProductTerm, SignedClass};
use rustc_hash::FxBuildHasher;
use smallvec::SmallVec;
use std::hash::BuildHasher;

/// Number of sums that are kept: few enough for the processor's cache.
const KEPT: usize = 1 << 11;

/// Terms in the order given, and the class of their sum; `None` for zero.
#[derive(Clone, Default)]
struct RecentSum {
    terms: SmallVec<[ProductTerm; 6]>,
    class: Option<SignedClass>,
}

/// Sums with their classes, each at the place of its hash, where it replaces
/// the one before.
///
/// A form at one frontier has mostly the coefficients that it has at the next,
/// and those of one row serve all columns: half of all sums were requested
/// just before. A hit needs neither sorting nor the tables of the network.
#[derive(Default)]
pub(crate) struct RecentSums {
    sums: Vec<RecentSum>,
}

impl RecentSums {
    pub(crate) fn place(terms: &[ProductTerm]) -> usize {
        let hash = FxBuildHasher.hash_one(terms);
        (hash ^ hash >> 32) as usize % KEPT
    }

    /// The class of these terms in this order; outer `None` when not kept.
    pub(crate) fn find(&self, place: usize, terms: &[ProductTerm]) -> Option<Option<SignedClass>> {
        let sum = self.sums.get(place)?;
        (sum.terms[..] == *terms).then_some(sum.class)
    }

    /// Keeps the class of a sum of one term or more.
    pub(crate) fn keep(
        &mut self,
        place: usize,
        terms: SmallVec<[ProductTerm; 6]>,
        class: Option<SignedClass>,
    ) {
        assert!(!terms.is_empty(), "an empty place has no sum");
        if self.sums.is_empty() {
            self.sums = vec![RecentSum::default(); KEPT];
        }
        self.sums[place] = RecentSum { terms, class };
    }
}
