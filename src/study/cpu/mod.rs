//! The time of the same functions on one core of a processor: the C that
//! `codegen` writes, compiled by the user's compiler and run on random
//! states.
//!
//! These are measurements: they differ from run to run and stay apart from
//! the results of the study.

mod harness;
pub mod table;

use crate::bench::contestant::Family;
use crate::bench::own::{self, operations};
use crate::bench::{Compiler, Question, bench};
use crate::files::{Replace, TemporaryFolder, write_whole};
use crate::process::Call;
use robovec_ir::View;
use robovec_ir::fnv::Fnv;
use robovec_ir::print::print_file;
use robovec_ir::states::States;
use robovec_passes::codegen::c::{Real, c_files};
use serde::{Deserialize, Serialize};
use std::fs;

/// Functions with more operations are not compiled unless asked for: C
/// compilers take a second for some ten thousand operations.
pub const LARGEST: usize = 200_000;

/// How [`compile_and_run`] compiles.
const FLAGS: [&str; 3] = ["-std=c99", "-O1", "-ffp-contract=off"];

/// Measured times, or why there are none.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CpuTime {
    /// The model.
    pub model: String,
    /// The pipeline, or the formulation of a program that is made for
    /// processors.
    pub pipeline: String,
    /// Hash of the text of the functions, in hexadecimal: a time is one of
    /// these and no others.
    pub program: String,
    /// Operations of the function, sines and cosines apart.
    pub operations: usize,
    /// Time of one evaluation in binary64 by straight-line C, sines and
    /// cosines included: the least over many repetitions, µs of processor
    /// time.
    pub microseconds: Option<f64>,
    /// The same by C with loops.
    pub rolled: Option<f64>,
    /// Time per state when eight are evaluated at once.
    pub batch: Option<f64>,
    /// Why there is no time.
    pub remark: String,
    /// The compiler and how it was called.
    pub compiler: String,
    /// The processor.
    pub processor: String,
}

impl CpuTime {
    /// True when it is a measurement of this program by the same compiler on
    /// the same processor.
    pub fn is_of(&self, job: &Job<'_>, computer: &Computer) -> bool {
        self.model == job.model
            && self.pipeline == job.pipeline
            && self.program == job.program()
            && self.compiler == computer.compiler
            && self.processor == computer.processor
            && self.microseconds.is_some()
    }

    /// The same times for a job of the same functions under other names.
    pub fn of(&self, job: &Job<'_>) -> CpuTime {
        CpuTime {
            model: job.model.to_owned(),
            pipeline: job.pipeline.to_owned(),
            ..self.clone()
        }
    }

    /// The time of one evaluation by the faster C.
    pub fn single(&self) -> Option<f64> {
        let both = self.microseconds.into_iter().chain(self.rolled);
        both.min_by(f64::total_cmp)
    }
}

/// A function to be timed.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// The model.
    pub model: &'a str,
    /// The pipeline or formulation.
    pub pipeline: &'a str,
    /// The function, in whose order loops are found.
    pub view: View<'a>,
    /// The same for straight-line code and batches.
    pub shorter: View<'a>,
}

impl Job<'_> {
    /// Hash of the text of both functions.
    pub fn program(&self) -> String {
        let mut hash = Fnv::new();
        for view in [self.view, self.shorter] {
            hash.update(print_file(view).as_bytes());
        }
        hash.text()
    }
}

/// Where the states come from that programs are timed at.
const SEED: u64 = 1;
/// How many states.
const STATES: u32 = 16;
/// Rounds, and the time of everybody in a round, ms.
const ROUNDS: (u32, u32) = (3, 60);

/// The computer that measures.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Computer {
    /// Compiler and flags; empty when there is no compiler.
    pub compiler: String,
    /// The processor's name.
    pub processor: String,
}

impl Computer {
    /// This computer.
    pub fn this() -> Computer {
        let compiler = Compiler::find("cc").ok();
        let compiler = compiler.map(|compiler| format!("{} {}", compiler.version, own::FLAGS));
        let information = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = information
            .lines()
            .find(|line| line.starts_with("model name"));
        let name = name
            .and_then(|line| line.split_once(':'))
            .map(|(_, name)| name.trim());
        Computer {
            compiler: compiler.unwrap_or_default(),
            processor: name.unwrap_or("this computer").to_owned(),
        }
    }
}

