//! A placement, replayed cycle by cycle.
//!
//! In every cycle first the operations that start read their operands, then the
//! writes of the cycle happen. Each word has its content and the cycle of its
//! write, each port its number of uses in the cycle, so all rules about
//! contents and ports are checked in one pass over the events in order of time.

use super::placement::PlacementCheck;
use super::{ViolationCollector, ViolationSubject, describe, describe_operand};
use crate::entity::{Operand, OperandKind, Value};
use crate::placement::{Bank, Word};
use hashbrown::HashMap;
use robovec_num::radix;
use rustc_hash::FxBuildHasher;

/// Replays the run and reports every read of a wrong word, and every port or
/// buffer word used more than it can be.
pub(super) fn check(check: &PlacementCheck<'_>, collector: &mut ViolationCollector<'_>) {
    let elements = check.schedule.element_count() as usize;
    let mut replay = PlacementReplay {
        check,
        collector,
        banks: std::array::from_fn(|side| check.bank(side)),
        memories: memories(check, elements),
        memory_ports: vec![Port::default(); 3 * elements],
        buffers: buffers(check, elements),
        buffer_ports: vec![Port::default(); elements],
    };
    replay.preload();
    replay.run();
    replay.homes();
}

/// Words by address; far addresses go through a map, so that a few of them
/// cost no memory.
struct WordStore<Content> {
    dense: Vec<Content>,
    sparse: HashMap<u32, Content, FxBuildHasher>,
}

impl<Content: Copy + Default> WordStore<Content> {
    /// Storage for the words used, dense unless they are far apart.
    fn with(extent: MemoryExtent) -> WordStore<Content> {
        let dense = if extent.words <= 8 * extent.uses + 64 {
            extent.words as usize
        } else {
            0
        };
        WordStore {
            dense: vec![Content::default(); dense],
            sparse: HashMap::default(),
        }
    }

    fn get(&self, address: u32) -> Content {
        match self.dense.get(address as usize) {
            Some(content) => *content,
            None => self.sparse.get(&address).copied().unwrap_or_default(),
        }
    }

    fn at(&mut self, address: u32) -> &mut Content {
        match self.dense.get_mut(address as usize) {
            Some(content) => content,
            None => self.sparse.entry(address).or_default(),
        }
    }
}

/// The used extent of a memory.
#[derive(Clone, Copy, Default)]
struct MemoryExtent {
    /// The largest address and one.
    words: u64,
    uses: u64,
}

impl MemoryExtent {
    fn add(&mut self, address: u32) {
        self.words = self.words.max(u64::from(address) + 1);
        self.uses += 1;
    }
}

/// A word of a memory.
#[derive(Clone, Copy)]
struct Cell {
    operand: Operand,
    /// The cycle after the last write, 0 before the first.
    readable: u64,
}

impl Default for Cell {
    fn default() -> Cell {
        Cell {
            operand: Operand::NONE,
            readable: 0,
        }
    }
}

/// A word of a buffer.
#[derive(Clone, Copy, Default)]
struct Stay {
    /// The value it was last taken for, if `to` is not 0.
    value: u32,
    /// The last cycle in which the value is read from here.
    to: u64,
    /// The cycle after the last read.
    read: u64,
}

/// Uses of a port in one cycle.
#[derive(Clone, Copy, Default)]
struct Port {
    cycle: u64,
    uses: u32,
}

impl Port {
    /// Counts a use and returns the number in the cycle.
    fn take(&mut self, cycle: u64) -> u32 {
        if self.cycle != cycle {
            *self = Port { cycle, uses: 0 };
        }
        self.uses = self.uses.saturating_add(1);
        self.uses
    }
}

struct PlacementReplay<'c, 'a, 'v> {
    check: &'c PlacementCheck<'a>,
    collector: &'c mut ViolationCollector<'v>,
    /// The bank that operands of each side are read from.
    banks: [Bank; Operand::MAX_COUNT],
    /// Three banks for every processing element.
    memories: Vec<WordStore<Cell>>,
    memory_ports: Vec<Port>,
    buffers: Vec<WordStore<Stay>>,
    buffer_ports: Vec<Port>,
}

fn memory(word: Word) -> usize {
    let bank = match word.bank {
        Bank::Unified => 0,
        Bank::Left => 1,
        Bank::Right => 2,
    };
    3 * word.element.index() + bank
}

fn memories(check: &PlacementCheck<'_>, elements: usize) -> Vec<WordStore<Cell>> {
    let mut extents = vec![MemoryExtent::default(); 3 * elements];
    let preloads = check.placement.preloads.iter().map(|preload| preload.word);
    let writes = check.placement.writes.iter().map(|write| write.word);
    for word in preloads.chain(writes) {
        extents[memory(word)].add(word.address.number());
    }
    extents.into_iter().map(WordStore::with).collect()
}

fn buffers(check: &PlacementCheck<'_>, elements: usize) -> Vec<WordStore<Stay>> {
    let mut extents = vec![MemoryExtent::default(); elements];
    for value in check.placed_values() {
        if let Some(word) = check.placement.buffers[value.index()] {
            extents[check.slot(value).element.index()].add(word.number());
        }
    }
    extents.into_iter().map(WordStore::with).collect()
}

