//! What the file tests share: one trial per input file, expected text beside
//! it.
//!
//! `INSTA_UPDATE=always cargo test` writes what the programs say now as the
//! expected text; `git diff` shows what that changes.

use libtest_mimic::{Arguments, Failed, Trial};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs one trial per file of a folder under `tests/` (and the folders below
/// it) with one of these extensions, and compares what `produce` says with
/// the `.snap` file beside it.
pub(crate) fn run(
    folder: &str,
    extensions: &[&str],
    produce: fn(&Path, &str) -> String,
) -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(folder);
    let mut files = Vec::new();
    collect(&root, extensions, &mut files);
    files.sort();
    assert!(!files.is_empty(), "no test files in {}", root.display());
    let trials = files
        .into_iter()
        .map(|path| {
            let name = path
                .strip_prefix(&root)
                .unwrap_or(&path)
                .display()
                .to_string();
            Trial::test(name, move || trial(&path, produce))
        })
        .collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

fn collect(folder: &Path, extensions: &[&str], files: &mut Vec<PathBuf>) {
    let entries = fs::read_dir(folder).expect("the test folders are in the repository");
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        let extension = path.extension().and_then(|extension| extension.to_str());
        if path.is_dir() {
            collect(&path, extensions, files);
        } else if extension.is_some_and(|extension| extensions.contains(&extension)) {
            files.push(path);
        }
    }
}

fn trial(path: &Path, produce: fn(&Path, &str) -> String) -> Result<(), Failed> {
    let bytes = fs::read(path).map_err(|error| Failed::from(error.to_string()))?;
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let produced = produce(path, &text);
    let name = path
        .file_name()
        .expect("a file has a name")
        .to_string_lossy()
        .into_owned();
    insta::with_settings!({
        snapshot_path => path.parent().expect("a file lies in a folder"),
        prepend_module_to_snapshot => false,
        omit_expression => true,
    }, {
        insta::assert_snapshot!(name, produced);
    });
    Ok(())
}

/// The words behind `// RUN:` on the first line of a test file.
pub(crate) fn directive(text: &str) -> &str {
    let first = text.lines().next().unwrap_or("");
    first
        .trim_start_matches(['/', '%', '#', ' '])
        .strip_prefix("RUN:")
        .expect("the first line of a test file says what to run")
        .trim()
}
