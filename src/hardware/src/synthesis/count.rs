//! Resources of the device that a netlist takes, module by module.
//!
//! Every primitive counts as the part of the device that it represents: a
//! look-up table of up to six inputs, one bit of a carry chain and an
//! inverter are one adaptive look-up table (ALUT) each; yosys' cell of an
//! MLAB is one bit wide, and those of a module that share their read and
//! write addresses share blocks of 20; a multiplier of 18 bits is half a DSP
//! block and one of 9 bits a third.

use super::SynthesisError;
use super::delays::TRUE_DUAL_PORT;
use super::netlist::{Bit, Netlist, NetlistCell, NetlistModule, readable};
use robovec_fpga::hardware::{ResourceUse, true_dual_port_blocks};
use robovec_ir::machine::DeviceFamily;
use std::collections::{BTreeMap, BTreeSet};

/// Bits of a word of an MLAB.
const MLAB_WIDTH: usize = 20;

/// Resources of the instances of one module.
#[derive(Clone, PartialEq, Debug)]
pub struct ModuleCount {
    /// Name of the module in the source, which all its variants have.
    pub name: String,
    /// The module's name in the netlist.
    pub netlist_name: String,
    /// Number of times it occurs below the top.
    pub instances: u32,
    /// Resources of one instance, without the modules inside.
    pub own: ResourceUse,
    /// Resources of one instance, with the modules inside.
    pub total: ResourceUse,
}

/// Counts a design, bottom up: the top comes last.
///
/// # Errors
///
/// Fails when a module instantiates itself.
pub fn count(netlist: &Netlist, top: &str) -> Result<Vec<ModuleCount>, SynthesisError> {
    let order = netlist.bottom_up(top)?;
    let mut totals: BTreeMap<&str, ResourceUse> = BTreeMap::new();
    let mut counts = Vec::new();
    for name in &order {
        let module = &netlist.modules[*name];
        let own = own(module);
        let mut total = own;
        for cell in module.cells.values() {
            if let Some(inside) = totals.get(cell.kind.as_str()) {
                total += *inside;
            }
        }
        totals.insert(name, total);
        counts.push(ModuleCount {
            name: readable(name).to_owned(),
            netlist_name: (*name).to_owned(),
            instances: 0,
            own,
            total,
        });
    }
    let instances = instances(netlist, &order, top);
    for one in &mut counts {
        one.instances = instances[one.netlist_name.as_str()];
    }
    Ok(counts)
}

/// Number of times every module occurs below the top.
fn instances<'a>(netlist: &'a Netlist, order: &[&'a str], top: &'a str) -> BTreeMap<&'a str, u32> {
    let mut instances: BTreeMap<&str, u32> = order.iter().map(|name| (*name, 0)).collect();
    instances.insert(top, 1);
    for name in order.iter().rev() {
        let times = instances[name];
        for cell in netlist.modules[*name].cells.values() {
            if let Some(count) = instances.get_mut(cell.kind.as_str()) {
                *count = count.saturating_add(times);
            }
        }
    }
    instances
}

fn own(module: &NetlistModule) -> ResourceUse {
    let mut taken = ResourceUse::default();
    let mut mlabs: BTreeMap<String, usize> = BTreeMap::new();
    for cell in module.cells.values() {
        match cell.kind.as_str() {
            "MISTRAL_ALUT2" | "MISTRAL_ALUT3" | "MISTRAL_ALUT4" | "MISTRAL_ALUT5"
            | "MISTRAL_ALUT6" | "MISTRAL_ALUT_ARITH" | "MISTRAL_NOT" => taken.aluts += 1.0,
            "MISTRAL_FF" => taken.registers += 1.0,
            "MISTRAL_M10K" => taken.memory_blocks += 1.0,
            "MISTRAL_MLAB" => *mlabs.entry(addresses(cell)).or_default() += 1,
            "MISTRAL_MUL27X27" => taken.multiplier_blocks += 1.0,
            "MISTRAL_MUL18X18" => taken.multiplier_blocks += 0.5,
            "MISTRAL_MUL9X9" => taken.multiplier_blocks += 1.0 / 3.0,
            kind if readable(kind) == TRUE_DUAL_PORT => {
                let words = 1_u32.unbounded_shl(parameter(cell, "ADDRESS"));
                let blocks = true_dual_port_blocks(
                    words,
                    parameter(cell, "WIDTH"),
                    DeviceFamily::CycloneV.device(),
                );
                taken.memory_blocks += f64::from(blocks);
            }
            _ => {}
        }
    }
    let blocks: usize = mlabs.values().map(|bits| bits.div_ceil(MLAB_WIDTH)).sum();
    taken.lab_memories = blocks as f64;
    taken
}

