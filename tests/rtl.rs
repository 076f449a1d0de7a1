//! Generated hardware against the cycle-accurate simulator, in the simulators
//! of hardware that are installed, and benches against planted faults.
//!
//! Where a tool is missing, a line on the standard error reports it and its
//! tests are skipped.

use crate::rtl_support::{Loaded, is_there, replace};
use crate::support::programs::{model, robovec};
use robovec::rtl::{CheckFailure, Door, HardwareSimulator, check};
use std::fs;
use std::path::Path;
use std::process::Command;

const PASSES: &str = "atomise,zero-removal,balance,cse,dce,place";

/// A machine that ships, with this number of elements of each kind and other
/// replacements in its file.
fn machine(folder: &Path, name: &str, count: u32, edits: &[(&str, &str)]) -> String {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("machines")
        .join(format!("{name}.toml"));
    let mut text = fs::read_to_string(shipped).expect("it ships");
    text = text.replace("count = 4", &format!("count = {count}"));
    for (old, new) in edits {
        assert!(text.contains(old), "{old}");
        text = text.replace(old, new);
    }
    let path = folder.join("machine.toml");
    fs::write(&path, text).expect("a folder of our own");
    path.display().to_string()
}

/// Writes hardware and benches for direct dynamics.
fn build(folder: &Path, input: &Path, machine: &str, more: &[&str]) {
    let (input, output) = (input.display().to_string(), folder.display().to_string());
    let mut arguments = vec!["rtl", &input, "--function", "dirdyna", "--machine", machine];
    arguments.extend(["-o", &output]);
    if !more.contains(&"--passes") {
        arguments.extend(["--passes", PASSES]);
    }
    arguments.extend(more);
    let output = robovec(&arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {errors}");
}

/// Verdict of `tb/` in a tool; it must pass.
fn verdicts(folder: &Path, tool: HardwareSimulator, doors: &[Door]) -> Vec<String> {
    match check(&folder.join("tb"), &folder.join("rtl"), tool, doors) {
        Ok(checked) => checked.verdicts,
        Err(failure) => panic!("{failure}"),
    }
}

/// The number before some words of a verdict.
fn count(verdict: &str, words: &str) -> u64 {
    let before = verdict.split(words).next().expect("it has a beginning");
    let number = before.trim_end().rsplit(' ').next();
    number
        .and_then(|n| n.parse().ok())
        .unwrap_or_else(|| panic!("{words} in {verdict}"))
}

/// A model, a machine, elements per kind, and changes of the machine's text.
type Case<'a> = (&'a str, &'a str, u32, &'a [(&'a str, &'a str)]);

/// Small programs on machines of all sorts: sizes that are no powers of two,
/// both styles of memory, more ports than one, words of other widths.
#[test]
fn every_result_is_right_in_icarus_verilog() {
    if !is_there(HardwareSimulator::Icarus) {
        return;
    }
    let wide = ("subnormals = true", "subnormals = false");
    let cases: [Case<'_>; 7] = [
        ("double-pendulum.mbs", "thesis", 1, &[]),
        ("double-pendulum.mbs", "side-split", 1, &[]),
        ("quarter-car.mbs", "thesis", 3, &[]),
        ("quarter-car.mbs", "side-split", 3, &[]),
        ("quarter-car.mbs", "de10-nano", 2, &[wide]),
        (
            "quarter-car.mbs",
            "side-split",
            2,
            &[("mantissa = 23", "mantissa = 29")],
        ),
        (
            "double-pendulum.mbs",
            "pipeline-3-3",
            2,
            &[("reads = 1", "reads = 2")],
        ),
    ];
    for (input, name, elements, edits) in cases {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let machine = machine(folder.path(), name, elements, edits);
        build(folder.path(), &model(input), &machine, &[]);
        // Every way into the smaller ones.
        let doors = match input {
            "double-pendulum.mbs" => HardwareSimulator::Icarus.doors(),
            _ => &[Door::Bus],
        };
        for verdict in verdicts(folder.path(), HardwareSimulator::Icarus, doors) {
            assert!(count(&verdict, " results compared") >= 3 * 41, "{verdict}");
            assert!(count(&verdict, " words read back") > 20, "{verdict}");
        }
    }
}

