//! Generated C, compiled and run.

use std::process::Command;

/// Output of the program that gcc makes of the `.c` files among these, without
/// a warning, and its success; none, with a remark, where there is no gcc.
pub(super) fn compiled_output(
    files: &[(String, String)],
    flags: &[&str],
    arguments: &[&str],
) -> Option<(String, bool)> {
    if Command::new("gcc").arg("--version").output().is_err() {
        eprintln!("no gcc: the generated C is not compiled");
        return None;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("a temporary file");
    }
    let names = files.iter().map(|(name, _)| name.as_str());
    let compiled = Command::new("gcc")
        .current_dir(folder.path())
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror"])
        .args(flags)
        .args(["-o", "program"])
        .args(names.filter(|name| name.ends_with(".c")))
        .arg("-lm")
        .output()
        .expect("gcc is there");
    let messages = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{messages}");
    let program = folder.path().join("program");
    let output = Command::new(program).args(arguments).output();
    let output = output.expect("it runs");
    let text = String::from_utf8(output.stdout).expect("text");
    Some((text, output.status.success()))
}
