//! Same input, same bytes: nothing that is written or printed depends on the
//! number of threads, the working directory or the run.

use crate::support::files::tree;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Threads of each run; each has its own working directory.
const THREADS: [&str; 3] = ["1", "2", "9"];

/// Results of a run: its output, and its files by their paths from the working
/// directory.
#[derive(PartialEq, Eq)]
struct Outcome {
    printed: Vec<u8>,
    files: BTreeMap<PathBuf, Vec<u8>>,
}

/// All files below a folder, by their relative paths.
pub(crate) fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a readable folder") {
            let path = entry.expect("a readable folder").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let content = fs::read(&path).expect("a readable file");
                let name = path.strip_prefix(folder).expect("it lies in the folder");
                found.insert(name.to_owned(), content);
            }
        }
    }
    found
}

/// Runs a program in an empty folder.
fn run(program: &str, arguments: &[&str], threads: &str) -> Outcome {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path().join(format!("with-{threads}"));
    fs::create_dir(&folder).expect("a folder of our own");
    let output = Command::new(program)
        .args(arguments)
        .env("RAYON_NUM_THREADS", threads)
        .current_dir(&folder)
        .output()
        .expect("the program starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {message}");
    Outcome {
        printed: output.stdout,
        files: files(&folder),
    }
}

/// Requires the same files from runs with every number of threads, and at least
/// this number of files.
fn same(program: &str, arguments: &[&str], least: usize) {
    let first = run(program, arguments, THREADS[0]);
    let count = first.files.len();
    assert!(count >= least, "{arguments:?}: {count} files");
    for threads in &THREADS[1..] {
        let other = run(program, arguments, threads);
        assert!(
            other.printed == first.printed,
            "{arguments:?} prints something else with {threads} threads"
        );
        let names = |outcome: &Outcome| outcome.files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&other), names(&first), "{arguments:?}");
        for (name, content) in &first.files {
            let name_shown = name.display();
            assert!(
                other.files[name] == *content,
                "{arguments:?}: {name_shown} is another with {threads} threads"
            );
        }
    }
}

fn path(of: &str) -> String {
    tree(of).display().to_string()
}

const OPT: &str = env!("CARGO_BIN_EXE_robovec-opt");
const ROBOVEC: &str = env!("CARGO_BIN_EXE_robovec");

#[test]
fn pipelines_give_the_same_bytes() {
    let input = path("examples/suspension/mbs_dirdyna_suspension.m");
    for pipeline in [
        "atomise,zero-removal,balance,cse,dce,place",
        "$shorten,place,codegen",
        "$ahead",
        "$cpu,codegen{target=c}",
        "$cpu,codegen{target=c superwords=auto}",
        "$cpu,codegen{target=batch}",
        "$cpu,codegen{target=mlir}",
        "atomise,zero-removal,balance,eqsat,cse,dce,factor,recurrence",
    ] {
        let pipeline = format!("-passes={pipeline}");
        // No report: it tells the time of every pass.
        same(OPT, &[&input, &pipeline, "-o", "out"], 1);
    }
}

#[test]
fn generated_equations_are_the_same_bytes() {
    let model = path("examples/models/four-bar.mbs");
    let arguments = ["gen", &model, "--function", "all", "--language", "c"];
    same(ROBOVEC, &[&arguments[..], &["-o", "out"]].concat(), 5);
}

#[test]
fn hardware_is_the_same_bytes() {
    let model = path("examples/models/double-pendulum.mbs");
    let pipeline = "atomise,zero-removal,balance,cse,dce,place";
    let arguments = ["rtl", &model, "--passes", pipeline, "--machine"];
    let arguments = [&arguments[..], &["side-split", "-o", "out"]].concat();
    same(ROBOVEC, &arguments, 10);
}

#[test]
fn sweeps_are_the_same_bytes() {
    let arguments = ["explore", "serial-3", "--adders=1,2", "--multipliers=1"];
    let arguments = [&arguments[..], &["--couples=3-3,6-4", "-o", "out"]].concat();
    same(ROBOVEC, &arguments, 4);
}

#[test]
fn studies_are_the_same_bytes() {
    let plan = path("tests/study/plans/suspension.toml");
    same(ROBOVEC, &["explore", "--plan", &plan, "-o", "out"], 10);
}
