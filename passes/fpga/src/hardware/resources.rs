//! Amounts of the parts of a device.

use serde::Serialize;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Mul};

/// Resources of a device of the Cyclone V family. Amounts are fractions where
/// two things share a part (two products of 18 bits share a multiplier block).
#[derive(Clone, Copy, PartialEq, Default, Debug, Serialize)]
pub struct ResourceUse {
    /// Adaptive look-up tables (ALUT), two of which are a logic module (ALM).
    pub aluts: f64,
    /// Registers.
    pub registers: f64,
    /// Memory blocks of 10 kbit (M10K).
    pub memory_blocks: f64,
    /// Memories of 32 words of 20 bits, each instead of ten logic modules
    /// (MLAB).
    pub lab_memories: f64,
    /// Multiplier blocks (DSP), each one product of up to 27 bits or two of
    /// up to 18.
    pub multiplier_blocks: f64,
}

impl Add for ResourceUse {
    type Output = ResourceUse;

    fn add(self, other: ResourceUse) -> ResourceUse {
        ResourceUse {
            aluts: self.aluts + other.aluts,
            registers: self.registers + other.registers,
            memory_blocks: self.memory_blocks + other.memory_blocks,
            lab_memories: self.lab_memories + other.lab_memories,
            multiplier_blocks: self.multiplier_blocks + other.multiplier_blocks,
        }
    }
}

impl AddAssign for ResourceUse {
    fn add_assign(&mut self, other: ResourceUse) {
        *self = *self + other;
    }
}

impl Mul<f64> for ResourceUse {
    type Output = ResourceUse;

    fn mul(self, times: f64) -> ResourceUse {
        ResourceUse {
            aluts: self.aluts * times,
            registers: self.registers * times,
            memory_blocks: self.memory_blocks * times,
            lab_memories: self.lab_memories * times,
            multiplier_blocks: self.multiplier_blocks * times,
        }
    }
}

impl Sum for ResourceUse {
    fn sum<I: Iterator<Item = ResourceUse>>(all: I) -> ResourceUse {
        all.fold(ResourceUse::default(), Add::add)
    }
}
