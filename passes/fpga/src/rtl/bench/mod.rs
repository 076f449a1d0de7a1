//! Self-checking benches of the hardware.
//!
//! A bench is a host that uses only the images and their manifest. It loads a
//! program through one of the windows of the machine, runs it on several states
//! in sequence, reads the outputs back, and monitors the buses meanwhile: every
//! result of every operation is compared with the one of the cycle-accurate
//! simulator, in its cycle and on its element. So a fault is reported at its
//! first occurrence, by the name of the operation and its equation, and not
//! only by a wrong output.
//!
//! The benches themselves are written by hand (`hdl/bench/`, in plain Verilog
//! and in C++ for Verilator) and read what is here as data:
//!
//! | file | content |
//! |---|---|
//! | `host.hex`, `configured.hex` | what the host does ([`script`]) |
//! | `places.hex` | element and cycle of every result |
//! | `results.hex` | the results, run after run |
//! | `operations.txt` | for every result its operation, for people |
//! | `reads.txt` | for every word that is read back what it is |
//! | `bench_config.vh`, `bench_config.h` | sizes |
//!
//! **Invariant.** Nothing here looks at the generated hardware: a mistake in
//! its address map or its timing cannot be in the bench as well.

mod names;
mod script;

use super::super::manifest::{AddressMap, Manifest};
use robovec_ir::{Machine, View};
use std::fmt::Write;

/// The files of the benches that are written by hand: the host's bridges, the
/// benches, and the makefile for Verilator.
const BRIDGES: [(&str, &str); 2] = hdl!["host", "robovec_avalon.v", "robovec_axi4lite.v"];
const BENCHES: [(&str, &str); 5] = hdl![
    "bench",
    "robovec_bench_top.v",
    "robovec_bench.v",
    "robovec_bench.cpp",
    "run_iverilog.sh",
    "Makefile",
];

/// A word that holds a value before the first cycle.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Load {
    /// The memory, counted over all memories of the manifest.
    pub memory: u32,
    /// The address in it, from 0.
    pub address: u32,
    /// The value.
    pub word: u64,
    /// True if it stays from run to run, so that it is loaded once.
    pub stays: bool,
}

/// A result on the bus of an element.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct BusResult {
    /// The cycle in which it is on the bus.
    pub cycle: u32,
    /// Index of the element in the manifest.
    pub element: u32,
    /// The value.
    pub word: u64,
}

/// One run of the program: inputs and expected outputs.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct BenchRun {
    /// Everything that is loaded.
    pub loads: Vec<Load>,
    /// Every result, in order of cycle and element.
    pub results: Vec<BusResult>,
    /// The words of the manifest's outputs, in their order.
    pub outputs: Vec<u64>,
}

/// The data from which a bench is made.
#[derive(Clone, Copy, Debug)]
pub struct TestBench<'a> {
    /// The placed function, for the names of operations.
    pub view: View<'a>,
    /// The machine of the placement.
    pub machine: &'a Machine,
    /// The manifest of its images.
    pub manifest: &'a Manifest,
    /// For every element its instruction words, each in limbs of 32 bits, the
    /// lowest first.
    pub instructions: &'a [Vec<Vec<u32>>],
    /// The runs, one after the other without a reset.
    pub runs: &'a [BenchRun],
}

/// The reason why there is no bench.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum BenchError {
    /// Images for the simulator alone.
    #[error("the images are not for hardware: their manifest has no 'window'")]
    NoWindow,
    /// The window lacks a memory that something is loaded into.
    #[error("the window has no '{0}', or it is too small")]
    NoUnit(String),
    /// Runs that do not belong to the program.
    #[error("the runs are not of this program: {0}")]
    Runs(String),
    /// More than a bench's files can state.
    #[error("{0}, more than a test bench holds")]
    TooLarge(String),
}

