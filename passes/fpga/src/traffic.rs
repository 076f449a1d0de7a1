//! The traffic of a placed function, sorted by element.
//!
//! The images are written element by element and cycle by cycle, the
//! placement is stored value by value. This module checks that the placement
//! can be indexed safely, and sorts issues, arriving writes and buffer reads
//! by element, in arrays of 32-bit numbers: memory stays a few words per
//! operation.

use super::ImageError;
use super::shape::{check_shape, element_kinds, malformed, value_name};
use robovec_ir::machine::Interconnect;
use robovec_ir::placement::{Bank, BufferWord, Element, Placement, Schedule, Word, Write};
use robovec_ir::{Machine, Value, View};

/// The parts of the machine that the program uses.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct Usage {
    /// Elements of all kinds.
    pub(super) elements: u32,
    /// Words of the fullest memory, counted by the highest address.
    pub(super) words: u32,
    /// Most writes into one memory in one cycle.
    pub(super) write_ports: u32,
    /// Words of the fullest buffer.
    pub(super) buffer_words: u32,
    /// Most distinct words read from one buffer in one cycle.
    pub(super) buffer_reads: u32,
}

/// Numbers grouped by element.
pub(super) struct ElementGroups {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl ElementGroups {
    /// Sorts the pairs (element, item) by element, keeping their order.
    fn new(elements: u32, pairs: impl Iterator<Item = (Element, u32)> + Clone) -> ElementGroups {
        let mut starts = vec![0u32; elements as usize + 1];
        for (element, _) in pairs.clone() {
            starts[element.index() + 1] += 1;
        }
        for index in 1..starts.len() {
            starts[index] += starts[index - 1];
        }
        let mut next = starts.clone();
        let mut items = vec![0; starts[elements as usize] as usize];
        for (element, item) in pairs {
            let place = &mut next[element.index()];
            items[*place as usize] = item;
            *place += 1;
        }
        ElementGroups { starts, items }
    }

    /// The items of one element.
    pub(super) fn of(&self, element: Element) -> &[u32] {
        let element = element.index();
        &self.items[self.starts[element] as usize..self.starts[element + 1] as usize]
    }

    fn of_mut(&mut self, element: Element) -> &mut [u32] {
        let element = element.index();
        &mut self.items[self.starts[element] as usize..self.starts[element + 1] as usize]
    }
}

/// One buffer word read in one cycle: element, cycle, word.
pub(super) type BufferRead = (Element, u32, BufferWord);

/// A placed function with its traffic sorted by element.
pub(super) struct Traffic<'a> {
    pub(super) view: View<'a>,
    pub(super) machine: &'a Machine,
    pub(super) schedule: &'a Schedule,
    pub(super) placement: &'a Placement,
    /// For each element its kind's place in the machine file.
    pub(super) kinds: Vec<usize>,
    /// For each write the value written.
    pub(super) owners: Vec<u32>,
    /// The values each element issues, in order of cycle.
    pub(super) issues: ElementGroups,
    /// The writes into each element's memories, in order of cycle and word.
    pub(super) arrivals: ElementGroups,
    /// The buffer words read, each once per cycle, sorted.
    pub(super) buffer_reads: Vec<BufferRead>,
    pub(super) usage: Usage,
}

