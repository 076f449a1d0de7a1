//! The longest path from register to register: static timing.
//!
//! Every net gets the latest time at which it can change after the clock:
//! outputs of clocked cells after their delay, outputs of logic after their
//! latest input. The delay of a net from cell to cell is one figure for all
//! nets ([`FAST_NET`] to [`SLOW_NET`]); a carry has a dedicated wire without
//! delay. A path ends at an input of a clocked cell, plus its set-up time.
//!
//! **Limits.** There is no placement and routing; delays of cells are those of
//! one speed grade as yosys publishes them; multipliers have no registers
//! inside. It is an estimate and was never calibrated against Quartus.
//!
//! **Invariant.** The same netlist gives the same path: among equals the
//! first in order of names wins.

use super::SynthesisError;
use super::delays::{self, DelayModel};
use super::flat::{self, Flat, Net, Primitive};
use super::netlist::{Netlist, readable};
use std::collections::VecDeque;

/// The lower estimate of the delay of a net, ps.
pub const FAST_NET: u32 = 500;

/// The upper estimate, ps: about the value that an open router reaches.
pub const SLOW_NET: u32 = 900;

/// Selection of paths.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct PathSelection {
    /// Those that start at a register or memory.
    pub from_registers: bool,
    /// From an input, which changes that long after the clock, ps.
    pub from_inputs: Option<u32>,
    /// Those that end at a register or memory.
    pub to_registers: bool,
    /// To an output, as if to a register without set-up time, one net away.
    pub to_outputs: bool,
}

impl PathSelection {
    /// From register to register inside the design.
    pub const INSIDE: PathSelection = PathSelection {
        from_registers: true,
        from_inputs: None,
        to_registers: true,
        to_outputs: false,
    };

    /// The design with a register before every input and after every output.
    pub const ENCLOSED: PathSelection = PathSelection {
        from_registers: true,
        from_inputs: Some(delays::REGISTER),
        to_registers: true,
        to_outputs: true,
    };
}

/// A cell on a path.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct PathCell {
    /// The primitive, or `input` and `output` for ports.
    pub kind: String,
    /// Its name with the instances above it, parts separated by dots.
    pub name: String,
    /// The module of the cell, by its name in the source.
    pub module: String,
    /// The time at its output, or where the path ends, ps after the clock.
    pub at: u32,
}

/// A longest path.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Path {
    /// Its delay with the set-up time at its end, ps.
    pub delay: u32,
    /// Cells from its start to its end.
    pub steps: Vec<PathCell>,
}

impl Path {
    /// The clock that this path allows, MHz.
    pub fn megahertz(&self) -> f64 {
        1e6 / f64::from(self.delay.max(1))
    }
}

/// A design whose paths can be requested.
#[derive(Debug)]
pub struct NetlistTiming<'a> {
    flat: Flat<'a>,
    models: Vec<DelayModel>,
    /// Primitives of logic, each after those that drive it.
    order: Vec<u32>,
}

/// Latest time at which a net changes, and its cause.
#[derive(Clone, Copy)]
struct Arrival {
    time: u32,
    /// The primitive that drives it; [`INPUT`] for an input.
    driver: u32,
    /// The net before it on the path.
    before: Net,
}

/// Represents an input of the top instead of a primitive.
const INPUT: u32 = u32::MAX;

