//! The crossing of values from one function of the generated text to the next.
//!
//! A body is cut into functions of bounded length. A value that one function
//! defines and a later one reads is in a work array, in a word that is free
//! again after the last function that reads it.

use robovec_ir::Value;
use std::ops::Range;

/// The values that a function defines and reads.
#[derive(Clone, Default, Debug)]
pub(crate) struct PartValues {
    pub(crate) defined: Vec<Value>,
    /// The values it reads, its own and others', in the order in which others'
    /// shall be loaded; some may be there more than once.
    pub(crate) read: Vec<Value>,
}

/// The values that cross, and where they lie.
#[derive(Clone, Debug)]
pub(crate) struct Crossing {
    /// For each function the values of earlier ones it reads, each once.
    pub(crate) loads: Vec<Vec<Value>>,
    /// For each value that crosses its word and the function that defines it.
    words: Vec<Option<(u32, usize)>>,
    /// Length of the work array.
    pub(crate) length: u32,
}

impl Crossing {
    /// Gives words to the values, among this number, that cross between the
    /// functions. The first `taken` words are in use; `freed` shows which of
    /// them are unused when a function begins.
    pub(crate) fn new(
        values: usize,
        functions: &[PartValues],
        taken: u32,
        freed: impl Fn(usize) -> Range<u32>,
    ) -> Crossing {
        let mut made: Vec<Option<usize>> = vec![None; values];
        let mut last: Vec<Option<usize>> = vec![None; values];
        let mut loads = Vec::with_capacity(functions.len());
        for (number, function) in functions.iter().enumerate() {
            for value in &function.defined {
                assert!(
                    made[value.index()].is_none(),
                    "a value is defined by one function"
                );
                made[value.index()] = Some(number);
            }
            let mut own = Vec::new();
            for &value in &function.read {
                let index = value.index();
                if made[index] != Some(number) && last[index] != Some(number) {
                    last[index] = Some(number);
                    own.push(value);
                }
            }
            loads.push(own);
        }
        let mut crossing = Crossing {
            loads,
            words: vec![None; values],
            length: taken,
        };
        let mut free: Vec<u32> = Vec::new();
        for (number, function) in functions.iter().enumerate() {
            free.extend(freed(number));
            for value in &function.defined {
                if last[value.index()] > Some(number) {
                    let word = free.pop().unwrap_or_else(|| {
                        crossing.length += 1;
                        crossing.length - 1
                    });
                    crossing.words[value.index()] = Some((word, number));
                }
            }
            let ended = crossing.loads[number].iter();
            let ended = ended.filter(|value| last[value.index()] == Some(number));
            free.extend(ended.map(|&value| {
                let word = crossing.word(value);
                word.expect("a value that is read elsewhere was defined before")
            }));
        }
        crossing
    }

    /// The word that a value travels in.
    pub(crate) fn word(&self, value: Value) -> Option<u32> {
        self.words[value.index()].map(|(word, _)| word)
    }

    /// The word that a function finds a value in that another one defines.
    pub(crate) fn load(&self, value: Value, function: usize) -> Option<u32> {
        let (word, from) = self.words[value.index()]?;
        (from != function).then_some(word)
    }
}