/// A parameter that is a number: binary digits.
fn parameter(cell: &NetlistCell, name: &str) -> u32 {
    let digits = cell.parameters.get(name).and_then(|value| value.as_str());
    let number = digits.and_then(|digits| u32::from_str_radix(digits, 2).ok());
    number.unwrap_or(0)
}

/// Addresses that the cells of one block of an MLAB share.
fn addresses(cell: &NetlistCell) -> String {
    let of =
        |port: &str| -> Vec<&Bit> { cell.connections.get(port).into_iter().flatten().collect() };
    format!("{:?} {:?} {:?}", of("A1ADDR"), of("A1EN"), of("B1ADDR"))
}

/// Primitives that are none of the device: the mapping is not complete.
pub fn unknown_cells(netlist: &Netlist, top: &str) -> Result<Vec<String>, SynthesisError> {
    let mut unknown = BTreeSet::new();
    for name in netlist.bottom_up(top)? {
        for cell in netlist.modules[name].cells.values() {
            let kind = cell.kind.as_str();
            let known = kind.starts_with("MISTRAL_") || readable(kind) == TRUE_DUAL_PORT;
            if !known && netlist.module_of(cell).is_none() {
                unknown.insert(format!("{kind} in {}", readable(name)));
            }
        }
    }
    Ok(unknown.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instances_multiply_what_is_inside() {
        let text = r#"{"modules": {
            "$paramod\\leaf\\W=s32'01": {"cells": {
                "a": {"type": "MISTRAL_ALUT6"}, "f": {"type": "MISTRAL_FF"},
                "m": {"type": "MISTRAL_MUL18X18"},
                "x": {"type": "MISTRAL_MLAB", "connections": {"A1ADDR": [2], "B1ADDR": [3]}},
                "y": {"type": "MISTRAL_MLAB", "connections": {"A1ADDR": [2], "B1ADDR": [4]}},
                "z": {"type": "MISTRAL_MLAB", "connections": {"A1ADDR": [2], "B1ADDR": [3]}}}},
            "middle": {"cells": {"k": {"type": "$paramod\\leaf\\W=s32'01"},
                                 "l": {"type": "$paramod\\leaf\\W=s32'01"}}},
            "all": {"attributes": {"top": "1"}, "cells": {
                "n": {"type": "middle"}, "o": {"type": "middle"}, "i": {"type": "MISTRAL_NOT"},
                "b": {"type": "$mem_v2"}, "r": {"type": "MISTRAL_M10K"},
                "t": {"type": "true_dual_port_memory",
                      "parameters": {"WIDTH": "100000", "ADDRESS": "1011"}}}}
        }}"#;
        let netlist = Netlist::parse(text).expect("it is a netlist");
        let counts = count(&netlist, "all").expect("it can be counted");
        let leaf = &counts[0];
        assert_eq!((leaf.name.as_str(), leaf.instances), ("leaf", 4));
        assert_eq!(leaf.own, leaf.total);
        assert_eq!(
            (leaf.own.aluts, leaf.own.registers, leaf.own.lab_memories),
            (1.0, 1.0, 2.0)
        );
        let all = counts.last().expect("the top is there");
        assert_eq!((all.own.aluts, all.total.aluts), (1.0, 5.0));
        assert_eq!(
            (all.total.multiplier_blocks, all.total.memory_blocks),
            (2.0, 8.0)
        );
        let unknown = unknown_cells(&netlist, "all").expect("it can be walked");
        assert_eq!(unknown, ["$mem_v2 in all"]);
    }
}
