//! What a machine takes of a device, by number format: an estimate.
//!
//! Operators of binary32 are those of the thesis' Tables 1.1 and 1.2. For
//! other formats look-up tables grow with the width of the word, and a
//! multiplier takes as many 27-bit blocks as its significands have pieces of
//! 27 bits, squared; two products of up to 18 bits share a block (Cyclone V
//! device handbook). Memories count in blocks of 10 kbit, the crossbar as one
//! multiplexer per write port, as in the study's Table 1.4. Nothing is
//! synthesised.

use crate::study::couples::{ADDERS, MULTIPLIERS};
use crate::study::tables::resources::{blocks, crossbar_luts};
use robovec_ir::{Format, Machine, Operation};
use serde::Serialize;

/// The device that shares are of: that of the thesis' board, 5CSEBA6U23I7.
const LOOK_UP_TABLES: f64 = 83_820.0;
const MEMORY_BLOCKS: f64 = 553.0;
const MULTIPLIER_BLOCKS: f64 = 112.0;

/// Width of the word that the thesis' operators are for.
const WORD: f64 = 32.0;

/// What a machine takes.
#[derive(Clone, Copy, PartialEq, Default, Debug, Serialize)]
pub struct Resources {
    /// Look-up tables.
    pub look_up_tables: f64,
    /// Blocks of 10 kbit.
    pub memory_blocks: f64,
    /// Multiplier blocks of 27 bits.
    pub multiplier_blocks: f64,
}

impl Resources {
    /// The largest of the three shares of the thesis' device; above 1 the
    /// machine does not fit.
    pub fn share(&self) -> f64 {
        let shares = [
            self.look_up_tables / LOOK_UP_TABLES,
            self.memory_blocks / MEMORY_BLOCKS,
            self.multiplier_blocks / MULTIPLIER_BLOCKS,
        ];
        shares.into_iter().fold(0.0, f64::max)
    }
}

/// The blocks that one multiplier takes.
fn multiplier_blocks(significand: u32) -> f64 {
    match significand {
        0..=18 => 0.5,
        _ => f64::from(significand.div_ceil(27).pow(2)),
    }
}

/// What a machine takes in a format, for a program of so many cycles whose
/// elements hold at most so many words each.
pub fn resources(machine: &Machine, format: Format, cycles: u32, words: u32) -> Resources {
    let width = format.width();
    let wider = f64::from(width) / WORD;
    let mut taken = Resources::default();
    let mut elements = 0;
    for kind in &machine.elements {
        let nearest = |stages: u32, luts: &mut dyn Iterator<Item = (u32, u32)>| {
            let best = luts.min_by_key(|(known, _)| known.abs_diff(stages));
            f64::from(best.map_or(0, |(_, luts)| luts)) * wider
        };
        let multiplies = kind.performs(Operation::Mul) || kind.is_fused();
        let adds = kind.performs(Operation::Add) || kind.is_fused();
        let mut luts = 0.0;
        if adds {
            luts += nearest(
                kind.stages,
                &mut ADDERS.iter().map(|one| (one.stages, one.luts)),
            );
        }
        if multiplies {
            luts += nearest(
                kind.stages,
                &mut MULTIPLIERS.iter().map(|one| (one.stages, one.luts)),
            );
            taken.multiplier_blocks +=
                f64::from(kind.count) * multiplier_blocks(format.significand());
        }
        taken.look_up_tables += f64::from(kind.count) * luts;
        elements += kind.count;
    }
    // Two reads, two writes, and whether to write: Table 1.4's instruction.
    let address = words.max(2).next_power_of_two().ilog2();
    let instruction = 4 * address + 4;
    let per_element = blocks(words.max(1), width) + blocks(cycles.max(1), instruction) + 1;
    taken.memory_blocks = f64::from(elements * per_element);
    taken.look_up_tables += f64::from(crossbar_luts(elements, width));
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrower_formats_and_fewer_elements_take_less() {
        let machine = Machine::built_in("thesis").expect("it ships");
        let of = |format: &str| {
            let format = format.parse().expect("it is a format");
            resources(&machine, format, 1024, 2048)
        };
        let (half, single, double) = (of("f16"), of("f32"), of("f64"));
        assert!(half.share() < single.share() && single.share() < double.share());
        assert_eq!(
            [half, single, double].map(|taken| taken.multiplier_blocks),
            [2.0, 4.0, 16.0]
        );
        // The thesis prints 120 blocks of memory for this machine, 20 of them
        // for the crossbar's selection, which is not counted here.
        assert!((90.0..130.0).contains(&single.memory_blocks));
    }
}