/// Measures a function; one at a time, or the figures mean nothing.
pub fn measure(job: &Job<'_>, computer: &Computer, largest: usize) -> CpuTime {
    let operations = operations(job.view);
    let result = if computer.compiler.is_empty() {
        Err("not measured, there is no C compiler 'cc'".to_owned())
    } else if operations > largest {
        Err(format!(
            "not measured, it has more than {largest} operations, which take a C compiler minutes"
        ))
    } else {
        contest(job.view, job.shorter)
    };
    let times = result.as_ref().copied().unwrap_or_default();
    let microseconds =
        |time: Option<f64>| time.map(|time| crate::present::number::round(time * 1e-3, 4));
    CpuTime {
        model: job.model.to_owned(),
        pipeline: job.pipeline.to_owned(),
        program: job.program(),
        operations,
        microseconds: microseconds(times.straight),
        rolled: microseconds(times.rolled),
        batch: microseconds(times.batch),
        remark: result.err().unwrap_or_default(),
        compiler: computer.compiler.clone(),
        processor: computer.processor.clone(),
    }
}

/// Times of one function, ns.
#[derive(Clone, Copy, Default, PartialEq, Debug)]
pub struct Times {
    /// One evaluation by straight-line C.
    pub straight: Option<f64>,
    /// One evaluation by C with loops.
    pub rolled: Option<f64>,
    /// Per state, when eight are evaluated at once.
    pub batch: Option<f64>,
}

impl Times {
    /// The time of one evaluation by the faster C.
    pub fn single(&self) -> Option<f64> {
        let both = self.straight.into_iter().chain(self.rolled);
        both.min_by(f64::total_cmp)
    }
}

/// Times of the C that is generated for processors, in binary64, after its
/// results were compared with the evaluator's. Loops are found in the order of
/// `regular`; straight-line code and batches are of `shorter`, the same
/// function after passes or not.
///
/// # Errors
///
/// Why there is no time: no compiler, what it says, or another result.
pub fn contest(regular: View<'_>, shorter: View<'_>) -> Result<Times, String> {
    let folder = TemporaryFolder::new().map_err(|error| format!("no temporary folder: {error}"))?;
    let compiler = Compiler::find("cc")?;
    let question = Question {
        name: "function".to_owned(),
        view: regular,
        model: None,
        states: &States::new(SEED),
        count: STATES,
    };
    let ways: [(own::Way, View<'_>); 3] = [
        (own::straight, shorter),
        (own::rolled, regular),
        (own::batch, shorter),
    ];
    let family = Family::Equations;
    let contestants = ways.map(|(way, view)| way(&question, &compiler, family, "C", view));
    let (rounds, milliseconds) = ROUNDS;
    let quiet = &mut |_: &str| {};
    let outcomes = bench(
        &question,
        &contestants,
        folder.path(),
        rounds,
        milliseconds,
        quiet,
    )
    .map_err(|error| error.to_string())?;
    let failure = outcomes.iter().find_map(|outcome| outcome.failure.clone());
    match (failure, outcomes.as_slice()) {
        (None, [straight, rolled, batch]) => Ok(Times {
            straight: straight.nanoseconds,
            rolled: rolled.nanoseconds,
            batch: batch.nanoseconds,
        }),
        (failure, _) => Err(failure.unwrap_or_default()),
    }
}

/// The time of one call of a function in ns: the least over many repetitions,
/// sines and cosines included.
///
/// # Errors
///
/// Why there is no time: no compiler, or what it says.
pub fn compile_and_run(view: View<'_>, real: Real) -> Result<f64, String> {
    let folder = TemporaryFolder::new().map_err(|error| format!("no temporary folder: {error}"))?;
    let [source, header] = c_files(view, real);
    let main = ("main.c".to_owned(), harness::main(view, &header.0, real));
    for (name, text) in [&source, &header, &main] {
        write_whole(&folder.path().join(name), Replace::Anything, |writer| {
            writer.write_all(text.as_bytes())
        })
        .map_err(|error| error.to_string())?;
    }
    let run = |call: Call| {
        let run = call.folder(folder.path()).run();
        let run = run.map_err(|error| error.to_string())?;
        if run.status.success() {
            return Ok(run.text());
        }
        let messages = run.messages();
        Err(format!(
            "it failed: {}",
            messages.lines().next().unwrap_or("no message")
        ))
    };
    let names = ["-o", "program", "main.c", &source.0, "-lm"];
    run(Call::new("cc").arguments(FLAGS).arguments(names))?;
    let text = run(Call::new("./program"))?;
    let nanoseconds = text
        .split_whitespace()
        .next()
        .and_then(|word| word.parse::<f64>().ok());
    nanoseconds.ok_or_else(|| "the program did not print its time".to_owned())
}