/// Verilator's lints, all of them, over hardware of all sorts and the agents
/// of both buses.
#[test]
fn verilator_has_no_warning() {
    if !is_there(HardwareSimulator::Verilator) {
        return;
    }
    let flush = ("subnormals = true", "subnormals = false");
    let cases: [Case<'_>; 9] = [
        ("double-pendulum.mbs", "thesis", 1, &[]),
        (
            "double-pendulum.mbs",
            "thesis",
            1,
            &[("writes = 2", "writes = 3")],
        ),
        ("double-pendulum.mbs", "side-split", 3, &[]),
        (
            "double-pendulum.mbs",
            "side-split",
            1,
            &[("writes = 1", "writes = 2")],
        ),
        (
            "double-pendulum.mbs",
            "side-split",
            2,
            &[("mantissa = 23", "mantissa = 52")],
        ),
        (
            "double-pendulum.mbs",
            "side-split",
            2,
            &[("mantissa = 23", "mantissa = 3")],
        ),
        ("double-pendulum.mbs", "de10-nano", 2, &[flush]),
        ("double-pendulum.mbs", "bufferless", 2, &[]),
        ("quarter-car.mbs", "solver", 2, &[]),
    ];
    for (input, name, elements, edits) in cases {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let machine = machine(folder.path(), name, elements, edits);
        let crossbar = ["full", "pruned"][elements as usize % 2];
        build(
            folder.path(),
            &model(input),
            &machine,
            &["--crossbar", crossbar],
        );
        let files = fs::read_to_string(folder.path().join("rtl/files.f")).expect("written");
        let files = files.lines().map(|file| format!("../rtl/{file}"));
        let agents = [
            "robovec_bench_top.v",
            "robovec_avalon.v",
            "robovec_axi4lite.v",
        ];
        let output = Command::new("verilator")
            .args([
                "--lint-only",
                "-Wall",
                "-I.",
                "--top-module",
                "robovec_bench_top",
            ])
            .args(agents)
            .args(files)
            .current_dir(folder.path().join("tb"))
            .output()
            .expect("it is there");
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.success() && told.is_empty(),
            "{name} {edits:?}: {told}"
        );
    }
}

/// Roots and quotients, of negative numbers as well.
const ROOTS: &str = "// robovec 1

function dirdyna equations {
  in x[1..3]
  in y[1..3]
  out d[1..4]

  %L = sqrt(x[1]*x[1] + x[2]*x[2] + x[3]*x[3])
  %K = sqrt(y[1]*y[1] + y[2]*y[2] + y[3]*y[3])
  %N = %L/%K
  %R = sqrt(%N*%N + 1.0)

  d[1] = %L
  d[2] = %K
  d[3] = %N/%R
  d[4] = sqrt(x[2])
}
";

