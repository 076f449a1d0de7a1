//! The netlist in the form of yosys' `write_json`.
//!
//! Only the parts needed for counting and timing are read: modules, their
//! ports, and their cells with their connections. A *bit* is a number that is
//! unique within its module, or a constant. Maps are ordered, so that nothing
//! that is computed from a netlist depends on the order of the file.

use super::SynthesisError;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// A design: modules by name.
#[derive(Clone, Debug, Deserialize)]
pub struct Netlist {
    /// The modules, those of the cell library included.
    pub modules: BTreeMap<String, NetlistModule>,
}

/// A module.
#[derive(Clone, Debug, Deserialize)]
pub struct NetlistModule {
    /// Attributes: `top`, `blackbox`, `hdlname` and others.
    #[serde(default)]
    pub attributes: BTreeMap<String, Value>,
    /// Its ports.
    #[serde(default)]
    pub ports: BTreeMap<String, NetlistPort>,
    /// Its cells by name.
    #[serde(default)]
    pub cells: BTreeMap<String, NetlistCell>,
}

/// A port of a module.
#[derive(Clone, Debug, Deserialize)]
pub struct NetlistPort {
    /// Direction of its signals.
    pub direction: PortDirection,
    /// Its bits, lowest first.
    pub bits: Vec<Bit>,
}

/// Direction of the signals of a port.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PortDirection {
    /// Into the module.
    Input,
    /// Out of it.
    Output,
    /// Both ways.
    Inout,
}

/// A cell: a primitive of the device or an instance of a module.
#[derive(Clone, Debug, Deserialize)]
pub struct NetlistCell {
    /// The primitive or module.
    #[serde(rename = "type")]
    pub kind: String,
    /// Parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, Value>,
    /// Bits that each port is connected to, lowest first.
    #[serde(default)]
    pub connections: BTreeMap<String, Vec<Bit>>,
}

/// A bit of a connection.
#[derive(Clone, PartialEq, Eq, Debug, Deserialize)]
#[serde(untagged)]
pub enum Bit {
    /// A net of the module.
    Net(u32),
    /// `"0"`, `"1"`, `"x"` or `"z"`.
    Constant(String),
}

impl Netlist {
    /// Reads the text of a netlist.
    pub fn parse(text: &str) -> Result<Netlist, SynthesisError> {
        serde_json::from_str(text).map_err(|error| SynthesisError::Netlist(error.to_string()))
    }

    /// Name of the module with the attribute `top`, else of the only own one.
    pub fn top(&self) -> Result<&str, SynthesisError> {
        let own = || {
            self.modules
                .iter()
                .filter(|(_, module)| !module.is_library())
        };
        let marked = own().find(|(_, module)| module.attributes.contains_key("top"));
        let only = || own().next().filter(|_| own().count() == 1);
        marked
            .or_else(only)
            .map(|(name, _)| name.as_str())
            .ok_or_else(|| SynthesisError::Netlist("no module is the top".to_owned()))
    }

    /// The modules below a module in an order in which every one comes after
    /// those it instantiates; library cells are left out.
    ///
    /// # Errors
    ///
    /// Fails when a module instantiates itself.
    pub fn bottom_up(&self, top: &str) -> Result<Vec<&str>, SynthesisError> {
        let mut order = Vec::new();
        let mut state: BTreeMap<&str, bool> = BTreeMap::new();
        let mut stack: Vec<(&str, bool)> = self
            .own(top)
            .map(|name| (name, false))
            .into_iter()
            .collect();
        while let Some((name, done)) = stack.pop() {
            if done {
                state.insert(name, true);
                order.push(name);
                continue;
            }
            match state.get(name) {
                Some(true) => continue,
                Some(false) => {
                    return Err(SynthesisError::Netlist(format!(
                        "the module {} instantiates itself",
                        readable(name)
                    )));
                }
                None => {}
            }
            state.insert(name, false);
            stack.push((name, true));
            let mut children: Vec<&str> = self.modules[name]
                .cells
                .values()
                .filter_map(|cell| self.own(&cell.kind))
                .collect();
            children.sort_unstable();
            children.dedup();
            let open = children
                .iter()
                .filter(|child| state.get(*child) != Some(&true));
            stack.extend(open.map(|child| (*child, false)));
        }
        Ok(order)
    }

    /// The name of a module that is no library cell.
    fn own(&self, name: &str) -> Option<&str> {
        let (name, module) = self.modules.get_key_value(name)?;
        (!module.is_library()).then_some(name.as_str())
    }

    /// The module of an instance, unless it is a library cell.
    pub fn module_of(&self, cell: &NetlistCell) -> Option<&NetlistModule> {
        self.modules
            .get(&cell.kind)
            .filter(|module| !module.is_library())
    }
}

impl NetlistModule {
    /// True for cells of the device, whose inside is not part of the design.
    pub fn is_library(&self) -> bool {
        ["blackbox", "whitebox"]
            .iter()
            .any(|name| self.attributes.contains_key(*name))
    }
}

/// A module's name for users: that of the source, without the parameters that
/// yosys adds (`$paramod\name\WIDTH=s32'…`, `$paramod$hash\name`).
pub fn readable(name: &str) -> &str {
    match name.strip_prefix("$paramod") {
        Some(rest) => rest.split('\\').nth(1).unwrap_or(rest),
        None => name.trim_start_matches('\\'),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO_LEVELS: &str = r#"{"modules": {
        "CELL": {"attributes": {"blackbox": "1"}},
        "leaf": {"cells": {"c": {"type": "CELL", "connections": {"A": [2, "x"]}}}},
        "middle": {"cells": {"l": {"type": "leaf"}, "k": {"type": "leaf"}}},
        "all": {"attributes": {"top": "1"}, "cells": {"l": {"type": "leaf"}, "m": {"type": "middle"}}}
    }}"#;

    #[test]
    fn modules_come_after_those_they_instantiate() {
        let netlist = Netlist::parse(TWO_LEVELS).expect("it is a netlist");
        assert_eq!(netlist.top().expect("it has one"), "all");
        let order = netlist.bottom_up("all").expect("no module contains itself");
        assert_eq!(order, ["leaf", "middle", "all"]);
        let cell = &netlist.modules["leaf"].cells["c"];
        assert_eq!(
            cell.connections["A"],
            [Bit::Net(2), Bit::Constant("x".to_owned())]
        );
    }

    #[test]
    fn what_is_no_netlist_is_refused() {
        for wrong in ["", "{", "[]", r#"{"modules": 3}"#, "\0\0"] {
            assert!(Netlist::parse(wrong).is_err(), "{wrong:?}");
        }
        let selfish = r#"{"modules": {"a": {"cells": {"x": {"type": "b"}}},
                                      "b": {"cells": {"y": {"type": "a"}}}}}"#;
        let netlist = Netlist::parse(selfish).expect("it is a netlist");
        assert!(netlist.bottom_up("a").is_err());
        assert!(netlist.top().is_err());
    }

    #[test]
    fn names_lose_their_parameters() {
        assert_eq!(readable("$paramod\\leaf\\W=s32'0001"), "leaf");
        assert_eq!(readable("$paramod$a81b\\pe_split"), "pe_split");
        assert_eq!(readable("\\top"), "top");
        assert_eq!(readable("top"), "top");
    }
}
