//! The reservations of each cycle: write ports, buffer outputs, buffer words.
//!
//! A transfer is reserved when the operation that needs it is issued, and it
//! may lie in the past: the crossbar could have written the word along with an
//! earlier one. So the tables keep every cycle. They are dense, one byte per
//! memory and cycle, because the requested cycles are close together and a row
//! then is a single cache line.

use super::graph::Datum;
use super::locations::{Locations, Memory};
use super::network::Wires;
use robovec_ir::placement::Element;
use robovec_ir::{Machine, Operand};

/// The maximum number of words planned at once, besides the requested one.
pub(super) const PLANNED: usize = Operand::MAX_COUNT - 1;

/// Reservations of all cycles so far.
#[derive(Clone, Default, Debug)]
pub(super) struct Ports {
    /// Memories: elements times banks.
    memories: usize,
    elements: usize,
    writes: Vec<u8>,
    write_limit: u8,
    buffer_reads: Vec<u8>,
    /// 0 when there is no buffer.
    buffer_read_limit: u8,
    /// Words in use in the buffers; kept only when they are limited.
    buffer_words: Vec<u16>,
    buffer_word_limit: Option<u16>,
    banks: usize,
    /// The network, unless it is a crossbar.
    wires: Option<Wires>,
    /// Words on each link of the network in each cycle.
    links: Vec<u8>,
}

/// A word during the run: the datum, its source and target, and its departure.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct WordTransfer {
    pub(super) datum: Datum,
    pub(super) from: Element,
    pub(super) to: Element,
    pub(super) departs: u32,
}

/// Memories per element: 1, or 2 when each operand side has its own.
pub(super) fn banks(machine: &Machine) -> usize {
    machine.memory.style.banks()
}

impl Ports {
    /// Everything free, for the elements of a machine.
    pub(super) fn new(machine: &Machine) -> Ports {
        let elements = machine
            .elements
            .iter()
            .map(|element| element.count as usize)
            .sum();
        // Limits above what a counter holds are cut to it: that many words at
        // once would take as many elements.
        let counts: Vec<u32> = machine.elements.iter().map(|kind| kind.count).collect();
        let byte = |limit: u32| limit.min(u32::from(u8::MAX)) as u8;
        let buffer = machine.buffer.filter(|buffer| buffer.words != Some(0));
        Ports {
            memories: elements * banks(machine),
            elements,
            writes: Vec::new(),
            write_limit: byte(machine.memory.write_limit()),
            buffer_reads: Vec::new(),
            buffer_read_limit: buffer.map_or(0, |buffer| byte(buffer.read_limit())),
            buffer_words: Vec::new(),
            buffer_word_limit: buffer
                .and_then(|buffer| buffer.words)
                .and_then(|words| u16::try_from(words).ok()),
            banks: banks(machine),
            wires: Wires::new(machine.interconnect, &counts),
            links: Vec::new(),
        }
    }

    /// Cells of the tables per cycle.
    pub(super) fn width(&self) -> usize {
        self.memories.max(self.links())
    }

    fn links(&self) -> usize {
        self.wires.as_ref().map_or(0, Wires::links)
    }

    /// True when words travel through a network, which takes time.
    pub(super) fn has_network(&self) -> bool {
        self.wires.is_some()
    }

    /// The longest time a word travels.
    pub(super) fn longest_travel(&self) -> u32 {
        self.wires.as_ref().map_or(0, Wires::longest)
    }

    /// Cycles from the departure of a word to its arrival in a memory.
    #[inline]
    pub(super) fn latency(&self, from: Element, memory: Memory) -> u32 {
        if self.has_network() {
            self.travel_time(from, memory)
        } else {
            0
        }
    }

    /// The latency of a network, separate from the fast path for a crossbar,
    /// which is evaluated for every operand at every place.
    #[inline(never)]
    fn travel_time(&self, from: Element, memory: Memory) -> u32 {
        let wires = self.wires.as_ref();
        wires.map_or(0, |wires| wires.latency(from, self.element_of(memory)))
    }

    /// The element that has a memory.
    pub(super) fn element_of(&self, memory: Memory) -> Element {
        Element::new((memory.index() / self.banks) as u32)
    }

    /// The transfer of a datum from its producer to a memory.
    pub(super) fn transfer(
        &self,
        datum: Datum,
        from: Element,
        memory: Memory,
        departs: u32,
    ) -> WordTransfer {
        WordTransfer {
            datum,
            from,
            to: self.element_of(memory),
            departs,
        }
    }

    /// All memories, in order.
    pub(super) fn memories(&self) -> impl Iterator<Item = Memory> + use<> {
        (0..self.memories as u32).map(Memory::new)
    }

