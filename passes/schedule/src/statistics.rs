//! The statistics of a placement, computed from the placed function alone.

use super::choice::RANKS;
use super::network::Wires;
use robovec_ir::placement::{Bank, Placement, Schedule, Write};
use robovec_ir::{Function, Machine, Value};
use serde::Serialize;

/// The least, the mean and the most over the elements of a kind.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize)]
pub struct ElementSpread {
    /// The least.
    pub min: u32,
    /// The arithmetic mean.
    pub mean: f64,
    /// The most.
    pub max: u32,
}

/// The work of the elements of one kind.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct KindStatistics {
    /// Name of the kind.
    pub kind: String,
    /// Number of elements.
    pub count: u32,
    /// Operations they perform together.
    pub operations: u32,
    /// Operations per element and cycle: 1 is an issue in every cycle.
    pub occupancy: f64,
    /// Words of memory per element, both sides of a split one together.
    pub memory: ElementSpread,
    /// Words of buffer per element.
    pub buffer: ElementSpread,
}

/// The resources a placement uses (thesis 2.3, figures 2.4 to 2.7, and 1.2.3).
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct PlacementStatistics {
    /// The kinds, in the machine's order.
    pub kinds: Vec<KindStatistics>,
    /// Operations per processing element and cycle.
    pub parallelisation_rate: f64,
    /// The number of operations of each rank of Table 2.1, from rank 1 on. The
    /// first reader of a word accounts for its transfer; later readers find
    /// it in memory.
    pub ranks: [u32; 9],
    /// Writes in the cycle in which the result appears.
    pub direct_writes: u32,
    /// Writes through a buffer.
    pub indirect_writes: u32,
    /// Results that pass through a buffer.
    pub buffered_results: u32,
    /// Words filled before the run.
    pub preloads: u32,
}

/// The statistics of a placed function on its machine; `None` for a function
/// that is not placed.
pub fn placement_statistics(function: &Function, machine: &Machine) -> Option<PlacementStatistics> {
    let (schedule, placement) = (function.schedule.as_ref()?, function.placement.as_ref()?);
    let counts: Vec<u32> = schedule.kinds.iter().map(|kind| kind.count).collect();
    let view = PlacedView {
        function,
        machine,
        schedule,
        placement,
        wires: Wires::new(machine.interconnect, &counts),
    };
    let operations = view.operations();
    let (memory, buffer) = (memory_words(schedule, placement), view.buffer_words());
    let mut kinds = Vec::with_capacity(schedule.kinds.len());
    let mut first = 0;
    for kind in &schedule.kinds {
        let elements = first as usize..(first + kind.count) as usize;
        first += kind.count;
        let total: u32 = operations[elements.clone()].iter().sum();
        kinds.push(KindStatistics {
            kind: kind.name.clone(),
            count: kind.count,
            operations: total,
            occupancy: rate(total, kind.count, schedule.cycles),
            memory: spread(&memory[elements.clone()]),
            buffer: spread(&buffer[elements]),
        });
    }
    let direct = view.values().map(|(value, back)| {
        let writes = placement.writes_of(value).iter();
        let is_direct = |write: &&Write| view.departs(value, write) == back;
        writes.filter(is_direct).count() as u32
    });
    let direct_writes: u32 = direct.sum();
    Some(PlacementStatistics {
        parallelisation_rate: rate(operations.iter().sum(), first, schedule.cycles),
        kinds,
        ranks: view.ranks(),
        direct_writes,
        indirect_writes: placement.writes.len() as u32 - direct_writes,
        buffered_results: placement.buffers.iter().flatten().count() as u32,
        preloads: placement.preloads.len() as u32,
    })
}

/// The maximum number of words that an element of a placed function has in its
/// operand memories together; `None` for a function that is not placed.
pub fn most_memory_words(function: &Function) -> Option<u32> {
    let (schedule, placement) = (function.schedule.as_ref()?, function.placement.as_ref()?);
    let words = memory_words(schedule, placement).into_iter();
    Some(words.fold(0, u32::max))
}

/// The words of operand memory of every element, both sides of a split one
/// together.
fn memory_words(schedule: &Schedule, placement: &Placement) -> Vec<u32> {
    let mut words = vec![[0; 2]; schedule.element_count() as usize];
    let preloads = placement.preloads.iter().map(|preload| preload.word);
    let writes = placement.writes.iter().map(|write| write.word);
    for word in preloads.chain(writes) {
        let side = usize::from(word.bank == Bank::Right);
        let used = &mut words[word.element.index()][side];
        *used = (word.address.number() + 1).max(*used);
    }
    words.into_iter().map(|sides| sides.iter().sum()).collect()
}

fn rate(operations: u32, elements: u32, cycles: u32) -> f64 {
    match f64::from(elements) * f64::from(cycles) {
        0.0 => 0.0,
        issues => f64::from(operations) / issues,
    }
}

fn spread(numbers: &[u32]) -> ElementSpread {
    let total: u64 = numbers.iter().map(|&number| u64::from(number)).sum();
    ElementSpread {
        min: numbers.iter().copied().min().unwrap_or(0),
        mean: total as f64 / numbers.len().max(1) as f64,
        max: numbers.iter().copied().fold(0, u32::max),
    }
}

struct PlacedView<'a> {
    function: &'a Function,
    machine: &'a Machine,
    schedule: &'a Schedule,
    placement: &'a Placement,
    wires: Option<Wires>,
}

