//! The devices that machines are built on, as data.
//!
//! A machine file names a family; the cost of its cells and nets, the width of
//! a multiplier block and the number of all resources are in a TOML file per
//! family (`devices/`), with the origin of the figures. Clocks, cuts of
//! operators and shares of a device all come from there.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

robovec_num::named! {
    /// A family of devices.
    #[derive(
        Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Debug, Serialize, Deserialize,
    )]
    #[serde(rename_all = "kebab-case")]
    pub enum DeviceFamily {
        /// The family of the thesis' board, by Intel.
        #[default]
        CycloneV = "cyclone-v",
        /// By Lattice; open tools support placement and routing for it.
        Ecp5 = "ecp5",
    }
}

impl DeviceFamily {
    /// True for the family that a machine file need not name.
    pub fn is_default(&self) -> bool {
        *self == DeviceFamily::default()
    }

    /// Its figures.
    pub fn device(self) -> &'static Device {
        static DEVICES: LazyLock<[Device; 2]> = LazyLock::new(|| {
            let texts = [
                include_str!("../../devices/cyclone-v.toml"),
                include_str!("../../devices/ecp5.toml"),
            ];
            texts.map(|text| toml::from_str(text).expect("shipped devices are valid"))
        });
        &DEVICES[self as usize]
    }
}

impl fmt::Display for DeviceFamily {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for DeviceFamily {
    type Err = String;

    fn from_str(name: &str) -> Result<DeviceFamily, String> {
        let mut all = DeviceFamily::ALL.into_iter();
        let found = all.find(|family| family.name() == name);
        found.ok_or_else(|| {
            let names = DeviceFamily::ALL.map(DeviceFamily::name);
            format!("there is no family '{name}'; choose {}", names.join(" or "))
        })
    }
}

robovec_num::named! {
    /// Origin of a clock.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Default, Debug, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum ClockOrigin {
        /// Whoever wrote the machine file states it.
        #[default]
        Declared = "declared",
        /// It was measured with hardware of this machine.
        Measured = "measured",
        /// The thesis prints it, of hardware that is not robovec's.
        Published = "published",
        /// The model of the device states it.
        Estimated = "estimated",
    }
}

/// The figures of a device.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Device {
    /// Its name.
    pub name: String,
    /// Origin of its delays.
    pub origin: String,
    /// The delays of its cells.
    pub cells: CellDelays,
    /// The delays of its nets.
    pub nets: NetDelays,
    /// Abilities of its blocks.
    pub blocks: DeviceBlocks,
    /// Amount of each resource.
    pub capacity: DeviceCapacity,
}

/// Delays of cells, ps.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellDelays {
    /// A function of up to six inputs, on average over its inputs.
    pub table: u32,
    /// The same through its slowest input.
    pub table_slowest: u32,
    /// Into a carry chain and out of it again.
    pub chain: u32,
    /// One place of a carry chain.
    pub carry: u32,
    /// A multiplier block.
    pub multiplier: u32,
    /// From the clock to the output of a register.
    pub register: u32,
    /// From the clock to the output of a block memory.
    pub memory: u32,
    /// The set-up time of a block memory's data.
    pub memory_data: u32,
    /// The set-up time of a block memory's address.
    pub memory_address: u32,
    /// A memory in logic cells, from its address.
    pub logic_memory: u32,
}

/// Delays of the nets between two cells, ps: two guesses, or the range that
/// place and route gives.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetDelays {
    /// The lower bound.
    pub quick: u32,
    /// The upper bound.
    pub slow: u32,
}

/// Abilities of the blocks of a device.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeviceBlocks {
    /// Bits of the widest factor of a multiplier block.
    pub factor: u32,
    /// The highest clock of a block memory, MHz.
    pub memory_mhz: f64,
    /// Words and bits per word that a block memory with one read and one
    /// write port can have, the narrowest first.
    pub memory_shapes: Vec<[u32; 2]>,
    /// The same for two ports that both read and write.
    pub dual_port_shapes: Vec<[u32; 2]>,
}

/// Total resources of a device.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeviceCapacity {
    /// Look-up tables.
    pub look_up_tables: f64,
    /// Look-up tables instead of an adaptive one of a Cyclone V, which the
    /// formulas count.
    pub tables_per_adaptive: f64,
    /// Look-up tables instead of a memory in logic of 32 words of 20 bits.
    pub tables_per_memory: f64,
    /// Block memories.
    pub memory_blocks: f64,
    /// Multiplier blocks.
    pub multiplier_blocks: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_family_has_figures_and_is_read_by_its_name() {
        for family in DeviceFamily::ALL {
            let device = family.device();
            assert!(device.nets.quick < device.nets.slow && !device.origin.is_empty());
            let text = serde_json::to_string(&family).expect("it can be written");
            assert_eq!(text, format!("\"{}\"", family.name()));
        }
        assert_ne!(DeviceFamily::CycloneV.device(), DeviceFamily::Ecp5.device());
    }
}
