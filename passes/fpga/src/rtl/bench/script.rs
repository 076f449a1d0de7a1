//! The script of the host, command by command.
//!
//! A line of `host.hex` is a command of 96 bits: kind (8), note (24), address
//! (32), data (32).
//!
//! | kind | command |
//! |---|---|
//! | 0 | the end |
//! | 1 | write the data |
//! | 2 | read, and expect the data; the note is the line of `reads.txt`, from 0 |
//! | 3 | write the data, which starts the next run |
//! | 4 | read until all bits of the data are set: the run has ended |
//!
//! `configured.hex` is the same for a machine whose memories hold the images
//! from configuration on: only inputs are loaded.

use super::{BenchError, BenchRun, TestBench};
use crate::manifest::{AddressMap, MappedMemory, OutputValue};
use std::collections::BTreeMap;
use std::fmt::Write;

const END: u8 = 0;
const WRITE: u8 = 1;
const READ: u8 = 2;
const START: u8 = 3;
const WAIT: u8 = 4;

/// Bits of the registers of control and status.
const CONTROL_START: u32 = 1;
const CONTROL_CLEAR: u32 = 2;
const STATUS_DONE: u32 = 2;

/// Notes at most, by the width of their field.
const MAX_NOTES: usize = 1 << 24;

/// The commands, and their comments.
pub(super) struct Script {
    /// Text of `host.hex`.
    pub(super) commands: String,
    /// The number of commands, the end included.
    pub(super) count: u64,
    /// Text of `reads.txt`.
    pub(super) reads: String,
}

struct ScriptWriter<'a> {
    bench: &'a TestBench<'a>,
    window: &'a AddressMap,
    units: BTreeMap<&'a str, &'a MappedMemory>,
    /// The memories hold the images already.
    configured: bool,
    script: Script,
    notes: usize,
}

/// Writes the commands of a bench, for a machine with images in its
/// configuration or for an empty one.
pub(super) fn write(
    bench: &TestBench<'_>,
    window: &AddressMap,
    configured: bool,
) -> Result<Script, BenchError> {
    let units = window.units.iter();
    let mut writer = ScriptWriter {
        bench,
        window,
        units: units.map(|unit| (unit.name.as_str(), unit)).collect(),
        configured,
        script: Script {
            commands: String::new(),
            count: 0,
            reads: String::new(),
        },
        notes: 0,
    };
    writer.registers()?;
    if !configured {
        writer.instructions()?;
    }
    writer.first_loads()?;
    let outputs = writer.note_outputs();
    for (number, run) in bench.runs.iter().enumerate() {
        writer.run(number, run, outputs)?;
    }
    writer.command(END, 0, 0, 0);
    if writer.notes > MAX_NOTES {
        let what = format!("{} words are read back", writer.notes);
        return Err(BenchError::TooLarge(what));
    }
    Ok(writer.script)
}