impl PlacedView<'_> {
    /// The values the machine computes, with their write-back cycles.
    fn values(&self) -> impl Iterator<Item = (Value, u32)> + '_ {
        self.function.values().filter_map(|(value, node)| {
            let slot = self.schedule.slots[value.index()]?;
            let weight = self.machine.weight(node.operation);
            Some((value, slot.cycle.saturating_add(weight).saturating_sub(1)))
        })
    }

    /// The cycle in which a written word left its producer.
    fn departs(&self, value: Value, write: &Write) -> u32 {
        let from = self.schedule.slot(value).element;
        let wires = self.wires.as_ref();
        let latency = wires.map_or(0, |wires| wires.latency(from, write.word.element));
        write.cycle.saturating_sub(latency)
    }

    fn operations(&self) -> Vec<u32> {
        let mut operations = vec![0; self.schedule.element_count() as usize];
        for slot in self.schedule.slots.iter().flatten() {
            operations[slot.element.index()] += 1;
        }
        operations
    }

    fn buffer_words(&self) -> Vec<u32> {
        let mut words = vec![0; self.schedule.element_count() as usize];
        for (slot, word) in self.schedule.slots.iter().zip(&self.placement.buffers) {
            if let (Some(slot), Some(word)) = (slot, word) {
                let used: &mut u32 = &mut words[slot.element.index()];
                *used = (word.number() + 1).max(*used);
            }
        }
        words
    }

    /// The write that an operand of a node is read from, as an index into
    /// [`Placement::writes`]; `None` for initial data and no operand.
    fn write_read(&self, node: Value, side: usize) -> Option<usize> {
        let operand = *self.function.node(node).operands().get(side)?;
        let value = operand.value()?;
        let element = self.schedule.slot(node).element;
        let address = self.placement.reads[node.index()][side]?;
        let wrong_side = if side == 0 { Bank::Right } else { Bank::Left };
        let feeds = |write: &Write| {
            let word = write.word;
            word.element == element && word.bank != wrong_side && word.address == address
        };
        let place = self.placement.writes_of(value).iter().position(feeds)?;
        Some(self.placement.write_starts[value.index()] as usize + place)
    }

    fn ranks(&self) -> [u32; 9] {
        let mut first_read: Vec<Option<u32>> = vec![None; self.placement.writes.len()];
        for (node, _) in self.values() {
            let cycle = self.schedule.slot(node).cycle;
            for write in (0..2).filter_map(|side| self.write_read(node, side)) {
                let first = first_read[write].get_or_insert(cycle);
                *first = cycle.min(*first);
            }
        }
        let backs: Vec<(Value, u32)> = self.values().collect();
        let back_of = |value: Value| {
            let found = backs.binary_search_by_key(&value, |&(known, _)| known);
            backs[found.expect("a value that is written was computed by an element")].1
        };
        let mut ranks = [0; 9];
        for (node, _) in self.values() {
            let cycle = self.schedule.slot(node).cycle;
            let status = |side: usize| match self.write_read(node, side) {
                Some(write) if first_read[write] == Some(cycle) => {
                    let producer = self.function.node(node).operands[side].value();
                    let producer = producer.expect("only values are written");
                    let departs = self.departs(producer, &self.placement.writes[write]);
                    if departs == back_of(producer) { 1 } else { 2 }
                }
                _ => 0,
            };
            ranks[RANKS[status(0)][status(1)] as usize - 1] += 1;
        }
        ranks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{TestFunctionBuilder, machine, random_function};
    use crate::{PlaceOptions, place};
    use robovec_ir::{Operand, Operation};

    #[test]
    fn a_small_placement_is_counted_by_hand() {
        let mut builder = TestFunctionBuilder::new(4, 1);
        let q: Vec<Operand> = (0..4).map(|number| builder.input(number)).collect();
        let a = builder.push(Operation::Mul, q[0], q[1]);
        let b = builder.push(Operation::Mul, q[2], q[3]);
        let c = builder.push(Operation::Add, a, b);
        let d = builder.push(Operation::Sub, c, a);
        builder.output(0, d);
        let mut function = builder.function;
        let mut machine = machine("thesis", 1, 2);
        machine.memory.writes = Some(1);
        assert_eq!(placement_statistics(&function, &machine), None);
        place(&mut function, &machine, PlaceOptions::default()).expect("it fits");
        let statistics = placement_statistics(&function, &machine).expect("placed");
        // The products read preloads; the sum finds one product directly and
        // one through the buffer; the difference has one product in memory.
        assert_eq!(statistics.ranks[0], 2);
        assert_eq!(statistics.ranks[6] + statistics.ranks[7], 1);
        assert_eq!(statistics.ranks[1] + statistics.ranks[2], 1);
        assert_eq!(statistics.direct_writes, 3);
        assert_eq!(statistics.indirect_writes, 1);
        assert_eq!(statistics.buffered_results, 1);
        assert_eq!(statistics.preloads, 4);
        assert_eq!(statistics.kinds[0].operations, 2);
        assert_eq!(statistics.kinds[1].memory.mean, 2.0);
        assert_eq!(statistics.kinds[1].buffer.max, 1);
        // 4 operations on 3 elements in 32 cycles.
        assert_eq!(statistics.parallelisation_rate, 4.0 / (3.0 * 32.0));
    }

    #[test]
    fn every_operation_has_a_rank_and_every_write_a_kind() {
        for name in ["thesis", "side-split"] {
            let mut function = random_function(500, 60, 7);
            let machine = machine(name, 3, 4);
            place(&mut function, &machine, PlaceOptions::default()).expect("it fits");
            let statistics = placement_statistics(&function, &machine).expect("placed");
            assert_eq!(statistics.ranks.iter().sum::<u32>(), 500);
            let placement = function.placement.as_ref().expect("placed");
            let writes = statistics.direct_writes + statistics.indirect_writes;
            assert_eq!(writes as usize, placement.writes.len());
            let buffers = statistics.kinds.iter().map(|kind| kind.buffer.max);
            assert_eq!(buffers.max() == Some(0), statistics.indirect_writes == 0);
        }
    }
}
