//! `robovec check` on the pairs of tests/check: `NAME.before.rvir` and
//! `NAME.after.rvir`. A first line `// RUN: OPTIONS` gives options; what is
//! printed stands beside them. Bless with INSTA_UPDATE=always.

use std::path::Path;
use std::process::Command;

#[test]
fn pairs_of_functions_are_compared_as_their_snapshots_say() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/check");
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .expect("the folder")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| Some(name.strip_suffix(".before.rvir")?.to_owned()))
        .collect();
    names.sort();
    assert!(names.len() >= 9, "{names:?}");
    for name in names {
        let before = format!("{name}.before.rvir");
        let text = std::fs::read_to_string(folder.join(&before)).expect("the file");
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
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path(&folder);
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings.bind(|| insta::assert_snapshot!(name, shown));
    }
}
