//! Trees that combine the two earliest operands first.
//!
//! That is optimal for one associative operation of constant weight (Golumbic
//! 1976, Parker 1979): Huffman's algorithm on arrival times, with `max +
//! weight` instead of the sum.

use smallvec::SmallVec;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The two latest of some operands of a sum or product, and their number.
#[derive(Clone, Copy, Default, Debug)]
pub(crate) struct LatestTwo {
    latest: u32,
    second: u32,
    count: usize,
}

impl LatestTwo {
    /// Adds an operand.
    #[inline]
    pub(crate) fn add(&mut self, time: u32) {
        self.second = self.second.max(time.min(self.latest));
        self.latest = self.latest.max(time);
        self.count += 1;
    }

    /// A time before which the last operation is not done, and a flag: true
    /// when it is done then. Mostly a balanced tree of all other operands is
    /// done when the latest comes.
    #[inline]
    pub(crate) fn finish(self, weight: u32) -> (u32, bool) {
        let others = match self.count {
            0 | 1 => return (self.latest, true),
            2 => return (self.latest.saturating_add(weight), true),
            count => count - 2,
        };
        // Of three operands or more the two latest are not joined alone.
        let joined = self.latest.max(self.second.saturating_add(weight));
        let depth = usize::BITS - others.leading_zeros();
        let done = self.second.saturating_add(weight.saturating_mul(depth));
        (
            joined.saturating_add(weight),
            others == 1 || done <= self.latest,
        )
    }
}

/// Tests whether a tree of the operands can be done at a time: whether the
/// levels that there is time for obey Kraft's inequality.
pub(crate) fn fits(times: impl Iterator<Item = u32>, weight: u32, done: u32) -> bool {
    const WHOLE: u64 = 1 << 32;
    let Some(weight) = std::num::NonZeroU32::new(weight) else {
        return true;
    };
    let part = |time: u32| WHOLE >> (done.saturating_sub(time) / weight).min(32);
    times.map(part).sum::<u64>() <= WHOLE
}

/// Time at which the last operation of a sum or product is done.
pub(crate) fn finish(arrivals: impl IntoIterator<Item = u32>, weight: u32) -> u32 {
    let mut two = LatestTwo::default();
    let mut times: SmallVec<[u32; 32]> = SmallVec::new();
    for time in arrivals {
        two.add(time);
        times.push(time);
    }
    if let (time, true) = two.finish(weight) {
        return time;
    }
    let done = two.latest.saturating_add(weight);
    if fits(times.iter().copied(), weight, done) {
        done
    } else {
        joined(times, weight)
    }
}

/// Time at which the last operation of a sum or product of two operands or more
/// is done.
pub(crate) fn joined(mut times: SmallVec<[u32; 32]>, weight: u32) -> u32 {
    times.sort_unstable();
    // Results come in the order of their times: they queue up in the places
    // of the operands that have been taken.
    let (mut operand, mut result) = (0, 0);
    for made in 1..times.len() {
        let mut later = 0;
        for _ in 0..2 {
            let is_result =
                result + 1 < made && (operand == times.len() || times[result] <= times[operand]);
            let next = if is_result { &mut result } else { &mut operand };
            later = times[*next];
            *next += 1;
        }
        times[made - 1] = later.saturating_add(weight);
    }
    times[times.len() - 2]
}

/// For each operand the number of operations on its path in the tree. Of
/// operands with one time the first is taken first, and before results.
pub(crate) fn levels(arrivals: &[u32], weight: u32) -> SmallVec<[u32; 16]> {
    let count = arrivals.len();
    // Most have two or three.
    if count < 4 {
        let mut levels: SmallVec<[u32; 16]> =
            SmallVec::from_elem(count as u32 - u32::from(count > 0), count);
        let last = (0..count).max_by_key(|&operand| arrivals[operand]);
        if let (Some(last), 3) = (last, count) {
            levels[last] = 1;
        }
        return levels;
    }
    let mut order: SmallVec<[usize; 16]> = (0..count).collect();
    order.sort_by_key(|&operand| arrivals[operand]);
    // Results stand behind the operands, in the order they are made, which is
    // that of their times.
    let mut times: SmallVec<[u32; 32]> = SmallVec::from_slice(arrivals);
    let mut parents: SmallVec<[usize; 32]> = SmallVec::from_elem(usize::MAX, count);
    let (mut operand, mut result) = (0, count);
    for made in count..(2 * count).saturating_sub(1) {
        let mut later = 0;
        for _ in 0..2 {
            let next_operand = order.get(operand).copied();
            let next = match next_operand {
                Some(next) if result == made || times[next] <= times[result] => {
                    operand += 1;
                    next
                }
                _ => {
                    result += 1;
                    result - 1
                }
            };
            parents[next] = made;
            later = times[next];
        }
        times.push(later.saturating_add(weight));
        parents.push(usize::MAX);
    }
    let mut levels: SmallVec<[u32; 32]> = SmallVec::from_elem(0, parents.len());
    for place in (0..parents.len().saturating_sub(1)).rev() {
        levels[place] = levels[parents[place]] + 1;
    }
    levels.truncate(count);
    levels.into_iter().collect()
}

/// The order of terms that arrive at the same time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum TieOrder {
    /// The order of the terms; a result replaces its first operand.
    Written,
    /// The terms first, then the results in the order they were made.
    Made,
}

