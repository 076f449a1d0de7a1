//! A run of the machine.
//!
//! One cycle is simulated in the order of the hardware: results leave the
//! pipelines, operations read their operands, then all writes are made at the
//! end of the cycle. Reads therefore see the content at the start of the cycle.

use super::decode::{BufferWrite, Issue, MemoryWrite};
use super::error::Hazard;
use super::program::{LoadedProgram, OutputPlace, SimulatedOutputs};
use super::trace::{Observer, Silent};
use robovec_fpga::manifest::ValueReference;
use robovec_num::arithmetic::Arithmetic;

impl LoadedProgram {
    /// Loads the inputs and the values that the host computes from them, runs,
    /// and collects the outputs. Inputs are rounded to the machine's format.
    ///
    /// # Errors
    ///
    /// The first hazard, by cycle.
    pub fn run(&self, inputs: &[f64]) -> Result<SimulatedOutputs, Hazard> {
        self.run_observed(inputs, &mut Silent)
    }

    /// A run that reports its events to an observer.
    pub(super) fn run_observed<O: Observer>(
        &self,
        inputs: &[f64],
        observer: &mut O,
    ) -> Result<SimulatedOutputs, Hazard> {
        if inputs.len() != self.inputs.len() {
            return Err(Hazard::InputCount {
                expected: self.inputs.len(),
                given: inputs.len(),
            });
        }
        ProgramRunner::new(self).run(inputs, observer)
    }
}

/// Mark of a word that was never written.
const EMPTY: u32 = u32::MAX;
/// The word was loaded before the run.
const LOADED: u32 = u32::MAX - 1;

/// A word of a memory or buffer.
#[derive(Clone, Copy)]
struct MemoryCell {
    number: f64,
    /// The cycle of the last write, [`LOADED`] or [`EMPTY`].
    written: u32,
    /// True if it was read since.
    read: bool,
}

struct ProgramRunner<'p> {
    program: &'p LoadedProgram,
    memory: Vec<MemoryCell>,
    buffers: Vec<MemoryCell>,
    /// For each element a ring of slots, one per cycle of its latency.
    pipelines: Vec<Option<f64>>,
    /// For each element its first slot and the slot of this cycle.
    slots: Vec<(u32, u32)>,
    /// The results that are on the crossbar in this cycle.
    bus: Vec<Option<f64>>,
}

