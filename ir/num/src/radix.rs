//! Sorting of indices by numbers of 32 bits, in linear time.
//!
//! What is sorted in a compiler of large functions is nearly always the
//! numbers of values by a cycle or a count. Comparing costs twenty steps for
//! each of 600,000 of them; distributing them by eleven bits of their key at a
//! time costs two for any number of cycles that occurs.
//!
//! # Invariant
//!
//! The order is stable: equal keys keep the order they came in. So to sort by
//! a pair, sort by the second part first.

/// Bits of a key that are looked at in one pass.
const DIGIT_BITS: u32 = 11;

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
    let mut keyed: Vec<(u32, u32)> = order.iter().map(|&index| (key(index), index)).collect();
    let keys = || keyed.iter().map(|&(key, _)| key);
    let (least, largest) = (keys().min().unwrap_or(0), keys().max().unwrap_or(0));
    // What all keys have in common takes no pass.
    keyed.iter_mut().for_each(|(key, _)| *key -= least);
    let bits = u32::BITS - (largest - least).leading_zeros();
    let mut other = vec![(0, 0); keyed.len()];
    for shift in (0..bits).step_by(DIGIT_BITS as usize) {
        distribute(&keyed, &mut other, shift);
        std::mem::swap(&mut keyed, &mut other);
    }
    order.clear();
    order.extend(keyed.into_iter().map(|(_, index)| index));
}

/// The indices below `count`, sorted by the key of each; equal keys in
/// increasing order.
pub fn sorted_by_key(count: usize, key: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    sort_by_key(&mut order, key);
    order
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
