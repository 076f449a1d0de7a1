//! The placement, checked against the machine.
//!
//! This is the machine's view: it depends only on the conventions of
//! [`crate::placement`], not on the placer. An operation issued at cycle `t` on
//! an element of `L` stages has its result on the crossbar at `t + L + 1`; a
//! word written in cycle `w` can be read from `w + 1` on; a write later than
//! the result comes from the buffer of the element.

use super::network::{NetworkWire, Routes};
use super::{ViolationCollector, ViolationSubject};
use crate::entity::Value;
use crate::machine::{Machine, MemoryStyle};
use crate::module::View;
use crate::placement::{Bank, Element, Placement, Schedule, Slot, Word, Write};
use robovec_num::operation::Operation;

/// Numbers of the machine about a processing element.
#[derive(Clone, Copy)]
struct ElementFacts {
    stages: u32,
    /// By operation, true when the element's kind performs it.
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

/// A word on a wire in a cycle: wire, cycle, value, departure.
type WireUse = (NetworkWire, u64, u32, u64);

pub(super) struct PlacementCheck<'a> {
    pub(super) view: View<'a>,
    pub(super) machine: &'a Machine,
    pub(super) schedule: &'a Schedule,
    pub(super) placement: &'a Placement,
    elements: Vec<ElementFacts>,
    /// The routes of words, unless there is a crossbar.
    pub(super) routes: Option<Routes>,
}

impl<'a> PlacementCheck<'a> {
    /// The check of a placed function; `None` where its schedule is for
    /// another machine.
    pub(super) fn new(
        view: View<'a>,
        (schedule, placement): (&'a Schedule, &'a Placement),
        machine: &'a Machine,
        collector: &mut ViolationCollector<'_>,
    ) -> Option<PlacementCheck<'a>> {
        let counts: Vec<u32> = schedule.kinds.iter().map(|kind| kind.count).collect();
        Some(PlacementCheck {
            view,
            machine,
            schedule,
            placement,
            elements: elements(collector, schedule, machine)?,
            routes: Routes::new(machine.interconnect, &counts),
        })
    }
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

    pub(super) fn preloads(&self, collector: &mut ViolationCollector<'_>) {
        for (index, preload) in self.placement.preloads.iter().enumerate() {
            if !self.fits(preload.word) {
                collector.add(ViolationSubject::Preload(index), || {
                    format!("the machine has no word {}", self.name(preload.word))
                });
            }
        }
    }

    /// Who performs every operation, and where and when its result is written.
    pub(super) fn values(&self, collector: &mut ViolationCollector<'_>) {
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

    /// Reports every wire that carries more words than it can, and every buffer
    /// that hands out more.
    pub(super) fn links(&self, collector: &mut ViolationCollector<'_>) {
        let Some(routes) = &self.routes else {
            return;
        };
        let mut uses: Vec<WireUse> = Vec::new();
        let mut sent: Vec<(Element, u64, u32)> = Vec::new();
        for value in self.placed_values() {
            let from = self.slot(value).element;
            let back = self.write_back(value);
            for write in self.placement.writes_of(value) {
                let to = write.word.element;
                let departs = u64::from(write.cycle).saturating_sub(routes.latency(from, to));
                let used = routes.uses(from, to).into_iter();
                uses.extend(used.map(|(wire, after)| (wire, departs + after, value.0, departs)));
                if departs > back && self.placement.buffers[value.index()].is_some() {
                    sent.push((from, departs, value.0));
                }
            }
        }
        uses.sort_unstable();
        uses.dedup();
        let words = routes.words();
        for group in uses.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            if group.len() > words {
                let (count, cycle) = (group.len(), group[0].1);
                let name = routes.topology();
                collector.value(Value(group[words].2), || {
                    format!(
                        "is one of {count} words on one link of the {name} at cycle {cycle}, which \
                         carries {words}"
                    )
                });
            }
        }
        let Some(limit) = self.machine.buffer.and_then(|buffer| buffer.reads) else {
            return;
        };
        sent.sort_unstable();
        sent.dedup();
        for group in sent.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            if group.len() > limit as usize {
                let (kind, number) = self.schedule.element_name(group[0].0);
                let cycle = group[0].1;
                collector.add(ViolationSubject::Schedule, || {
                    format!(
                        "more words of the buffer of {kind}{number} are read at cycle {cycle} than the \
                         {limit} it hands out"
                    )
                });
            }
        }
    }
}
