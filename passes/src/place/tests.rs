//! Placement on random programs and at the edges of the machine's rules.

use super::testing::{machine, random_function, replay};
use super::{Choice, PlaceOptions, Priority, place};
use robovec_ir::Machine;

const CHOICES: [Choice; 2] = [Choice::Preferential, Choice::First];
const PRIORITIES: [Priority; 4] = [
    Priority::Best,
    Priority::Alap,
    Priority::FanOut,
    Priority::Mobility,
];

/// Machines harder than the shipped ones.
fn machines(adders: u32, multipliers: u32) -> Vec<(String, Machine)> {
    let mut machines = Vec::new();
    for name in ["thesis", "side-split", "pipeline-3-3"] {
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
    let placed = place(&mut function, machine, options);
    let summary = placed.unwrap_or_else(|error| panic!("{error}"));
    assert!(summary.lower_bound <= summary.cycles);
    if let Err(breach) = replay(&function, machine) {
        panic!("{name}, {operations} operations, {options:?}: {breach}");
    }
}

#[test]
fn random_programs_obey_the_shipped_machines() {
    for name in ["thesis", "side-split", "ideal", "de10-nano"] {
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
