//! Reduction of a failing pass, from the command line.

use crate::support::programs::{opt_in, stderr};
use std::fs;

/// The thesis' machine has no divider, so that `place` refuses the function.
const TEXT: &str = "function f equations {
  in q[1..9]
  out M[1..2,1..2]
  out c

  %A = q[1]*q[2]+q[3]
  %B = (%A-q[4])/(q[5]+%A*q[6])
  %C = sin(q[7])*%A-%B*q[8]

  M[1,1] = %A*%C
  M[1,2] = %C*%C+q[9]
  c = %A-%B+q[1]+q[2]+q[3]
}
";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("f.rvir"), TEXT).expect("room for the input");
    folder
}

#[test]
fn a_refused_function_is_reduced_and_the_result_runs_again() {
    let folder = folder();
    let output = opt_in(
        folder.path(),
        &[
            "f.rvir",
            "-passes=atomise,balance,place",
            "--auto-reduce",
            "--reproducer=before.rvir",
        ],
    );
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("pass 3 of the run, place"), "{message}");
    let text = fs::read_to_string(folder.path().join("reduced.rvir")).expect("it was written");
    let module = robovec_ir::parse::parse_module("reduced", &text).expect("well formed");
    assert_eq!(module.functions[0].nodes().len(), 1, "{text}");
    assert!(text.starts_with("// RUN: place\n"), "{text}");
    let before = fs::read_to_string(folder.path().join("before.rvir")).expect("it was written");
    assert!(before.contains("out M[1..2,1..2]"), "{before}");
    for file in ["reduced.rvir", "before.rvir"] {
        let again = opt_in(folder.path(), &[file, "--run-reproducer"]);
        assert_eq!(again.status.code(), Some(1));
        assert!(
            stderr(&again).contains("performs div"),
            "{}",
            stderr(&again)
        );
    }
    // What is said besides is preferred.
    let fixed = opt_in(
        folder.path(),
        &["reduced.rvir", "--run-reproducer", "--passes=cse"],
    );
    assert!(fixed.status.success(), "{}", stderr(&fixed));
    let none = opt_in(folder.path(), &["f.rvir", "--run-reproducer"]);
    assert_eq!(none.status.code(), Some(1));
    assert!(
        stderr(&none).contains("not a reproducer"),
        "{}",
        stderr(&none)
    );
}

#[test]
fn nothing_is_written_when_nothing_goes_wrong() {
    let folder = folder();
    let arguments = [
        "-passes=atomise,cse",
        "--auto-reduce=a.rvir",
        "--reproducer=b.rvir",
    ];
    let output = opt_in(folder.path(), &[&["f.rvir"], &arguments[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let left: Vec<_> = fs::read_dir(folder.path()).expect("the folder").collect();
    assert_eq!(left.len(), 1);
}

#[test]
fn a_limit_stops_the_pipeline_and_the_pass() {
    let folder = folder();
    let run = |limit: &str| {
        let passes = "-passes=atomise,balance,cse";
        opt_in(
            folder.path(),
            &["f.rvir", passes, &format!("--bisect-limit={limit}")],
        )
    };
    let whole = run("3");
    assert!(whole.status.success(), "{}", stderr(&whole));
    assert_eq!(stderr(&whole).matches("BISECT: running").count(), 3);
    let unbalanced = run("1");
    assert!(stderr(&unbalanced).contains("BISECT: NOT running pass (2) balance on f"));
    // Without a rewrite the function stays as it was.
    assert_eq!(run("2:0").stdout, unbalanced.stdout);
    assert_ne!(whole.stdout, unbalanced.stdout);
    let wrong = run("x");
    assert_eq!(wrong.status.code(), Some(2));
}
