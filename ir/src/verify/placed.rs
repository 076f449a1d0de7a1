//! Invariants 17 to 19: what of a placement can be checked without knowing
//! the machine.

use super::{ViolationCollector, ViolationSubject};
use crate::entity::{Operand, OperandKind, Value};
use crate::placement::{Placement, Schedule, Word};

pub(super) fn check(
    collector: &mut ViolationCollector<'_>,
    schedule: &Schedule,
    placement: &Placement,
) {
    if !lengths(collector, placement) {
        return;
    }
    let elements = schedule.element_count();
    for (value, node) in collector.view.function.values() {
        let slot = schedule.slots[value.index()];
        let reads = placement.reads[value.index()];
        let expected = match slot.is_host() {
            true => 0,
            false => node.operation.arity(),
        };
        let is_there = |&&read: &&u32| read != Placement::NONE;
        let present = reads.iter().filter(is_there).count();
        let in_order = reads.iter().take_while(is_there).count() == present;
        if present != expected || !in_order {
            collector.value(value, || {
                format!("has {present} addresses to read from instead of {expected}")
            });
        }
        writes(collector, schedule, placement, value);
    }
    preloads(collector, schedule, placement, elements);
    homes(collector, schedule, placement, elements);
}

fn lengths(collector: &mut ViolationCollector<'_>, placement: &Placement) -> bool {
    let function = collector.view.function;
    let nodes = function.nodes().len();
    let starts = &placement.write_starts;
    let sound = placement.reads.len() == nodes
        && placement.buffers.len() == nodes
        && starts.len() == nodes + 1
        && starts.first() == Some(&0)
        && starts.is_sorted()
        && starts.last().map(|&end| end as usize) == Some(placement.writes.len())
        && placement.homes.len() == function.assignments.len();
    if !sound {
        let message = || "the tables of the placement do not fit the function".to_owned();
        collector.add(ViolationSubject::Schedule, message);
    }
    sound
}

fn writes(
    collector: &mut ViolationCollector<'_>,
    schedule: &Schedule,
    placement: &Placement,
    value: Value,
) {
    let slot = schedule.slots[value.index()];
    let writes = placement.writes_of(value);
    let buffered = placement.buffers[value.index()] != Placement::NONE;
    if slot.is_host() {
        if !writes.is_empty() || buffered {
            collector.value(value, || {
                "is written, but the host evaluates it before the run".to_owned()
            });
        }
        return;
    }
    let elements = schedule.element_count();
    for (index, write) in writes.iter().enumerate() {
        if write.word.element >= elements {
            collector.value(value, || {
                "is written to a processing element that does not exist".to_owned()
            });
        }
        if write.cycle <= slot.cycle || write.cycle >= schedule.cycles {
            collector.value(value, || {
                let (start, end) = (slot.cycle, schedule.cycles);
                let cycle = write.cycle;
                format!(
                    "is written at cycle {cycle}, not between its start {start} and the end {end}"
                )
            });
        }
        let key = |at: usize| (writes[at].cycle, writes[at].word);
        if index > 0 && key(index - 1) >= key(index) {
            collector.value(value, || "has writes out of order".to_owned());
        }
    }
    if buffered && writes.is_empty() {
        collector.value(value, || {
            "is kept in a buffer, but never written".to_owned()
        });
    }
}

/// True when the operand is known before the run.
fn is_initial(schedule: &Schedule, operand: Operand) -> bool {
    match operand.kind() {
        OperandKind::Value(value) => schedule.slots[value.index()].is_host(),
        OperandKind::Input(_) | OperandKind::Constant(_) => true,
        OperandKind::None => false,
    }
}

fn exists(collector: &ViolationCollector<'_>, operand: Operand) -> bool {
    let function = collector.view.function;
    match operand.kind() {
        OperandKind::Value(value) => value.index() < function.nodes().len(),
        OperandKind::Input(input) => input.index() < function.input_len(),
        OperandKind::Constant(constant) => constant.index() < function.constants().len(),
        OperandKind::None => false,
    }
}

fn preloads(
    collector: &mut ViolationCollector<'_>,
    schedule: &Schedule,
    placement: &Placement,
    elements: u32,
) {
    let mut last: Option<Word> = None;
    for (index, preload) in placement.preloads.iter().enumerate() {
        let subject = ViolationSubject::Preload(index);
        if preload.word.element >= elements {
            collector.add(subject, || {
                "initial data lies in a processing element that does not exist".to_owned()
            });
        }
        if last == Some(preload.word) {
            let message = || "two initial data lie in one word".to_owned();
            collector.add(subject, message);
        } else if last > Some(preload.word) {
            let message = || "initial data is not in order of its words".to_owned();
            collector.add(subject, message);
        }
        last = Some(preload.word);
        if !exists(collector, preload.operand) || !is_initial(schedule, preload.operand) {
            let message = || "initial data is not known before the run".to_owned();
            collector.add(subject, message);
        }
    }
}

fn homes(
    collector: &mut ViolationCollector<'_>,
    schedule: &Schedule,
    placement: &Placement,
    elements: u32,
) {
    let assignments = &collector.view.function.assignments;
    for (index, (assignment, home)) in assignments.iter().zip(&placement.homes).enumerate() {
        match home {
            None if !is_initial(schedule, assignment.operand) => {
                collector.assignment(index, || "has no word where it stays".to_owned());
            }
            Some(_) if is_initial(schedule, assignment.operand) => {
                collector.assignment(index, || {
                    "has a word where it stays, but is known before the run".to_owned()
                });
            }
            Some(word) if word.element >= elements => collector.assignment(index, || {
                "stays in a processing element that does not exist".to_owned()
            }),
            None | Some(_) => {}
        }
    }
}
