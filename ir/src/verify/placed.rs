//! Invariants 17 to 19 of [`verify`](super): the rules of a placement that do
//! not depend on the machine. Cycles and ports, which need it, are checked by
//! [`verify_placement`](super::verify_placement).
//!
//! Cycles count from 0, and processing elements over all kinds from 0. The
//! schedule has passed its own checks (14 to 16): it has a slot for every
//! node.

use super::{ViolationCollector, ViolationSubject};
use crate::entity::{Operand, OperandKind, Value};
use crate::placement::{Placement, Schedule, Word};

/// Adds the faults of a placement to the violations.
pub(super) fn check(
    collector: &mut ViolationCollector<'_>,
    schedule: &Schedule,
    placement: &Placement,
) {
    // All that follows indexes the tables by node and assignment.
    if !tables_fit(collector, placement) {
        return;
    };
    let elements = schedule.element_count();
    for (value, node) in collector.view.function.values() {
        let addresses = placement.reads[value.index()];
        let expected = match schedule.is_host(value) {
            // What the host evaluates reads no memory.
            true => 0,
            false => node.operation.arity(),
        };
        // The first operands have the addresses, without a gap.
        let fits = |place: usize| addresses[place].is_some() == (place < expected);
        if !(0..Operand::MAX_COUNT).all(fits) {
            let present = addresses.iter().flatten().count();
            collector.value(value, || {
                format!("has {present} addresses to read from instead of {expected}")
            });
        }
        writes(collector, (schedule, elements), placement, value);
    }
    preloads(collector, schedule, placement, elements);
    homes(collector, schedule, placement, elements);
}

/// Tests whether the tables have an entry for every node or assignment, and the
/// ranges of writes cover all writes; a violation when not.
fn tables_fit(collector: &mut ViolationCollector<'_>, placement: &Placement) -> bool {
    let function = collector.view.function;
    let nodes = function.nodes().len();
    let starts = &placement.write_starts;
    let fit = placement.reads.len() == nodes
        && placement.buffers.len() == nodes
        && starts.len() == nodes + 1
        && starts.first() == Some(&0)
        && starts.is_sorted()
        && starts.last().map(|&end| end as usize) == Some(placement.writes.len())
        && placement.homes.len() == function.assignments.len();
    if !fit {
        let message = || "the tables of the placement do not fit the function".to_owned();
        collector.add(ViolationSubject::Schedule, message);
    }
    fit
}

/// The writes of a value's result (17): to elements that exist, in order of
/// cycle and word, between issue and end; none for a value of the host.
fn writes(
    collector: &mut ViolationCollector<'_>,
    (schedule, elements): (&Schedule, u32),
    placement: &Placement,
    value: Value,
) {
    let writes = placement.writes_of(value);
    let buffered = placement.buffers[value.index()].is_some();
    let Some(slot) = schedule.slots[value.index()] else {
        if !writes.is_empty() || buffered {
            collector.value(value, || {
                "is written, but the host evaluates it before the run".to_owned()
            });
        }
        return;
    };
    for (index, write) in writes.iter().enumerate() {
        if write.word.element.number() >= elements {
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
        let place_in_order = |index: usize| (writes[index].cycle, writes[index].word);
        if index > 0 && place_in_order(index - 1) >= place_in_order(index) {
            collector.value(value, || "has writes out of order".to_owned());
        }
    }
    if buffered && writes.is_empty() {
        collector.value(value, || {
            "is kept in a buffer, but never written".to_owned()
        });
    }
}

/// True when the operand is known before the run: an input, a constant or a
/// value that the host evaluates. The value must exist.
fn is_initial(schedule: &Schedule, operand: Operand) -> bool {
    match operand.kind() {
        OperandKind::Value(value) => schedule.is_host(value),
        OperandKind::Input(_) | OperandKind::Constant(_) => true,
        OperandKind::None => false,
    }
}

/// True when the function has the operand.
fn exists(collector: &ViolationCollector<'_>, operand: Operand) -> bool {
    let function = collector.view.function;
    match operand.kind() {
        OperandKind::Value(value) => value.index() < function.nodes().len(),
        OperandKind::Input(input) => input.index() < function.input_len(),
        OperandKind::Constant(constant) => constant.index() < function.constants().len(),
        OperandKind::None => false,
    }
}

/// The initial data (18): in strict order of their words, on elements that
/// exist, and known before the run.
fn preloads(
    collector: &mut ViolationCollector<'_>,
    schedule: &Schedule,
    placement: &Placement,
    elements: u32,
) {
    // `None` before the first one, which is less than every word.
    let mut previous: Option<Word> = None;
    for (index, preload) in placement.preloads.iter().enumerate() {
        let subject = ViolationSubject::Preload(index);
        if preload.word.element.number() >= elements {
            collector.add(subject, || {
                "initial data lies in a processing element that does not exist".to_owned()
            });
        }
        if previous == Some(preload.word) {
            let message = || "two initial values are in one word".to_owned();
            collector.add(subject, message);
        } else if previous > Some(preload.word) {
            let message = || "initial data is not in order of its words".to_owned();
            collector.add(subject, message);
        }
        previous = Some(preload.word);
        if !exists(collector, preload.operand) || !is_initial(schedule, preload.operand) {
            let message = || "initial data is not known before the run".to_owned();
            collector.add(subject, message);
        }
    }
}

/// The words in which outputs stay to the end of the run (19): on elements
/// that exist, one for each output that is a result of a processing element.
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
            Some(word) if word.element.number() >= elements => collector.assignment(index, || {
                "stays in a processing element that does not exist".to_owned()
            }),
            None | Some(_) => {}
        }
    }
}
