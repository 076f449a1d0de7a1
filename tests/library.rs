//! The examples of the library crates agree with their first lines.
//!
//! `cargo test` builds examples beside the tests; where only a test was built
//! they may be missing, and a remark is printed.

use crate::support::files::tree;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// Folder in which examples are built.
fn built(name: &str) -> PathBuf {
    let program = std::env::current_exe().expect("a test knows its program");
    let folder = program
        .ancestors()
        .nth(2)
        .expect("it lies in target/PROFILE/deps");
    folder.join("examples").join(name)
}

/// The files of the examples of all crates.
fn examples() -> Vec<PathBuf> {
    let folders = [
        "examples",
        "ir/num/examples",
        "ir/examples",
        "passes/analysis/examples",
        "passes/rules/examples",
        "passes/framework/examples",
        "passes/schedule/examples",
        "passes/cgen/examples",
        "passes/fpga/examples",
        "passes/examples",
    ];
    let of = |folder: &str| {
        let entries = fs::read_dir(tree(folder)).expect("every library crate has examples");
        let paths = entries.map(|entry| entry.expect("a readable folder").path());
        let mut sources: Vec<PathBuf> = paths
            .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
            .collect();
        assert!(!sources.is_empty(), "{folder} has no example");
        sources.sort();
        sources
    };
    folders.into_iter().flat_map(of).collect()
}

#[test]
fn examples_run_as_they_say() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for source in examples() {
        let name = source
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let program = built(&name);
        if !program.exists() {
            eprintln!("SKIPPED: the example {name} is not built");
            continue;
        }
        let text = fs::read_to_string(&source).expect("it is readable");
        let mark = format!("--example {name} -- ");
        let line = text.lines().find_map(|line| line.split_once(&mark));
        let (_, line) = line.unwrap_or_else(|| panic!("{name} does not say how to run it"));
        let arguments = line
            .replace('\'', "")
            .replace("/tmp", &folder.path().to_string_lossy());
        let output = Command::new(&program)
            .args(arguments.split_whitespace())
            .current_dir(tree(""))
            .output()
            .expect("it starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name} {arguments}: {message}");
        assert!(!output.stdout.is_empty(), "{name} prints nothing");
    }
}
