//! What is taken in which cycle: write ports, buffer outputs, buffer words.
//!
//! A transfer is reserved when the operation that needs it is issued, and it
//! may lie in the past: the crossbar could have written the word along with
//! an earlier one. So the tables keep every cycle. They are dense, one byte
//! per memory and cycle, because the cycles asked about lie close together
//! and a row then is a single cache line.

use robovec_ir::Machine;
use robovec_ir::machine::MemoryStyle;

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
}

/// Memories per element: 1, or 2 when each operand side has its own.
pub(super) fn banks(machine: &Machine) -> usize {
    match machine.memory.style {
        MemoryStyle::Unified => 1,
        MemoryStyle::SideSplit => 2,
    }
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
        let byte = |limit: Option<u32>| limit.map_or(u8::MAX, |limit| limit.min(255) as u8);
        let buffer = machine.buffer.filter(|buffer| buffer.words != Some(0));
        Ports {
            memories: elements * banks(machine),
            elements,
            writes: Vec::new(),
            write_limit: byte(machine.memory.writes),
            buffer_reads: Vec::new(),
            buffer_read_limit: buffer.map_or(0, |buffer| byte(buffer.reads)),
            buffer_words: Vec::new(),
            buffer_word_limit: buffer
                .and_then(|buffer| buffer.words)
                .and_then(|words| u16::try_from(words).ok()),
        }
    }

    /// Makes room for reservations up to a cycle.
    pub(super) fn reach(&mut self, cycle: u32) {
        let rows = cycle as usize + 1;
        if self.writes.len() < rows * self.memories {
            self.writes.resize(rows * self.memories, 0);
            self.buffer_reads.resize(rows * self.elements, 0);
            if self.buffer_word_limit.is_some() {
                self.buffer_words.resize(rows * self.elements, 0);
            }
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
    pub(super) fn can_write(&self, cycle: u32, memory: usize, words: u8) -> bool {
        let taken = self.writes[cycle as usize * self.memories + memory];
        taken.saturating_add(words) <= self.write_limit
    }

    /// Takes a write port.
    pub(super) fn write(&mut self, cycle: u32, memory: usize) {
        self.writes[cycle as usize * self.memories + memory] += 1;
    }

    /// True when the element's buffer can hand out `words` more in the cycle.
    pub(super) fn can_read_buffer(&self, cycle: u32, element: usize, words: u8) -> bool {
        let taken = self.buffer_reads[cycle as usize * self.elements + element];
        taken.saturating_add(words) <= self.buffer_read_limit
    }

    /// Takes a buffer output.
    pub(super) fn read_buffer(&mut self, cycle: u32, element: usize) {
        self.buffer_reads[cycle as usize * self.elements + element] += 1;
    }

    /// True when the element's buffer has room for `words` more in the cycle.
    pub(super) fn has_room(&self, cycle: u32, element: usize, words: u16) -> bool {
        self.buffer_word_limit.is_none_or(|limit| {
            self.buffer_words[cycle as usize * self.elements + element] + words <= limit
        })
    }

    /// Keeps a word in the element's buffer during the cycles given.
    pub(super) fn occupy(&mut self, cycles: std::ops::RangeInclusive<u32>, element: usize) {
        if self.buffer_word_limit.is_some() {
            for cycle in cycles {
                self.buffer_words[cycle as usize * self.elements + element] += 1;
            }
        }
    }
}