impl<'a> NetlistTiming<'a> {
    /// Opens a design and puts its logic in order.
    ///
    /// # Errors
    ///
    /// Fails at an unknown cell or logic in circles, or as opening does.
    pub fn new(netlist: &'a Netlist, top: &'a str) -> Result<NetlistTiming<'a>, SynthesisError> {
        let flat = flat::flatten(netlist, top)?;
        let model = |primitive: &Primitive<'_>| {
            delays::model(&primitive.cell.kind).ok_or_else(|| {
                let kind = &primitive.cell.kind;
                SynthesisError::Netlist(format!("the cell {kind} has no published delays"))
            })
        };
        let models: Vec<DelayModel> = flat
            .primitives
            .iter()
            .map(model)
            .collect::<Result<_, _>>()?;
        let order = in_order(&flat, &models)?;
        Ok(NetlistTiming {
            flat,
            models,
            order,
        })
    }

    /// The longest path at this delay of nets, ps, of the kinds requested.
    pub fn longest(&self, net: u32, paths: PathSelection) -> Option<Path> {
        let arrivals = self.arrivals(net, paths);
        let mut worst: Option<(u32, u32, Net)> = None;
        let mut end = |time: u32, primitive: u32, at: Net| {
            if worst.is_none_or(|(latest, _, _)| time > latest) {
                worst = Some((time, primitive, at));
            }
        };
        if paths.to_registers {
            for (index, primitive) in self.flat.primitives.iter().enumerate() {
                let setup = match self.models[index] {
                    DelayModel::Clocked { setup, .. } => setup,
                    DelayModel::LookUpMemory => &delays::LOOK_UP_SETUP,
                    _ => continue,
                };
                for (port, setup) in setup {
                    for &at in primitive.port(port) {
                        if let Some(arrival) = arrival(&arrivals, at) {
                            end(arrival.time + net + setup, index as u32, at);
                        }
                    }
                }
            }
        }
        if paths.to_outputs {
            for (index, (_, at)) in self.flat.outputs.iter().enumerate() {
                if let Some(arrival) = arrival(&arrivals, Some(*at)) {
                    let output = self.flat.primitives.len() + index;
                    end(arrival.time + net, output as u32, Some(*at));
                }
            }
        }
        let (delay, last, at) = worst?;
        let mut steps = self.trace(&arrivals, at);
        steps.push(self.step(last, delay));
        Some(Path { delay, steps })
    }

    /// The latest change of every net.
    fn arrivals(&self, net: u32, paths: PathSelection) -> Vec<Option<Arrival>> {
        let mut arrivals = vec![None; self.flat.nets as usize];
        if let Some(time) = paths.from_inputs {
            for (_, at) in &self.flat.inputs {
                arrivals[*at as usize] = Some(Arrival {
                    time,
                    driver: INPUT,
                    before: None,
                });
            }
        }
        for (index, primitive) in self.flat.primitives.iter().enumerate() {
            if let (DelayModel::Clocked { outputs, delay, .. }, true) =
                (self.models[index], paths.from_registers)
            {
                for at in outputs
                    .iter()
                    .flat_map(|port| primitive.port(port))
                    .flatten()
                {
                    arrivals[*at as usize] = Some(Arrival {
                        time: delay,
                        driver: index as u32,
                        before: None,
                    });
                }
            }
        }
        for &index in &self.order {
            self.propagate(index, net, &mut arrivals);
        }
        arrivals
    }

    /// The changes of the outputs of one primitive of logic.
    fn propagate(&self, index: u32, net: u32, arrivals: &mut [Option<Arrival>]) {
        let primitive = &self.flat.primitives[index as usize];
        let latest = |delays: &[(&str, u32)]| {
            let pins = delays.iter().flat_map(|(port, delay)| {
                let wire = if *port == "CI" { 0 } else { net };
                let nets = primitive.port(port).iter();
                nets.map(move |at| (*at, delay + wire))
            });
            through(pins, arrivals, index)
        };
        let changes = match self.models[index as usize] {
            DelayModel::Logic(delays) => {
                let outputs = if primitive.port("Q").is_empty() {
                    "Y"
                } else {
                    "Q"
                };
                vec![(outputs, latest(delays))]
            }
            DelayModel::Carry => vec![
                ("SO", latest(&delays::CARRY_SUM)),
                ("CO", latest(&delays::CARRY_OUT)),
            ],
            DelayModel::LookUpMemory => {
                let address = primitive.port("B1ADDR").iter();
                let pins = address
                    .zip(delays::LOOK_UP_READ)
                    .map(|(at, delay)| (*at, delay + net));
                vec![("B1DATA", through(pins, arrivals, index))]
            }
            DelayModel::Clocked { .. } | DelayModel::Ignored => Vec::new(),
        };
        for (port, arrival) in changes {
            for at in primitive.port(port).iter().flatten() {
                arrivals[*at as usize] = arrival;
            }
        }
    }

    /// The steps to the latest change of a net, from the start.
    fn trace(&self, arrivals: &[Option<Arrival>], mut at: Net) -> Vec<PathCell> {
        let mut steps = Vec::new();
        while let Some(arrival) = arrival(arrivals, at) {
            steps.push(match (arrival.driver, at) {
                (INPUT, Some(net)) => {
                    let input = self.flat.inputs.iter().find(|(_, input)| *input == net);
                    port(
                        "input",
                        &input.expect("an input drives the net").0,
                        arrival.time,
                    )
                }
                (driver, _) => self.step(driver, arrival.time),
            });
            at = arrival.before;
        }
        steps.reverse();
        steps
    }

    /// A primitive, or an output numbered after them, as a step.
    fn step(&self, index: u32, at: u32) -> PathCell {
        let index = index as usize;
        let Some(primitive) = self.flat.primitives.get(index) else {
            let output = &self.flat.outputs[index - self.flat.primitives.len()];
            return port("output", &output.0, at);
        };
        let instance = &self.flat.instances[primitive.instance as usize];
        let name = match instance.path.as_str() {
            "" => primitive.name.to_owned(),
            path => format!("{path}.{}", primitive.name),
        };
        PathCell {
            kind: primitive.cell.kind.clone(),
            name,
            module: readable(instance.module).to_owned(),
            at,
        }
    }
}