/// Dividers, roots and fused operations on separate elements or together, and a
/// pruned crossbar.
#[test]
fn every_kind_of_operation_is_right_in_icarus_verilog() {
    if !is_there(HardwareSimulator::Icarus) {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let roots = folder.path().join("roots.rvir");
    fs::write(&roots, ROOTS).expect("a folder of our own");
    let both = ("operations = [\"div\"]", "operations = [\"div\", \"sqrt\"]");
    let own = (
        "[memory]",
        "[[element]]\nkind = \"root\"\noperations = [\"sqrt\"]\ncount = 2\nstages = 5\n\
         transfer = 2\n\n[memory]",
    );
    let pendulum = model("double-pendulum.mbs");
    let fused = "atomise,zero-removal,balance,cse,fma,dce,place";
    type Edits<'a> = &'a [(&'a str, &'a str)];
    let cases: [(&Path, &str, Edits<'_>, &[&str]); 4] = [
        (&roots, "solver", &[both], &[]),
        (&roots, "solver", &[own], &["--crossbar", "pruned"]),
        (&pendulum, "fused", &[], &["--passes", fused]),
        (&pendulum, "side-split", &[], &["--crossbar", "pruned"]),
    ];
    for (input, name, edits, more) in cases {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let machine = machine(folder.path(), name, 2, edits);
        build(folder.path(), input, &machine, more);
        for verdict in verdicts(folder.path(), HardwareSimulator::Icarus, &[Door::Bus]) {
            assert!(count(&verdict, " results compared") >= 3 * 18, "{verdict}");
        }
    }
}

/// The program that ships as Robotran's file, and the bogie of the thesis.
#[test]
fn real_programs_are_right_in_icarus_verilog() {
    if !is_there(HardwareSimulator::Icarus) {
        return;
    }
    let suspension =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension/mbs_dirdyna_suspension.m");
    let folder = tempfile::tempdir().expect("a temporary folder");
    build(folder.path(), &suspension, "de10-nano", &["--runs", "2"]);
    verdicts(
        folder.path(),
        HardwareSimulator::Icarus,
        &[Door::Configured],
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    build(
        folder.path(),
        &model("bogie.mbs"),
        "side-split",
        &["--runs", "1"],
    );
    for verdict in verdicts(
        folder.path(),
        HardwareSimulator::Icarus,
        &[Door::Configured],
    ) {
        assert!(count(&verdict, " results compared") > 3000, "{verdict}");
    }
}

/// Both benches in Verilator, and `--check`.
#[test]
fn real_programs_are_right_in_verilator() {
    if !is_there(HardwareSimulator::Verilator) {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = folder.path().display().to_string();
    let input = model("bogie.mbs").display().to_string();
    let words = [
        "rtl",
        &input,
        "--passes",
        PASSES,
        "--machine",
        "thesis",
        "-o",
        &output,
    ];
    let said = robovec(&[&words[..], &["--check", "verilator"]].concat());
    let text = String::from_utf8_lossy(&said.stdout).into_owned();
    let errors = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{text}{errors}");
    let passed = text
        .lines()
        .filter(|line| line.starts_with("PASS dirdyna, Verilator"));
    assert_eq!(passed.count(), 3, "{text}");
}

#[test]
fn the_verilog_bench_runs_in_verilator_as_well() {
    if !is_there(HardwareSimulator::VerilatorVerilog) {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let machine = machine(folder.path(), "side-split", 1, &[]);
    build(folder.path(), &model("double-pendulum.mbs"), &machine, &[]);
    let there = verdicts(
        folder.path(),
        HardwareSimulator::VerilatorVerilog,
        HardwareSimulator::Verilator.doors(),
    );
    // Everything is deterministic, so both simulators count the same clocks.
    if is_there(HardwareSimulator::Icarus) {
        assert_eq!(
            verdicts(
                folder.path(),
                HardwareSimulator::Icarus,
                HardwareSimulator::Verilator.doors()
            ),
            there
        );
    }
}

/// Message of the bench about hardware that is not right.
fn mismatch(folder: &Path, what: &str) -> String {
    match check(
        &folder.join("tb"),
        &folder.join("rtl"),
        HardwareSimulator::Icarus,
        &[Door::Bus],
    ) {
        Err(CheckFailure::Mismatch(said)) => said,
        Err(other) => panic!("{what}: {other}"),
        Ok(checked) => panic!("{what} was not seen: {:?}", checked.verdicts),
    }
}

/// Images with one wrong field in one word: the bench must find each, and the
/// first mismatch must name an operation or an output.
#[test]
fn planted_faults_in_images_are_caught() {
    if !is_there(HardwareSimulator::Icarus) {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let machine = machine(folder.path(), "side-split", 2, &[]);
    build(
        folder.path(),
        &model("quarter-car.mbs"),
        &machine,
        &["--runs", "1"],
    );
    let right = Loaded::read(folder.path());
    let sources = right.manifest.sources.len() as u64;
    let write = |loaded: &Loaded| {
        loaded
            .find("left.write0.enable", 8)
            .expect("there are writes")
    };

    let mut faults: Vec<(&str, Loaded)> = Vec::new();
    let mut wrong = right.clone();
    let (element, cycle) = write(&wrong);
    let select = wrong.get(element, cycle, "left.write0.select");
    wrong.set(element, cycle, "left.write0.select", (select + 1) % sources);
    faults.push(("another source", wrong));

    let mut wrong = right.clone();
    wrong.set(element, cycle, "left.write0.enable", 0);
    faults.push(("a write left out", wrong));

    let mut wrong = right.clone();
    for field in ["enable", "address", "select"].map(|f| format!("left.write0.{f}")) {
        let value = wrong.get(element, cycle, &field);
        wrong.set(element, cycle + 1, &field, value);
        wrong.set(element, cycle, &field, 0);
    }
    faults.push(("a write one cycle late", wrong));

    let mut wrong = right.clone();
    let address = wrong.get(element, cycle, "left.write0.address");
    wrong.set(element, cycle, "left.write0.address", address ^ 1);
    faults.push(("a write to another word", wrong));

    let mut wrong = right.clone();
    let (element, cycle) = wrong.find("issue", 20).expect("there are operations");
    let address = wrong.get(element, cycle, "read.right");
    wrong.set(element, cycle, "read.right", address ^ 1);
    faults.push(("an operand from another word", wrong));

    let mut wrong = right.clone();
    let (element, cycle) = wrong.find("operation", 20).expect("there are differences");
    wrong.set(element, cycle, "operation", 0);
    faults.push(("a sum instead of a difference", wrong));

    let mut wrong = right.clone();
    let (element, cycle) = wrong
        .find("buffer.write.enable", 0)
        .expect("buffers are used");
    wrong.set(element, cycle, "buffer.write.enable", 0);
    faults.push(("a result that does not reach its buffer", wrong));

    for (what, wrong) in faults {
        wrong.write(folder.path());
        let said = mismatch(folder.path(), what);
        let named = said.contains(", on its bus in cycle ") || said.contains("output ");
        assert!(named, "{what}: {said}");
        // The equation is told as well.
        assert!(
            !said.contains("on its bus") || said.contains(" = "),
            "{what}: {said}"
        );
    }
    right.write(folder.path());
    verdicts(folder.path(), HardwareSimulator::Icarus, &[Door::Bus]);
}

/// Faults of a hardware designer, as replacements in the generated Verilog.
const HARDWARE_FAULTS: &[(&str, &str, &str, &str)] = &[
    (
        "operands swapped",
        "pe_split.v",
        ".read_address(left_address)",
        ".read_address(right_address)",
    ),
    (
        "a port with the select of another",
        "robovec_crossbar.v",
        ".select(selects[8:6])",
        ".select(selects[5:3])",
    ),
    (
        "an adder with a stage too many",
        "robovec_element_add.v",
        ".EXTRA(0)",
        ".EXTRA(1)",
    ),
    (
        "a clock in which the status is neither running nor done",
        "host_window.v",
        "running | start | finished",
        "running | start",
    ),
    (
        "a program that ends one cycle early",
        "sequencer.v",
        "left <= cycles - 1'b1;",
        "left <= cycles - 2'd2;",
    ),
    (
        "an instruction memory that is one word off",
        "instruction_memory.v",
        ".read_address(fetch_address)",
        ".read_address(fetch_address + 1'b1)",
    ),
    (
        "a buffer that is written in every cycle",
        "result_buffer.v",
        "if (write & advance)",
        "if (advance)",
    ),
];

#[test]
fn planted_faults_in_the_machine_are_caught() {
    if !is_there(HardwareSimulator::Icarus) {
        return;
    }
    for &(what, file, right, wrong) in HARDWARE_FAULTS {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let machine = machine(folder.path(), "side-split", 2, &[]);
        build(
            folder.path(),
            &model("quarter-car.mbs"),
            &machine,
            &["--runs", "1"],
        );
        replace(&folder.path().join("rtl").join(file), right, wrong);
        mismatch(folder.path(), what);
    }
}