impl<'a> Traffic<'a> {
    /// Checks and sorts.
    pub(super) fn new(view: View<'a>, machine: &'a Machine) -> Result<Traffic<'a>, ImageError> {
        let function = view.function;
        let (Some(schedule), Some(placement)) = (&function.schedule, &function.placement) else {
            return Err(ImageError::NotPlaced {
                function: function.name.clone(),
                level: function.level.name(),
            });
        };
        schedule.check_machine(machine)?;
        if machine.interconnect != Interconnect::Crossbar {
            return Err(ImageError::Interconnect {
                machine: machine.name.clone(),
                interconnect: machine.interconnect.name(),
            });
        }
        let kinds = element_kinds(schedule, machine)?;
        check_shape(view, machine, schedule, placement, &kinds)?;
        let elements = kinds.len() as u32;
        let slots = &schedule.slots;
        let mut issues = ElementGroups::new(
            elements,
            (0u32..)
                .zip(slots)
                .filter_map(|(value, slot)| Some(((*slot)?.element, value))),
        );
        let mut arrivals = ElementGroups::new(
            elements,
            (0u32..)
                .zip(&placement.writes)
                .map(|(index, write)| (write.word.element, index)),
        );
        for element in (0..elements).map(Element::new) {
            let issued = issues.of_mut(element);
            issued.sort_by_key(|&value| schedule.slot(Value(value)).cycle);
            let arriving = arrivals.of_mut(element);
            arriving.sort_by_key(|&index| {
                let write = placement.writes[index as usize];
                (write.cycle, write.word)
            });
        }
        assert_eq!(
            placement.write_starts.len(),
            view.function.nodes().len() + 1,
            "every node has a range of writes"
        );
        let mut owners = Vec::with_capacity(placement.writes.len());
        for (value, range) in (0u32..).zip(placement.write_starts.windows(2)) {
            owners.extend((range[0]..range[1]).map(|_| value));
        }
        assert_eq!(
            owners.len(),
            placement.writes.len(),
            "every write is that of a value"
        );
        let mut traffic = Traffic {
            view,
            machine,
            schedule,
            placement,
            kinds,
            owners,
            issues,
            arrivals,
            buffer_reads: Vec::new(),
            usage: Usage::default(),
        };
        traffic.collect_buffer_reads()?;
        traffic.usage = traffic.measure();
        traffic.check_addresses()?;
        traffic.check_issues()?;
        traffic.check_ports()?;
        Ok(traffic)
    }

    /// All elements, in order.
    pub(super) fn elements(&self) -> impl Iterator<Item = Element> + use<> {
        (0..self.kinds.len() as u32).map(Element::new)
    }

    /// The operations that an element performs, in order of their codes.
    pub(super) fn operations(&self, element: Element) -> &[String] {
        &self.machine.elements[self.kinds[element.index()]].operations
    }

    /// The cycle in which a value's result is on the crossbar.
    pub(super) fn ready(&self, value: u32) -> u64 {
        let slot = self.schedule.slot(Value(value));
        let kind = self.kinds[slot.element.index()];
        u64::from(slot.cycle) + u64::from(self.machine.elements[kind].stages) + 1
    }

    /// The crossbar's code for a value in a cycle: its producer's result, or the
    /// read port of the producer's buffer that shows it.
    pub(super) fn select(&self, value: u32, cycle: u32) -> u32 {
        let element = self.schedule.slot(Value(value)).element;
        if u64::from(cycle) == self.ready(value) {
            return element.number();
        }
        let reads = &self.buffer_reads;
        let word = self.placement.buffers[value as usize];
        let word = word.expect("traffic has checked that late writes have a buffer word");
        let first = reads.partition_point(|&(e, c, _)| (e, c) < (element, cycle));
        let port = reads.partition_point(|&read| read < (element, cycle, word)) - first;
        self.usage.elements * (1 + port as u32) + element.number()
    }

    /// Kind and number of an element, as in the placed text.
    pub(super) fn element_name(&self, element: Element) -> String {
        let (kind, number) = self.schedule.element_name(element);
        format!("{kind}{number}")
    }

    pub(super) fn memory_name(&self, element: Element, bank: Bank) -> String {
        let side = match bank {
            Bank::Unified => "",
            Bank::Left => ".left",
            Bank::Right => ".right",
        };
        self.element_name(element) + side
    }

    /// A value's name, without the percent sign.
    pub(super) fn value_name(&self, value: u32) -> String {
        value_name(self.view, Value(value))
    }

    /// Every write must be direct or come from a buffer; the latter are
    /// collected.
    fn collect_buffer_reads(&mut self) -> Result<(), ImageError> {
        for (write, &value) in self.placement.writes.iter().zip(&self.owners) {
            let Some(slot) = self.schedule.slots[value as usize] else {
                return Err(self.malformed(format!(
                    "'%{}' is computed by the host and written in cycle {}",
                    self.value_name(value),
                    write.cycle
                )));
            };
            let ready = self.ready(value);
            if u64::from(write.cycle) < ready {
                return Err(ImageError::WriteTooEarly {
                    value: self.value_name(value),
                    cycle: write.cycle,
                    ready,
                });
            }
            if write.cycle >= self.schedule.cycles {
                return Err(ImageError::AfterEnd {
                    value: self.value_name(value),
                    cycle: u64::from(write.cycle),
                    cycles: self.schedule.cycles,
                });
            }
            if u64::from(write.cycle) > ready {
                let word = self.placement.buffers[value as usize];
                let Some(word) = word.filter(|_| self.machine.buffer.is_some()) else {
                    return Err(ImageError::NotBuffered {
                        value: self.value_name(value),
                        element: self.element_name(slot.element),
                        cycle: write.cycle,
                    });
                };
                self.buffer_reads.push((slot.element, write.cycle, word));
            }
        }
        self.buffer_reads.sort_unstable();
        self.buffer_reads.dedup();
        Ok(())
    }

    fn measure(&self) -> Usage {
        let placement = self.placement;
        let addresses = placement
            .reads
            .iter()
            .flatten()
            .flatten()
            .copied()
            .chain(placement.writes.iter().map(|write| write.word.address))
            .chain(placement.preloads.iter().map(|load| load.word.address))
            .chain(placement.homes.iter().flatten().map(|word| word.address));
        let buffer_words = placement.buffers.iter().flatten();
        let write_ports = self
            .elements()
            .flat_map(|element| self.write_groups(element))
            .map(<[u32]>::len);
        let buffer_reads = self
            .buffer_reads
            .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
            .map(<[BufferRead]>::len);
        Usage {
            elements: self.kinds.len() as u32,
            words: addresses.map(|word| word.number() + 1).fold(0, u32::max),
            write_ports: write_ports.fold(0, usize::max) as u32,
            buffer_words: buffer_words.map(|word| word.number() + 1).fold(0, u32::max),
            buffer_reads: buffer_reads.fold(0, usize::max) as u32,
        }
    }

    /// The writes into an element's memories, those of one memory and cycle
    /// together, in order of cycle.
    pub(super) fn write_groups(&self, element: Element) -> impl Iterator<Item = &[u32]> {
        let writes = &self.placement.writes;
        self.arrivals.of(element).chunk_by(|&a, &b| {
            let [a, b] = [a, b].map(|index| writes[index as usize]);
            a.cycle == b.cycle && a.word.bank == b.word.bank
        })
    }

    /// The words an element's buffer shows, those of one cycle together, in
    /// order of cycle.
    pub(super) fn buffer_groups(&self, element: Element) -> impl Iterator<Item = &[BufferRead]> {
        let start = self.buffer_reads.partition_point(|read| read.0 < element);
        let end = self.buffer_reads.partition_point(|read| read.0 <= element);
        self.buffer_reads[start..end].chunk_by(|a, b| a.1 == b.1)
    }

    /// The error of a placement that does not fit its function.
    pub(super) fn malformed(&self, what: String) -> ImageError {
        malformed(self.view, what)
    }

    /// The writes that put a value into a word, the last first.
    pub(super) fn last_write(&self, value: Value, word: Word) -> Option<Write> {
        let writes = self.placement.writes_of(value);
        writes
            .iter()
            .rev()
            .find(|write| write.word == word)
            .copied()
    }
}
