//! The placement, checked against the machine.
//!
//! This is the machine's view: nothing is taken from how the placer works,
//! only from the conventions of [`crate::placement`]. An operation issued at
//! cycle `t` on an element of `L` stages has its result on the crossbar at
//! `t + L + 1`; a word written in cycle `w` can be read from `w + 1` on; a
//! write later than the result comes from the buffer of the element.

use super::network::{self, Routes};
use super::{Violation, ViolationCollector, ViolationSubject, replay, verify};
use crate::entity::Value;
use crate::machine::{Machine, MemoryStyle};
use crate::module::View;
use crate::placement::{Bank, Placement, Schedule, Slot, Word, Write};
use robovec_num::operation::Operation;

/// Checks a placed function against its machine, after [`verify`] finds
/// nothing; the form of the result is the same.
///
/// 1. Every operation is on a kind of element that performs it, of the
///    machine's stages; memories have the machine's style.
/// 2. A result departs in its write-back cycle (`issue + stages + 1`) or,
///    if it is in a buffer, later, and is written as long after that as it
///    takes to the memory, over a crossbar at once; it is in a buffer only if
///    it departs later for one of its writes.
/// 3. Every operand is read from a word that holds it when the operation
///    starts, and every output stays in a word that holds it at the end.
/// 4. No memory takes more words in a cycle than the machine writes, and no
///    word is written twice in a cycle.
/// 5. A buffer word is not taken anew before the cycle after its last read,
///    and a buffer hands out no more words in a cycle than the machine reads.
/// 6. No link of a network carries more words in a cycle than it can.
/// 7. Addresses and buffer words lie within the memories and buffers.
pub fn verify_placement(view: View<'_>, machine: &Machine) -> Vec<Violation> {
    let violations = verify(view);
    if !violations.is_empty() {
        return violations;
    }
    let mut collector = ViolationCollector::new(view);
    let function = view.function;
    let (Some(schedule), Some(placement)) = (&function.schedule, &function.placement) else {
        let message = || "only a placed function can be checked against a machine".to_owned();
        collector.add(ViolationSubject::Function, message);
        return collector.finish();
    };
    let Some(elements) = elements(&mut collector, schedule, machine) else {
        return collector.finish();
    };
    let counts: Vec<u32> = schedule.kinds.iter().map(|kind| kind.count).collect();
    let check = PlacementCheck {
        view,
        machine,
        schedule,
        placement,
        elements,
        routes: Routes::new(machine.interconnect, &counts),
    };
    check.preloads(&mut collector);
    check.values(&mut collector);
    replay::check(&check, &mut collector);
    if let Some(routes) = &check.routes {
        network::check(&check, routes, &mut collector);
    }
    collector.finish()
}

/// Numbers of the machine about a processing element.
#[derive(Clone, Copy)]
struct ElementFacts {
    stages: u32,
    /// By operation, whether it is the element's kind that performs it.
    performs: [bool; Operation::ALL.len()],
}

/// The facts of each processing element; `None` when the kinds are not those
/// of the machine.
fn elements(
    collector: &mut ViolationCollector<'_>,
    schedule: &Schedule,
    machine: &Machine,
) -> Option<Vec<ElementFacts>> {
    if let Err(mismatch) = schedule.check_machine(machine) {
        collector.add(ViolationSubject::Schedule, || mismatch.to_string());
        return None;
    }
    let performers = Operation::ALL.map(|operation| machine.kind_of(operation));
    let mut facts = Vec::new();
    for kind in &schedule.kinds {
        let mut elements = machine.elements.iter();
        let Some(index) = elements.position(|element| element.kind == kind.name) else {
            collector.add(ViolationSubject::Schedule, || {
                format!("the machine has no processing elements '{}'", kind.name)
            });
            return None;
        };
        let element = ElementFacts {
            stages: machine.elements[index].stages,
            performs: performers.map(|performer| performer == Some(index)),
        };
        facts.extend((0..kind.count).map(|_| element));
    }
    Some(facts)
}

pub(super) struct PlacementCheck<'a> {
    pub(super) view: View<'a>,
    pub(super) machine: &'a Machine,
    pub(super) schedule: &'a Schedule,
    pub(super) placement: &'a Placement,
    elements: Vec<ElementFacts>,
    /// The routes of words, unless there is a crossbar.
    pub(super) routes: Option<Routes>,
}

