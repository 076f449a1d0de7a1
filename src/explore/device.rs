//! What a machine takes of a device, by number format: an estimate.
//!
//! The formulas are those of [`robovec_codegen::hardware`], for the
//! hardware that `robovec rtl` writes. Nothing is synthesised.

use robovec_codegen::hardware::{self, MachineShape};
use robovec_ir::{Format, Machine};
use serde::Serialize;

/// The device that shares are of: that of the thesis' board, 5CSEBA6U23I7.
const LOOK_UP_TABLES: f64 = 83_820.0;
const MEMORY_BLOCKS: f64 = 553.0;
const MULTIPLIER_BLOCKS: f64 = 112.0;

/// What a machine takes.
#[derive(Clone, Copy, PartialEq, Default, Debug, Serialize)]
pub struct DeviceShare {
    /// Look-up tables.
    pub look_up_tables: f64,
    /// Blocks of 10 kbit.
    pub memory_blocks: f64,
    /// Multiplier blocks of 27 bits.
    pub multiplier_blocks: f64,
}

impl DeviceShare {
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

/// What a machine takes in a format, for a program of so many cycles whose
/// elements hold at most so many words each. A memory in logic counts as the
/// twenty tables whose place it takes.
pub fn taken(machine: &Machine, format: Format, cycles: u32, words: u32) -> DeviceShare {
    let machine = Machine {
        number: format,
        ..machine.clone()
    };
    let taken = hardware::resources(&MachineShape::of(&machine, cycles, words));
    DeviceShare {
        look_up_tables: taken.aluts + 20.0 * taken.lab_memories,
        memory_blocks: taken.memory_blocks,
        multiplier_blocks: taken.multiplier_blocks,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrower_formats_and_fewer_elements_take_less() {
        let machine = Machine::built_in("thesis").expect("it ships");
        let of = |format: &str| {
            let format = format.parse().expect("it is a format");
            taken(&machine, format, 1024, 2048)
        };
        let (half, single, double) = (of("f16"), of("f32"), of("f64"));
        assert!(half.share() < single.share() && single.share() < double.share());
        assert_eq!(
            [half, single, double].map(|taken| taken.multiplier_blocks),
            [2.0, 4.0, 16.0]
        );
        // The thesis prints 120 blocks of memory for this machine.
        assert!((90.0..130.0).contains(&single.memory_blocks));
    }
}
