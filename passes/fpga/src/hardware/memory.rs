//! Memories: number and kind of the blocks for a number of words.

use robovec_ir::machine::Device;

/// Words of an MLAB.
const LAB_WORDS: u32 = 32;

/// Bits of a word of an MLAB.
const LAB_WIDTH: u32 = 20;

fn least(shapes: &[[u32; 2]], words: u32, bits: u32) -> u32 {
    let counts = shapes
        .iter()
        .map(|[depth, width]| words.div_ceil(*depth) * bits.div_ceil(*width));
    counts.min().expect("a block has a shape")
}

/// Blocks for a memory with one read and one write port, all blocks of one
/// shape (thesis 1.3.1).
pub(super) fn blocks(words: u32, bits: u32, device: &Device) -> u32 {
    least(&device.blocks.memory_shapes, words, bits)
}

/// Blocks for a memory with two ports that both read and write.
pub fn true_dual_port_blocks(words: u32, bits: u32, device: &Device) -> u32 {
    least(&device.blocks.dual_port_shapes, words, bits)
}

/// Blocks of a larger device for a memory with two read and two write ports:
/// its blocks hold 20 kbit (M20K).
pub(super) fn four_port_blocks(words: u32, bits: u32) -> u32 {
    least(&[[2048, 10], [1024, 20], [512, 40]], words, bits)
}

/// MLABs for a memory that is read without a clock.
pub(super) fn lab_memories(words: u32, bits: u32) -> u32 {
    words.div_ceil(LAB_WORDS) * bits.div_ceil(LAB_WIDTH)
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::machine::DeviceFamily;

    fn blocks(words: u32, bits: u32) -> u32 {
        super::blocks(words, bits, DeviceFamily::CycloneV.device())
    }

    fn true_dual_port_blocks(words: u32, bits: u32) -> u32 {
        super::true_dual_port_blocks(words, bits, DeviceFamily::CycloneV.device())
    }

    #[test]
    fn blocks_follow_the_shapes_of_an_m10k() {
        // Thesis 1.3.1: 2048 words of 32 bits in 7 blocks, 16 of 32 in one.
        assert_eq!(
            [blocks(2048, 32), blocks(16, 32), blocks(1024, 64)],
            [7, 1, 7]
        );
        assert_eq!([blocks(1024, 47), blocks(1024, 32)], [5, 4]);
        assert_eq!(
            [
                true_dual_port_blocks(2048, 32),
                true_dual_port_blocks(16, 32)
            ],
            [7, 2]
        );
        assert_eq!([lab_memories(16, 32), lab_memories(40, 20)], [2, 2]);
    }
}
