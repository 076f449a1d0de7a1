//! Placement on random programs and at the edges of the machine's rules.

use super::testing::{machine, random_function, random_function_with_roots, replay, with_fused};
use super::{Choice, PlaceOptions, Priority, place};
use robovec_ir::{Machine, Operation};

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