impl ScriptWriter<'_> {
    fn command(&mut self, kind: u8, note: usize, address: u32, data: u32) {
        self.script.count += 1;
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(
            self.script.commands,
            "{kind:02x}{note:06x}{address:08x}{data:08x}"
        );
    }

    /// Adds a line of `reads.txt`.
    fn note(&mut self, text: &str) -> usize {
        let _ = writeln!(self.script.reads, "{text}");
        self.notes += 1;
        self.notes - 1
    }

    fn read(&mut self, text: &str, address: u32, data: u32) {
        let note = self.note(text);
        self.command(READ, note, address, data);
    }

    /// Makes sure that it is the right machine, and prints the loaded program.
    fn registers(&mut self) -> Result<(), BenchError> {
        let window = self.window;
        let hash = |text: &str| {
            u64::from_str_radix(text, 16)
                .map_err(|_| BenchError::Runs(format!("'{text}' is not a hash")))
        };
        let machine = halves(hash(&window.machine_hash)?);
        let schedule = halves(hash(&self.bench.manifest.schedule_hash)?);
        for (half, name) in ["low", "high"].into_iter().enumerate() {
            let address = window.machine + half as u32;
            self.read(
                &format!("machine hash, {name} half"),
                address,
                machine[half],
            );
        }
        self.read("status before the first run", window.status, 0);
        let cycles = self.bench.manifest.cycles;
        if !self.configured {
            self.command(WRITE, 0, window.cycles, cycles);
        }
        self.read("cycles of the program", window.cycles, cycles);
        for (half, name) in ["low", "high"].into_iter().enumerate() {
            let address = window.schedule + half as u32;
            if !self.configured {
                self.command(WRITE, 0, address, schedule[half]);
            }
            self.read(
                &format!("schedule hash, {name} half"),
                address,
                schedule[half],
            );
        }
        Ok(())
    }

    fn unit(&self, name: &str, words: u32) -> Result<MappedMemory, BenchError> {
        let found = self.units.get(name).filter(|unit| words <= unit.words);
        let unit = found.map(|&unit| unit.clone());
        unit.ok_or_else(|| BenchError::NoUnit(name.to_owned()))
    }

    fn instructions(&mut self) -> Result<(), BenchError> {
        let bench = self.bench;
        for (element, words) in bench.manifest.elements.iter().zip(bench.instructions) {
            let name = format!("{}.instructions", element.name);
            let unit = self.unit(&name, bench.manifest.cycles)?;
            for (index, limbs) in (0u32..).zip(words) {
                for limb in 0..unit.limbs {
                    let data = limbs.get(limb as usize).copied().unwrap_or(0);
                    self.command(WRITE, 0, unit.address + index * unit.stride + limb, data);
                }
            }
        }
        Ok(())
    }

    fn limbs(&self, memory: &str, address: u32, word: u64) -> Result<Vec<(u32, u32)>, BenchError> {
        let unit = self.unit(memory, address.saturating_add(1))?;
        let first = unit.address + address * unit.stride;
        let limbs = halves(word).into_iter().take(unit.limbs as usize);
        Ok((first..).zip(limbs).collect())
    }

    fn memory(&self, index: u32) -> Result<&str, BenchError> {
        let elements = self.bench.manifest.elements.iter();
        let mut memories = elements.flat_map(|element| &element.memories);
        let found = memories.nth(index as usize);
        found
            .map(|memory| memory.name.as_str())
            .ok_or_else(|| BenchError::NoUnit(format!("memory {index}")))
    }

    /// Loads everything for the first run, and reads it back.
    fn first_loads(&mut self) -> Result<(), BenchError> {
        let mut back = Vec::new();
        for load in self.bench.runs.iter().take(1).flat_map(|run| &run.loads) {
            let memory = self.memory(load.memory)?;
            let what = format!("{memory}[{}], as loaded", load.address);
            for (address, data) in self.limbs(memory, load.address, load.word)? {
                if !(self.configured && load.stays) {
                    self.command(WRITE, 0, address, data);
                }
                back.push((what.clone(), address, data));
            }
        }
        for (what, address, data) in back {
            self.read(&what, address, data);
        }
        Ok(())
    }

    /// Notes the words that are read after every run; returns the index of the
    /// first.
    fn note_outputs(&mut self) -> usize {
        let first = self.note("status after a run: done and no longer running");
        self.note("status after 'done' was cleared");
        for output in &self.bench.manifest.outputs {
            if let OutputValue::Home(home) = &output.value {
                let (memory, address) = (&home.memory, home.address);
                let text = format!("output {} in {memory}[{address}]", output.name);
                self.note(&text);
            }
        }
        first
    }

    fn run(&mut self, number: usize, run: &BenchRun, notes: usize) -> Result<(), BenchError> {
        if number > 0 {
            for load in run.loads.iter().filter(|load| !load.stays) {
                let memory = self.memory(load.memory)?;
                for (address, data) in self.limbs(memory, load.address, load.word)? {
                    self.command(WRITE, 0, address, data);
                }
            }
        }
        let window = self.window;
        self.command(START, 0, window.control, CONTROL_START);
        self.command(WAIT, 0, window.status, STATUS_DONE);
        self.command(READ, notes, window.status, STATUS_DONE);
        self.command(WRITE, 0, window.control, CONTROL_CLEAR);
        self.command(READ, notes + 1, window.status, 0);
        let mut note = notes + 2;
        let outputs = self.bench.manifest.outputs.iter();
        assert_eq!(run.outputs.len(), outputs.len(), "a run has every output");
        for (output, &word) in outputs.zip(&run.outputs) {
            if let OutputValue::Home(home) = &output.value {
                for (address, data) in self.limbs(&home.memory, home.address, word)? {
                    self.command(READ, note, address, data);
                }
                note += 1;
            }
        }
        Ok(())
    }
}

fn halves(word: u64) -> [u32; 2] {
    [word as u32, (word >> 32) as u32]
}
