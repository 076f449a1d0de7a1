//! Wrong inputs: the messages, and that no file is written.

use super::{SUSPENSION, example, opt, refused, run};
use crate::support::programs::stderr;
use std::fs;

#[test]
fn bad_text_is_refused_with_a_caret() {
    let header = "function f atomic {\n  in x\n  out o\n";
    let body = |lines: &str| format!("{header}{lines}}}\n").into_bytes();
    let at_line_4 = ["a.rvir:4:", "^"];
    refused(
        &body("  %a = x + %b\n  o = %a\n"),
        "a.rvir",
        &[],
        &at_line_4,
    );
    refused(
        &body("  %a = x\n  %a = x + x\n  o = %a\n"),
        "a.rvir",
        &[],
        &["^"],
    );
    refused(
        &body("  %a = x*%b\n  %b = %a + x\n  o = %b\n"),
        "a.rvir",
        &[],
        &at_line_4,
    );
    refused(
        &body("  %a = x + NaN\n  o = %a\n"),
        "a.rvir",
        &[],
        &at_line_4,
    );
    refused(
        &body("  %a = x + 1e999\n  o = %a\n"),
        "a.rvir",
        &[],
        &at_line_4,
    );
    refused(
        &body("  %a = x + x\n"),
        "a.rvir",
        &[],
        &["is ever set", "^"],
    );
    refused(
        b"function f atomic {\n  in x\n",
        "a.rvir",
        &[],
        &["a.rvir", "^"],
    );
    refused(
        &[0, 159, 146, 150, 255, 254, 0, 1],
        "a.rvir",
        &[],
        &["data that is not text"],
    );
    refused(&[b'('; 1 << 20], "a.rvir", &[], &["a.rvir:1:"]);
    let deep = format!("  o = {}x{}\n", "(".repeat(100_000), ")".repeat(99_999));
    refused(&body(&deep), "a.rvir", &[], &["a.rvir:", "^"]);
}

#[test]
fn what_sets_no_output_is_refused() {
    for (text, name, words) in [
        ("x = 1;\n", "a.c", ["a.c sets no output", "c[1] = …"]),
        ("x = 1\n", "a.m", ["a.m sets no output", "c[1] = …"]),
        (
            "void mbs_cons_hJ(double *h, double **Jac, MbsData *s, double tsim)\n{\n}\n",
            "cons.c",
            ["cons.c sets no output", "such a stub"],
        ),
        (
            "// robovec 1\n",
            "a.rvir",
            ["a.rvir holds no function", "text-format"],
        ),
        (
            "function f equations {\n  in x\n}\n",
            "a.rvir",
            ["a.rvir sets no output", "such a stub"],
        ),
    ] {
        refused(text.as_bytes(), name, &[], &words);
    }
}

/// Old systems end lines with a carriage return alone, comments included.
#[test]
fn carriage_returns_alone_end_lines() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let read = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("room for the input");
        let output = run(opt().arg(&path));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    for (name, text) in [
        (
            "a.rvir",
            "// a comment\nfunction f equations {\n  in q\n  out y\n  y = q + q\n}\n",
        ),
        ("a.fpcore", "; a comment\n(FPCore f (x) (+ x 1))\n"),
        (
            "a.c",
            "// a comment\nvoid mbs_invdyna(double *Qq, MbsData *s, double tsim)\n{\n\
             Qq[1] = s->q[1]; // more\n}\n",
        ),
    ] {
        let functions =
            |text: String| text[text.find("function").expect("it has one")..].to_owned();
        let expected = functions(read(name, text));
        let lone = functions(read(name, &text.replace('\n', "\r")));
        let places = |text: &str| text.split('@').next().unwrap_or_default().to_owned();
        assert_eq!(places(&lone), places(&expected), "{name}");
    }
}

#[test]
fn bad_robotran_files_are_refused_with_a_caret() {
    let good = fs::read(example(SUSPENSION)).expect("the example");
    refused(&good[..good.len() / 2], "a.m", &[], &["a.m:"]);
    refused(&[0u8; 4096], "a.c", &[], &["a.c"]);
    refused(&[b'('; 1 << 20], "a.c", &[], &["a.c:1:"]);
    let text = String::from_utf8(good).expect("ASCII");
    let line = text
        .lines()
        .find(|line| line.contains("sin("))
        .expect("a sine")
        .to_owned();
    let unknown = text.replacen(&line, &format!("{line}\n  X1 = Y1*Y2;"), 1);
    refused(unknown.as_bytes(), "a.m", &[], &["a.m:", "^", "Y1"]);
    let twice = text.replacen(&line, &format!("{line}\n{line}"), 1);
    refused(twice.as_bytes(), "a.m", &[], &["a.m:", "^"]);
    let nan = text.replacen(&line, &format!("{line}\n  X1 = NaN;"), 1);
    refused(nan.as_bytes(), "a.m", &[], &["a.m:", "^"]);
    let deep = format!(
        "{line}\n  X1 = {}q(1){};",
        "(".repeat(100_000),
        ")".repeat(99_999)
    );
    refused(
        text.replacen(&line, &deep, 1).as_bytes(),
        "a.m",
        &[],
        &["a.m:", "^"],
    );
}

#[test]
fn bad_pipelines_and_machines_are_refused_with_a_caret() {
    let input = fs::read(example(SUSPENSION)).expect("the example");
    let cases: [(&str, &[&str]); 6] = [
        (
            "-passes=atomize",
            &["<-passes>:1:1", "^", "did you mean 'atomise'?"],
        ),
        (
            "-passes=atomise,place{n_mul=4}",
            &["<-passes>:1:15", "^", "n_multi"],
        ),
        ("-passes=atomise,(", &["<-passes>:1:9", "^"]),
        ("-passes=cse", &["<-passes>:1:1", "^", "'atomise'"]),
        ("-passes=@nowhere", &["cannot read nowhere"]),
        ("--machine=thesiss", &["did you mean 'thesis'?"]),
    ];
    for (argument, words) in cases {
        refused(&input, "mbs_dirdyna_suspension.m", &[argument], words);
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (text, words) in [
        ("name = \"x\"\nclock_mhz = fast\n", ["bad.toml:2:", "^"]),
        (
            "name = \"x\"\nclock_mhz = 1.0\nelement = []\n[memory]\nstyle = \"unified\"\n",
            ["bad.toml", "at least one"],
        ),
    ] {
        let machine = folder.path().join("bad.toml");
        fs::write(&machine, text).expect("room");
        let argument = format!("--machine={}", machine.display());
        refused(&input, "mbs_dirdyna_suspension.m", &[&argument], &words);
    }
    refused(
        &input,
        "mbs_dirdyna_suspension.m",
        &["--machine=absent.toml"],
        &["cannot read absent.toml"],
    );
}
