//! Another program on existing hardware: the messages, files and runs of
//! `robovec rtl --fits`.

use crate::support::programs::{model, robovec};
use robovec::rtl::HardwareSimulator;
use std::process::Output;

const PASSES: &str = "atomise,zero-removal,balance,cse,dce,place";

fn rtl(name: &str, arguments: &[&str]) -> Output {
    let input = model(name).display().to_string();
    robovec(&[&["rtl", &input], arguments].concat())
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Hardware for the larger of two models, with four elements.
fn build(folder: &str) {
    let built = rtl(
        "quarter-car.mbs",
        &["--machine", "side-split", "--passes", PASSES, "-o", folder],
    );
    assert!(built.status.success(), "{}", text(&built.stderr));
}

#[test]
fn images_of_another_model_run_on_hardware_that_is_there() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let hardware = folder.path().join("hardware").display().to_string();
    let images = folder.path().join("images").display().to_string();
    build(&hardware);
    let fits = ["--fits", &hardware, "--passes", PASSES, "-o", &images];
    let said = rtl("double-pendulum.mbs", &fits);
    assert!(said.status.success(), "{}", text(&said.stderr));
    let told = text(&said.stdout);
    assert!(told.contains("fits the hardware with hash"), "{told}");
    assert!(told.contains("cycles: "), "{told}");
    assert!(!folder.path().join("images/rtl").exists());
    if let Some(program) = HardwareSimulator::Icarus.missing() {
        eprintln!("SKIPPED: {program} is not installed, the images were not run");
        return;
    }
    let check = [
        "--check",
        "iverilog",
        "--through",
        "bus,avalon",
        "--runs",
        "2",
    ];
    let checked = rtl("double-pendulum.mbs", &[&fits[..], &check].concat());
    let verdicts = text(&checked.stdout);
    assert!(checked.status.success(), "{verdicts}");
    assert_eq!(verdicts.matches("PASS").count(), 2, "{verdicts}");
}

#[test]
fn a_program_that_does_not_fit_is_told_why() {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let hardware = folder.path().join("hardware").display().to_string();
    let images = folder.path().join("images");
    build(&hardware);
    let place = ["--fits", &hardware, "--passes", PASSES];
    let said = rtl(
        "bogie.mbs",
        &[&place[..], &["-o", &images.display().to_string()]].concat(),
    );
    assert_eq!(said.status.code(), Some(1));
    let told = text(&said.stderr);
    assert!(told.contains("does not fit the hardware"), "{told}");
    assert!(told.contains("cycles, and the hardware has"), "{told}");
    assert!(!images.exists());
}

#[test]
fn equations_are_not_hardware_yet() {
    let said = rtl(
        "quarter-car.mbs",
        &["--machine", "side-split", "-o", "never-written"],
    );
    assert_eq!(said.status.code(), Some(1));
    let told = text(&said.stderr);
    assert!(told.contains("hardware runs placed programs"), "{told}");
    assert!(told.contains("--passes atomise"), "{told}");
}
