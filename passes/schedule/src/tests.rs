//! Placement on random programs and at the edges of the machine's rules.

use super::testing::{machine, random_function, random_function_with_roots, replay, with_fused};
use super::{ElementChoice, PlaceOptions, Priority, place};
use robovec_ir::machine::{Interconnect, LinkNetwork, Topology};
use robovec_ir::verify::{Violation, verify_placement};
use robovec_ir::{Machine, Operation, Tables, View};

const CHOICES: [ElementChoice; 2] = [ElementChoice::Preferential, ElementChoice::First];
const PRIORITIES: [Priority; 4] = [
    Priority::Best,
    Priority::Alap,
    Priority::FanOut,
    Priority::Mobility,
];

/// Machines harder than the shipped ones.
fn machines(adders: u32, multipliers: u32) -> Vec<(String, Machine)> {
    let mut machines = Vec::new();
    for name in ["thesis", "side-split", "pipeline-3-3", "fused"] {
        let machine = machine(name, adders, multipliers);
        let variants = [
            (Some(1), machine.buffer),
            (None, None),
            (Some(1), None),
            (None, tiny_buffer(&machine)),
        ];
        for (writes, buffer) in variants {
            let mut variant = machine.clone();
            variant.memory.writes = writes.or(machine.memory.writes);
            variant.buffer = buffer;
            machines.push((format!("{name} {writes:?} {buffer:?}"), variant));
        }
    }
    machines
}

fn tiny_buffer(machine: &Machine) -> Option<robovec_ir::machine::BufferDescription> {
    machine.buffer.map(|mut buffer| {
        buffer.words = Some(1);
        buffer
    })
}

fn check(name: &str, machine: &Machine, operations: usize, near: usize, options: PlaceOptions) {
    let mut function = random_function(operations, near, operations as u64);
    if machine.kind_of(Operation::Fma).is_some() {
        function = with_fused(function, operations as u64);
    }
    let placed = place(&mut function, machine, options);
    let summary = placed.unwrap_or_else(|error| panic!("{error}"));
    assert!(summary.lower_bound <= summary.cycles);
    if let Err(breach) = replay(&function, machine) {
        panic!("{name}, {operations} operations, {options:?}: {breach}");
    }
}

#[test]
fn random_programs_obey_the_shipped_machines() {
    for name in ["thesis", "side-split", "ideal", "de10-nano", "fused"] {
        for (adders, multipliers) in [(1, 1), (2, 3), (6, 4)] {
            for (choice, priority) in CHOICES
                .into_iter()
                .flat_map(|choice| PRIORITIES.map(|priority| (choice, priority)))
            {
                let options = PlaceOptions { priority, choice };
                let machine = machine(name, adders, multipliers);
                check(name, &machine, 300, 40, options);
            }
        }
    }
}

#[test]
fn any_kinds_of_elements_will_do() {
    for name in ["thesis", "side-split"] {
        for buffer in [true, false] {
            let mut machine = machine(name, 2, 3);
            for (kind, stages) in [("div", 14), ("root", 20)] {
                let mut element = machine.elements[0].clone();
                element.kind = kind.to_owned();
                element.operations = vec![if kind == "div" { "div" } else { "sqrt" }.to_owned()];
                (element.count, element.stages) = (1, stages);
                machine.elements.push(element);
            }
            if !buffer {
                machine.buffer = None;
            }
            for choice in CHOICES {
                let mut function = random_function_with_roots(300, 5);
                let priority = Priority::Best;
                let options = PlaceOptions { priority, choice };
                place(&mut function, &machine, options).expect("it fits");
                assert_eq!(replay(&function, &machine), Ok(()), "{name} {choice:?}");
            }
        }
    }
}

#[test]
fn random_programs_obey_machines_with_few_ports_and_buffers() {
    for (adders, multipliers) in [(1, 1), (2, 3), (6, 4)] {
        for (name, machine) in machines(adders, multipliers) {
            for (operations, near) in [(0, 1), (40, 5), (150, 30)] {
                for choice in CHOICES {
                    let priority = Priority::Best;
                    let options = PlaceOptions { priority, choice };
                    check(&name, &machine, operations, near, options);
                }
            }
        }
    }
}

/// Every way results can travel, under the verifier, which follows words on
/// its own.
#[test]
fn random_programs_obey_networks() {
    let mut tables = Tables::default();
    for name in ["q", "o", "v"] {
        tables.symbols.intern(name);
    }
    let networks = Topology::ALL.map(LinkNetwork::of);
    let wide = networks.map(|network| LinkNetwork {
        hop: 0,
        words: 2,
        ..network
    });
    for (adders, multipliers) in [(1, 1), (2, 3), (6, 4)] {
        for network in networks.into_iter().chain(wide) {
            for (name, buffer) in [("thesis", true), ("side-split", true), ("thesis", false)] {
                let mut machine = machine(name, adders, multipliers);
                machine.interconnect = Interconnect::Network(network);
                if !buffer {
                    machine.buffer = None;
                }
                for choice in CHOICES {
                    let mut function = random_function(150, 25, u64::from(network.words));
                    let priority = Priority::Alap;
                    let options = PlaceOptions { priority, choice };
                    let summary = place(&mut function, &machine, options).expect("it fits");
                    let view = tables.view(&function);
                    let violations = verify_placement(view, &machine);
                    assert!(violations.is_empty(), "{network:?} {name}: {violations:?}");
                    assert!(summary.lower_bound <= summary.cycles);
                }
            }
        }
    }
}

/// Test of the verifier: a word that arrives before its earliest possible
/// cycle.
#[test]
fn a_placement_for_a_crossbar_breaks_the_rules_of_a_network() {
    let mut function = random_function(200, 20, 3);
    let mut machine = machine("thesis", 3, 3);
    place(&mut function, &machine, PlaceOptions::default()).expect("it fits");
    let mut tables = Tables::default();
    for name in ["q", "o", "v"] {
        tables.symbols.intern(name);
    }
    let view = tables.view(&function);
    assert_eq!(verify_placement(view, &machine), []);
    for (topology, hop, message) in [
        (Topology::Mesh, 1, "before its result is there"),
        (Topology::Bus, 0, "words on one link of the bus"),
    ] {
        machine.interconnect = Interconnect::Network(LinkNetwork {
            hop,
            ..LinkNetwork::of(topology)
        });
        // The schedule claims to be for this machine, and is not.
        let mut function = function.clone();
        let schedule = function.schedule.as_mut().expect("it is placed");
        schedule.machine_hash = Some(machine.content_hash());
        let view = View {
            function: &function,
            ..view
        };
        let violations = verify_placement(view, &machine);
        let said = |violation: &Violation| violation.message.contains(message);
        assert!(violations.iter().any(said), "{topology:?}: {violations:?}");
    }
}

/// Without buffers schedules stay within a few per cent of the bound.
#[test]
fn little_is_lost_without_buffers() {
    for (name, most) in [("thesis", 1.03), ("side-split", 1.05)] {
        for count in [1, 2, 4] {
            let mut machine = machine(name, count, count);
            machine.buffer = None;
            let mut function = random_function(3000, 400, 5);
            let summary = place(&mut function, &machine, PlaceOptions::default()).expect("it fits");
            assert_eq!(replay(&function, &machine), Ok(()));
            let gap = f64::from(summary.cycles) / f64::from(summary.lower_bound);
            assert!(gap < most, "{name} {count}: {summary:?}");
        }
    }
}
