//! The command that writes files, and its refusals.

use super::read_file;
use robovec::robotran::Language;
use robovec::robotran::write::{WriteOptions, write};
use robovec_ir::parse::parse_module;
use std::path::Path;
use std::process::Command;

/// `robovec check` accepts the C that robovec writes.
#[test]
fn check_compares_c_that_robovec_wrote() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension");
    let original = root.join("mbs_dirdyna_suspension.c");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let module = read_file(&original).expect("a good file");
    let written = write(&module, Language::C, &WriteOptions::default()).expect("it is C");
    let path = folder.path().join(&written[0].0);
    let check = |text: &str| {
        std::fs::write(&path, text).expect("a temporary file");
        Command::new(env!("CARGO_BIN_EXE_robovec"))
            .arg("check")
            .args([&original, &path])
            .output()
            .expect("it runs")
            .status
            .success()
    };
    assert!(check(&written[0].1));
    let place = written[0].1.find("*C2").expect("a product with a cosine");
    let mut changed = written[0].1.clone();
    changed.replace_range(place..place + 3, "*S2");
    assert!(!check(&changed));
}

fn refusal(text: &str) -> String {
    let module = parse_module("test", text).expect("a well-formed module");
    let error = write(&module, Language::C, &WriteOptions::default());
    error.expect_err("this cannot be written").to_string()
}

#[test]
fn what_cannot_be_written_is_refused() {
    assert!(refusal("").contains("no function"));
    let unknown =
        "function equation_2_1 equations {\n  in q[1..2]\n  out a[1..1]\n\n  a[1] = q[1]\n}\n";
    assert!(refusal(unknown).contains("equation_2_1"));
    let part = "function accelred_part_1 equations {\n  meta kind \"accelred\"\n  meta part \"1 of 2\"\n}\n";
    assert!(refusal(part).contains("part"));
    let scalar = "function invdyna equations {\n  in q[1..2]\n  out energy\n\n  energy = q[1]\n}\n";
    assert!(refusal(scalar).contains("energy"));
    let name =
        "function invdyna equations {\n  in while[1..2]\n  out Qq[1..1]\n\n  Qq[1] = while[1]\n}\n";
    assert!(refusal(name).contains("while"));
    let cycle = "function link equations {\n  in F1\n  out Z1\n  \
         call \"user_LinkForces\"(\"Z1\") -> \"F1\"\n\n  %Z1 = F1*F1\n\n  Z1 = %Z1\n}\n";
    assert!(refusal(cycle).contains("user_LinkForces"));
    let callee = "function link equations {\n  call \"printf\"(\"1\")\n}\n";
    assert!(refusal(callee).contains("printf"));
    let twice = "function sensor_1 equations {\n}\n\nfunction mbs_sensor_1 equations {\n}\n";
    assert!(refusal(twice).contains("same place"));
    let number =
        "function sensor equations {\n  in q[1..2]\n  out sens.P[1..3]\n\n  sens.P[1] = q[1]\n}\n";
    assert!(refusal(number).contains("_1, _2"));
}

#[test]
fn the_command_writes_files_and_names_them() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let input =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension/mbs_cons_hJ_suspension.m");
    let written = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("gen")
        .arg(&input)
        .args(["--language", "c", "--model", "other", "--zeros"])
        .args(["--passes", "atomise,cse,inline", "-o"])
        .arg(folder.path())
        .output()
        .expect("it runs");
    assert!(written.status.success());
    let names = String::from_utf8_lossy(&written.stdout).into_owned();
    assert_eq!(names.lines().count(), 2);
    let text = std::fs::read_to_string(folder.path().join("mbs_cons_hJ_other.c"));
    let text = text.expect("the file is there");
    assert!(text.contains("==> Project name : other"));
    // Every element is set, those that are zero whatever the state too.
    let jacobian = text.matches("\nJac[").count();
    let rows = text.matches("\nh[").count();
    assert_eq!(jacobian, 5 * rows);
    assert!(text.contains("\nJac[1][1] = 0;\n"));
    let over = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("gen")
        .arg(folder.path().join("mbs_cons_hJ_other.c"))
        .args(["--language", "c", "-o"])
        .arg(folder.path())
        .output()
        .expect("it runs");
    assert!(!over.status.success());
    assert!(String::from_utf8_lossy(&over.stderr).contains("would be overwritten"));
    let several = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("gen")
        .arg(&input)
        .arg(input.with_file_name("mbs_link_suspension.py"))
        .args(["--language", "matlab", "-o"])
        .arg(folder.path())
        .output()
        .expect("it runs");
    assert_eq!(String::from_utf8_lossy(&several.stdout).lines().count(), 2);
    let refused = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("gen")
        .arg(input.with_file_name("README.md"))
        .args(["--language", "matlab", "-o"])
        .arg(folder.path().join("none"))
        .output()
        .expect("it runs");
    assert!(!refused.status.success());
    assert!(!folder.path().join("none").exists());
}
