//! The time of the same functions on one core of a processor: the C that
//! `codegen` writes, compiled by the user's compiler and run on random
//! states.
//!
//! These are measurements: they differ from run to run and stay apart from
//! the results of the study.

mod harness;

use super::program::Program;
use robovec_ir::View;
use robovec_passes::codegen::c::{Real, c_files};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Functions with more operations are not compiled unless asked for: C
/// compilers take a second for some ten thousand operations.
pub const LARGEST: usize = 200_000;

/// How the C is compiled.
const FLAGS: [&str; 3] = ["-std=c99", "-O1", "-ffp-contract=off"];

/// A measured time, or why there is none.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CpuTime {
    /// The model.
    pub model: String,
    /// The pipeline.
    pub pipeline: String,
    /// Operations of the function, sines and cosines apart.
    pub operations: usize,
    /// Time of one call in binary64, sines and cosines included: the least
    /// over many repetitions, µs of processor time.
    pub microseconds: Option<f64>,
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
    pub fn is_of(&self, program: &Program, computer: &Computer) -> bool {
        let facts = &program.facts;
        self.model == facts.model
            && self.pipeline == facts.pipeline
            && self.operations == facts.operations
            && self.compiler == computer.compiler
            && self.processor == computer.processor
            && self.microseconds.is_some()
    }
}

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
        let version = Command::new("cc").arg("--version").output();
        let version = version.ok().filter(|output| output.status.success());
        let compiler = version.map(|output| {
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            format!(
                "{} {}",
                text.lines().next().unwrap_or("cc"),
                FLAGS[1..].join(" ")
            )
        });
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

/// Measures a program; one at a time, or the figures mean nothing.
pub fn measure(program: &Program, computer: &Computer, largest: usize) -> CpuTime {
    let facts = &program.facts;
    let result = if computer.compiler.is_empty() {
        Err("not measured, there is no C compiler 'cc'".to_owned())
    } else if facts.operations > largest {
        Err(format!(
            "not measured, it has more than {largest} operations, which take a C compiler minutes"
        ))
    } else {
        let view = View {
            tables: &program.module.tables,
            function: &program.module.functions[0],
        };
        compile_and_run(view, Real::Double).map(|time| super::table::round(time * 1e-3, 4))
    };
    CpuTime {
        model: facts.model.clone(),
        pipeline: facts.pipeline.clone(),
        operations: facts.operations,
        remark: result.as_ref().err().cloned().unwrap_or_default(),
        microseconds: result.ok(),
        compiler: computer.compiler.clone(),
        processor: computer.processor.clone(),
    }
}

/// The time of one call of a function in ns: the least over many repetitions,
/// sines and cosines included.
///
/// # Errors
///
/// Why there is no time: no compiler, or what it says.
pub fn compile_and_run(view: View<'_>, real: Real) -> Result<f64, String> {
    let folder = tempfile::tempdir().map_err(|error| format!("no temporary folder: {error}"))?;
    let [source, header] = c_files(view, real);
    let main = ("main.c".to_owned(), harness::main(view, &header.0, real));
    for (name, text) in [&source, &header, &main] {
        fs::write(folder.path().join(name), text).map_err(|error| error.to_string())?;
    }
    let run = |command: &mut Command| {
        let output = command.current_dir(folder.path()).output();
        let output = output.map_err(|error| format!("it does not run: {error}"))?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
        }
        let messages = String::from_utf8_lossy(&output.stderr);
        Err(format!(
            "it failed: {}",
            messages.lines().next().unwrap_or("no message")
        ))
    };
    let mut compiler = Command::new("cc");
    compiler
        .args(FLAGS)
        .args(["-o", "program", "main.c", &source.0, "-lm"]);
    run(&mut compiler)?;
    let text = run(&mut Command::new(Path::new("./program")))?;
    let nanoseconds = text
        .split_whitespace()
        .next()
        .and_then(|word| word.parse::<f64>().ok());
    nanoseconds.ok_or_else(|| "the program did not print its time".to_owned())
}