impl PlacementCheck<'_> {
    /// The slot of a value that the machine computes.
    pub(super) fn slot(&self, value: Value) -> Slot {
        self.schedule.slot(value)
    }

    /// The cycle in which the result is on the crossbar.
    pub(super) fn write_back(&self, value: Value) -> u64 {
        let slot = self.slot(value);
        u64::from(slot.cycle) + u64::from(self.elements[slot.element.index()].stages) + 1
    }

    /// The cycle in which the word of a write left its producer or the
    /// producer's buffer.
    pub(super) fn departs(&self, value: Value, write: &Write) -> u64 {
        let from = self.slot(value).element;
        let routes = self.routes.as_ref();
        let latency = routes.map_or(0, |routes| routes.latency(from, write.word.element));
        // A write before its word can have arrived has left too early, too.
        u64::from(write.cycle).saturating_sub(latency)
    }

    pub(super) fn placed_values(&self) -> impl Iterator<Item = Value> + '_ {
        let count = self.view.function.nodes().len() as u32;
        (0..count)
            .map(Value)
            .filter(|&value| !self.schedule.is_host(value))
    }

    pub(super) fn name(&self, word: Word) -> String {
        let (kind, number) = self.schedule.element_name(word.element);
        let bank = match word.bank {
            Bank::Unified => "",
            Bank::Left => ".left",
            Bank::Right => ".right",
        };
        format!("{kind}{number}{bank}[{}]", word.address)
    }

    fn fits(&self, word: Word) -> bool {
        let memory = &self.machine.memory;
        let split = word.bank != Bank::Unified;
        split == (memory.style == MemoryStyle::SideSplit)
            && memory
                .words
                .is_none_or(|words| word.address.number() < words)
    }

    /// The memory an operand is read from, by its side.
    pub(super) fn bank(&self, side: usize) -> Bank {
        match (self.machine.memory.style, side) {
            (MemoryStyle::Unified | MemoryStyle::FourPort, _) => Bank::Unified,
            (MemoryStyle::SideSplit, 0) => Bank::Left,
            (MemoryStyle::SideSplit, _) => Bank::Right,
        }
    }

    fn preloads(&self, collector: &mut ViolationCollector<'_>) {
        for (index, preload) in self.placement.preloads.iter().enumerate() {
            if !self.fits(preload.word) {
                collector.add(ViolationSubject::Preload(index), || {
                    format!("the machine has no word {}", self.name(preload.word))
                });
            }
        }
    }

    /// Who performs every operation, and where and when its result is written.
    fn values(&self, collector: &mut ViolationCollector<'_>) {
        for value in self.placed_values() {
            let operation = self.view.function.node(value).operation;
            let element = self.slot(value).element;
            if !self.elements[element.index()].performs[operation as usize] {
                let (kind, number) = self.schedule.element_name(element);
                let operation = operation.name();
                collector.value(value, || {
                    format!("is on {kind}{number}, which does not perform '{operation}'")
                });
            }
            self.writes(collector, value);
        }
    }

    fn writes(&self, collector: &mut ViolationCollector<'_>, value: Value) {
        let back = self.write_back(value);
        let buffered = self.placement.buffers[value.index()].is_some();
        // Whether a write departs later than the result appears.
        let mut waits = false;
        for write in self.placement.writes_of(value) {
            if !self.fits(write.word) {
                let name = self.name(write.word);
                collector.value(value, || {
                    format!("is written to {name}, which does not exist")
                });
            }
            let departs = self.departs(value, write);
            waits |= departs > back;
            if departs < back {
                collector.value(value, || {
                    format!(
                        "is written at cycle {}, before its result is there at {back}",
                        write.cycle
                    )
                });
            } else if departs > back && !buffered {
                collector.value(value, || {
                    format!(
                        "is written at cycle {}, after {back}, but is in no buffer",
                        write.cycle
                    )
                });
            }
        }
        if buffered {
            self.buffer_word(collector, value);
        }
        if buffered && !waits {
            collector.value(value, || {
                "is in a buffer that nothing reads it from".to_owned()
            });
        }
    }

    fn buffer_word(&self, collector: &mut ViolationCollector<'_>, value: Value) {
        let words = self.machine.buffer.map_or(Some(0), |buffer| buffer.words);
        if let Some(word) = self.placement.buffers[value.index()]
            && let Some(words) = words
            && word.number() >= words
        {
            collector.value(value, || {
                format!("is in buffer word {word}, but the buffers have {words} words")
            });
        }
    }
}
