//! `robovec check` on the pairs of tests/check: `NAME.before.rvir` and
//! `NAME.after.rvir`. A first line `// RUN: OPTIONS` gives options; the
//! expected output is beside them. Bless with INSTA_UPDATE=always.

use crate::support::files::{compare_with_record, each, list, name, tree};
use std::process::Command;

/// The pair that a file begins, if it is the function before.
fn pair(name: &str) -> Option<&str> {
    name.strip_suffix(".before.rvir")
}

#[test]
fn pairs_of_functions_are_compared_as_their_snapshots_say() {
    let folder = tree("tests/check");
    let files = list("tests/check", &["rvir"]);
    let pairs = files.iter().filter(|path| pair(&name(path)).is_some());
    assert!(pairs.count() >= 9, "{files:?}");
    each("tests/check", &["rvir"], |path| {
        let before = name(path);
        let Some(name) = pair(&before) else {
            return;
        };
        let text = std::fs::read_to_string(path).expect("the file");
        let first = text.lines().next().unwrap_or_default();
        let options = first.strip_prefix("// RUN:").unwrap_or_default();
        // In the folder of the files, so that no message holds a path.
        let output = Command::new(env!("CARGO_BIN_EXE_robovec"))
            .args(["check", &before, &format!("{name}.after.rvir")])
            .args(options.split_whitespace())
            .current_dir(&folder)
            .output()
            .expect("the program starts");
        let shown = format!(
            "{}--- messages, exit code {:?}\n{}",
            String::from_utf8_lossy(&output.stdout),
            output.status.code(),
            String::from_utf8_lossy(&output.stderr)
        );
        compare_with_record(&folder, name, &shown);
    });
}