impl PlacementReplay<'_, '_, '_> {
    fn preload(&mut self) {
        for preload in &self.check.placement.preloads {
            let word = preload.word;
            self.memories[memory(word)]
                .at(word.address.number())
                .operand = preload.operand;
        }
    }

    fn run(&mut self) {
        let check = self.check;
        let mut starts: Vec<u32> = check.placed_values().map(|value| value.0).collect();
        radix::sort_by_key(&mut starts, |value| check.slot(Value(value)).cycle);
        let all_writes = &check.placement.writes;
        let writes =
            radix::sorted_by_key(all_writes.len(), |write| all_writes[write as usize].cycle);
        let owners = self.owners();
        let mut starts = starts.into_iter().map(Value).peekable();
        for index in writes.into_iter().map(|write| write as usize) {
            let cycle = all_writes[index].cycle;
            // What starts in the cycle of a write does not see it.
            while let Some(start) = starts.next_if(|&start| check.slot(start).cycle <= cycle) {
                self.start(start);
            }
            self.write(u64::from(cycle), index, Value(owners[index]));
        }
        for start in starts {
            self.start(start);
        }
    }

    /// The value of every write.
    fn owners(&self) -> Vec<u32> {
        let placement = self.check.placement;
        let mut owners = Vec::with_capacity(placement.writes.len());
        for (value, range) in (0..).zip(placement.write_starts.windows(2)) {
            owners.resize(range[1] as usize, value);
        }
        owners
    }

    fn start(&mut self, value: Value) {
        let check = self.check;
        let operands = check.view.function.node(value).operands();
        let addresses = &check.placement.reads[value.index()];
        let element = check.slot(value).element;
        for (side, &operand) in operands.iter().enumerate() {
            let word = Word {
                element,
                bank: self.banks[side],
                address: addresses[side].expect("every operand has an address"),
            };
            let held = self.memories[memory(word)]
                .get(word.address.number())
                .operand;
            if held != operand {
                let cycle = check.slot(value).cycle;
                self.collector.value(value, || {
                    let operand = describe_operand(check.view, operand);
                    let (word, held) = (check.name(word), holds(check, held));
                    format!("reads {operand} at cycle {cycle} from {word}, which then {held}")
                });
            }
        }
        self.enter_buffer(value);
    }

    /// The values of an element enter a buffer in the order of their start,
    /// since all take the same number of stages.
    fn enter_buffer(&mut self, value: Value) {
        let check = self.check;
        let Some(word) = check.placement.buffers[value.index()] else {
            return;
        };
        let from = check.write_back(value);
        let writes = check.placement.writes_of(value).iter();
        let last = writes.map(|write| check.departs(value, write)).max();
        let element = check.slot(value).element;
        let stay = self.buffers[element.index()].at(word.number());
        if stay.to >= from {
            let (other, to) = (Value(stay.value), stay.to);
            self.collector.value(value, || {
                let other = describe(check.view, other);
                format!(
                    "takes buffer word {word} at cycle {from}, but {other} stays there until {to}"
                )
            });
        }
        stay.value = value.0;
        stay.to = last.unwrap_or(from).max(from);
    }

    fn write(&mut self, cycle: u64, index: usize, value: Value) {
        let check = self.check;
        let word = check.placement.writes[index].word;
        let limit = check.machine.memory.write_limit();
        if self.memory_ports[memory(word)].take(cycle) == limit.saturating_add(1) {
            let name = check.name(word);
            let name = name.split('[').next().expect("a text has a first part");
            self.collector.value(value, || {
                format!("is one word too many for {name} at cycle {cycle}, which takes {limit}")
            });
        }
        let cell = self.memories[memory(word)].at(word.address.number());
        if cell.readable == cycle + 1 {
            let other = cell.operand;
            self.collector.value(value, || {
                let (name, other) = (check.name(word), describe_operand(check.view, other));
                format!("is written to {name} at cycle {cycle}, and so is {other}")
            });
        }
        *cell = Cell {
            operand: value.into(),
            readable: cycle + 1,
        };
        // Words of a network leave buffers in another order than they arrive.
        if check.routes.is_none() && cycle > check.write_back(value) {
            self.read_buffer(cycle, value);
        }
    }

    /// One word of a buffer reaches any number of memories in a cycle.
    fn read_buffer(&mut self, cycle: u64, value: Value) {
        let element = self.check.slot(value).element;
        let limit = self.check.machine.buffer.and_then(|buffer| buffer.reads);
        let word = self.check.placement.buffers[value.index()];
        let (Some(limit), Some(word)) = (limit, word) else {
            return;
        };
        let stay = self.buffers[element.index()].at(word.number());
        if stay.read == cycle + 1 {
            return;
        }
        stay.read = cycle + 1;
        if self.buffer_ports[element.index()].take(cycle) == limit.saturating_add(1) {
            let (kind, number) = self.check.schedule.element_name(element);
            self.collector.add(ViolationSubject::Schedule, || {
                format!(
                    "more words of the buffer of {kind}{number} are read at cycle {cycle} than the {limit} it hands out"
                )
            });
        }
    }

    fn homes(&mut self) {
        let check = self.check;
        for (index, assignment) in check.view.function.assignments.iter().enumerate() {
            let Some(word) = check.placement.homes[index] else {
                continue;
            };
            let held = self.memories[memory(word)]
                .get(word.address.number())
                .operand;
            if held != assignment.operand {
                self.collector.assignment(index, || {
                    let operand = describe_operand(check.view, assignment.operand);
                    let (word, held) = (check.name(word), holds(check, held));
                    format!("({operand}) should stay in {word}, which at the end {held}")
                });
            }
        }
    }
}

fn holds(check: &PlacementCheck<'_>, held: Operand) -> String {
    match held.kind() {
        OperandKind::None => "holds nothing yet".to_owned(),
        _ => format!("holds {}", describe_operand(check.view, held)),
    }
}
