//! Benches: a core, a stream of vectors and a simulator.

use super::vectors::Vector;
use robovec_fpga::rtl::cores::{Cuts, OperatorCore, SOURCES, cuts};
use robovec_ir::machine::Device;
use robovec_num::NumberFormat;
use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// Simulator of hardware.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Simulator {
    /// Interpreted; starts at once.
    Iverilog,
    /// Compiled by way of C++; takes seconds to start and is a hundred times
    /// faster then.
    Verilator,
}

impl Simulator {
    pub(crate) fn is_installed(self) -> bool {
        let (program, option) = match self {
            Simulator::Iverilog => ("iverilog", "-V"),
            Simulator::Verilator => ("verilator", "--version"),
        };
        Command::new(program)
            .arg(option)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .is_ok_and(|status| status.success())
    }
}

/// Report of a simulation.
pub(crate) struct Report {
    pub(crate) checked: usize,
    pub(crate) wrong: usize,
    /// The first differences.
    pub(crate) text: String,
}

/// A core to be simulated.
pub(crate) struct Bench {
    core: OperatorCore,
    format: NumberFormat,
    cuts: Cuts,
    device: &'static Device,
    sources: Vec<(&'static str, &'static str)>,
    mutated: Option<(&'static str, String)>,
}

impl Bench {
    pub(crate) fn new(
        core: OperatorCore,
        format: NumberFormat,
        stages: u32,
        device: &'static Device,
    ) -> Bench {
        Bench {
            core,
            format,
            cuts: cuts(core, format, stages, device),
            device,
            sources: SOURCES.to_vec(),
            mutated: None,
        }
    }

    /// The same with another text for one file.
    pub(crate) fn with(mut self, file: &'static str, text: String) -> Bench {
        self.mutated = Some((file, text));
        self
    }

    /// Simulates; panics with the tool's words when it fails.
    pub(crate) fn run(&self, simulator: Simulator, vectors: &[Vector]) -> Report {
        let folder = TempDir::new().expect("a temporary folder");
        let folder = folder.path();
        let mut files = Vec::new();
        for &(name, source) in &self.sources {
            let text = match &self.mutated {
                Some((file, text)) if *file == name => text,
                _ => source,
            };
            std::fs::write(folder.join(name), text).expect("a source file");
            files.push(name);
        }
        std::fs::write(folder.join("top.v"), self.top()).expect("the top");
        files.push("top.v");
        let output = match simulator {
            Simulator::Iverilog => self.interpret(folder, &files, vectors),
            Simulator::Verilator => self.compile(folder, &files, vectors),
        };
        parsed(&output)
    }

    /// One shape for all cores: operation and three operands.
    fn top(&self) -> String {
        let ports = match self.core {
            OperatorCore::Add => ".subtract(operation[0]), .left(left), .right(right),",
            OperatorCore::Multiply | OperatorCore::Divide => ".left(left), .right(right),",
            OperatorCore::Root => ".left(left),",
            OperatorCore::Fused => {
                ".operation(operation), .left(left), .right(right), .addend(addend),"
            }
        };
        let NumberFormat {
            exponent,
            mantissa,
            subnormals,
        } = self.format;
        let blocks = self.core.device_parameters(self.device).into_iter();
        let blocks: Vec<String> = blocks
            .map(|(name, value)| format!(".{name}({value}), "))
            .collect();
        format!(
            "module top(input clock, input enable, input [1:0] operation,
    input [{width}:0] left, input [{width}:0] right, input [{width}:0] addend,
    output [{width}:0] result);
    {module} #(.EXPONENT({exponent}), .MANTISSA({mantissa}), .SUBNORMALS({subnormals}),
        {blocks}.CUTS(64'd{mask}), .EXTRA({extra})) core (
        .clock(clock), .enable(enable), {ports} .result(result));
endmodule
",
            width = exponent + mantissa,
            module = self.core.name(),
            subnormals = u32::from(subnormals),
            blocks = blocks.concat(),
            mask = self.cuts.mask,
            extra = self.cuts.extra,
        )
    }

    fn interpret(&self, folder: &Path, files: &[&str], vectors: &[Vector]) -> String {
        let mut text = String::new();
        for vector in vectors {
            let Vector {
                operation,
                left,
                right,
                addend,
                result,
            } = vector;
            writeln!(
                text,
                "{operation:x}{left:016x}{right:016x}{addend:016x}{result:016x}"
            )
            .expect("memory");
        }
        std::fs::write(folder.join("vectors.hex"), text).expect("the vectors");
        std::fs::write(folder.join("bench.v"), include_str!("bench.v")).expect("the bench");
        let mut build = Command::new("iverilog");
        build.current_dir(folder).args(["-g2005", "-s", "bench"]);
        build.arg(format!("-Pbench.COUNT={}", vectors.len()));
        build.arg(format!("-Pbench.STAGES={}", self.cuts.stages()));
        let width = 1 + self.format.exponent + self.format.mantissa;
        build.arg(format!("-Pbench.WIDTH={width}"));
        build.args(["-o", "bench.vvp", "bench.v"]).args(files);
        said(&mut build);
        said(
            Command::new("vvp")
                .current_dir(folder)
                .args(["-n", "bench.vvp"]),
        )
    }

    fn compile(&self, folder: &Path, files: &[&str], vectors: &[Vector]) -> String {
        let bytes: Vec<u8> = vectors
            .iter()
            .flat_map(|vector| {
                [
                    vector.operation,
                    vector.left,
                    vector.right,
                    vector.addend,
                    vector.result,
                ]
            })
            .flat_map(u64::to_le_bytes)
            .collect();
        std::fs::write(folder.join("vectors.bin"), bytes).expect("the vectors");
        std::fs::write(folder.join("bench.cpp"), include_str!("bench.cpp")).expect("the bench");
        let mut build = Command::new("verilator");
        build.current_dir(folder).args([
            "--cc",
            "--exe",
            "--build",
            "-O3",
            "--top-module",
            "top",
            "-CFLAGS",
            "-O2",
            "-o",
            "bench",
            "bench.cpp",
        ]);
        said(build.args(files));
        said(
            Command::new(folder.join("obj_dir").join("bench"))
                .current_dir(folder)
                .arg("vectors.bin")
                .arg(self.cuts.stages().to_string()),
        )
    }
}

/// Output of a program that succeeds.
fn said(command: &mut Command) -> String {
    let output = command.output().expect("the program starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "{command:?} failed:\n{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    text
}

/// Reads `checked N wrong K`, the last line of a bench.
fn parsed(output: &str) -> Report {
    let line = output
        .lines()
        .rev()
        .find(|line| line.starts_with("checked "))
        .unwrap_or_else(|| panic!("the bench did not finish:\n{output}"));
    let numbers: Vec<usize> = line
        .split(' ')
        .filter_map(|word| word.parse().ok())
        .collect();
    let text = output
        .lines()
        .filter(|line| line.starts_with("vector "))
        .fold(String::new(), |text, line| text + line + "\n");
    Report {
        checked: numbers[0],
        wrong: numbers[1],
        text,
    }
}
