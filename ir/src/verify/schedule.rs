//! Invariants 14 to 16: the rules of a schedule that do not depend on the
//! machine.

use super::{ViolationCollector, ViolationSubject, all_differ, describe};
use crate::entity::Value;
use crate::placement::{Schedule, Slot};

/// Bits per node of the set of slots in use: the size of the keys that would be
/// sorted instead.
const BITS_PER_NODE: usize = 64;

/// True when every node has a slot on an element that exists.
pub(super) fn check(collector: &mut ViolationCollector<'_>, schedule: &Schedule) -> bool {
    kinds(collector, schedule);
    let count = collector.view.function.nodes().len();
    if schedule.slots.len() != count {
        let slots = schedule.slots.len();
        let message = || format!("there are slots for {slots} of {count} nodes");
        collector.add(ViolationSubject::Schedule, message);
        return false;
    }
    let sound = slots(collector, schedule);
    dependencies(collector, schedule);
    one_at_a_time(collector, schedule);
    if schedule.lower_bound > schedule.cycles {
        collector.add(ViolationSubject::Schedule, || {
            let (cycles, bound) = (schedule.cycles, schedule.lower_bound);
            format!("the schedule of {cycles} cycles is shorter than its lower bound {bound}")
        });
    }
    sound
}

fn kinds(collector: &mut ViolationCollector<'_>, schedule: &Schedule) {
    let mut elements = 0u64;
    for (index, kind) in schedule.kinds.iter().enumerate() {
        let name = &kind.name;
        let letters = name.bytes().all(|byte| byte.is_ascii_lowercase());
        if name.is_empty() || !letters || name == "host" {
            collector.add(ViolationSubject::Schedule, || {
                format!("the kind '{name}' is not a word of lower-case letters other than 'host'")
            });
        }
        if schedule.kinds[..index]
            .iter()
            .any(|other| other.name == *name)
        {
            let message = || format!("there are two kinds '{name}' of processing elements");
            collector.add(ViolationSubject::Schedule, message);
        }
        elements += u64::from(kind.count);
    }
    if elements >= 1 << 24 {
        let message = || "there are more than 2^24 processing elements".to_owned();
        collector.add(ViolationSubject::Schedule, message);
    }
}

fn slots(collector: &mut ViolationCollector<'_>, schedule: &Schedule) -> bool {
    let elements: u64 = schedule
        .kinds
        .iter()
        .map(|kind| u64::from(kind.count))
        .sum();
    let mut sound = elements < 1 << 24;
    for (value, node) in collector.view.function.values() {
        let Some(slot) = schedule.slots[value.index()] else {
            continue;
        };
        if u64::from(slot.element.number()) >= elements {
            sound = false;
            collector.value(value, || {
                format!("is on processing element {} of {elements}", slot.element)
            });
        }
        if slot.cycle >= schedule.cycles {
            let cycles = schedule.cycles;
            collector.value(value, || {
                format!("starts at cycle {} of {cycles}", slot.cycle)
            });
        }
        if node.operation.is_trigonometric() {
            collector.value(value, || {
                "is a sine or cosine, which only the host evaluates".to_owned()
            });
        }
    }
    sound
}

fn dependencies(collector: &mut ViolationCollector<'_>, schedule: &Schedule) {
    let view = collector.view;
    for (value, node) in view.function.values() {
        let slot = schedule.slots[value.index()];
        for operand in node.values() {
            let Some(source) = schedule.slots[operand.index()] else {
                continue;
            };
            match slot {
                None => collector.value(value, || {
                    let operand = describe(view, operand);
                    format!("is evaluated by the host before the run, but reads {operand}")
                }),
                Some(slot) if slot.cycle <= source.cycle => collector.value(value, || {
                    let operand = describe(view, operand);
                    format!(
                        "starts at cycle {}, but {operand}, which it reads, starts at {}",
                        slot.cycle, source.cycle
                    )
                }),
                Some(_) => {}
            }
        }
    }
}

fn one_at_a_time(collector: &mut ViolationCollector<'_>, schedule: &Schedule) {
    let slots = || schedule.slots.iter().flatten();
    let cycles = slots().map(|slot| slot.cycle as usize + 1);
    let cycles = cycles.fold(0, usize::max);
    let elements = slots().map(|slot| slot.element.index() + 1);
    let bits = elements.fold(0, usize::max).saturating_mul(cycles);
    let is_dense = bits <= BITS_PER_NODE * (schedule.slots.len() + 1);
    let bit = |slot: &Slot| slot.element.index() * cycles + slot.cycle as usize;
    if !is_dense || !all_differ(slots().map(bit), bits) {
        taken_twice(collector, schedule);
    }
}

/// Reports who shares a slot.
fn taken_twice(collector: &mut ViolationCollector<'_>, schedule: &Schedule) {
    let key = |slot: &Slot| u64::from(slot.element.number()) << 32 | u64::from(slot.cycle);
    let mut keys: Vec<u64> = schedule.slots.iter().flatten().map(key).collect();
    keys.sort_unstable();
    let mut twice: Vec<u64> = keys
        .windows(2)
        .filter(|pair| pair[0] == pair[1])
        .map(|pair| pair[0])
        .collect();
    twice.dedup();
    if twice.is_empty() {
        return;
    }
    let mut first: Vec<Option<Value>> = vec![None; twice.len()];
    let view = collector.view;
    for (index, slot) in schedule.slots.iter().enumerate() {
        let Some(slot) = slot else { continue };
        let Ok(at) = twice.binary_search(&key(slot)) else {
            continue;
        };
        let value = Value(index as u32);
        match first[at] {
            None => first[at] = Some(value),
            Some(other) => collector.value(value, || {
                let (kind, number) = schedule.element_name(slot.element);
                format!(
                    "starts on {kind}{number} at cycle {}, and so does {}",
                    slot.cycle,
                    describe(view, other)
                )
            }),
        }
    }
}
