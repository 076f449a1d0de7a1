//! The placement, checked against the machine.
//!
//! This is the machine's view: nothing is taken from how the placer works,
//! only from the conventions of [`crate::placement`]. An operation issued at
//! cycle `t` on an element of `L` stages has its result on the crossbar at
//! `t + L + 1`; a word written in cycle `w` can be read from `w + 1` on; a
//! write later than the result comes from the buffer of the element.

use super::{Collector, Subject, Violation, describe, describe_operand, verify};
use crate::entity::{Operand, OperandKind, Value};
use crate::machine::{Machine, MemoryStyle};
use crate::module::View;
use crate::placement::{Bank, Placement, Schedule, Slot, Word};

/// Checks a placed function against its machine, after [`verify`] finds
/// nothing; the form of the result is the same.
///
/// 1. Every operation is on a kind of element that performs it, of the
///    machine's stages; memories have the machine's style.
/// 2. A result is written in its write-back cycle (`issue + stages + 1`) or,
///    if it is in a buffer, later; it is in a buffer only if one of its
///    writes is later.
/// 3. Every operand is read from a word that holds it when the operation
///    starts, and every output stays in a word that holds it at the end.
/// 4. No memory takes more words in a cycle than the machine writes, and no
///    word is written twice in a cycle.
/// 5. A buffer word is not taken anew before the cycle after its last read,
///    and a buffer hands out no more words in a cycle than the machine reads.
/// 6. Addresses and buffer words lie within the memories and buffers.
pub fn verify_placement(view: View<'_>, machine: &Machine) -> Vec<Violation> {
    let violations = verify(view);
    if !violations.is_empty() {
        return violations;
    }
    let mut collector = Collector::new(view);
    let function = view.function;
    let (Some(schedule), Some(placement)) = (&function.schedule, &function.placement) else {
        let message = || "only a placed function can be checked against a machine".to_owned();
        collector.add(Subject::Function, message);
        return collector.finish();
    };
    let Some(stages) = stages(&mut collector, schedule, machine) else {
        return collector.finish();
    };
    let check = Check {
        view,
        machine,
        schedule,
        placement,
        stages,
    };
    check.performers(&mut collector);
    check.words(&mut collector);
    check.write_cycles(&mut collector);
    check.contents(&mut collector);
    check.write_ports(&mut collector);
    check.buffers(&mut collector);
    collector.finish()
}

/// The stages of each processing element; `None` when the kinds are not those
/// of the machine.
fn stages(
    collector: &mut Collector<'_>,
    schedule: &Schedule,
    machine: &Machine,
) -> Option<Vec<u32>> {
    if schedule.machine != machine.name {
        let (own, other) = (&schedule.machine, &machine.name);
        collector.add(Subject::Schedule, || {
            format!("the schedule is for the machine '{own}', not '{other}'")
        });
        return None;
    }
    let mut stages = Vec::new();
    for kind in &schedule.kinds {
        let mut elements = machine.elements.iter();
        let Some(element) = elements.find(|element| element.kind == kind.name) else {
            collector.add(Subject::Schedule, || {
                format!("the machine has no processing elements '{}'", kind.name)
            });
            return None;
        };
        stages.extend((0..kind.count).map(|_| element.stages));
    }
    Some(stages)
}

struct Check<'a> {
    view: View<'a>,
    machine: &'a Machine,
    schedule: &'a Schedule,
    placement: &'a Placement,
    stages: Vec<u32>,
}

/// Something that happens to a memory word; in order of word and cycle, what
/// is in the word by a cycle before what is read in it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Event {
    word: Word,
    /// The first cycle in which the content can be read, or that of a read.
    cycle: u64,
    /// `false` for a content, `true` for a read.
    is_read: bool,
    /// What the word holds from now on, or what should be read.
    operand: Operand,
    /// The reading operation, or an assignment by its index plus the number
    /// of nodes.
    reader: u32,
}

/// A stay in a buffer.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Stay {
    element: u32,
    word: u32,
    from: u64,
    to: u64,
    value: Value,
}

