//! The schedule on a page: starts, reasons of delays, memories over time.

use super::data::ScheduleData;
use robovec_analysis::critical_path::Weights;
use robovec_ir::placement::{Bank, Element, Placement, Schedule, Word};
use robovec_ir::{Function, Machine, Operand, Value};
use std::collections::BTreeMap;

/// Into this number of slices the use of memory is cut at most.
const SLICES: u32 = 240;

pub(super) fn collect(function: &Function, machine: &Machine) -> Option<ScheduleData> {
    let schedule = function.schedule.as_ref()?;
    let weights = Weights::cycles(machine);
    let busy = BusyKinds::new(schedule);
    let elements = (0..schedule.element_count()).map(|number| {
        let (kind, number) = schedule.element_name(Element::new(number));
        format!("{kind}{number}")
    });
    let mut data = ScheduleData {
        cycles: schedule.cycles,
        bound: schedule.lower_bound,
        elements: elements.collect(),
        element: Vec::new(),
        cycle: Vec::new(),
        delay: Vec::new(),
        ready: Vec::new(),
        last: Vec::new(),
        free: Vec::new(),
        writes: Vec::new(),
        slice: schedule.cycles.div_ceil(SLICES).max(1),
        memory: Vec::new(),
    };
    for (value, node) in function.values() {
        let Some(slot) = schedule.slots[value.index()] else {
            data.element.push(-1);
            for column in [
                &mut data.cycle,
                &mut data.delay,
                &mut data.ready,
                &mut data.free,
            ] {
                column.push(0);
            }
            data.last.push(-1);
            continue;
        };
        let (ready, last) = ready(function, schedule, &weights, value);
        data.element.push(i64::from(slot.element.number()));
        data.cycle.push(slot.cycle);
        data.delay.push(weights.of(node.operation));
        data.ready.push(ready);
        data.last
            .push(last.map_or(-1, |value| value.index() as i64));
        data.free
            .push(busy.first_free(slot.element, ready, slot.cycle));
    }
    let columns = [
        data.element.len(),
        data.cycle.len(),
        data.delay.len(),
        data.ready.len(),
        data.last.len(),
        data.free.len(),
    ];
    assert_eq!(
        columns,
        [function.nodes().len(); 6],
        "every value is in every column"
    );
    if let Some(placement) = &function.placement {
        for (value, _) in function.values() {
            let writes = placement.writes_of(value).iter();
            data.writes.extend(writes.map(|write| {
                let element = write.word.element.number();
                [value.index() as u32, write.cycle, element]
            }));
        }
        data.memory = memory(function, schedule, placement, data.slice);
    }
    Some(data)
}

/// First cycle in which a value can read its operands, and the latest one.
fn ready(
    function: &Function,
    schedule: &Schedule,
    weights: &Weights,
    value: Value,
) -> (u32, Option<Value>) {
    let slot = schedule.slot(value);
    let mut found = (0, None);
    let operands = function.node(value).operands();
    for (side, operand) in operands.iter().enumerate() {
        let Some(operand) = operand.value() else {
            continue;
        };
        let Some(made) = schedule.slots[operand.index()] else {
            continue;
        };
        let result = made.cycle + weights.of(function.node(operand).operation);
        debug_assert!(result <= slot.cycle, "an operand is there when it is read");
        let readable = function.placement.as_ref().and_then(|placement| {
            let address = placement.reads[value.index()][side]?;
            let writes = placement.writes_of(operand).iter();
            let here = writes.filter(|write| {
                write.word.element == slot.element
                    && write.word.address == address
                    && write.cycle < slot.cycle
            });
            here.map(|write| write.cycle + 1).max()
        });
        let readable = readable.unwrap_or(result);
        if readable > found.0 {
            found = (readable, Some(operand));
        }
    }
    found
}

/// Number of elements of each kind that start an operation in each cycle.
struct BusyKinds {
    /// The kind of every element.
    kinds: Vec<usize>,
    /// The elements of every kind.
    counts: Vec<u32>,
    issues: BTreeMap<(usize, u32), u32>,
}

