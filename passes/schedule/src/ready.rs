//! The operations that could be issued, best first, and those that will be.

use super::graph::DependenceGraph;
use super::order::SchedulingOrder;

/// A set of ranks that finds its smallest member, or the next one after a
/// rank, in a handful of word operations.
///
/// Every 64 members of a level share one word of the level above, so a set
/// over 600,000 ranks is four levels high and takes 80 kB: it stays in the
/// cache where a heap of the same ranks would not, and stepping over an
/// operation that finds no element needs no removal and reinsertion.
#[derive(Clone, Debug)]
pub(super) struct RankSet {
    levels: Vec<Vec<u64>>,
}

impl RankSet {
    /// The empty set over the ranks `0..capacity`.
    pub(super) fn new(capacity: usize) -> RankSet {
        let mut levels = Vec::new();
        let mut words = capacity.div_ceil(64).max(1);
        loop {
            levels.push(vec![0; words]);
            if words == 1 {
                return RankSet { levels };
            }
            words = words.div_ceil(64);
        }
    }

    /// Adds a rank.
    pub(super) fn insert(&mut self, rank: u32) {
        let mut index = rank as usize;
        for level in &mut self.levels {
            let word = &mut level[index >> 6];
            let was_empty = *word == 0;
            *word |= 1 << (index & 63);
            if !was_empty {
                return;
            }
            index >>= 6;
        }
    }

    /// Removes a rank.
    pub(super) fn remove(&mut self, rank: u32) {
        let mut index = rank as usize;
        for level in &mut self.levels {
            let word = &mut level[index >> 6];
            *word &= !(1 << (index & 63));
            if *word != 0 {
                return;
            }
            index >>= 6;
        }
    }

    /// The smallest member that is at least `rank`.
    pub(super) fn next_from(&self, rank: u32) -> Option<u32> {
        let mut index = rank as usize;
        let mut height = 0;
        // Climbs until a word has a member at or after the index, then
        // descends along the first members.
        loop {
            let level = self.levels.get(height)?;
            let word = level.get(index >> 6).copied().unwrap_or(0);
            let rest = word & (u64::MAX << (index & 63));
            if rest != 0 {
                index = (index & !63) | rest.trailing_zeros() as usize;
                break;
            }
            index = (index >> 6) + 1;
            height += 1;
        }
        for level in self.levels[..height].iter().rev() {
            index = (index << 6) | level[index].trailing_zeros() as usize;
        }
        Some(index as u32)
    }

    /// True when there is no member.
    pub(super) fn is_empty(&self) -> bool {
        self.levels.last().is_none_or(|top| top[0] == 0)
    }
}

/// Operations by the cycle from which they may be tried: a ring of buckets,
/// long enough for the longest wait.
#[derive(Clone, Debug)]
pub(super) struct Calendar {
    buckets: Vec<Vec<u32>>,
    waiting: usize,
}

impl Calendar {
    /// An empty calendar for waits of up to `longest_wait` cycles.
    pub(super) fn new(longest_wait: u32) -> Calendar {
        Calendar {
            buckets: vec![Vec::new(); longest_wait as usize + 1],
            waiting: 0,
        }
    }

    /// Enters a node for a cycle at most the longest wait away.
    pub(super) fn enter(&mut self, cycle: u32, node: u32) {
        let length = self.buckets.len();
        self.buckets[cycle as usize % length].push(node);
        self.waiting += 1;
    }

    /// Hands the nodes of a cycle to `take`, in order of entry.
    fn drain(&mut self, cycle: u32, mut take: impl FnMut(u32)) {
        let length = self.buckets.len();
        let bucket = &mut self.buckets[cycle as usize % length];
        self.waiting -= bucket.len();
        for node in bucket.drain(..) {
            take(node);
        }
    }

    /// The first cycle from `cycle` on that has an entry.
    fn next_from(&self, cycle: u32) -> Option<u32> {
        if self.waiting == 0 {
            return None;
        }
        let length = self.buckets.len() as u32;
        (cycle..cycle + length).find(|&at| !self.buckets[(at % length) as usize].is_empty())
    }
}

/// The operations that are ready, and those that will be.
pub(super) struct ReadyNodes {
    /// The ranks of those that are ready, by kind.
    pub(super) sets: Vec<RankSet>,
    /// The others whose cycle is known.
    pub(super) calendar: Calendar,
}

impl ReadyNodes {
    /// None, for waits of up to `longest_wait` cycles.
    pub(super) fn new(order: &SchedulingOrder, longest_wait: u32) -> ReadyNodes {
        let nodes = order.nodes.iter();
        ReadyNodes {
            sets: nodes.map(|nodes| RankSet::new(nodes.len())).collect(),
            calendar: Calendar::new(longest_wait),
        }
    }

    /// The first cycle from `cycle` on with operations that are ready, which
    /// are then in their sets; `None` after the last one.
    pub(super) fn advance(
        &mut self,
        graph: &DependenceGraph,
        order: &SchedulingOrder,
        mut cycle: u32,
    ) -> Option<u32> {
        if self.sets.iter().all(RankSet::is_empty) {
            cycle = self.calendar.next_from(cycle)?;
        }
        self.calendar.drain(cycle, |node| {
            let node = node as usize;
            self.sets[graph.kind[node] as usize].insert(order.rank[node]);
        });
        Some(cycle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_num::random::Random;

    #[test]
    fn a_rank_set_agrees_with_a_sorted_set() {
        let mut set = RankSet::new(300_000);
        let mut model = std::collections::BTreeSet::new();
        let mut random = Random::new(1);
        for step in 0..20_000 {
            let rank = random.below(300_000) as u32;
            if step % 3 == 2 {
                let victim = model.range(rank..).next().copied();
                assert_eq!(set.next_from(rank), victim);
                if let Some(victim) = victim {
                    set.remove(victim);
                    model.remove(&victim);
                }
            } else {
                set.insert(rank);
                model.insert(rank);
            }
            assert_eq!(set.is_empty(), model.is_empty());
        }
        for rank in model {
            assert_eq!(set.next_from(0), Some(rank));
            set.remove(rank);
        }
        assert!(set.is_empty());
        assert_eq!(set.next_from(0), None);
    }

    #[test]
    fn a_calendar_gives_back_what_falls_due() {
        let mut calendar = Calendar::new(5);
        calendar.enter(7, 1);
        calendar.enter(9, 2);
        calendar.enter(7, 3);
        assert_eq!(calendar.next_from(5), Some(7));
        let mut due = Vec::new();
        calendar.drain(7, |node| due.push(node));
        assert_eq!(due, [1, 3]);
        assert_eq!(calendar.next_from(8), Some(9));
        calendar.drain(9, |node| due.push(node));
        assert_eq!(calendar.next_from(10), None);
    }
}
