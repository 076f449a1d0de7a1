//! Sorting of indices by numbers of 32 bits, in linear time.
//!
//! A compiler of large functions sorts mostly numbers of values by a cycle or a
//! count. Comparing costs twenty steps for each of 600,000 of them; counting
//! the keys costs two where these are few, and distributing by eleven bits of
//! the key at a time two for each of these.
//!
//! # Invariant
//!
//! The order is stable: equal keys keep their original order. So to sort by a
//! pair, sort by the second part first.

/// Bits of a key that are considered in one pass.
const DIGIT_BITS: u32 = 11;

/// Maximum number of key bits counted in one pass: their counts still fit into
/// a second-level cache.
const COUNTED_BITS: u32 = 17;

/// Sequences up to this length are compared, which costs less than the counts
/// of a pass.
const SHORT: usize = 256;

/// Sorts indices by the key of each, smallest first; equal keys keep their
/// order.
pub fn sort_by_key(order: &mut Vec<u32>, key: impl Fn(u32) -> u32) {
    if order.len() <= SHORT {
        order.sort_by_key(|&index| key(index));
        return;
    }
    let range = order
        .iter()
        .fold((u32::MAX, 0), |(least, largest), &index| {
            let key = key(index);
            (key.min(least), key.max(largest))
        });
    let (least, largest) = range;
    // What all keys have in common takes no pass.
    let key = |index: u32| key(index) - least;
    let bits = u32::BITS - (largest - least).leading_zeros();
    if bits <= COUNTED_BITS.min(order.len().ilog2()) {
        *order = counted(order, (largest - least) as usize + 1, key);
        return;
    }
    let mut keyed: Vec<(u32, u32)> = order.iter().map(|&index| (key(index), index)).collect();
    let mut other = vec![(0, 0); keyed.len()];
    for shift in (0..bits).step_by(DIGIT_BITS as usize) {
        distribute(&keyed, &mut other, shift);
        std::mem::swap(&mut keyed, &mut other);
    }
    order.clear();
    order.extend(keyed.into_iter().map(|(_, index)| index));
    debug_assert!(
        order.is_sorted_by_key(|&index| key(index)),
        "indices are in the order of their keys"
    );
}

/// The indices below `count`, sorted by the key of each; equal keys in
/// increasing order.
pub fn sorted_by_key(count: usize, key: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    sort_by_key(&mut order, key);
    order
}

/// The indices in the order of their keys, which are below a bound.
fn counted(order: &[u32], bound: usize, key: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut next = vec![0u32; bound];
    for &index in order {
        next[key(index) as usize] += 1;
    }
    let mut start = 0;
    for place in &mut next {
        (*place, start) = (start, start + *place);
    }
    let mut sorted = vec![0; order.len()];
    for &index in order {
        let place = &mut next[key(index) as usize];
        sorted[*place as usize] = index;
        *place += 1;
    }
    sorted
}

/// One pass: copies the pairs in the order of one digit of their keys.
fn distribute(from: &[(u32, u32)], to: &mut [(u32, u32)], shift: u32) {
    let digit = |key: u32| (key >> shift) as usize & ((1 << DIGIT_BITS) - 1);
    let mut next = [0u32; 1 << DIGIT_BITS];
    for &(key, _) in from {
        next[digit(key)] += 1;
    }
    let mut start = 0;
    for place in &mut next {
        (*place, start) = (start, start + *place);
    }
    for &pair in from {
        let place = &mut next[digit(pair.0)];
        to[*place as usize] = pair;
        *place += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn the_order_is_that_of_a_stable_sort() {
        let mut random = Random::new(1);
        for (count, keys) in [(0, 1), (100, 10), (5000, 1), (5000, 300), (5000, 1 << 31)] {
            let keys: Vec<u32> = (0..count).map(|_| random.below(keys) as u32).collect();
            let mut expected: Vec<u32> = (0..count as u32).collect();
            expected.sort_by_key(|&index| keys[index as usize]);
            assert_eq!(sorted_by_key(count, |index| keys[index as usize]), expected);
        }
    }
}
