//! The floating-point operators of `hdl/cores` in simulation, against other
//! implementations of the same arithmetic.
//!
//! A vector is a set of operands and the word that must come out. The short
//! tests run some thousands of them through iverilog, for a few latencies and
//! formats, and through planted mutants, each of which must be noticed. The
//! long one runs three million per operator and latency through verilator:
//!
//!     cargo test --release -p robovec-fpga --features softfloat --test all rtl_cores:: -- --ignored --nocapture --test-threads 1
//!
//! In every run `enable` is low at some cycles, while other operands are at the
//! inputs: a result must come exactly as many enabled clocks after its operands
//! as the operator has stages, and must stay while the operator is disabled.

mod mutants;
mod reference;
mod simulators;
mod vectors;

use robovec_fpga::rtl::cores::OperatorCore;
use robovec_ir::machine::{Device, DeviceFamily};
use robovec_num::NumberFormat;
use simulators::{Bench, Simulator};

/// A format with these numbers of exponent and mantissa bits.
const fn float(exponent: u32, mantissa: u32, subnormals: bool) -> NumberFormat {
    NumberFormat {
        exponent,
        mantissa,
        subnormals,
    }
}

const BINARY32: NumberFormat = NumberFormat::BINARY32;
const BINARY32_FLUSHED: NumberFormat = float(8, 23, false);

fn device() -> &'static Device {
    DeviceFamily::default().device()
}

/// The devices for which the Verilog of an operator differs by more than the
/// places of its registers.
fn devices(core: OperatorCore) -> Vec<&'static Device> {
    let all = DeviceFamily::ALL.map(DeviceFamily::device);
    if core.device_parameters(device()).is_empty() {
        vec![device()]
    } else {
        all.to_vec()
    }
}

/// Reports loudly that a simulator is missing.
fn is_missing(simulator: Simulator) -> bool {
    let missing = !simulator.is_installed();
    if missing {
        eprintln!(
            "SKIPPED: {simulator:?} is not installed, so hardware was not simulated \
             (Debian: apt-get install iverilog verilator)"
        );
    }
    missing
}

/// Runs vectors through a core and asserts that all results are equal.
fn check(
    simulator: Simulator,
    core: OperatorCore,
    format: NumberFormat,
    stages: u32,
    count: usize,
) {
    for device in devices(core) {
        check_on(device, simulator, (core, format), stages, count);
    }
}

fn check_on(
    device: &'static Device,
    simulator: Simulator,
    (core, format): (OperatorCore, NumberFormat),
    stages: u32,
    count: usize,
) {
    let vectors = vectors::vectors(core, format, count, 1);
    let bench = Bench::new(core, format, stages, device);
    let report = bench.run(simulator, &vectors);
    assert_eq!(
        (report.checked, report.wrong),
        (count, 0),
        "{core:?} {format:?} {stages} stages, {}:\n{}",
        device.name,
        report.text
    );
}

/// One register, a handful, one at every cut, and more than that.
fn stages(core: OperatorCore, format: NumberFormat) -> [u32; 4] {
    let places = core.steps(format, device()).len() as u32;
    [1, places.min(5), places, places + 2]
}

fn short(core: OperatorCore) {
    if is_missing(Simulator::Iverilog) {
        return;
    }
    for format in [BINARY32, BINARY32_FLUSHED] {
        for stages in stages(core, format) {
            let count = if stages == 5 { 5_000 } else { 500 };
            check(Simulator::Iverilog, core, format, stages, count);
        }
    }
}

#[test]
fn sums_are_right() {
    short(OperatorCore::Add);
}

#[test]
fn products_are_right() {
    short(OperatorCore::Multiply);
}

#[test]
fn quotients_are_right() {
    short(OperatorCore::Divide);
}

#[test]
fn roots_are_right() {
    short(OperatorCore::Root);
}

#[test]
fn fused_results_are_right() {
    short(OperatorCore::Fused);
}

/// The smallest and the widest format, narrow exponents with long mantissas and
/// the reverse.
const FORMATS: [(u32, u32); 8] = [
    (2, 1),
    (2, 9),
    (3, 14),
    (5, 10),
    (8, 7),
    (11, 3),
    (8, 17),
    (11, 52),
];

