//! The programs and the example models, for tests of the command line.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A model that ships.
pub(crate) fn model(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("examples/models")
        .join(name)
}

/// Runs `robovec` in the root of the repository.
pub(crate) fn robovec(arguments: &[&str]) -> Output {
    robovec_in(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// Runs `robovec` in a folder.
pub(crate) fn robovec_in(folder: &Path, arguments: &[&str]) -> Output {
    run_in(folder, env!("CARGO_BIN_EXE_robovec"), arguments)
}

/// Runs `robovec-opt` in a folder.
pub(crate) fn opt_in(folder: &Path, arguments: &[&str]) -> Output {
    run_in(folder, env!("CARGO_BIN_EXE_robovec-opt"), arguments)
}

fn run_in(folder: &Path, program: &str, arguments: &[&str]) -> Output {
    Command::new(program)
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// Messages of a run that fails.
pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A text in one line, before it is folded for a terminal.
pub(crate) fn unfolded(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Output of a run that must succeed.
pub(crate) fn said(output: &Output) -> String {
    assert!(output.status.success(), "{}", stderr(output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// At most 20 lines of 80 columns.
pub(crate) fn assert_fits_a_screen(text: &str) {
    assert!(text.lines().count() <= 20, "{text}");
    // Paths of temporary folders are as long as they are.
    let is_wide = |line: &&str| line.chars().count() > 80 && !line.contains("/tmp");
    assert_eq!(text.lines().find(is_wide), None);
}
