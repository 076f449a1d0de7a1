//! A run with all data for a comparison with hardware.
//!
//! Outputs show only whether a machine is right; a trace shows where it goes
//! wrong first. It holds the words that a host loads before the run, and every
//! result with the cycle in which it is on its element's bus, as words of the
//! machine's format. A test bench replays the former and compares the latter.

use super::error::Hazard;
use super::program::{LoadedProgram, SimulatedOutputs};
use robovec_num::soft_float::FormatArithmetic;

/// Observer of a run; without one ([`Silent`]) no trace is compiled.
pub(super) trait Observer {
    /// A word of all memories holds a number before the first cycle.
    fn loaded(&mut self, _word: u32, _number: f64) {}
    /// A result is on the bus of an element.
    fn result(&mut self, _cycle: u32, _element: u32, _number: f64) {}
    /// A word of all memories was written during the run.
    fn overwritten(&mut self, _word: u32) {}
}

/// Nobody looks on.
pub(super) struct Silent;

impl Observer for Silent {}

/// A word that holds a value before the first cycle.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LoadedWord {
    /// The memory, by its place in [`LoadedProgram::memories`].
    pub memory: u32,
    /// The address in it, from 0.
    pub address: u32,
    /// The value, as a word of the machine's format.
    pub word: u64,
    /// True if the data images hold it, so that it is the same in all runs.
    pub constant: bool,
    /// True if the run overwrites the word, which the next must load again.
    pub overwritten: bool,
}

/// The result of one operation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TracedResult {
    /// The cycle in which it is on its element's bus.
    pub cycle: u32,
    /// The element, by its place in [`LoadedProgram::elements`].
    pub element: u32,
    /// The value, as a word of the machine's format.
    pub word: u64,
}

/// A run in all its results.
#[derive(Clone, PartialEq, Debug)]
pub struct Trace {
    /// Contents of memories before the first cycle, by memory and address.
    pub loaded: Vec<LoadedWord>,
    /// Every result, in order of cycle and element.
    pub results: Vec<TracedResult>,
    /// Results of the run.
    pub outputs: SimulatedOutputs,
}

struct Recorder<'p> {
    program: &'p LoadedProgram,
    arithmetic: FormatArithmetic,
    loaded: Vec<LoadedWord>,
    /// Words of all memories together, in the order of `loaded`.
    places: Vec<u32>,
    /// Words of all memories together that the data images give a content.
    constant: Vec<bool>,
    results: Vec<TracedResult>,
}

impl Observer for Recorder<'_> {
    fn loaded(&mut self, word: u32, number: f64) {
        let memories = &self.program.memories;
        // Memories follow one another in the order of their offsets, none is
        // empty where there is a word.
        let memory = memories.partition_point(|unit| unit.offset <= word) - 1;
        debug_assert!(
            self.places.last().is_none_or(|&last| last < word),
            "words are loaded in order"
        );
        self.places.push(word);
        self.loaded.push(LoadedWord {
            memory: memory as u32,
            address: word - memories[memory].offset,
            word: self.arithmetic.word(number),
            constant: self.constant[word as usize],
            overwritten: false,
        });
    }

    fn result(&mut self, cycle: u32, element: u32, number: f64) {
        let word = self.arithmetic.word(number);
        self.results.push(TracedResult {
            cycle,
            element,
            word,
        });
    }

    fn overwritten(&mut self, word: u32) {
        if let Ok(place) = self.places.binary_search(&word) {
            self.loaded[place].overwritten = true;
        }
    }
}

impl LoadedProgram {
    /// As [`LoadedProgram::run`], with every word that is loaded and every result.
    pub fn run_traced(&self, inputs: &[f64]) -> Result<Trace, Hazard> {
        let mut constant = vec![false; self.words];
        for &(word, _) in &self.data {
            constant[word as usize] = true;
        }
        // What depends on the state is loaded over what an image may hold.
        let host = self.host.iter().map(|step| &step.words);
        for &word in self.inputs.iter().chain(host).flatten() {
            constant[word as usize] = false;
        }
        let mut recorder = Recorder {
            program: self,
            arithmetic: self.arithmetic,
            loaded: Vec::new(),
            places: Vec::new(),
            constant,
            results: Vec::new(),
        };
        let outputs = self.run_observed(inputs, &mut recorder)?;
        Ok(Trace {
            loaded: recorder.loaded,
            results: recorder.results,
            outputs,
        })
    }
}
