//! The program `robovec` and the example models, as tests of the command line
//! use them.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A model that ships.
pub(crate) fn model(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("examples/models")
        .join(name)
}

/// Runs `robovec`.
pub(crate) fn robovec(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_robovec"))
        .args(arguments)
        .output()
        .expect("the program starts")
}
