//! Sums that were looked for a short while ago.

use super::term::{ProductTerm, SignedClass};
use rustc_hash::FxBuildHasher;
use smallvec::SmallVec;
use std::hash::BuildHasher;

/// Number of sums that are kept: few enough to stay near the processor.
const KEPT: usize = 1 << 11;

/// Terms as they were given, and the class they are; `None` of zero.
#[derive(Clone, Default)]
struct RecentSum {
    terms: SmallVec<[ProductTerm; 6]>,
    class: Option<SignedClass>,
}

/// Sums and the classes they were found to be, each in the place its hash
/// tells, where the next one with that place takes it.
///
/// A form at one frontier has mostly the coefficients that it has at the next,
/// and those of one row serve all columns: half of all sums were looked for
/// just before. Here that costs neither sorting nor a look into tables of the
/// size of the network.
#[derive(Default)]
pub(crate) struct RecentSums {
    sums: Vec<RecentSum>,
}

impl RecentSums {
    /// The place of a sum.
    pub(crate) fn place(terms: &[ProductTerm]) -> usize {
        let hash = FxBuildHasher.hash_one(terms);
        (hash ^ hash >> 32) as usize % KEPT
    }

    /// The class of these terms in this order, when they are kept.
    pub(crate) fn find(&self, place: usize, terms: &[ProductTerm]) -> Option<Option<SignedClass>> {
        let sum = self.sums.get(place)?;
        (sum.terms[..] == *terms).then_some(sum.class)
    }

    /// Keeps what a sum of terms, at least one, was found to be.
    pub(crate) fn keep(
        &mut self,
        place: usize,
        terms: SmallVec<[ProductTerm; 6]>,
        class: Option<SignedClass>,
    ) {
        assert!(!terms.is_empty(), "an empty place stands for no sum");
        if self.sums.is_empty() {
            self.sums = vec![RecentSum::default(); KEPT];
        }
        self.sums[place] = RecentSum { terms, class };
    }
}