impl<'p> ProgramRunner<'p> {
    fn new(program: &'p LoadedProgram) -> ProgramRunner<'p> {
        let empty = MemoryCell {
            number: 0.0,
            written: EMPTY,
            read: false,
        };
        assert!(
            program.elements.iter().all(|element| element.latency > 0),
            "a result leaves its element in a later cycle"
        );
        let mut slots = Vec::with_capacity(program.elements.len());
        let mut next = 0;
        for element in &program.elements {
            slots.push((next, 0));
            next += element.latency;
        }
        ProgramRunner {
            program,
            memory: vec![empty; program.words],
            buffers: vec![empty; program.buffer_words],
            pipelines: vec![None; next as usize],
            slots,
            bus: vec![None; program.elements.len()],
        }
    }

    fn run<O: Observer>(
        mut self,
        inputs: &[f64],
        observer: &mut O,
    ) -> Result<SimulatedOutputs, Hazard> {
        let program = self.program;
        let known = self.load(inputs);
        let cells = self.memory.iter().zip(0..);
        cells
            .filter(|(cell, _)| cell.written == LOADED)
            .for_each(|(cell, word)| observer.loaded(word, cell.number));
        for cycle in 0..program.cycles {
            self.advance(cycle, observer);
            for issue in program.steps.issues(cycle) {
                self.issue(cycle, issue)?;
            }
            for write in program.steps.writes(cycle) {
                self.write(cycle, write)?;
            }
            for write in program.steps.buffer_writes(cycle) {
                self.buffer_write(cycle, write)?;
            }
        }
        self.check_pipelines()?;
        let cells = self.memory.iter().zip(0..);
        cells
            .filter(|(cell, _)| cell.written < LOADED)
            .for_each(|(_, word)| observer.overwritten(word));
        self.collect(&known)
    }

    /// Loads the memories; the values known before the run.
    fn load(&mut self, inputs: &[f64]) -> InitialValues {
        let program = self.program;
        let arithmetic = &program.arithmetic;
        for &(word, bits) in &program.data {
            self.put(word, arithmetic.from_word(bits));
        }
        let round = |number: &f64| arithmetic.convert(*number);
        let mut known = InitialValues {
            inputs: inputs.iter().map(round).collect(),
            constants: program.constants.iter().map(round).collect(),
            host: Vec::with_capacity(program.host.len()),
        };
        assert_eq!(
            known.inputs.len(),
            program.inputs.len(),
            "one number per input element"
        );
        for (words, &number) in program.inputs.iter().zip(&known.inputs) {
            words.iter().for_each(|&word| self.put(word, number));
        }
        for step in &program.host {
            let operands = step.operands.map(|operand| known.get(operand));
            let number = match &program.unit {
                Some(unit) => unit.within(*arithmetic).apply(step.operation, operands),
                None => arithmetic.apply(step.operation, operands),
            };
            known.host.push(number);
            step.words.iter().for_each(|&word| self.put(word, number));
        }
        known
    }

    fn put(&mut self, word: u32, number: f64) {
        self.memory[word as usize] = MemoryCell {
            number,
            written: LOADED,
            read: false,
        };
    }

    /// Moves every pipeline one cycle on.
    fn advance<O: Observer>(&mut self, cycle: u32, observer: &mut O) {
        let elements = self.program.elements.iter().zip(0..);
        for (((element, place), slot), bus) in elements.zip(&mut self.slots).zip(&mut self.bus) {
            slot.1 += 1;
            if slot.1 == element.latency {
                slot.1 = 0;
            }
            *bus = self.pipelines[(slot.0 + slot.1) as usize].take();
            if let Some(number) = *bus {
                observer.result(cycle, place, number);
            }
        }
    }

    fn issue(&mut self, cycle: u32, issue: &Issue) -> Result<(), Hazard> {
        let program = self.program;
        let element = &program.elements[issue.element as usize];
        let Some(&operation) = element.operations.get(issue.code as usize) else {
            return Err(Hazard::UnknownOperation {
                cycle,
                element: element.name.clone(),
                code: issue.code,
            });
        };
        let mut operands = [0.0; 3];
        for (side, operand) in operands[..operation.arity()].iter_mut().enumerate() {
            *operand = self.read(cycle, issue, side)?;
        }
        let result = program.arithmetic.apply(operation, operands);
        let (first, now) = self.slots[issue.element as usize];
        self.pipelines[(first + now) as usize] = Some(result);
        Ok(())
    }

    fn read(&mut self, cycle: u32, issue: &Issue, side: usize) -> Result<f64, Hazard> {
        let element = &self.program.elements[issue.element as usize];
        // An addend comes from where the left operand does.
        let memory = element.memories[side % 2];
        let place = self.place(cycle, memory, issue.reads[side])?;
        let cell = &mut self.memory[place];
        if cell.written == EMPTY {
            return Err(Hazard::UninitialisedRead {
                cycle,
                element: element.name.clone(),
                memory: self.program.memories[memory as usize].name.clone(),
                address: issue.reads[side],
            });
        }
        cell.read = true;
        Ok(cell.number)
    }

    fn place(&self, cycle: u32, memory: u32, address: u32) -> Result<usize, Hazard> {
        let unit = &self.program.memories[memory as usize];
        if address >= unit.words {
            return Err(Hazard::AddressRange {
                cycle,
                memory: unit.name.clone(),
                address,
                words: unit.words,
            });
        }
        Ok((unit.offset + address) as usize)
    }

    fn write(&mut self, cycle: u32, write: &MemoryWrite) -> Result<(), Hazard> {
        let program = self.program;
        let element = &program.elements[write.element as usize];
        let memory = element.memories[write.memory as usize];
        let number = self.source(cycle, write, memory)?;
        let place = self.place(cycle, memory, write.address)?;
        let cell = &mut self.memory[place];
        let name = || program.memories[memory as usize].name.clone();
        if cell.written == cycle {
            return Err(Hazard::WrittenTwice {
                cycle,
                memory: name(),
                address: write.address,
            });
        }
        if cell.written != EMPTY && !cell.read {
            return Err(Hazard::Lost {
                cycle,
                memory: name(),
                address: write.address,
            });
        }
        *cell = MemoryCell {
            number,
            written: cycle,
            read: false,
        };
        Ok(())
    }

    /// Value that the crossbar brings to a write port.
    fn source(&mut self, cycle: u32, write: &MemoryWrite, memory: u32) -> Result<f64, Hazard> {
        let program = self.program;
        let name = || program.memories[memory as usize].name.clone();
        let elements = program.elements.len();
        let inputs = elements * (1 + program.buffer_reads as usize);
        let select = write.select as usize;
        if select >= inputs {
            return Err(Hazard::UnknownSource {
                cycle,
                memory: name(),
                select: write.select,
                inputs: inputs as u32,
            });
        }
        let element = &program.elements[select % elements];
        if select < elements {
            return self.bus[select].ok_or_else(|| Hazard::NoResult {
                cycle,
                memory: name(),
                element: element.name.clone(),
            });
        }
        let word = write.buffer_word;
        if word >= element.buffer_words {
            return Err(overflow(cycle, element, word));
        }
        let cell = &mut self.buffers[(element.buffer_offset + word) as usize];
        if cell.written == EMPTY {
            return Err(Hazard::UninitialisedBufferRead {
                cycle,
                element: element.name.clone(),
                word,
            });
        }
        cell.read = true;
        Ok(cell.number)
    }

    fn buffer_write(&mut self, cycle: u32, write: &BufferWrite) -> Result<(), Hazard> {
        let element = &self.program.elements[write.element as usize];
        let Some(number) = self.bus[write.element as usize] else {
            return Err(Hazard::NoResultToBuffer {
                cycle,
                element: element.name.clone(),
            });
        };
        if write.word >= element.buffer_words {
            return Err(overflow(cycle, element, write.word));
        }
        let cell = &mut self.buffers[(element.buffer_offset + write.word) as usize];
        if cell.written != EMPTY && !cell.read {
            return Err(Hazard::LostInBuffer {
                cycle,
                element: element.name.clone(),
                word: write.word,
            });
        }
        *cell = MemoryCell {
            number,
            written: cycle,
            read: false,
        };
        Ok(())
    }

    fn check_pipelines(&self) -> Result<(), Hazard> {
        for (element, &(first, _)) in self.program.elements.iter().zip(&self.slots) {
            let slots = first as usize..(first + element.latency) as usize;
            if self.pipelines[slots].iter().any(Option::is_some) {
                return Err(Hazard::StillRunning {
                    cycles: self.program.cycles,
                    element: element.name.clone(),
                });
            }
        }
        Ok(())
    }

    fn collect(&self, known: &InitialValues) -> Result<SimulatedOutputs, Hazard> {
        let program = self.program;
        let mut numbers = Vec::with_capacity(program.outputs.len());
        for output in &program.outputs {
            let (memory, address, expected) = match output.place {
                OutputPlace::Known(reference) => {
                    numbers.push(known.get(reference));
                    continue;
                }
                OutputPlace::Home {
                    memory,
                    address,
                    written,
                } => (memory, address, written),
            };
            let unit = &program.memories[memory as usize];
            let cell = self.memory[(unit.offset + address) as usize];
            let overwritten = cell.written < LOADED && cell.written > expected;
            if overwritten {
                return Err(Hazard::OutputOverwritten {
                    output: output.name.clone(),
                    memory: unit.name.clone(),
                    address,
                    cycle: cell.written,
                });
            }
            if cell.written != expected {
                return Err(Hazard::OutputNotWritten {
                    output: output.name.clone(),
                    memory: unit.name.clone(),
                    address,
                    expected,
                });
            }
            numbers.push(cell.number);
        }
        Ok(SimulatedOutputs {
            words: numbers
                .iter()
                .map(|&number| program.arithmetic.word(number))
                .collect(),
            values: numbers,
            cycles: program.cycles,
        })
    }
}

fn overflow(cycle: u32, element: &super::program::ElementUnit, word: u32) -> Hazard {
    Hazard::BufferOverflow {
        cycle,
        element: element.name.clone(),
        word,
        words: element.buffer_words,
    }
}

/// The values known before the run.
struct InitialValues {
    inputs: Vec<f64>,
    constants: Vec<f64>,
    host: Vec<f64>,
}

impl InitialValues {
    fn get(&self, reference: ValueReference) -> f64 {
        match reference {
            ValueReference::Input(index) => self.inputs[index as usize],
            ValueReference::Constant(index) => self.constants[index as usize],
            ValueReference::Host(index) => self.host[index as usize],
        }
    }
}
