//! The space of designs.

use crate::axes::Axes;
use crate::operators::{Couple, with_stages};
use crate::placing::with_elements;
use robovec_ir::Machine;
use robovec_ir::machine::{
    BufferDescription, DeviceFamily, Interconnect, LinkNetwork, MemoryStyle, Topology,
};
use serde::Serialize;

/// One machine, and its number of interleaved instances.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct MachineDesign {
    /// Adders.
    pub adders: u32,
    /// Multipliers.
    pub multipliers: u32,
    /// Stages of an adder and of a multiplier.
    pub stages: [u32; 2],
    /// Style of the memories.
    pub memory: MemoryStyle,
    /// Words of each buffer; none for a machine without.
    pub buffer: Option<u32>,
    /// Instances evaluated at once.
    pub instances: u32,
    /// Interconnect that results travel on.
    pub interconnect: Interconnect,
    /// The family of devices it is built on.
    pub device: DeviceFamily,
}

impl MachineDesign {
    /// The design as a machine.
    pub fn machine(&self) -> Machine {
        let machine = with_elements(&super::thesis(), [self.adders, self.multipliers]);
        let mut machine = with_stages(&machine, self.stages);
        machine.memory.style = self.memory;
        machine.memory.writes = Some(match self.memory {
            MemoryStyle::SideSplit => 1,
            MemoryStyle::Unified | MemoryStyle::FourPort => 2,
        });
        machine.buffer = self.buffer.map(|words| BufferDescription {
            words: Some(words),
            reads: Some(1),
        });
        machine.interconnect = self.interconnect;
        machine.clock_mhz = None;
        machine.device = self.device;
        machine
    }
}

/// Designs that are tried: every combination, except for numbers of adders and
/// multipliers that differ by more than a factor of [`DesignSpace::ratio`].
#[derive(Clone, PartialEq, Debug)]
pub struct DesignSpace {
    /// Numbers of adders.
    pub adders: Vec<u32>,
    /// Numbers of multipliers.
    pub multipliers: Vec<u32>,
    /// The largest quotient of the two.
    pub ratio: u32,
    /// Operators with a common clock.
    pub couples: Vec<Couple>,
    /// Styles of memories.
    pub memories: Vec<MemoryStyle>,
    /// Words of buffers, or none.
    pub buffers: Vec<Option<u32>>,
    /// Instances at once.
    pub instances: Vec<u32>,
    /// Interconnects.
    pub interconnects: Vec<Interconnect>,
    /// The family of devices of all of them.
    pub device: DeviceFamily,
}

impl DesignSpace {
    /// All designs, in order.
    pub fn designs(&self) -> Vec<MachineDesign> {
        let pairs: Vec<[u32; 2]> = self.pairs().collect();
        let axes = self.axes(pairs.len()).combinations();
        axes.map(|[pair, couple, memory, buffer, interconnect, instances]| {
            let [adders, multipliers] = pairs[pair];
            let couple = &self.couples[couple];
            MachineDesign {
                adders,
                multipliers,
                stages: couple.stages(),
                memory: self.memories[memory],
                buffer: self.buffers[buffer],
                instances: self.instances[instances],
                interconnect: self.interconnects[interconnect],
                device: self.device,
            }
        })
        .collect()
    }

    fn axes(&self, pairs: usize) -> Axes<6> {
        Axes([
            pairs,
            self.couples.len(),
            self.memories.len(),
            self.buffers.len(),
            self.interconnects.len(),
            self.instances.len(),
        ])
    }

    /// Numbers of adders and multipliers.
    pub(super) fn pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        let pairs = self.adders.iter().flat_map(|&adders| {
            let multipliers = self.multipliers.iter();
            multipliers.map(move |&multipliers| [adders, multipliers])
        });
        pairs.filter(|&[a, b]| a.max(b) <= a.min(b).saturating_mul(self.ratio))
    }

    /// Number of designs, and of all instances in them, without making them.
    pub fn count(&self) -> (u64, u64) {
        let designs = self.axes(self.pairs().count()).count();
        let instances: u64 = self.instances.iter().copied().map(u64::from).sum();
        let machines = designs / (self.instances.len() as u64).max(1);
        (designs, machines.saturating_mul(instances))
    }
}

/// All interconnects, the crossbar first.
pub fn interconnects() -> Vec<Interconnect> {
    let networks = Topology::ALL.map(|topology| Interconnect::Network(LinkNetwork::of(topology)));
    [&[Interconnect::Crossbar], &networks[..]].concat()
}
