//! Running the benches with the simulators of hardware that are installed.

use robovec_io::process::{FinishedProcess, ProgramCall, ToolError};
use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

/// A simulator of hardware.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
pub enum HardwareSimulator {
    /// Icarus Verilog, with the bench in plain Verilog.
    #[value(name = "iverilog")]
    Icarus,
    /// Verilator, with the bench in C++.
    Verilator,
    /// Verilator, with the bench in plain Verilog.
    #[value(name = "verilog-verilator")]
    VerilatorVerilog,
}

robovec_num::named! {
    /// A way into the machine.
    #[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
    pub enum Door {
        /// The machine's own host bus.
        Bus = "bus",
        /// Avalon-MM.
        Avalon = "avalon",
        /// AXI4-Lite.
        #[value(name = "axi4lite")]
        Axi4Lite = "axi4lite",
        /// The host bus, with the images loaded by the configuration (iverilog).
        Configured = "configured",
    }
}

impl HardwareSimulator {
    /// The programs it takes, with the argument that prints their version.
    fn programs(self) -> &'static [(&'static str, &'static str)] {
        match self {
            HardwareSimulator::Icarus => &[("iverilog", "-V"), ("vvp", "-V")],
            HardwareSimulator::Verilator | HardwareSimulator::VerilatorVerilog => {
                &[("verilator", "--version"), ("make", "--version")]
            }
        }
    }

    /// The first of its programs that cannot be started.
    pub fn missing(self) -> Option<&'static str> {
        let mut programs = self.programs().iter();
        let missing = |(program, version): &&(&str, &str)| {
            let run = ProgramCall::version(program, version).run();
            matches!(run, Err(ToolError::Start { .. }))
        };
        programs.find(missing).map(|(program, _)| *program)
    }

    /// The ways in that it can take.
    pub fn doors(self) -> &'static [Door] {
        let all = &[Door::Bus, Door::Avalon, Door::Axi4Lite, Door::Configured];
        match self {
            HardwareSimulator::Icarus => all,
            HardwareSimulator::Verilator | HardwareSimulator::VerilatorVerilog => &all[..3],
        }
    }

    /// Command that a user would type in the folder of the benches.
    fn command(self, doors: &[Door]) -> (&'static str, Vec<String>) {
        let names: Vec<&str> = doors.iter().map(|door| door.name()).collect();
        let made = |goal: &str| {
            let windows = format!("WINDOWS={}", names.join(" "));
            ("make", vec!["-s".to_owned(), goal.to_owned(), windows])
        };
        match self {
            HardwareSimulator::Icarus => {
                let names = names.iter().copied();
                let words = std::iter::once("run_iverilog.sh").chain(names);
                ("sh", words.map(str::to_owned).collect())
            }
            HardwareSimulator::Verilator => made("verilator"),
            HardwareSimulator::VerilatorVerilog => made("verilog-verilator"),
        }
    }
}

/// Reason why a check did not pass.
#[derive(Debug, thiserror::Error)]
pub enum CheckFailure {
    /// A program is not installed.
    #[error("'{0}' is not installed")]
    Missing(&'static str),
    /// The folder of the hardware is not there.
    #[error("no hardware in {0}: {1}")]
    Hardware(String, io::Error),
    /// It cannot be started, or does not end.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// The bench could not be built, or ended without a verdict.
    #[error("the bench did not run:\n{0}")]
    Build(String),
    /// The hardware is not right.
    #[error("the hardware and the simulator give different results:\n{0}")]
    Mismatch(String),
}

/// Result of a check that passed.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Checked {
    /// The lines that print PASS, one per window.
    pub verdicts: Vec<String>,
    /// The time it took, building included.
    pub time: Duration,
}

/// Builds the benches of a folder with the hardware of another, which contains
/// `files.f`, and runs them through the named windows.
pub fn check(
    folder: &Path,
    hardware: &Path,
    tool: HardwareSimulator,
    doors: &[Door],
) -> Result<Checked, CheckFailure> {
    if let Some(program) = tool.missing() {
        return Err(CheckFailure::Missing(program));
    }
    let start = Instant::now();
    let (program, arguments) = tool.command(doors);
    // The tools run in the folder of the benches.
    let hardware = hardware
        .canonicalize()
        .map_err(|error| CheckFailure::Hardware(hardware.display().to_string(), error))?;
    let output = ProgramCall::new(program)
        .arguments(arguments)
        .variable("RTL", hardware)
        .folder(folder)
        .run()?;
    judge(&output, doors.len()).map(|verdicts| Checked {
        verdicts,
        time: start.elapsed(),
    })
}

/// A bench has passed when every host window reports success, none a failure.
fn judge(output: &FinishedProcess, doors: usize) -> Result<Vec<String>, CheckFailure> {
    let said = output.text();
    let is = |word: &'static str| move |line: &&str| line.starts_with(word);
    let verdicts: Vec<String> = (said.lines().filter(is("PASS")))
        .map(str::to_owned)
        .collect();
    if said.lines().any(|line| line.starts_with("FAIL")) {
        return Err(CheckFailure::Mismatch(said.trim_end().to_owned()));
    }
    if !output.status.success() || verdicts.len() != doors {
        let errors = output.messages();
        let all = format!("{said}{errors}");
        // A C++ compiler can say a great deal.
        let lines: Vec<&str> = all.lines().collect();
        let last = lines.len().saturating_sub(MAX_LINES);
        return Err(CheckFailure::Build(lines[last..].join("\n")));
    }
    Ok(verdicts)
}

/// Lines of a tool's messages that are shown.
const MAX_LINES: usize = 40;
