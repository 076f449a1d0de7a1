//! The programs as a user meets them: exit codes, messages, outputs that are
//! whole or absent, the same bytes every time.

mod instruments;
mod jobs;
mod refusals;

use crate::support::programs::stderr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("examples")
        .join(name)
}

fn opt() -> Command {
    Command::new(env!("CARGO_BIN_EXE_robovec-opt"))
}

fn run(command: &mut Command) -> Output {
    command.output().expect("the program starts")
}

const SUSPENSION: &str = "suspension/mbs_dirdyna_suspension.m";

const PIPELINE: &str = "-passes=atomise,zero-removal,balance,cse,dce,place";

/// Runs on a wrong input: the exit code is 1, the message has the words, and no
/// file is written.
fn refused(input: &[u8], name: &str, arguments: &[&str], words: &[&str]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    fs::write(&path, input).expect("room for the input");
    let result = folder.path().join("result.rvir");
    let output = run(opt().arg(&path).args(arguments).arg("-o").arg(&result));
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{name}: {message}");
    for word in words {
        assert!(message.contains(word), "{name}: no '{word}' in\n{message}");
    }
    assert!(!message.contains("panicked"), "{message}");
    assert!(
        message.len() < 100_000,
        "{name}: a message of {} bytes",
        message.len()
    );
    assert!(output.stdout.is_empty());
    let left: Vec<_> = fs::read_dir(folder.path()).expect("the folder").collect();
    assert_eq!(left.len(), 1, "{name}: something half-written was left");
}
