//! The resources that a machine takes of a device and its clock, by formulas:
//! nothing is synthesised.
//!
//! The device is a Cyclone V, as in the thesis. [`MachineShape`] has every size
//! of a machine, [`parts`] the resources of each part of it, in tables,
//! registers, memory blocks and multiplier blocks.
//!
//! **Invariant.** This is the only place with such formulas, for searches,
//! studies and reports. They are checked against the mapping of the real
//! hardware by yosys, which `robovec rtl --synthesise` prints beside them.

mod clock;
mod interconnect;
mod memory;
mod operator;
mod parts;
mod resources;
mod shape;

pub use clock::{
    Estimate, MachineClock, clock, clock_with_elements, estimate_of, estimated_clock_mhz,
    operator_period, published_clock,
};
pub use memory::true_dual_port_blocks;
pub use operator::operator;
pub use parts::{MachinePart, PartKind, parts, resources};
pub use resources::ResourceUse;
pub use shape::{ElementsOfKind, MachineShape};