impl BusyKinds {
    fn new(schedule: &Schedule) -> BusyKinds {
        let mut kinds = Vec::new();
        for (index, kind) in schedule.kinds.iter().enumerate() {
            kinds.extend((0..kind.count).map(|_| index));
        }
        let mut issues = BTreeMap::new();
        for slot in schedule.slots.iter().flatten() {
            *issues
                .entry((kinds[slot.element.index()], slot.cycle))
                .or_insert(0) += 1;
        }
        BusyKinds {
            kinds,
            counts: schedule.kinds.iter().map(|kind| kind.count).collect(),
            issues,
        }
    }

    /// The first cycle in a range in which an element of the same kind starts
    /// no operation; the end of the range when there is none.
    fn first_free(&self, element: Element, from: u32, until: u32) -> u32 {
        let kind = self.kinds[element.index()];
        let busy = |cycle: &u32| self.issues.get(&(kind, *cycle)) == Some(&self.counts[kind]);
        (from..until).find(|cycle| !busy(cycle)).unwrap_or(until)
    }
}

/// For every element the words in use, the most of each slice: a word is in use
/// from its write to its last reader, those of outputs to the end.
fn memory(
    function: &Function,
    schedule: &Schedule,
    placement: &Placement,
    slice: u32,
) -> Vec<Vec<u32>> {
    // What a word is written with, cycle by cycle, and when it is read last.
    let mut writes: BTreeMap<Word, Vec<(u32, u32)>> = BTreeMap::new();
    for preload in &placement.preloads {
        writes.entry(preload.word).or_default().push((0, 0));
    }
    for write in &placement.writes {
        let lives = writes.entry(write.word).or_default();
        lives.push((write.cycle + 1, write.cycle + 1));
    }
    for lives in writes.values_mut() {
        lives.sort_unstable();
    }
    let mut read = |word: Word, cycle: u32| {
        let lives = writes.get_mut(&word);
        let life = lives.and_then(|lives| lives.iter_mut().rev().find(|life| life.0 <= cycle));
        if let Some(life) = life {
            life.1 = life.1.max(cycle + 1);
        }
    };
    let split = placement
        .writes
        .iter()
        .any(|write| write.word.bank != Bank::Unified)
        || placement
            .preloads
            .iter()
            .any(|preload| preload.word.bank != Bank::Unified);
    for (value, node) in function.values() {
        let Some(slot) = schedule.slots[value.index()] else {
            continue;
        };
        for side in 0..node.operands().len().min(Operand::MAX_COUNT) {
            let Some(address) = placement.reads[value.index()][side] else {
                continue;
            };
            let bank = match (split, side) {
                (false, _) => Bank::Unified,
                (true, 0) => Bank::Left,
                (true, _) => Bank::Right,
            };
            let element = slot.element;
            read(
                Word {
                    element,
                    bank,
                    address,
                },
                slot.cycle,
            );
        }
    }
    for home in placement.homes.iter().flatten() {
        read(*home, schedule.cycles);
    }
    let mut changes = vec![BTreeMap::new(); schedule.element_count() as usize];
    for (word, lives) in &writes {
        for &(from, to) in lives {
            let changes: &mut BTreeMap<u32, i64> = &mut changes[word.element.index()];
            *changes.entry(from).or_insert(0) += 1;
            *changes.entry(to).or_insert(0) -= 1;
        }
    }
    let count = schedule.cycles / slice + 1;
    changes
        .iter()
        .map(|changes| slices(changes, slice, count))
        .collect()
}

/// The largest sum of changes within each slice.
fn slices(changes: &BTreeMap<u32, i64>, slice: u32, count: u32) -> Vec<u32> {
    let mut most = Vec::with_capacity(count as usize);
    let mut now = 0i64;
    let mut changes = changes.iter().peekable();
    for number in 0..count {
        let mut largest = now;
        while let Some((_, change)) =
            changes.next_if(|&(&cycle, _)| cycle < (number + 1).saturating_mul(slice))
        {
            now += change;
            largest = largest.max(now);
        }
        most.push(u32::try_from(largest).expect("a word is freed after it was taken"));
    }
    most
}