fn port(kind: &str, name: &str, at: u32) -> PathCell {
    PathCell {
        kind: kind.to_owned(),
        name: name.to_owned(),
        module: String::new(),
        at,
    }
}

fn arrival(arrivals: &[Option<Arrival>], at: Net) -> Option<Arrival> {
    arrivals[at? as usize]
}

/// The latest change that pins with delays hand on.
fn through(
    pins: impl Iterator<Item = (Net, u32)>,
    arrivals: &[Option<Arrival>],
    driver: u32,
) -> Option<Arrival> {
    let mut latest: Option<Arrival> = None;
    for (at, delay) in pins {
        if let Some(before) = arrival(arrivals, at) {
            let time = before.time + delay;
            if latest.is_none_or(|latest| time > latest.time) {
                latest = Some(Arrival {
                    time,
                    driver,
                    before: at,
                });
            }
        }
    }
    latest
}

/// The ports of a primitive of logic that its outputs follow, and these.
fn logic_ports(model: DelayModel) -> Option<(&'static [&'static str], &'static [&'static str])> {
    match model {
        DelayModel::Logic(_) => Some((&["A", "B", "C", "D", "E", "F"], &["Q", "Y"])),
        DelayModel::Carry => Some((&["A", "B", "C", "D0", "D1", "CI"], &["SO", "CO"])),
        DelayModel::LookUpMemory => Some((&["B1ADDR"], &["B1DATA"])),
        DelayModel::Clocked { .. } | DelayModel::Ignored => None,
    }
}

