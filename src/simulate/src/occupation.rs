//! The use of elements and memories over time, for the charts of a report.

use super::program::LoadedProgram;

/// The use of the machine by a program.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct MachineOccupation {
    /// Length of the program.
    pub cycles: u32,
    /// Element by element, in order of the crossbar.
    pub elements: Vec<ElementOccupation>,
}

/// The use of one element.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ElementOccupation {
    /// Kind and number: `add0`.
    pub name: String,
    /// The kind in the machine file.
    pub kind: String,
    /// The cycles in which an operation starts, ascending.
    pub issues: Vec<u32>,
    /// Results written in the cycle in which they leave the pipeline, counted
    /// at the element that produces them, once for every word.
    pub direct_writes: u64,
    /// Results written later, from the buffer, counted likewise.
    pub buffered_writes: u64,
    /// Distinct words in use, initial data included, of each memory.
    pub memory_words: Vec<u32>,
    /// Distinct buffer words in use.
    pub buffer_words: u32,
    /// Most buffer words that hold a value still to be read.
    pub buffer_peak: u32,
}

impl LoadedProgram {
    /// The use the program makes of its machine; the same in every run, since
    /// nothing in a program depends on values.
    pub fn occupation(&self) -> MachineOccupation {
        let mut elements: Vec<ElementOccupation> = self
            .elements
            .iter()
            .map(|element| ElementOccupation {
                name: element.name.clone(),
                kind: element.kind.clone(),
                issues: Vec::new(),
                direct_writes: 0,
                buffered_writes: 0,
                memory_words: Vec::new(),
                buffer_words: 0,
                buffer_peak: 0,
            })
            .collect();
        let mut used = self.loaded_words();
        let mut buffer = BufferUse::new(self);
        for cycle in 0..self.cycles {
            for issue in self.steps.issues(cycle) {
                elements[issue.element as usize].issues.push(cycle);
            }
            for write in self.steps.writes(cycle) {
                let owner = &self.elements[write.element as usize];
                let memory = &self.memories[owner.memories[write.memory as usize] as usize];
                if write.address < memory.words {
                    used[(memory.offset + write.address) as usize] = true;
                }
                let source = write.select as usize % self.elements.len();
                if (write.select as usize) < self.elements.len() {
                    elements[source].direct_writes += 1;
                } else {
                    elements[source].buffered_writes += 1;
                    buffer.read(self, source, write.buffer_word, cycle);
                }
            }
            for write in self.steps.buffer_writes(cycle) {
                buffer.write(self, write.element as usize, write.word, cycle);
            }
        }
        let uses = buffer.finish(self);
        for ((unit, element), (words, peak)) in self.elements.iter().zip(&mut elements).zip(uses) {
            let [left, right] = unit.memories;
            let memories = if left == right {
                vec![left]
            } else {
                vec![left, right]
            };
            let count = |memory: u32| {
                let memory = &self.memories[memory as usize];
                let range = memory.offset as usize..(memory.offset + memory.words) as usize;
                used[range].iter().filter(|&&used| used).count() as u32
            };
            element.memory_words = memories.into_iter().map(count).collect();
            element.buffer_words = words;
            element.buffer_peak = peak;
        }
        MachineOccupation {
            cycles: self.cycles,
            elements,
        }
    }

    /// The words that hold initial data.
    fn loaded_words(&self) -> Vec<bool> {
        let mut used = vec![false; self.words];
        let inputs = self.inputs.iter().flatten();
        let host = self.host.iter().flat_map(|step| &step.words);
        let data = self.data.iter().map(|(word, _)| word);
        for &word in data.chain(inputs).chain(host) {
            used[word as usize] = true;
        }
        used
    }
}

/// For each buffer word the cycle of its write and of its last read so far;
/// finished intervals are kept per element.
struct BufferUse {
    open: Vec<Option<(u32, u32)>>,
    intervals: Vec<Vec<(u32, u32)>>,
    used: Vec<bool>,
}

impl BufferUse {
    fn new(program: &LoadedProgram) -> BufferUse {
        BufferUse {
            open: vec![None; program.buffer_words],
            intervals: vec![Vec::new(); program.elements.len()],
            used: vec![false; program.buffer_words],
        }
    }

    fn place(program: &LoadedProgram, element: usize, word: u32) -> Option<usize> {
        let unit = &program.elements[element];
        (word < unit.buffer_words).then_some((unit.buffer_offset + word) as usize)
    }

    fn write(&mut self, program: &LoadedProgram, element: usize, word: u32, cycle: u32) {
        if let Some(place) = BufferUse::place(program, element, word) {
            self.used[place] = true;
            // Held for one cycle at least, read or not.
            let before = self.open[place].replace((cycle, cycle + 1));
            self.intervals[element].extend(before);
        }
    }

    fn read(&mut self, program: &LoadedProgram, element: usize, word: u32, cycle: u32) {
        if let Some(place) = BufferUse::place(program, element, word)
            && let Some(interval) = &mut self.open[place]
        {
            interval.1 = cycle;
        }
    }

    /// For each element its words in use and the most at one time.
    fn finish(mut self, program: &LoadedProgram) -> Vec<(u32, u32)> {
        let mut uses = Vec::with_capacity(program.elements.len());
        for (unit, intervals) in program.elements.iter().zip(&mut self.intervals) {
            let range =
                unit.buffer_offset as usize..(unit.buffer_offset + unit.buffer_words) as usize;
            intervals.extend(self.open[range.clone()].iter().flatten());
            let words = self.used[range].iter().filter(|&&used| used).count() as u32;
            uses.push((words, most_at_once(intervals)));
        }
        uses
    }
}

/// Most intervals that share a cycle. A value is held from the end of the
/// first cycle to the last cycle.
fn most_at_once(intervals: &[(u32, u32)]) -> u32 {
    debug_assert!(
        intervals.iter().all(|(start, end)| start < end),
        "a value is held for one cycle at least"
    );
    let mut changes: Vec<(u32, bool)> = intervals
        .iter()
        .flat_map(|&(start, end)| [(start, true), (end, false)])
        .collect();
    // Ends sort before starts: a word read in a cycle can be written at its
    // end.
    changes.sort_unstable();
    let (mut now, mut most) = (0u32, 0u32);
    for (_, starts) in changes {
        now = if starts { now + 1 } else { now - 1 };
        most = most.max(now);
    }
    most
}
