//! Check that a placement has the shape of its function, so that later code can
//! index with it.

use super::ImageError;
use robovec_ir::machine::MemoryStyle;
use robovec_ir::placement::{Bank, Placement, Schedule};
use robovec_ir::{Machine, Value, View};

/// The maximum number of elements of a kind, as in a machine file.
const MAX_ELEMENTS: u32 = 4096;

/// For each element of the schedule its kind's place in the machine file.
pub(super) fn element_kinds(
    schedule: &Schedule,
    machine: &Machine,
) -> Result<Vec<usize>, ImageError> {
    let mut kinds = Vec::new();
    for kind in &schedule.kinds {
        let place = machine
            .elements
            .iter()
            .position(|element| element.kind == kind.name);
        let Some(place) = place.filter(|_| kind.count <= MAX_ELEMENTS) else {
            return Err(ImageError::UnknownKind {
                kind: kind.name.clone(),
            });
        };
        kinds.extend((0..kind.count).map(|_| place));
    }
    Ok(kinds)
}

/// Everything that later code indexes with must be in range.
pub(super) fn check_shape(
    view: View<'_>,
    machine: &Machine,
    schedule: &Schedule,
    placement: &Placement,
    kinds: &[usize],
) -> Result<(), ImageError> {
    let count = view.function.nodes().len();
    let starts = &placement.write_starts;
    let whole = schedule.slots.len() == count
        && placement.reads.len() == count
        && placement.buffers.len() == count
        && starts.len() == count + 1
        && starts.first() == Some(&0)
        && starts.last().copied().map(|end| end as usize) == Some(placement.writes.len())
        && starts.is_sorted()
        && placement.homes.len() == view.function.assignments.len();
    if !whole {
        return Err(malformed(
            view,
            "its parts do not have one entry per value and output".to_owned(),
        ));
    }
    let split = machine.memory.style == MemoryStyle::SideSplit;
    let words = (placement.writes.iter().map(|write| write.word))
        .chain(placement.preloads.iter().map(|load| load.word))
        .chain(placement.homes.iter().flatten().copied());
    for word in words {
        let bank_exists = (word.bank != Bank::Unified) == split;
        if word.element.index() >= kinds.len() || !bank_exists {
            return Err(malformed(view, format!("there is no memory word {word:?}")));
        }
    }
    check_issues(view, machine, schedule, placement, kinds)
}

/// Every operation is on an element that performs it, reads a word for each
/// operand, and starts before the end.
fn check_issues(
    view: View<'_>,
    machine: &Machine,
    schedule: &Schedule,
    placement: &Placement,
    kinds: &[usize],
) -> Result<(), ImageError> {
    for (value, node) in view.function.values() {
        let Some(slot) = schedule.slots[value.index()] else {
            continue;
        };
        let Some(&kind) = kinds.get(slot.element.index()) else {
            let what = format!("there is no element {}", slot.element);
            return Err(malformed(view, what));
        };
        let reads = &placement.reads[value.index()];
        let operands = node.operands();
        let pairs = operands.iter().zip(reads);
        if pairs
            .into_iter()
            .any(|(operand, read)| operand.is_none() || read.is_none())
        {
            let what = format!(
                "the operation issued in cycle {} lacks an operand or its address",
                slot.cycle
            );
            return Err(malformed(view, what));
        }
        if !machine.elements[kind].performs(node.operation) {
            let (kind, number) = schedule.element_name(slot.element);
            return Err(ImageError::CannotPerform {
                element: format!("{kind}{number}"),
                operation: node.operation.name(),
                value: value_name(view, value),
            });
        }
        if slot.cycle >= schedule.cycles {
            return Err(ImageError::AfterEnd {
                value: value_name(view, value),
                cycle: u64::from(slot.cycle),
                cycles: schedule.cycles,
            });
        }
    }
    Ok(())
}

/// A value's name, without the percent sign.
pub(super) fn value_name(view: View<'_>, value: Value) -> String {
    let name = view.function.node(value).name;
    if name.is_none() {
        return format!("node {}", value.0);
    }
    name.display(&view.tables.symbols)
}

/// The error of a placement that does not fit its function.
pub(super) fn malformed(view: View<'_>, what: String) -> ImageError {
    ImageError::Malformed {
        function: view.function.name.clone(),
        what,
    }
}