/// The primitives of logic, each after all of its drivers.
fn in_order(flat: &Flat<'_>, models: &[DelayModel]) -> Result<Vec<u32>, SynthesisError> {
    let mut driver = vec![u32::MAX; flat.nets as usize];
    for (index, primitive) in flat.primitives.iter().enumerate() {
        let Some((_, outputs)) = logic_ports(models[index]) else {
            continue;
        };
        for net in outputs
            .iter()
            .flat_map(|port| primitive.port(port))
            .flatten()
        {
            driver[*net as usize] = index as u32;
        }
    }
    let count = flat.primitives.len();
    let mut missing = vec![0_u32; count];
    let mut followers: Vec<Vec<u32>> = vec![Vec::new(); count];
    let mut ready = VecDeque::new();
    for (index, primitive) in flat.primitives.iter().enumerate() {
        let Some((inputs, _)) = logic_ports(models[index]) else {
            continue;
        };
        for net in inputs
            .iter()
            .flat_map(|port| primitive.port(port))
            .flatten()
        {
            let driver = driver[*net as usize];
            if driver != u32::MAX {
                followers[driver as usize].push(index as u32);
                missing[index] += 1;
            }
        }
        if missing[index] == 0 {
            ready.push_back(index as u32);
        }
    }
    let mut order = Vec::new();
    while let Some(index) = ready.pop_front() {
        order.push(index);
        for &follower in &followers[index as usize] {
            missing[follower as usize] -= 1;
            if missing[follower as usize] == 0 {
                ready.push_back(follower);
            }
        }
    }
    match missing.iter().position(|left| *left > 0) {
        Some(stuck) => Err(SynthesisError::Loop(flat.primitives[stuck].name.to_owned())),
        None => Ok(order),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two registers with a look-up table in an instance between them, and
    /// an adder of two bits after the second.
    const SMALL: &str = r#"{"modules": {
        "leaf": {"ports": {"a": {"direction": "input", "bits": [2]},
                           "y": {"direction": "output", "bits": [3]}},
                 "cells": {"lut": {"type": "MISTRAL_ALUT2",
                           "connections": {"A": [2], "B": ["1"], "Q": [3]}}}},
        "all": {"attributes": {"top": "1"},
            "ports": {"d": {"direction": "input", "bits": [9]},
                      "s": {"direction": "output", "bits": [6, 8]}},
            "cells": {
            "first": {"type": "MISTRAL_FF", "connections": {"DATAIN": [9], "ENA": ["1"], "Q": [2]}},
            "through": {"type": "leaf", "connections": {"a": [2], "y": [3]}},
            "second": {"type": "MISTRAL_FF", "connections": {"DATAIN": [3], "ENA": ["1"], "Q": [4]}},
            "low": {"type": "MISTRAL_ALUT_ARITH",
                    "connections": {"A": [4], "B": [4], "CI": ["0"], "SO": [6], "CO": [7]}},
            "high": {"type": "MISTRAL_ALUT_ARITH",
                     "connections": {"A": ["0"], "B": ["0"], "CI": [7], "SO": [8]}}}}
    }}"#;

    fn netlist(text: &str) -> Netlist {
        Netlist::parse(text).expect("it is a netlist")
    }

    #[test]
    fn a_path_crosses_modules_and_adds_up() {
        let netlist = netlist(SMALL);
        let timing = NetlistTiming::new(&netlist, "all").expect("it has an order");
        let path = timing
            .longest(500, PathSelection::INSIDE)
            .expect("there is one");
        // Register, net, table, net; no set-up time.
        assert_eq!(path.delay, 731 + 500 + 400 + 500);
        let names: Vec<&str> = path.steps.iter().map(|step| step.name.as_str()).collect();
        assert_eq!(names, ["first", "through.lut", "second"]);
        let times: Vec<u32> = path.steps.iter().map(|step| step.at).collect();
        assert_eq!(times, [731, 1631, 2131]);
        assert_eq!(path.steps[1].module, "leaf");
        // With registers outside: the second's output through the carry
        // chain, whose wire takes nothing, and a net to the register behind.
        let path = timing
            .longest(500, PathSelection::ENCLOSED)
            .expect("there is one");
        assert_eq!(path.delay, 731 + 500 + 1082 + 368 + 500);
        assert_eq!(
            path.steps.last().map(|step| step.name.as_str()),
            Some("s[1]")
        );
        assert!((path.megahertz() - 314.366).abs() < 1e-3);
    }

    #[test]
    fn memories_start_and_end_paths() {
        let netlist = netlist(
            r#"{"modules": {"all": {"attributes": {"top": "1"}, "cells": {
            "code": {"type": "MISTRAL_M10K", "connections": {"B1ADDR": [2, 3], "B1DATA": [4, 5]}},
            "buffer": {"type": "MISTRAL_MLAB", "connections":
                {"B1ADDR": [4, 5, "0", "0", "0"], "B1DATA": [6], "A1DATA": [5]}},
            "product": {"type": "MISTRAL_MUL9X9", "connections": {"A": [6], "B": [5], "Y": [7]}},
            "next": {"type": "MISTRAL_M10K", "connections": {"A1DATA": [7], "B1DATA": [8]}}}}}}"#,
        );
        let timing = NetlistTiming::new(&netlist, "all").expect("it has an order");
        let path = timing
            .longest(900, PathSelection::INSIDE)
            .expect("there is one");
        assert_eq!(path.delay, 1004 + 900 + 487 + 900 + 2818 + 900 + 97);
        assert_eq!(path.steps.len(), 4);
    }

    #[test]
    fn loops_and_unknown_cells_are_refused() {
        let turning = netlist(
            r#"{"modules": {"all": {"attributes": {"top": "1"}, "cells": {
            "a": {"type": "MISTRAL_NOT", "connections": {"A": [2], "Q": [3]}},
            "b": {"type": "MISTRAL_NOT", "connections": {"A": [3], "Q": [2]}}}}}}"#,
        );
        let error = NetlistTiming::new(&turning, "all").expect_err("it turns");
        assert!(matches!(error, SynthesisError::Loop(_)), "{error}");
        let unmapped = netlist(
            r#"{"modules": {"all": {"attributes": {"top": "1"}, "cells": {
            "a": {"type": "$add", "connections": {"A": [2]}}}}}}"#,
        );
        assert!(NetlistTiming::new(&unmapped, "all").is_err());
    }

    #[test]
    fn a_wire_through_a_module_is_the_same_net() {
        let netlist = netlist(
            r#"{"modules": {
            "wire": {"ports": {"a": {"direction": "input", "bits": [2]},
                               "y": {"direction": "output", "bits": [2]},
                               "z": {"direction": "output", "bits": ["1"]}}},
            "all": {"attributes": {"top": "1"}, "cells": {
                "first": {"type": "MISTRAL_FF", "connections": {"DATAIN": [5], "Q": [2]}},
                "w": {"type": "wire", "connections": {"a": [2], "y": [3], "z": [4]}},
                "second": {"type": "MISTRAL_FF",
                           "connections": {"DATAIN": [3], "ENA": [4], "Q": [5]}}}}}}"#,
        );
        let timing = NetlistTiming::new(&netlist, "all").expect("it has an order");
        let path = timing
            .longest(500, PathSelection::INSIDE)
            .expect("there is one");
        assert_eq!((path.delay, path.steps.len()), (1231, 2));
    }
}
