//! One program of a bench.

use super::functions::OutputKey;
use super::tools::{self, BuildStep};
use robovec_io::files::{Replace, write_whole};
use robovec_num::fnv::Fnv;
use robovec_present::number::or_dash;
use serde::Serialize;
use std::path::Path;

/// Origin of a contestant.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContestantFamily {
    /// Robotran's file.
    Robotran,
    /// Robovec's, from the same equations.
    Equations,
    /// Robovec's, from the model.
    Model,
    /// Somebody else's.
    Peer,
}

/// A program that evaluates the function.
#[derive(Clone, Debug)]
pub struct Contestant {
    /// Its name.
    pub name: String,
    /// Origin.
    pub family: ContestantFamily,
    /// Compiler and flags, version.
    pub remark: String,
    /// Operations, where known.
    pub operations: Option<usize>,
    /// States computed at once.
    pub lanes: u32,
    /// Files of its folder.
    pub files: Vec<(String, Vec<u8>)>,
    /// Way in which the program `program` is made.
    pub steps: Vec<BuildStep>,
    /// Files of its folder that the program only reads when it runs.
    pub data: Vec<(String, Vec<u8>)>,
    /// Arguments of the program before the milliseconds.
    pub arguments: Vec<String>,
    /// Outputs in its file of results, for each state in this order.
    pub outputs: Vec<OutputKey>,
    /// The largest difference that is rounding.
    pub tolerance: f64,
    /// The rounding of its numbers relative to that of binary64.
    pub coarseness: f64,
    /// Reason why it cannot take part.
    pub missing: Option<String>,
    /// The folder of a program that serves every model.
    pub shared: Option<String>,
}

pub(super) struct Built {
    pub(super) seconds: Option<f64>,
    pub(super) code_bytes: Option<u64>,
}

/// Times of a run.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RunTime {
    /// The smallest processor time per state, ns.
    pub least: f64,
    /// The 99.9th percentile of the times of single calls less their median,
    /// ns, by the clock on the wall: interrupts and other programs count.
    /// `None` where a run is too short for a thousand calls.
    pub jitter: Option<f64>,
}

/// The name of the file of results.
pub(super) const RESULTS: &str = "results.bin";

/// The file with a hash of the sources of a program.
const MADE_OF: &str = "program.hash";

impl Contestant {
    /// One that computes these outputs, state by state, without a program yet.
    pub(super) fn named(
        name: &str,
        family: ContestantFamily,
        outputs: Vec<OutputKey>,
    ) -> Contestant {
        Contestant {
            name: name.to_owned(),
            family,
            remark: String::new(),
            operations: None,
            lanes: 1,
            files: Vec::new(),
            steps: Vec::new(),
            data: Vec::new(),
            arguments: vec![RESULTS.to_owned()],
            outputs,
            tolerance: 1e-12,
            coarseness: 1.0,
            missing: None,
            shared: None,
        }
    }

    pub(super) fn write(&self, place: &Path) -> std::io::Result<()> {
        for (name, content) in self.files.iter().chain(&self.data) {
            write_whole(&place.join(name), Replace::Anything, |writer| {
                writer.write_all(content)
            })
            .map_err(std::io::Error::other)?;
        }
        Ok(())
    }

    /// Builds it in an empty folder and runs it; its least time per state, ns.
    ///
    /// # Errors
    ///
    /// The message of the compiler or the program.
    pub fn time(&self, folder: &Path, milliseconds: u32) -> Result<f64, String> {
        self.write(folder).map_err(|error| error.to_string())?;
        self.build(folder)?;
        Ok(self.run(folder, milliseconds)?.least)
    }

    pub(super) fn build(&self, place: &Path) -> Result<Built, String> {
        let mut built = Built {
            seconds: None,
            code_bytes: None,
        };
        let made_of = self.content();
        if let Ok(made) = std::fs::read_to_string(place.join(MADE_OF))
            && let Some((known, figures)) = made.split_once('\n')
            && known == made_of
            && place.join("program").exists()
        {
            let mut figures = figures.split_whitespace();
            built.seconds = figures.next().and_then(|seconds| seconds.parse().ok());
            built.code_bytes = figures.next().and_then(|bytes| bytes.parse().ok());
            return Ok(built);
        }
        for step in &self.steps {
            let seconds = step.run(place)?;
            if step.timed {
                *built.seconds.get_or_insert(0.0) += seconds;
            }
            if let Some(object) = &step.object {
                let bytes = tools::code_bytes(&place.join(object));
                built.code_bytes = built.code_bytes.max(bytes);
            }
        }
        let path = place.join(MADE_OF);
        let seconds = or_dash(built.seconds, |seconds| seconds.to_string());
        let bytes = or_dash(built.code_bytes, |bytes| bytes.to_string());
        write_whole(&path, Replace::Anything, |writer| {
            writeln!(writer, "{made_of}\n{seconds} {bytes}")
        })
        .map_err(|error| error.to_string())?;
        Ok(built)
    }

    /// Hash of the files and of the commands that make the program of them.
    pub(super) fn content(&self) -> String {
        let mut hash = Fnv::new();
        for (name, bytes) in &self.files {
            hash.update(format!("{name} {}\n", bytes.len()).as_bytes());
            hash.update(bytes);
        }
        for step in &self.steps {
            hash.update(format!("{step:?}\n").as_bytes());
        }
        hash.text()
    }

    pub(super) fn run(&self, place: &Path, milliseconds: u32) -> Result<RunTime, String> {
        let mut arguments = self.arguments.clone();
        arguments.push(milliseconds.to_string());
        let text = tools::output(place, "./program", &arguments)?;
        let mut words = text.split_whitespace().map(str::parse);
        let Some(Ok(least)) = words.next() else {
            return Err("the program did not print its time".to_owned());
        };
        Ok(RunTime {
            least,
            jitter: words.next().and_then(Result::ok),
        })
    }

    /// The results of the last run: for each state one number per output.
    pub(super) fn results(&self, place: &Path, states: usize) -> Result<Vec<Vec<f64>>, String> {
        let bytes = std::fs::read(place.join(RESULTS)).map_err(|error| error.to_string())?;
        let width = self.outputs.len();
        if bytes.len() != states * width * 8 {
            return Err(format!(
                "{} bytes of results instead of {}",
                bytes.len(),
                states * width * 8
            ));
        }
        let numbers: Vec<f64> = bytes
            .as_chunks::<8>()
            .0
            .iter()
            .map(|&bytes| f64::from_le_bytes(bytes))
            .collect();
        let rows = (0..states).map(|state| numbers[state * width..][..width].to_vec());
        Ok(rows.collect())
    }
}