    /// True when every link on the path of a word has capacity for it besides
    /// the planned words; its own word on other paths needs no further
    /// capacity.
    pub(super) fn can_travel(
        &self,
        locations: &Locations,
        word: WordTransfer,
        planned: impl Fn() -> [Option<WordTransfer>; PLANNED] + Clone,
    ) -> bool {
        let Some(wires) = &self.wires else {
            return true;
        };
        let width = wires.links();
        wires.way(word.from, word.to).all(|(link, delay)| {
            let cell = (word.departs + delay) as usize * width + link;
            let rivals = planned().into_iter().flatten().filter(|other| {
                (other.datum, other.departs) != (word.datum, word.departs)
                    && wires.way(other.from, other.to).any(|(other_link, after)| {
                        other_link == link && other.departs + after == word.departs + delay
                    })
            });
            let rivals = rivals.count() as u8;
            self.links[cell].saturating_add(rivals) < wires.words()
                || self.carries(locations, word, link)
        })
    }

    /// True when the word is on the link anyway, during the run elsewhere.
    fn carries(&self, locations: &Locations, word: WordTransfer, link: usize) -> bool {
        let Some(wires) = &self.wires else {
            return false;
        };
        locations.of(word.datum).any(|(_, entry)| {
            let to = self.element_of(entry.memory);
            entry.departed() == Some(word.departs)
                && wires.way(word.from, to).any(|(other, _)| other == link)
        })
    }

    /// Takes the links on the way of a word, before its entry is added.
    pub(super) fn travel(&mut self, locations: &Locations, word: WordTransfer) {
        self.change_links(locations, word, |uses| *uses += 1);
    }

    /// Gives up the links and the write port of a word, after its entry was
    /// forgotten.
    pub(super) fn retract(
        &mut self,
        locations: &Locations,
        word: WordTransfer,
        arrives: u32,
        memory: Memory,
    ) {
        self.writes[arrives as usize * self.memories + memory.index()] -= 1;
        self.change_links(locations, word, |uses| *uses -= 1);
    }

    fn change_links(
        &mut self,
        locations: &Locations,
        word: WordTransfer,
        change: impl Fn(&mut u8),
    ) {
        let Some(wires) = &self.wires else { return };
        let width = wires.links();
        let own = wires.way(word.from, word.to);
        let own: Vec<(usize, u32)> = own
            .filter(|&(link, _)| !self.carries(locations, word, link))
            .collect();
        for (link, delay) in own {
            change(&mut self.links[(word.departs + delay) as usize * width + link]);
        }
    }

    /// Makes room for reservations up to a cycle.
    pub(super) fn reach(&mut self, cycle: u32) {
        let rows = cycle as usize + self.longest_travel() as usize + 1;
        if self.writes.len() < rows * self.memories {
            self.writes.resize(rows * self.memories, 0);
            self.buffer_reads.resize(rows * self.elements, 0);
            if self.buffer_word_limit.is_some() {
                self.buffer_words.resize(rows * self.elements, 0);
            }
            let links = self.links();
            self.links.resize(rows * links, 0);
        }
    }

    /// True when results can wait in a buffer.
    pub(super) fn has_buffer(&self) -> bool {
        self.buffer_read_limit > 0
    }

    /// True when a buffer can fill up.
    pub(super) fn buffers_are_limited(&self) -> bool {
        self.buffer_word_limit.is_some()
    }

    /// True when the memory can take `words` more in the cycle.
    pub(super) fn can_write(&self, cycle: u32, memory: Memory, words: u8) -> bool {
        let taken = self.writes[cycle as usize * self.memories + memory.index()];
        taken.saturating_add(words) <= self.write_limit
    }

    /// Takes a write port.
    pub(super) fn write(&mut self, cycle: u32, memory: Memory) {
        debug_assert!(
            self.can_write(cycle, memory, 1),
            "a memory that is written has a free port"
        );
        self.writes[cycle as usize * self.memories + memory.index()] += 1;
    }

    /// True when the element's buffer can hand out `words` more in the cycle.
    pub(super) fn can_read_buffer(&self, cycle: u32, element: Element, words: u8) -> bool {
        let taken = self.buffer_reads[cycle as usize * self.elements + element.index()];
        taken.saturating_add(words) <= self.buffer_read_limit
    }

    /// Takes a buffer output.
    pub(super) fn read_buffer(&mut self, cycle: u32, element: Element) {
        debug_assert!(
            self.can_read_buffer(cycle, element, 1),
            "a buffer that is read has a free port"
        );
        self.buffer_reads[cycle as usize * self.elements + element.index()] += 1;
    }

    /// True when the element's buffer has room for `words` more in the cycle.
    pub(super) fn has_room(&self, cycle: u32, element: Element, words: u16) -> bool {
        self.buffer_word_limit.is_none_or(|limit| {
            self.buffer_words[cycle as usize * self.elements + element.index()] + words <= limit
        })
    }

    /// Keeps a word in the element's buffer during the cycles given.
    pub(super) fn occupy(&mut self, cycles: std::ops::RangeInclusive<u32>, element: Element) {
        if self.buffer_word_limit.is_some() {
            for cycle in cycles {
                self.buffer_words[cycle as usize * self.elements + element.index()] += 1;
            }
        }
    }
}
