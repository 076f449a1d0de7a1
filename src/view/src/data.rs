//! Contents of a page, as columns: a list of numbers for every property of the
//! statements of a state, so that large pages stay small and open fast. Texts
//! and sets of source places are numbers into tables.

use crate::report::PassReport;
use serde::Serialize;
use std::collections::BTreeMap;

/// All of a page.
#[derive(Serialize)]
pub(super) struct ViewData {
    pub(super) robovec: String,
    /// The file that was read.
    pub(super) title: String,
    /// The pipeline as the user wrote it.
    pub(super) pipeline: String,
    /// The files of the places.
    pub(super) files: Vec<FileData>,
    /// Sets of places: file (from 0), line and column (from 1) of each.
    pub(super) sources: Vec<Vec<[u32; 3]>>,
    /// The joints of the model, in their order; none when no model is known.
    pub(super) joints: Vec<JointData>,
    /// Descriptions of the passes of the pipeline, by name.
    pub(super) summaries: BTreeMap<String, String>,
    pub(super) functions: Vec<FunctionData>,
    pub(super) texts: Vec<String>,
}

/// A joint, which arrays of the equations have an element for.
#[derive(Serialize)]
pub(super) struct JointData {
    pub(super) name: String,
    /// The file and the line that name it first.
    pub(super) place: Option<[u32; 2]>,
}

/// A file that equations come from.
#[derive(Serialize)]
pub(super) struct FileData {
    pub(super) name: String,
    /// Its lines, where the file is available.
    pub(super) lines: Option<Vec<String>>,
}

/// A function and the passes run on it.
#[derive(Serialize)]
pub(super) struct FunctionData {
    pub(super) name: String,
    pub(super) machine: String,
    /// The number format in which errors are measured.
    pub(super) format: String,
    /// The passes that were run, also those that changed nothing.
    pub(super) passes: Vec<PassReport>,
    /// The states, starting with the one that was read.
    pub(super) states: Vec<StateData>,
    /// The schedule of the last state, when it has one.
    pub(super) schedule: Option<ScheduleData>,
    /// Share of source lines in the errors of all outputs: file, line, share.
    pub(super) heat: Vec<(u32, u32, f64)>,
    pub(super) report: String,
}

/// A state of a function: columns of properties of its values, then outputs.
#[derive(Serialize)]
pub(super) struct StateData {
    /// The pass that left the function so; absent for the state that was read.
    pub(super) pass: Option<String>,
    /// The level of the text form.
    pub(super) level: &'static str,
    /// The longest path, in cycles.
    pub(super) path: u32,
    /// Number of the statements that are values.
    pub(super) values: usize,
    pub(super) names: Vec<u32>,
    /// Right sides, as texts.
    pub(super) texts: Vec<u32>,
    /// Sets of places.
    pub(super) sources: Vec<u32>,
    /// Time at which the result is available, in cycles.
    pub(super) arrivals: Vec<u32>,
    /// Number of cycles it could be later.
    pub(super) slacks: Vec<u32>,
    /// The statement of the state before that it was made from, or -1.
    pub(super) origins: Vec<i64>,
    /// Texts of the rules that made a statement, by its number.
    pub(super) rules: BTreeMap<u32, Vec<u32>>,
    /// The rounding error over the exact number at one state, with two digits;
    /// absent where the exact number is zero or the run overflowed.
    pub(super) errors: Vec<Option<f32>>,
}

/// A schedule: columns of properties of the values of the last state.
#[derive(Serialize)]
pub(super) struct ScheduleData {
    /// Length, in cycles.
    pub(super) cycles: u32,
    /// No schedule is shorter.
    pub(super) bound: u32,
    /// The processing elements by name.
    pub(super) elements: Vec<String>,
    /// The element of each value, or -1 for values of the host.
    pub(super) element: Vec<i64>,
    /// The cycle of its issue.
    pub(super) cycle: Vec<u32>,
    /// Number of cycles until its result can be read.
    pub(super) delay: Vec<u32>,
    /// The first cycle in which all its operands can be read on its element.
    pub(super) ready: Vec<u32>,
    /// The latest operand, or -1 when all are available from the start.
    pub(super) last: Vec<i64>,
    /// The first cycle from `ready` on in which some element of its kind was
    /// free; its own cycle when all were busy until then.
    pub(super) free: Vec<u32>,
    /// Writes of results: value, cycle, element that is written.
    pub(super) writes: Vec<[u32; 3]>,
    /// Number of cycles a slice of `memory` is long.
    pub(super) slice: u32,
    /// For every element the most words of memory in use, slice by slice.
    pub(super) memory: Vec<Vec<u32>>,
}

/// Texts by number, in order of their first use.
#[derive(Default)]
pub(super) struct TextTable {
    numbers: BTreeMap<String, u32>,
}

impl TextTable {
    pub(super) fn number(&mut self, text: &str) -> u32 {
        if let Some(&number) = self.numbers.get(text) {
            return number;
        }
        let number = self.numbers.len() as u32;
        self.numbers.insert(text.to_owned(), number);
        number
    }

    pub(super) fn into_texts(self) -> Vec<String> {
        let mut texts = vec![String::new(); self.numbers.len()];
        for (text, number) in self.numbers {
            texts[number as usize] = text;
        }
        texts
    }
}