impl Check<'_> {
    fn slot(&self, value: Value) -> Slot {
        self.schedule.slots[value.index()]
    }

    /// The cycle in which the result is on the crossbar.
    fn write_back(&self, value: Value) -> u64 {
        let slot = self.slot(value);
        u64::from(slot.cycle) + u64::from(self.stages[slot.element as usize]) + 1
    }

    fn placed_values(&self) -> impl Iterator<Item = Value> + '_ {
        let count = self.view.function.nodes().len() as u32;
        (0..count)
            .map(Value)
            .filter(|&value| !self.slot(value).is_host())
    }

    fn name(&self, word: Word) -> String {
        let (kind, number) = self.schedule.element_name(word.element);
        let bank = match word.bank {
            Bank::Unified => "",
            Bank::Left => ".left",
            Bank::Right => ".right",
        };
        format!("{kind}{number}{bank}[{}]", word.address)
    }

    fn performers(&self, collector: &mut Collector<'_>) {
        for value in self.placed_values() {
            let operation = self.view.function.node(value).operation;
            let (kind, number) = self.schedule.element_name(self.slot(value).element);
            let performer = self.machine.kind_of(operation);
            let fits = performer.is_some_and(|index| self.machine.elements[index].kind == kind);
            if !fits {
                let operation = operation.name();
                collector.value(value, || {
                    format!("is on {kind}{number}, which does not perform '{operation}'")
                });
            }
        }
    }

    fn fits(&self, word: Word) -> bool {
        let memory = &self.machine.memory;
        let style = match word.bank {
            Bank::Unified => MemoryStyle::Unified,
            Bank::Left | Bank::Right => MemoryStyle::SideSplit,
        };
        style == memory.style && memory.words.is_none_or(|words| word.address < words)
    }

    /// The word an operand is read from.
    fn read_word(&self, value: Value, side: usize) -> Word {
        let bank = match (self.machine.memory.style, side) {
            (MemoryStyle::Unified, _) => Bank::Unified,
            (MemoryStyle::SideSplit, 0) => Bank::Left,
            (MemoryStyle::SideSplit, _) => Bank::Right,
        };
        Word {
            element: self.slot(value).element,
            bank,
            address: self.placement.reads[value.index()][side],
        }
    }

    fn words(&self, collector: &mut Collector<'_>) {
        for (index, preload) in self.placement.preloads.iter().enumerate() {
            if !self.fits(preload.word) {
                collector.add(Subject::Preload(index), || {
                    format!("the machine has no word {}", self.name(preload.word))
                });
            }
        }
        for value in self.placed_values() {
            for write in self.placement.writes_of(value) {
                if !self.fits(write.word) {
                    let name = self.name(write.word);
                    collector.value(value, || {
                        format!("is written to {name}, which does not exist")
                    });
                }
            }
        }
    }

    fn write_cycles(&self, collector: &mut Collector<'_>) {
        for value in self.placed_values() {
            let back = self.write_back(value);
            let writes = self.placement.writes_of(value);
            let buffered = self.placement.buffers[value.index()] != Placement::NONE;
            for write in writes {
                if u64::from(write.cycle) < back {
                    collector.value(value, || {
                        format!(
                            "is written at cycle {}, before its result is there at {back}",
                            write.cycle
                        )
                    });
                } else if u64::from(write.cycle) > back && !buffered {
                    collector.value(value, || {
                        format!(
                            "is written at cycle {}, after {back}, but is in no buffer",
                            write.cycle
                        )
                    });
                }
            }
            if buffered && writes.iter().all(|write| u64::from(write.cycle) <= back) {
                collector.value(value, || {
                    "is in a buffer that nothing reads it from".to_owned()
                });
            }
        }
    }

    /// What every word holds when it is read.
    fn contents(&self, collector: &mut Collector<'_>) {
        let mut events = self.events();
        events.sort_unstable();
        let mut held: Option<(Word, Operand)> = None;
        for event in &events {
            let content = held.filter(|(word, _)| *word == event.word);
            if !event.is_read {
                held = Some((event.word, event.operand));
            } else if content.map(|(_, operand)| operand) != Some(event.operand) {
                self.wrong(collector, event, content.map(|(_, operand)| operand));
            }
        }
    }

    fn events(&self) -> Vec<Event> {
        let function = self.view.function;
        let nodes = function.nodes().len() as u32;
        let mut events = Vec::with_capacity(self.placement.writes.len() + 2 * nodes as usize);
        let content = |word, cycle, operand| Event {
            word,
            cycle,
            is_read: false,
            operand,
            reader: 0,
        };
        for preload in &self.placement.preloads {
            events.push(content(preload.word, 0, preload.operand));
        }
        for value in self.placed_values() {
            for write in self.placement.writes_of(value) {
                events.push(content(
                    write.word,
                    u64::from(write.cycle) + 1,
                    value.into(),
                ));
            }
            for (side, &operand) in function.node(value).operands().iter().enumerate() {
                events.push(Event {
                    word: self.read_word(value, side),
                    cycle: u64::from(self.slot(value).cycle),
                    is_read: true,
                    operand,
                    reader: value.0,
                });
            }
        }
        for (index, assignment) in function.assignments.iter().enumerate() {
            if let Some(word) = self.placement.homes[index] {
                events.push(Event {
                    word,
                    cycle: u64::MAX,
                    is_read: true,
                    operand: assignment.operand,
                    reader: nodes + index as u32,
                });
            }
        }
        events
    }

    fn wrong(&self, collector: &mut Collector<'_>, event: &Event, content: Option<Operand>) {
        let nodes = self.view.function.nodes().len() as u32;
        let view = self.view;
        let word = self.name(event.word);
        let held = || match content.map(Operand::kind) {
            None | Some(OperandKind::None) => "holds nothing yet".to_owned(),
            Some(_) => {
                let operand = content.unwrap_or(Operand::NONE);
                format!("holds {}", describe_operand(view, operand))
            }
        };
        if event.reader < nodes {
            let cycle = event.cycle;
            collector.value(Value(event.reader), || {
                let operand = describe_operand(view, event.operand);
                format!(
                    "reads {operand} at cycle {cycle} from {word}, which then {}",
                    held()
                )
            });
        } else {
            let index = (event.reader - nodes) as usize;
            collector.assignment(index, || {
                let operand = describe_operand(view, event.operand);
                format!(
                    "({operand}) should stay in {word}, which at the end {}",
                    held()
                )
            });
        }
    }

    fn write_ports(&self, collector: &mut Collector<'_>) {
        let mut writes: Vec<(u32, Bank, u32, u32, Value)> = Vec::new();
        for value in self.placed_values() {
            writes.extend(self.placement.writes_of(value).iter().map(|write| {
                let word = write.word;
                (word.element, word.bank, write.cycle, word.address, value)
            }));
        }
        writes.sort_unstable();
        let limit = self
            .machine
            .memory
            .writes
            .map_or(usize::MAX, |limit| limit as usize);
        for group in writes.chunk_by(|a, b| (a.0, a.1, a.2) == (b.0, b.1, b.2)) {
            let (element, bank, cycle, address, value) = group[0];
            if group.len() > limit {
                let word = Word {
                    element,
                    bank,
                    address,
                };
                let name = self.name(word);
                let memory = name.split('[').next().unwrap_or_default();
                let count = group.len();
                collector.value(value, || {
                    format!("is one of {count} results written to {memory} at cycle {cycle}; it takes {limit}")
                });
            }
            for pair in group.windows(2).filter(|pair| pair[0].3 == pair[1].3) {
                let address = pair[0].3;
                let name = self.name(Word {
                    element,
                    bank,
                    address,
                });
                let other = describe(self.view, pair[0].4);
                collector.value(pair[1].4, || {
                    format!("is written to {name} at cycle {cycle}, and so is {other}")
                });
            }
        }
    }

    fn buffers(&self, collector: &mut Collector<'_>) {
        let mut stays: Vec<Stay> = Vec::new();
        // Buffer reads: element, cycle, word.
        let mut reads: Vec<(u32, u32, u32)> = Vec::new();
        for value in self.placed_values() {
            let word = self.placement.buffers[value.index()];
            if word == Placement::NONE {
                continue;
            }
            let element = self.slot(value).element;
            let from = self.write_back(value);
            let later = self.placement.writes_of(value).iter();
            let later = later
                .map(|write| write.cycle)
                .filter(|&cycle| u64::from(cycle) > from);
            let to = later.clone().max().map_or(from, u64::from);
            reads.extend(later.map(|cycle| (element, cycle, word)));
            stays.push(Stay {
                element,
                word,
                from,
                to,
                value,
            });
        }
        stays.sort_unstable();
        self.stays(collector, &stays);
        reads.sort_unstable();
        reads.dedup();
        self.buffer_reads(collector, &reads);
    }

    fn stays(&self, collector: &mut Collector<'_>, stays: &[Stay]) {
        let words = match self.machine.buffer {
            None => Some(0),
            Some(buffer) => buffer.words,
        };
        for stay in stays {
            if words.is_some_and(|words| stay.word >= words) {
                collector.value(stay.value, || {
                    let word = stay.word;
                    format!(
                        "is in buffer word {word}, but the buffers have {} words",
                        words.unwrap_or(0)
                    )
                });
            }
        }
        for pair in stays.windows(2) {
            let [first, second] = [pair[0], pair[1]];
            let same = (first.element, first.word) == (second.element, second.word);
            if same && second.from <= first.to {
                let other = describe(self.view, first.value);
                collector.value(second.value, || {
                    let (word, from, to) = (second.word, second.from, first.to);
                    format!("takes buffer word {word} at cycle {from}, but {other} stays there until {to}")
                });
            }
        }
    }

    fn buffer_reads(&self, collector: &mut Collector<'_>, reads: &[(u32, u32, u32)]) {
        let Some(limit) = self.machine.buffer.and_then(|buffer| buffer.reads) else {
            return;
        };
        for group in reads.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (element, cycle, _) = group[0];
            if group.len() > limit as usize {
                let (kind, number) = self.schedule.element_name(element);
                let count = group.len();
                collector.add(Subject::Schedule, || {
                    format!("{count} words of the buffer of {kind}{number} are read at cycle {cycle}; it hands out {limit}")
                });
            }
        }
    }
}
