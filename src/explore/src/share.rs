//! A share of the work of an exploration, for several workers on one folder.
//!
//! Where pieces of work do not depend on one another a worker does only those
//! of its share. In a search the next trial depends on the results of all
//! earlier ones: there a worker does its own pieces first, then reads those of
//! the others from the folder or does them itself. No worker waits for another.

use super::store::{PointKey, PointStore, build_key};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io;
use std::str::FromStr;

/// A share of the work: the `k`-th of `n`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct WorkShare {
    k: usize,
    n: usize,
}

impl WorkShare {
    /// All of the work.
    pub const ALL: WorkShare = WorkShare { k: 1, n: 1 };

    /// Tests whether the share holds a piece of work, by its number from 0.
    pub fn holds(self, number: usize) -> bool {
        number % self.n == self.k - 1
    }

    /// Order of a number of pieces of work: first those of the share, then
    /// those of others, the last one first, since others begin at the front.
    pub fn own_and_others(self, count: usize) -> [Vec<usize>; 2] {
        let (own, mut others): (Vec<usize>, Vec<usize>) =
            (0..count).partition(|&number| self.holds(number));
        others.reverse();
        [own, others]
    }
}

/// Store of an exploration's results, and the share of it that is done.
#[derive(Clone, Copy, Debug)]
pub struct SharedWork<'a> {
    /// Absent without a store.
    kept: Option<(&'a PointStore, PointKey)>,
    /// The share.
    pub share: WorkShare,
}

impl<'a> SharedWork<'a> {
    /// All of the work, without storage.
    pub const ALONE: SharedWork<'static> = SharedWork {
        kept: None,
        share: WorkShare::ALL,
    };

    /// A share of the work, whose results are kept in a store, if given.
    pub fn new(store: Option<&'a PointStore>, share: WorkShare) -> SharedWork<'a> {
        SharedWork {
            // Where the build cannot be known no result can be told from another's.
            kept: store.zip(build_key().ok()),
            share,
        }
    }

    /// The key of results of this build, without dependences, with a store.
    pub fn key(&self, kind: &str) -> Option<PointKey> {
        let (_, build) = self.kept?;
        Some(build.with(kind))
    }

    /// The result of a key, if it is kept.
    pub fn load<P: Serialize + DeserializeOwned>(&self, key: Option<PointKey>) -> Option<P> {
        let ((store, _), key) = self.kept.zip(key)?;
        store.load(key)
    }

    /// Keeps a result. One that cannot be kept is only made again.
    pub fn save(&self, key: Option<PointKey>, point: &impl Serialize) {
        if let Some(((store, _), key)) = self.kept.zip(key) {
            drop(store.save(key, point));
        }
    }

    /// The result of a key, measured if missing; true if it was stored.
    pub fn point<P: Serialize + DeserializeOwned>(
        &self,
        key: Option<PointKey>,
        measure: impl FnOnce() -> P,
    ) -> io::Result<(P, bool)> {
        if let Some(known) = self.load(key) {
            return Ok((known, true));
        }
        let point = measure();
        if let Some(((store, _), key)) = self.kept.zip(key) {
            store.save(key, &point)?;
        }
        Ok((point, false))
    }
}

impl FromStr for WorkShare {
    type Err = String;

    fn from_str(text: &str) -> Result<WorkShare, String> {
        let wrong = || "a share is K/N with K from 1 to N, as 2/8".to_owned();
        let (k, n) = text.split_once('/').ok_or_else(wrong)?;
        let read = |text: &str| text.parse::<usize>().map_err(|_| wrong());
        let (k, n) = (read(k)?, read(n)?);
        if (1..=n).contains(&k) {
            Ok(WorkShare { k, n })
        } else {
            Err(wrong())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_of_work_is_in_one_share() {
        let shares: Vec<WorkShare> = (1..=3)
            .map(|k| format!("{k}/3").parse().expect("a share"))
            .collect();
        for number in 0..10 {
            let holders = shares.iter().filter(|share| share.holds(number));
            assert_eq!(holders.count(), 1, "{number}");
            assert!(WorkShare::ALL.holds(number));
        }
        let [own, others] = shares[1].own_and_others(7);
        assert_eq!((own, others), (vec![1, 4], vec![6, 5, 3, 2, 0]));
        for wrong in ["0/3", "4/3", "1", "1/0", "-1/2", "a/b"] {
            assert!(wrong.parse::<WorkShare>().is_err(), "{wrong}");
        }
    }
}
