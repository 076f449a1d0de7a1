//! File tests: every file of a folder is processed, and the output is compared
//! with the text recorded beside it.
//!
//! `INSTA_UPDATE=always cargo test --workspace` records the present output;
//! `git diff` shows the changes.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// A path of the repository, from its root.
pub(crate) fn tree(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The files of a folder of the repository with one of these extensions, in
/// order.
pub(crate) fn list(folder: &str, extensions: &[&str]) -> Vec<PathBuf> {
    let root = tree(folder);
    let entries = fs::read_dir(&root).expect("the folders of tests are in the repository");
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|path| {
            let extension = path.extension().and_then(|extension| extension.to_str());
            path.is_file() && extension.is_some_and(|extension| extensions.contains(&extension))
        })
        .collect();
    files.sort();
    assert!(!files.is_empty(), "no test files in {}", root.display());
    files
}

/// Tries every file of a folder of the repository with one of these
/// extensions, and fails with the names of all files on which `attempt`
/// panics.
pub(crate) fn each(folder: &str, extensions: &[&str], mut attempt: impl FnMut(&Path)) {
    let files = list(folder, extensions);
    let failed: Vec<String> = files
        .iter()
        .filter(|path| catch_unwind(AssertUnwindSafe(|| attempt(path))).is_err())
        .map(|path| name(path))
        .collect();
    assert!(
        failed.is_empty(),
        "{} of {} files in {folder} failed: {}",
        failed.len(),
        files.len(),
        failed.join(", ")
    );
}

/// The name of a file, without its folder.
pub(crate) fn name(path: &Path) -> String {
    let name = path.file_name().expect("a file has a name");
    name.to_string_lossy().into_owned()
}

/// The name of a file, without its folder and extension.
pub(crate) fn stem(path: &Path) -> String {
    let stem = path.file_stem().expect("a file has a name");
    stem.to_string_lossy().into_owned()
}

/// Compares a text with `NAME.snap` in a folder.
pub(crate) fn compare_with_record(folder: &Path, name: &str, text: &str) {
    insta::with_settings!({
        snapshot_path => folder,
        prepend_module_to_snapshot => false,
        omit_expression => true,
    }, {
        insta::assert_snapshot!(name, text);
    });
}
