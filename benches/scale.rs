//! The whole pipeline on large programs, beside MLIR and LLVM on the same
//! operations where those are installed (Debian: mlir-16-tools, llvm-16).
//!
//! `cargo bench` runs it. Each figure is the best of several runs of a whole
//! process: CPU seconds, user and system, and peak memory, as the system
//! counts them for the child. Ratios are to robovec in the same run.

mod synthetic;

use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use synthetic::Program;

const RUNS: usize = 3;
const PIPELINE: &str = "-passes=atomise,cse,balance,place";

fn main() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let sizes = [100_000, 600_000];
    println!(
        "{:44} {:>10} {:>9} {:>9} {:>7}",
        "", "operations", "CPU s", "peak MB", "ratio"
    );
    let mut own = Vec::new();
    for size in sizes {
        let program = Program::new(size, 1);
        let c = write(folder.path(), "mbs_dirdyna_synthetic.c", &program.c());
        let seconds = row(
            &format!("robovec-opt {PIPELINE}"),
            size,
            own_command(&c, folder.path()),
            None,
        );
        own.push(seconds);
        for (name, arguments, text) in [
            (
                "mlir-opt-16",
                vec!["--cse", "--canonicalize"],
                program.mlir(),
            ),
            (
                "opt-16",
                vec!["-passes=reassociate,early-cse", "-S"],
                program.llvm(),
            ),
        ] {
            let input = write(folder.path(), "input.txt", &text);
            let label = format!("{name} {}", arguments.join(" "));
            if Command::new(name).arg("--version").output().is_err() {
                println!("{label:44} {size:>10}  not installed");
                continue;
            }
            let mut command = Command::new(name);
            command
                .args(arguments)
                .arg(input)
                .arg("-o")
                .arg("/dev/null");
            row(&label, size, command, seconds);
        }
    }
    let c = write(
        folder.path(),
        "mbs_dirdyna_synthetic.c",
        &Program::new(600_000, 1).c(),
    );
    translation(&c, folder.path());
    generation(folder.path());
    saturation(folder.path());
    if let [Some(small), Some(large)] = own[..] {
        println!(
            "\nCPU time at 600,000 operations over 100,000: {:.2}",
            large / small
        );
    }
}

/// The default pipeline with `eqsat` on chains, whose critical slice is theirs
/// in truth; a synthetic program has none that windows could shorten.
fn saturation(folder: &Path) {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    for (model, size) in [
        ("serial-50", 84_000),
        ("serial-70", 160_000),
        ("serial-100", 323_000),
        ("serial-130", 543_457),
    ] {
        let equations = folder.join(format!("{model}.rvir"));
        let made = Command::new(env!("CARGO_BIN_EXE_robovec"))
            .arg("gen")
            .arg(models.join(format!("{model}.mbs")))
            .args(["--no-forces", "-o"])
            .arg(&equations)
            .status()
            .expect("the command starts");
        assert!(made.success(), "the model is generated");
        let mut command = Command::new(env!("CARGO_BIN_EXE_robovec-opt"));
        command
            .arg(&equations)
            .arg("-passes=atomise,zero-removal,balance,eqsat,balance,cse,dce")
            .arg("-o")
            .arg(folder.join("out.rvir"));
        row(
            &format!("robovec-opt {model}, with eqsat"),
            size,
            command,
            None,
        );
    }
}

/// Reading a file and writing it in each language.
fn translation(input: &Path, folder: &Path) {
    for language in ["c", "matlab", "python"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_robovec"));
        command
            .arg("write")
            .arg(input)
            .args(["--language", language]);
        command.arg("-o").arg(folder.join("written"));
        let label = format!("robovec gen --language {language}");
        row(&label, 600_000, command, None);
    }
}

/// The equations of a chain of 130 joints, as the thesis counts them and in
/// the formulation with the fewest operations; and their compilation.
fn generation(folder: &Path) {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models/serial-130.mbs");
    let printed = [
        "--no-forces",
        "--expanded",
        "--child-first",
        "--leading-signs",
    ];
    for (label, size, arguments) in [
        (
            "robovec gen serial-130.mbs, as printed",
            599_024,
            &printed[..],
        ),
        ("robovec gen serial-130.mbs", 543_457, &["--no-forces"][..]),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_robovec"));
        command.arg("gen").arg(&model).args(arguments);
        let text = folder.join("generated.rvir");
        command.arg("-o").arg(&text);
        row(label, size, command, None);
        row(
            &format!("robovec-opt {PIPELINE}"),
            size,
            own_command(&text, folder),
            None,
        );
    }
}

fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("room for the test program");
    path
}

fn own_command(input: &Path, folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_robovec-opt"));
    command
        .arg(input)
        .arg(PIPELINE)
        .arg("-o")
        .arg(folder.join("out.rvir"));
    command
}

/// Runs a command several times and prints its best CPU time.
fn row(label: &str, size: usize, mut command: Command, reference: Option<f64>) -> Option<f64> {
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut best = f64::INFINITY;
    for _ in 0..RUNS {
        let before = children_seconds();
        let status = command.status().expect("the command starts");
        if !status.success() {
            println!("{label:44} {size:>10}  failed: {status}");
            return None;
        }
        best = best.min(children_seconds() - before);
    }
    let peak = peak_megabytes(&command);
    let ratio = reference.map_or(String::new(), |own| format!("{:.2}", best / own));
    println!("{label:44} {size:>10} {best:>9.3} {peak:>9} {ratio:>7}");
    Some(best)
}

fn children_seconds() -> f64 {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).expect("the system counts children");
    let time = usage.user_time().num_microseconds() + usage.system_time().num_microseconds();
    time as f64 * 1e-6
}

/// Peak memory of one run, through GNU time where it is installed: the system
/// only gives the largest of all children so far.
fn peak_megabytes(command: &Command) -> String {
    let output = Command::new("/usr/bin/time")
        .arg("-f")
        .arg("%M")
        .arg(command.get_program())
        .args(command.get_args())
        .stdout(Stdio::null())
        .output();
    let Ok(output) = output else {
        return "-".to_owned();
    };
    let text = String::from_utf8_lossy(&output.stderr);
    let kilobytes = text
        .lines()
        .last()
        .and_then(|line| line.trim().parse::<f64>().ok());
    kilobytes.map_or("-".to_owned(), |kilobytes| {
        format!("{:.0}", kilobytes * 1.024e-3)
    })
}
