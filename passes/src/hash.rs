//! Hashes that affect results: slots of counters, and the order of otherwise
//! equal items.
//!
//! The hasher that tables use computes otherwise where pointers have 32 bits,
//! as in WebAssembly. On 64-bit targets these functions give the same values.

const MULTIPLIER: u64 = 0xf135_7aea_2e62_a9c5;
const SEEDS: [u64; 2] = [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344];
const AGAINST_ZERO: u64 = 0xa409_3822_299f_31d0;

/// Hash of single numbers, one after another.
pub(crate) fn of_words(words: &[u64]) -> u64 {
    let add = |hash: u64, word: &u64| hash.wrapping_add(*word).wrapping_mul(MULTIPLIER);
    words.iter().fold(0, add).rotate_left(26)
}

/// Hash of a number with a list that is not empty.
pub(crate) fn of_list(number: u64, list: &[u64]) -> u64 {
    let (last, others) = list.split_last().expect("a list of operands");
    let [mut a, mut b] = SEEDS;
    for pair in others.chunks_exact(2) {
        (a, b) = (b, folded(a ^ pair[0], AGAINST_ZERO ^ pair[1]));
    }
    let count = list.len() as u64;
    let of_list = folded(a ^ others.last().unwrap_or(last), b ^ last) ^ (8 * count);
    of_words(&[number, count, of_list])
}

/// Both halves of a product over one another.
fn folded(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    product as u64 ^ (product >> 64) as u64
}

#[cfg(all(test, target_pointer_width = "64"))]
mod tests {
    use super::*;
    use rustc_hash::FxBuildHasher;
    use std::hash::BuildHasher;

    #[test]
    fn hashes_are_those_of_tables_with_long_pointers() {
        let mut numbers = robovec_num::random::Random::new(1);
        for length in 1..=7 {
            let list: Vec<u64> = (0..length).map(|_| numbers.bits()).collect();
            let number = numbers.bits() as u32;
            assert_eq!(
                of_list(number.into(), &list),
                FxBuildHasher.hash_one((number, &list))
            );
            let pair = (number, list[0]);
            assert_eq!(
                of_words(&[number.into(), list[0]]),
                FxBuildHasher.hash_one(pair)
            );
        }
    }
}
