//! A whole machine, as `robovec rtl` writes it: mapped part by part.
//!
//! The modules of the parts stay closed, so that equal ones are mapped once and
//! every part has its own counts; the modules inside a part are flattened and
//! mapped as one. Initial contents are left out: they do not affect counts, and
//! without them more elements are equal.

use super::netlist::{Netlist, readable};
use super::timing::{FAST_NET, NetlistTiming, Path, PathSelection, SLOW_NET};
use super::{SynthesisDesign, SynthesisError, Yosys, count};
use robovec_fpga::hardware::{MachinePart, MachineShape, PartKind, ResourceUse, parts};
use robovec_fpga::rtl::cores::OperatorCore;
use std::collections::BTreeMap;

const TOP: &str = "robovec_machine";

/// Prefix of the modules of elements; their kind follows.
const ELEMENT: &str = "robovec_element_";

/// The memory with two ports that write, which yosys has no cell for.
const CLOSED: &str = "true_dual_port_memory.v";

/// The module that takes one table per bit where it stays closed.
const MULTIPLEXER: &str = "multiplexer_4";

/// The modules of the parts, and their kinds.
const MODULES: [(&str, PartKind); 7] = [
    ("instruction_memory", PartKind::Instructions),
    ("pe_split", PartKind::Operands),
    ("pe_pumped", PartKind::Operands),
    ("result_buffer", PartKind::Buffer),
    ("robovec_crossbar", PartKind::Crossbar),
    ("sequencer", PartKind::Sequencer),
    ("host_window", PartKind::Window),
];

/// A machine, as mapped.
#[derive(Clone, PartialEq, Debug)]
pub struct MappedMachine {
    /// Resources of every part by the formulas.
    pub estimated: Vec<MachinePart>,
    /// Resources that yosys counts, in the same order: all of a part together.
    pub counted: Vec<ResourceUse>,
    /// The longest path with fast nets.
    pub quick: Option<Path>,
    /// The longest path with slow nets.
    pub slow: Option<Path>,
    /// Clocks of a cycle, for paths between registers of the elements.
    pub phases: u32,
}

impl MappedMachine {
    /// Total resources counted by yosys.
    pub fn total(&self) -> ResourceUse {
        self.counted.iter().copied().sum()
    }

    /// Total resources by the formulas.
    pub fn estimate(&self) -> ResourceUse {
        let all = self.estimated.iter();
        all.map(|part| part.each * f64::from(part.count)).sum()
    }
}

/// The design for a machine's files: name and text of every Verilog file.
pub fn design(files: &[(String, String)]) -> SynthesisDesign {
    let (closed, sources) = files
        .iter()
        .filter(|(name, _)| name.ends_with(".v"))
        .cloned()
        .partition(|(name, _)| name == CLOSED);
    let parts = MODULES.iter().map(|(name, _)| *name);
    let operators = OperatorCore::ALL.iter().map(|core| core.name());
    SynthesisDesign {
        top: TOP.to_owned(),
        parameters: vec![("INITIAL".to_owned(), "0".to_owned())],
        sources,
        closed,
        others: Vec::new(),
        kept: parts
            .chain(operators)
            .chain([ELEMENT, MULTIPLEXER])
            .map(str::to_owned)
            .collect(),
    }
}

/// Maps a machine.
pub fn map(
    tool: &Yosys,
    shape: &MachineShape,
    files: &[(String, String)],
) -> Result<MappedMachine, SynthesisError> {
    let netlist = tool.map(&design(files))?;
    measure(&netlist, shape)
}

/// Counts and times a mapped machine.
fn measure(netlist: &Netlist, shape: &MachineShape) -> Result<MappedMachine, SynthesisError> {
    let unknown = count::unknown_cells(netlist, TOP)?;
    if !unknown.is_empty() {
        return Err(SynthesisError::Netlist(format!(
            "cells that the device does not have: {}",
            unknown.join(", ")
        )));
    }
    let estimated = parts(shape);
    let by_part = by_part(netlist)?;
    let counted = estimated
        .iter()
        .map(|part| {
            let key = (part.kind.clone(), part.part);
            by_part.get(&key).copied().unwrap_or_default()
        })
        .collect();
    let timing = NetlistTiming::new(netlist, TOP)?;
    Ok(MappedMachine {
        counted,
        estimated,
        quick: timing.longest(FAST_NET, PathSelection::INSIDE),
        slow: timing.longest(SLOW_NET, PathSelection::INSIDE),
        phases: shape.phases(),
    })
}

/// Total resources of all parts of a kind.
fn by_part(
    netlist: &Netlist,
) -> Result<BTreeMap<(Option<String>, PartKind), ResourceUse>, SynthesisError> {
    let counts = count::count(netlist, TOP)?;
    let totals: BTreeMap<&str, ResourceUse> = counts
        .iter()
        .map(|count| (count.netlist_name.as_str(), count.total))
        .collect();
    let mut parts: BTreeMap<(Option<String>, PartKind), ResourceUse> = BTreeMap::new();
    for count in &counts {
        let kind = count.name.strip_prefix(ELEMENT);
        // What stands in an element or the top itself, outside of its parts.
        let own = match (kind, count.name.as_str()) {
            (Some(_), _) => PartKind::Operators,
            (None, TOP) => PartKind::Window,
            _ => continue,
        };
        let kind = kind.map(str::to_owned);
        let times = f64::from(count.instances);
        let mut add = |part: PartKind, taken: ResourceUse| {
            *parts.entry((kind.clone(), part)).or_default() += taken * times;
        };
        add(own, count.own);
        for cell in netlist.modules[&count.netlist_name].cells.values() {
            let Some(inside) = totals.get(cell.kind.as_str()) else {
                continue;
            };
            let name = readable(&cell.kind);
            if name.starts_with(ELEMENT) {
                continue;
            }
            let known = MODULES.iter().find(|(module, _)| *module == name);
            add(known.map_or(own, |(_, part)| *part), *inside);
        }
    }
    Ok(parts)
}
