//! The adapters of the host bus under their benches, and the benches under
//! planted faults.
//!
//! The benches are run with Icarus Verilog and Verilator where installed; where
//! one is missing, a line on the standard error reports it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn hardware(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("hdl/host")
        .join(file)
}

fn is_installed(tool: &str, version: &str) -> bool {
    let found = Command::new(tool).arg(version).output().is_ok();
    if !found {
        eprintln!("SKIPPED: {tool} is not installed, nothing was checked with it");
    }
    found
}

/// Compiles the bench of an adapter with a text of the adapter and runs it.
fn icarus(folder: &Path, adapter: &str, text: &str) -> Output {
    let source = folder.join("adapter.v");
    let program = folder.join("bench.vvp");
    fs::write(&source, text).expect("a folder of our own");
    let compiled = Command::new("iverilog")
        .args(["-g2005", "-Wall", "-Wno-timescale", "-o"])
        .args([&program, &hardware("bench/host_bus_model.v")])
        .args([&hardware(&format!("bench/{adapter}_bench.v")), &source])
        .output()
        .expect("it is installed");
    let warnings = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{warnings}");
    assert!(warnings.is_empty(), "{warnings}");
    Command::new("vvp")
        .arg("-N")
        .arg(&program)
        .output()
        .expect("it is installed")
}

fn text_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

const ADAPTERS: [&str; 2] = ["robovec_avalon", "robovec_axi4lite"];

#[test]
fn adapters_pass_their_benches_in_icarus_verilog() {
    if !is_installed("iverilog", "-V") {
        return;
    }
    for adapter in ADAPTERS {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let text = fs::read_to_string(hardware(&format!("{adapter}.v"))).expect("it ships");
        let output = icarus(folder.path(), adapter, &text);
        let said = text_of(&output);
        assert!(output.status.success(), "{said}");
        assert!(said.starts_with(&format!("PASS {adapter}")), "{said}");
    }
}

#[test]
fn adapters_pass_their_benches_in_verilator() {
    if !is_installed("verilator", "--version") {
        return;
    }
    for adapter in ADAPTERS {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let source = hardware(&format!("{adapter}.v"));
        let lint = Command::new("verilator")
            .args(["--lint-only", "-Wall"])
            .arg(&source)
            .output()
            .expect("it is installed");
        let warnings = String::from_utf8_lossy(&lint.stderr);
        assert!(lint.status.success() && warnings.is_empty(), "{warnings}");
        let bench = format!("{adapter}_bench");
        let built = Command::new("verilator")
            .args([
                "--binary",
                "-Wno-lint",
                "-CFLAGS",
                "-O0",
                "--top-module",
                &bench,
            ])
            .arg("--Mdir")
            .arg(folder.path())
            .args([&hardware("bench/host_bus_model.v"), &source])
            .arg(hardware(&format!("bench/{bench}.v")))
            .output()
            .expect("it is installed");
        let errors = String::from_utf8_lossy(&built.stderr);
        assert!(built.status.success(), "{errors}");
        let output = Command::new(folder.path().join(format!("V{bench}")))
            .output()
            .expect("it was built");
        let said = text_of(&output);
        assert!(output.status.success(), "{said}");
        assert!(said.starts_with(&format!("PASS {adapter}")), "{said}");
    }
}

/// Faults that hardware people make, as replacements in the text.
const FAULTS: [(&str, &str, &str, &str); 14] = [
    (
        "robovec_axi4lite",
        "a response that is not held",
        "else if (s_axi_bready) begin",
        "else begin",
    ),
    (
        "robovec_axi4lite",
        "read data that are not held",
        "else if (s_axi_rready) begin",
        "else begin",
    ),
    (
        "robovec_axi4lite",
        "a write without its data",
        "write_address_held & write_data_held & ~s_axi_bvalid",
        "write_address_held & ~s_axi_bvalid",
    ),
    (
        "robovec_axi4lite",
        "a response over one that waits",
        "write_data_held & ~s_axi_bvalid;",
        "write_data_held;",
    ),
    (
        "robovec_axi4lite",
        "read data over some that wait",
        "~reading & ~s_axi_rvalid;",
        "~reading;",
    ),
    (
        "robovec_axi4lite",
        "a second read under way",
        "read_address_held & ~reading &",
        "read_address_held &",
    ),
    (
        "robovec_axi4lite",
        "read and write together",
        "assign host_read      = read_turn",
        "assign host_read      = read_ready",
    ),
    (
        "robovec_axi4lite",
        "an address taken over another",
        "awake & ~write_address_held",
        "awake",
    ),
    (
        "robovec_axi4lite",
        "strobes ignored",
        "write_in_range & all_strobes;",
        "write_in_range;",
    ),
    (
        "robovec_axi4lite",
        "no error beyond the end",
        "s_axi_rresp  <= SLVERR;",
        "s_axi_rresp  <= OKAY;",
    ),
    (
        "robovec_axi4lite",
        "an answer in the same clock lost",
        "host_readvalid & (reading | host_read)",
        "host_readvalid & reading",
    ),
    (
        "robovec_avalon",
        "no waiting behind a read",
        "pending | reset;",
        "reset;",
    ),
    (
        "robovec_avalon",
        "byte enables ignored",
        " & (&avs_byteenable);",
        ";",
    ),
    (
        "robovec_avalon",
        "reads beyond the end on the bus",
        "avs_read & ~avs_waitrequest & in_range;",
        "avs_read & ~avs_waitrequest;",
    ),
];

#[test]
fn benches_catch_planted_faults() {
    if !is_installed("iverilog", "-V") {
        return;
    }
    for (adapter, what, right, wrong) in FAULTS {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let text = fs::read_to_string(hardware(&format!("{adapter}.v"))).expect("it ships");
        assert_eq!(text.matches(right).count(), 1, "{right}");
        let output = icarus(folder.path(), adapter, &text.replace(right, wrong));
        let said = text_of(&output);
        assert!(!output.status.success(), "{adapter} with {what}: {said}");
        assert!(said.contains("FAIL"), "{adapter} with {what}: {said}");
    }
}
