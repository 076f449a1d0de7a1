//! Pairs of leaves that occur together in several groups.
//!
//! Two terms that several sums have in common are worth adding once. The count
//! of a pair is the number of groups that contain it; groups with many leaves
//! are left out, so that the number of pairs stays linear.
//!
//! Counts are kept without their pairs, one byte per slot of a table four times
//! as large as the number of pairs: pairs that meet in a slot are counted
//! together. That can only make a pair seem more wanted than it is, which is
//! harmless, and the same function always gives the same counts.

use crate::hash;
use crate::sums::groups::{GroupFamily, GroupLeaf};

/// The largest group whose pairs are considered.
pub(super) const LARGEST_GROUP: usize = 16;

/// The number of pairs of a group that are counted.
pub(super) fn pairs_of(leaves: usize) -> usize {
    if leaves > LARGEST_GROUP {
        0
    } else {
        leaves * leaves.saturating_sub(1) / 2
    }
}

/// Number of groups that contain each pair.
pub(super) struct PairCounts {
    slots: Vec<u8>,
}

impl PairCounts {
    /// An empty table for about this number of pairs.
    pub(super) fn with_capacity(pairs: usize) -> PairCounts {
        let slots = (4 * pairs).next_power_of_two().clamp(1 << 10, 1 << 26);
        PairCounts {
            slots: vec![0; slots],
        }
    }

    /// Counts the pairs of one group, each once.
    pub(super) fn add(&mut self, family: GroupFamily, leaves: &[GroupLeaf]) {
        if leaves.len() > LARGEST_GROUP {
            return;
        }
        for (index, &a) in leaves.iter().enumerate() {
            for &b in &leaves[index + 1..] {
                let slot = self.slot(family, a, b);
                self.slots[slot] = self.slots[slot].saturating_add(1);
            }
        }
    }

    pub(super) fn of(&self, family: GroupFamily, a: GroupLeaf, b: GroupLeaf) -> u32 {
        u32::from(self.slots[self.slot(family, a, b)])
    }

    /// The slot of two leaves, for any order and common sign.
    fn slot(&self, family: GroupFamily, a: GroupLeaf, b: GroupLeaf) -> usize {
        let relation = match family {
            GroupFamily::Product => 0,
            GroupFamily::Sum => 1 + u64::from(a.negative != b.negative),
        };
        let low = a.operand.min(b.operand).bits();
        let high = a.operand.max(b.operand).bits();
        let pair = u64::from(low) << 32 | u64::from(high);
        let hash = hash::of_words(&[relation, pair]);
        (hash >> 20) as usize & (self.slots.len() - 1)
    }
}
