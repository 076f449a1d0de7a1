//! The host's window: the addresses of all memories.
//!
//! Eight control registers come first, then one block with all instruction
//! memories and one with all operand memories. Within a block all memories
//! have equal regions, and every block starts at a multiple of its size, so
//! that block, memory, word and limb are fields of the address and nothing
//! has to be subtracted.

/// Memories of one sort.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Block {
    /// First address.
    pub(crate) base: u32,
    /// 32-bit limbs of the widest word.
    pub(crate) limbs: u32,
    /// Address bits that count limbs.
    pub(crate) limb_bits: u32,
    /// Address bits that count words.
    pub(crate) word_bits: u32,
    /// Address bits that count memories.
    pub(crate) unit_bits: u32,
}

impl Block {
    /// The block of a number of memories, at no address yet.
    pub(super) fn new(width: u32, word_bits: u32, units: u32) -> Block {
        let limbs = width.div_ceil(32);
        Block {
            base: 0,
            limbs,
            limb_bits: log2(limbs),
            word_bits,
            unit_bits: log2(units),
        }
    }

    /// Bits of an address within the block.
    pub(crate) fn bits(&self) -> u32 {
        self.limb_bits + self.word_bits + self.unit_bits
    }

    /// The bit at which the number of the memory begins in an address.
    pub(crate) fn unit_low(&self) -> u32 {
        self.limb_bits + self.word_bits
    }

    /// The first address of a memory.
    pub(super) fn address(&self, unit: u32) -> u32 {
        assert!(unit >> self.unit_bits == 0, "the block has the memory");
        self.base + (unit << self.unit_low())
    }
}

/// The smallest number of bits that distinguishes `count` things.
fn log2(count: u32) -> u32 {
    count.next_power_of_two().trailing_zeros()
}

/// The map.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct AddressBlocks {
    /// Bits of the host's address.
    pub(crate) address_bits: u32,
    /// The instruction memories, in order of the elements.
    pub(crate) instructions: Block,
    /// The operand memories, element by element.
    pub(crate) operands: Block,
}

impl AddressBlocks {
    /// The map of two blocks.
    pub(super) fn new(mut instructions: Block, mut operands: Block) -> AddressBlocks {
        let (small, large) = if instructions.bits() < operands.bits() {
            (&mut instructions, &mut operands)
        } else {
            (&mut operands, &mut instructions)
        };
        assert!(small.bits() >= 6, "the registers lie below the blocks");
        small.base = 1u32.unbounded_shl(small.bits());
        let step = u32::from(small.bits() == large.bits());
        large.base = (1 + step) << large.bits().min(30);
        let address_bits = large.bits() + 1 + step;
        AddressBlocks {
            address_bits,
            instructions,
            operands,
        }
    }
}
