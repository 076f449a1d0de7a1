//! Another program on hardware that is there: what `robovec rtl --fits` says,
//! writes and runs.

use std::path::Path;
use std::process::{Command, Output};

const PASSES: &str = "atomise,zero-removal,balance,cse,dce,place";

fn rtl(model: &str, arguments: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("rtl")
        .arg(root.join("examples/models").join(model))
        .args(arguments)
        .output()
        .expect("the program can be started")
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

fn is_installed(tool: &str) -> bool {
    let found = Command::new(tool).arg("-V").output().is_ok();
    if !found {
        assert!(
            std::env::var_os("CI").is_none(),
            "{tool} is not installed, and CI runs hardware"
        );
        println!("skipped: {tool} is not installed");
    }
    found
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
    if !is_installed("iverilog") {
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
