//! Values that may compute the same, found without a comparison of pairs.
//!
//! A table of 600,000 operations is larger than the caches, and nearly every
//! lookup in it fails. So operations are hashed first, with their operands down
//! to inputs and constants, and only operations whose hash occurs twice need an
//! entry in a table. The bits that show so lie in a cache of second level.

use super::Key;
use robovec_ir::{Function, Operand, Value};

/// Bits of a set for each value: one value in sixteen then meets another
/// one by chance.
const BITS_PER_VALUE: usize = 8;

/// The values of a function that may be equal to another one.
///
/// **Invariant.** Of two values that compute the same operation on the same
/// operands, or would once equal values were merged, both are lookalikes.
pub(super) struct Lookalikes {
    hashes: Vec<u32>,
    /// The hashes that are there more than once.
    repeated: HashSetOfBits,
}

impl Lookalikes {
    pub(super) fn find(function: &Function) -> Lookalikes {
        let count = function.nodes().len();
        let mut hashes: Vec<u32> = Vec::with_capacity(count);
        let mut seen = HashSetOfBits::for_values(count);
        let mut repeated = HashSetOfBits::for_values(count);
        for node in function.nodes() {
            // Equal values have equal hashes, whatever number they bear.
            let operands = node.operands.map(|operand| match operand.value() {
                Some(value) => Operand::from(Value(hashes[value.index()] >> 2)),
                None => operand,
            });
            let hash = Key::new(node.operation, operands).hash();
            let hash = (hash ^ hash >> 32) as u32;
            if !seen.insert(hash) {
                repeated.insert(hash);
            }
            hashes.push(hash);
        }
        Lookalikes { hashes, repeated }
    }

    /// True for a value that may be equal to another one.
    pub(super) fn has(&self, value: Value) -> bool {
        self.repeated.has(self.hashes[value.index()])
    }

    /// The number of them.
    pub(super) fn count(&self) -> usize {
        let hashes = self.hashes.iter();
        hashes.filter(|&&hash| self.repeated.has(hash)).count()
    }
}

/// A set of hashes that may hold more than was entered.
struct HashSetOfBits {
    words: Vec<u64>,
    /// The number of bits is a power of two.
    mask: u32,
}

impl HashSetOfBits {
    fn for_values(count: usize) -> HashSetOfBits {
        let bits = (BITS_PER_VALUE * count).next_power_of_two();
        let bits = bits.clamp(u64::BITS as usize, 1 << 31);
        HashSetOfBits {
            words: vec![0; bits / u64::BITS as usize],
            mask: bits as u32 - 1,
        }
    }

    fn place(&self, hash: u32) -> (usize, u64) {
        let bit = hash & self.mask;
        ((bit / u64::BITS) as usize, 1 << (bit % u64::BITS))
    }

    /// Enters a hash; false when it may have been there.
    fn insert(&mut self, hash: u32) -> bool {
        let (word, bit) = self.place(hash);
        let known = self.words[word] & bit != 0;
        self.words[word] |= bit;
        !known
    }

    fn has(&self, hash: u32) -> bool {
        let (word, bit) = self.place(hash);
        self.words[word] & bit != 0
    }
}