#[test]
fn every_format_is_right() {
    if is_missing(Simulator::Iverilog) {
        return;
    }
    for (exponent, mantissa) in FORMATS {
        for core in OperatorCore::ALL {
            for subnormals in [true, false] {
                let format = float(exponent, mantissa, subnormals);
                let places = core.steps(format, device()).len() as u32;
                for stages in [3, places] {
                    check(Simulator::Iverilog, core, format, stages, 150);
                }
            }
        }
    }
}

#[test]
fn mutants_are_noticed() {
    if is_missing(Simulator::Iverilog) {
        return;
    }
    let survivors: Vec<String> = mutants::MUTANTS
        .iter()
        .filter(|mutant| !mutant.is_noticed(20_000))
        .map(|mutant| format!("{}: {}", mutant.file, mutant.what))
        .collect();
    assert!(survivors.is_empty(), "not noticed: {survivors:#?}");
}

/// The latencies of the thesis' Tables 1.1 and 1.2, and some for the rest.
fn tabled(core: OperatorCore) -> &'static [u32] {
    match core {
        OperatorCore::Add => &[1, 2, 3, 4, 5, 6, 7, 9, 10, 14],
        OperatorCore::Multiply => &[2, 3, 4, 5, 8, 9],
        OperatorCore::Divide => &[1, 8, 16, 28],
        OperatorCore::Root => &[1, 8, 16, 28],
        OperatorCore::Fused => &[1, 5, 13, 20],
    }
}

/// Every tabled latency of binary32, and other formats. `ROBOVEC_VECTORS` sets
/// another number of vectors per line than three million.
fn long(core: OperatorCore) {
    if is_missing(Simulator::Verilator) {
        return;
    }
    let count = std::env::var("ROBOVEC_VECTORS").map_or(3_000_000, |text| {
        text.parse().expect("ROBOVEC_VECTORS is a number")
    });
    println!("core      format            stages   vectors   wrong");
    let mut wrong = 0;
    for format in [BINARY32, BINARY32_FLUSHED] {
        let vectors = vectors::vectors(core, format, count, 2);
        for &stages in tabled(core) {
            wrong += line(core, format, stages, &vectors);
        }
    }
    for format in [
        NumberFormat::BINARY64,
        float(11, 52, false),
        float(5, 10, true),
        float(8, 17, true),
    ] {
        let vectors = vectors::vectors(core, format, count, 2);
        wrong += line(core, format, 10, &vectors);
    }
    assert_eq!(wrong, 0);
}

#[test]
#[ignore = "minutes of simulation, in a release build"]
fn millions_of_sums() {
    long(OperatorCore::Add);
}

#[test]
#[ignore = "minutes of simulation, in a release build"]
fn millions_of_products() {
    long(OperatorCore::Multiply);
}

#[test]
#[ignore = "minutes of simulation, in a release build"]
fn millions_of_quotients() {
    long(OperatorCore::Divide);
}

#[test]
#[ignore = "minutes of simulation, in a release build"]
fn millions_of_roots() {
    long(OperatorCore::Root);
}

#[test]
#[ignore = "minutes of simulation, in a release build"]
fn millions_of_fused_results() {
    long(OperatorCore::Fused);
}

/// Runs and prints one line of the table.
fn line(
    core: OperatorCore,
    format: NumberFormat,
    stages: u32,
    vectors: &[vectors::Vector],
) -> usize {
    let mut wrong = 0;
    for device in devices(core) {
        let bench = Bench::new(core, format, stages, device);
        let report = bench.run(Simulator::Verilator, vectors);
        println!(
            "{:<9} {:<17} {stages:>6} {:>9} {:>7} {}",
            core.name(),
            robovec_ir::Format::Float(format).to_string(),
            report.checked,
            report.wrong,
            device.name
        );
        print!("{}", report.text);
        assert_eq!(report.checked, vectors.len(), "every vector is compared");
        wrong += report.wrong;
    }
    wrong
}
