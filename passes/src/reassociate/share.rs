//! Pairs of leaves that occur together in several groups.
//!
//! Two terms that several sums have in common are worth adding once. The
//! count of a pair says in how many groups it occurs; groups with many leaves
//! are left out, so that the number of pairs stays linear.

use super::gather::{Family, Leaf};
use hashbrown::HashMap;
use robovec_ir::Operand;
use rustc_hash::FxBuildHasher;

/// The largest group whose pairs are considered.
pub(super) const LARGEST_GROUP: usize = 16;

/// Two leaves of a group, up to order and common sign.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
struct Pair {
    first: Operand,
    second: Operand,
    /// 0 for factors, 1 for terms of equal sign, 2 for opposite signs.
    relation: u8,
}

fn pair(family: Family, a: Leaf, b: Leaf) -> Pair {
    let relation = match family {
        Family::Product => 0,
        Family::Sum => 1 + u8::from(a.negative != b.negative),
    };
    Pair {
        first: a.operand.min(b.operand),
        second: a.operand.max(b.operand),
        relation,
    }
}

/// In how many groups each pair occurs.
#[derive(Default)]
pub(super) struct PairCounts {
    counts: HashMap<Pair, u32, FxBuildHasher>,
}

impl PairCounts {
    /// Counts the pairs of one group, each once.
    pub(super) fn add(&mut self, family: Family, leaves: &[Leaf]) {
        if leaves.len() > LARGEST_GROUP {
            return;
        }
        for (index, &a) in leaves.iter().enumerate() {
            for &b in &leaves[index + 1..] {
                *self.counts.entry(pair(family, a, b)).or_insert(0) += 1;
            }
        }
    }

    pub(super) fn of(&self, family: Family, a: Leaf, b: Leaf) -> u32 {
        self.counts.get(&pair(family, a, b)).copied().unwrap_or(0)
    }
}