/// Number of open terms that have room without an allocation.
const FEW: usize = 8;

/// The places of terms to be joined, by arrival and place.
enum OpenTerms {
    /// Few are searched, which costs less than to keep a heap.
    Few(SmallVec<[(u32, usize); FEW]>),
    Many(BinaryHeap<Reverse<(u32, usize)>>),
}

impl OpenTerms {
    /// Terms with these arrivals, in the order of their places.
    fn new(arrivals: impl ExactSizeIterator<Item = u32>) -> OpenTerms {
        if arrivals.len() <= FEW {
            OpenTerms::Few(arrivals.zip(0..).collect())
        } else {
            OpenTerms::Many(arrivals.zip(0..).map(Reverse).collect())
        }
    }

    /// Takes out the earliest, the first of equals.
    fn pop(&mut self) -> Option<usize> {
        match self {
            OpenTerms::Few(terms) => {
                let (mut least, mut found) = (*terms.first()?, 0);
                for (index, &term) in terms.iter().enumerate() {
                    if term < least {
                        (least, found) = (term, index);
                    }
                }
                terms.swap_remove(found);
                Some(least.1)
            }
            OpenTerms::Many(terms) => terms.pop().map(|Reverse((_, place))| place),
        }
    }

    fn push(&mut self, arrival: u32, place: usize) {
        match self {
            OpenTerms::Few(terms) => terms.push((arrival, place)),
            OpenTerms::Many(terms) => terms.push(Reverse((arrival, place))),
        }
    }

    fn is_empty(&self) -> bool {
        match self {
            OpenTerms::Few(terms) => terms.is_empty(),
            OpenTerms::Many(terms) => terms.is_empty(),
        }
    }
}

/// Joins terms, always the two earliest, until one is left; `None` of none.
/// `join` gets them in the order chosen for ties, with a flag for the last
/// result. The vector is left with results in the places of terms.
pub(crate) fn join_earliest<T: Copy>(
    terms: &mut Vec<T>,
    ties: TieOrder,
    arrival: impl Fn(&T) -> u32,
    mut join: impl FnMut([T; 2], bool) -> T,
) -> Option<T> {
    if let [a, b] = terms[..] {
        return Some(join([a, b], true));
    }
    let mut open = OpenTerms::new(terms.iter().map(&arrival));
    loop {
        let a = open.pop()?;
        let Some(b) = open.pop() else {
            return Some(terms[a]);
        };
        let joined = join([terms[a.min(b)], terms[a.max(b)]], open.is_empty());
        let place = match ties {
            TieOrder::Written => a.min(b),
            TieOrder::Made => terms.len(),
        };
        open.push(arrival(&joined), place);
        match terms.get_mut(place) {
            Some(term) => *term = joined,
            None => terms.push(joined),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The best finish over all trees, by trying every first pair.
    fn best(arrivals: &[u32], weight: u32) -> u32 {
        if arrivals.len() <= 1 {
            return arrivals.first().copied().unwrap_or(0);
        }
        let mut best = u32::MAX;
        for i in 0..arrivals.len() {
            for j in i + 1..arrivals.len() {
                let mut rest: Vec<u32> = (0..arrivals.len())
                    .filter(|&k| k != i && k != j)
                    .map(|k| arrivals[k])
                    .collect();
                rest.push(arrivals[i].max(arrivals[j]) + weight);
                best = best.min(self::best(&rest, weight));
            }
        }
        best
    }

    #[test]
    fn earliest_first_is_optimal() {
        let mut state = 1u32;
        for round in 0..60 {
            let arrivals: Vec<u32> = (0..2 + round % 5)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (state >> 16) % 60
                })
                .collect();
            let expected = best(&arrivals, 12);
            assert_eq!(finish(arrivals.iter().copied(), 12), expected);
            let levels = levels(&arrivals, 12);
            let through = arrivals
                .iter()
                .zip(&levels)
                .map(|(at, level)| at + 12 * level);
            assert_eq!(through.max(), Some(expected));
            for ties in [TieOrder::Written, TieOrder::Made] {
                let join = |[a, b]: [u32; 2], _| a.max(b) + 12;
                let joined = join_earliest(&mut arrivals.clone(), ties, |&at| at, join);
                assert_eq!(joined, Some(expected));
            }
        }
        assert_eq!(finish([], 12), 0);
        assert_eq!(finish([5], 12), 5);
        assert!(levels(&[], 12).is_empty());
        assert_eq!(levels(&[5], 12)[..], [0]);
    }

    #[test]
    fn ties_are_broken_as_asked() {
        let tree = |ties| {
            let mut terms = ["a", "b", "c", "d", "e"].map(|name| (0, name)).to_vec();
            let mut joins = Vec::new();
            let join = |[a, b]: [(u32, &'static str); 2], _| {
                joins.push([a.1, b.1]);
                (a.0.max(b.0), "r")
            };
            join_earliest(&mut terms, ties, |term| term.0, join);
            joins
        };
        // Nothing weighs anything, so all arrive at the same time.
        let [r, d, e] = ["r", "d", "e"];
        assert_eq!(
            tree(TieOrder::Written),
            [["a", "b"], [r, "c"], [r, d], [r, e]]
        );
        assert_eq!(tree(TieOrder::Made), [["a", "b"], ["c", d], [e, r], [r, r]]);
        assert_eq!(levels(&[0; 5], 0)[..], [3, 3, 2, 2, 2]);
    }
}