impl TestBench<'_> {
    /// The files of the folder `tb/`: name and text.
    ///
    /// # Errors
    ///
    /// Fails when images and runs do not fit together.
    pub fn files(&self) -> Result<Vec<(String, String)>, BenchError> {
        let window = self.manifest.window.as_ref().ok_or(BenchError::NoWindow)?;
        self.check_runs()?;
        let script = script::write(self, window, false)?;
        let configured = script::write(self, window, true)?;
        let fixed = BRIDGES.into_iter().chain(BENCHES);
        let mut files: Vec<(String, String)> = fixed
            .map(|(name, text)| (name.to_owned(), text.to_owned()))
            .collect();
        let mut add = |name: &str, text: String| files.push((name.to_owned(), text));
        add("places.hex", self.places());
        add("results.hex", self.results());
        add("operations.txt", names::operations(self));
        let sizes = self.sizes(window, &script, &configured)?;
        let function = &self.manifest.function;
        let verilog = |text: &str| format!("// {text}\n");
        let config = definitions(&sizes, function, verilog, ["`define", ""]);
        add("bench_config.vh", config);
        let c = |text: &str| format!("/* {text} */\n");
        let config = definitions(&sizes, function, c, ["#define", "u"]);
        add("bench_config.h", config);
        add("host.hex", script.commands);
        add("configured.hex", configured.commands);
        add("reads.txt", script.reads);
        Ok(files)
    }

    fn operations(&self) -> usize {
        self.runs.first().map_or(0, |run| run.results.len())
    }

    /// A schedule is fixed: all runs have their results in the same places.
    fn check_runs(&self) -> Result<(), BenchError> {
        let fail = |what: &str| Err(BenchError::Runs(what.to_owned()));
        let Some(first) = self.runs.first() else {
            return fail("there are none");
        };
        let manifest = self.manifest;
        if self.instructions.len() != manifest.elements.len() {
            return fail("there is not one list of instructions per element");
        }
        let cycles = manifest.cycles as usize;
        if self.instructions.iter().any(|words| words.len() != cycles) {
            return fail("an element does not have one instruction per cycle");
        }
        for run in self.runs {
            let places =
                |run: &BenchRun| run.results.iter().map(|r| (r.cycle, r.element)).collect();
            let (one, other): (Vec<_>, Vec<_>) = (places(first), places(run));
            if one != other {
                return fail("the places of results differ between runs");
            }
            if !one.is_sorted() {
                return fail("results are not in order of cycle and element");
            }
            if run.outputs.len() != manifest.outputs.len() {
                return fail("there is not one word per output");
            }
        }
        Ok(())
    }

    fn places(&self) -> String {
        let mut text = String::new();
        for result in self.runs.iter().take(1).flat_map(|run| &run.results) {
            // Writing to a string cannot fail, here and below.
            let _ = writeln!(text, "{:08x}{:08x}", result.element, result.cycle);
        }
        // One place more, which no cycle reaches: memories cannot be empty.
        text + "00000000ffffffff\n"
    }

    fn results(&self) -> String {
        let digits = self.manifest.number.width().div_ceil(4) as usize;
        let mut text = String::new();
        for result in self.runs.iter().flat_map(|run| &run.results) {
            let _ = writeln!(text, "{:0digits$x}", result.word);
        }
        let _ = writeln!(text, "{:0digits$x}", 0);
        text
    }

    /// The sizes with which the benches are compiled: purpose, name, and
    /// number.
    fn sizes(
        &self,
        window: &AddressMap,
        script: &script::Script,
        configured: &script::Script,
    ) -> Result<Vec<Size>, BenchError> {
        let manifest = self.manifest;
        let depth = window
            .units
            .iter()
            .filter(|unit| unit.name.ends_with(".instructions"))
            .map(|unit| unit.words)
            .fold(1, u32::max);
        let end = window.units.iter().map(|unit| {
            let words = u64::from(unit.words) * u64::from(unit.stride);
            u64::from(unit.address) + words
        });
        let end = end.fold(8, u64::max);
        let operations = self.operations() as u64;
        let runs = self.runs.len() as u64;
        if operations * runs > MAX_RESULTS {
            return Err(BenchError::TooLarge(format!(
                "{operations} results in {runs} runs"
            )));
        }
        let most_wait = 1000 + 64 * (u64::from(manifest.cycles) + 100);
        let most_clocks = 100_000 + 256 * script.count + runs * 2 * most_wait;
        let numbers = [
            ("elements", "ELEMENTS", manifest.elements.len() as u64),
            (
                "bits of a data word",
                "WIDTH",
                u64::from(manifest.number.width()),
            ),
            (
                "bits of the host's address",
                "ADDRESS",
                u64::from(window.address_bits),
            ),
            ("words of the host's window", "WINDOW", end),
            (
                "bits of a cycle's number",
                "CYCLE",
                u64::from(depth.max(2).next_power_of_two().trailing_zeros()),
            ),
            (
                "cycles of the program",
                "CYCLES",
                u64::from(manifest.cycles),
            ),
            ("results of a run", "OPERATIONS", operations),
            ("runs", "RUNS", runs),
            ("commands of the host", "COMMANDS", script.count),
            (
                "commands when the images are there",
                "CONFIGURED_COMMANDS",
                configured.count,
            ),
            (
                "clocks after which a run has failed",
                "MOST_WAIT",
                most_wait.min(MAX_CLOCKS / 2),
            ),
            (
                "clocks after which everything has failed",
                "MOST_CLOCKS",
                most_clocks.min(MAX_CLOCKS),
            ),
        ];
        Ok(numbers.to_vec())
    }
}

/// Results of all runs at most.
const MAX_RESULTS: u64 = 1 << 26;
/// Maximum number of clocks: the range of a signed number of 32 bits.
const MAX_CLOCKS: u64 = 2_000_000_000;

/// A size: its description, its name, and the number.
type Size = (&'static str, &'static str, u64);

/// Names of functions are identifiers; other characters are left out of quoted
/// texts.
fn quotable(name: &str) -> String {
    let good = |c: &char| c.is_ascii_alphanumeric() || *c == '_';
    name.chars().filter(good).collect()
}

/// The sizes as definitions, each after a comment.
fn definitions(
    sizes: &[Size],
    function: &str,
    comment: impl Fn(&str) -> String,
    [define, unsigned]: [&str; 2],
) -> String {
    let mut text = comment("What the benches are compiled with.");
    for (what, name, number) in sizes {
        text += &comment(what);
        let _ = writeln!(text, "{define} ROBOVEC_{name} {number}{unsigned}");
    }
    let name = quotable(function);
    text + &comment("the program") + &format!("{define} ROBOVEC_NAME \"{name}\"\n")
}
