//! `robovec rules` on the files of tests/rules: its output is beside each file.
//! Bless with INSTA_UPDATE=always.

use crate::support::files::{compare_with_record, each, list, name, stem};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/rules")
        .join(name)
}

/// Runs in the folder of the files, so that no message holds a path.
fn rules(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("rules")
        .args(arguments)
        .current_dir(file(""))
        .output()
        .expect("the program starts")
}

fn both(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let code = output.status.code();
    format!(
        "{}--- messages, exit code {code:?}\n{}",
        text(&output.stdout),
        text(&output.stderr)
    )
}

#[test]
fn files_of_rules_are_checked_as_their_snapshots_say() {
    assert!(list("tests/rules", &["rules"]).len() >= 3);
    each("tests/rules", &["rules"], |path| {
        let shown = both(&rules(&["check", &name(path)]));
        compare_with_record(&file(""), &stem(path), &shown);
    });
}

#[test]
fn a_false_rule_is_named_and_the_others_run() {
    let check = rules(&["check", "one-false.rules", "--json"]);
    assert_eq!(check.status.code(), Some(1));
    let found: serde_json::Value = serde_json::from_slice(&check.stdout).expect("JSON");
    let sound: Vec<(&str, bool)> = found
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|rule| Some((rule["rule"].as_str()?, rule["sound"].as_bool()?)))
        .collect();
    assert_eq!(
        sound,
        [("three-terms", true), ("hasty", false), ("double", true)]
    );
    let counterexample = &found[1]["counterexample"];
    assert_eq!(counterexample["values"]["c"], 1.0);
    assert_eq!(counterexample["left"], 0.0);
    assert_eq!(counterexample["right"], -1.0);

    // The compiler warns of it and goes on with the others.
    let input =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension/mbs_dirdyna_suspension.m");
    let output = Command::new(env!("CARGO_BIN_EXE_robovec-opt"))
        .arg(input)
        .args(["-passes=atomise", "--rules", "one-false.rules"])
        .current_dir(file(""))
        .output()
        .expect("the program starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    assert!(
        message.contains("warning: the rule 'hasty' is false"),
        "{message}"
    );
    assert!(message.contains("a = 0, b = 0, c = 1"), "{message}");
}

#[test]
fn what_ships_is_sound() {
    let output = rules(&["check"]);
    assert!(output.status.success(), "{}", both(&output));
}

#[test]
fn rules_survive_the_way_through_other_tools() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for syntax in ["egglog", "herbie"] {
        let there = folder.path().join(syntax);
        let path = there.to_str().expect("a plain path");
        let export = rules(&["export", "--syntax", syntax, "distribution", "-o", path]);
        assert!(export.status.success(), "{}", both(&export));
        let import = rules(&["import", "--syntax", syntax, path]);
        assert!(import.status.success(), "{}", both(&import));
        let text = String::from_utf8_lossy(&import.stdout).into_owned();
        assert!(
            text.contains("rule distribute: a*(b + c) => a*b + a*c class=real"),
            "{text}"
        );
    }
}

#[test]
fn what_cannot_be_read_is_an_error_and_no_panic() {
    for (arguments, expected) in [
        (&["check", "nothing.rules"][..], "cannot read"),
        (&["check", "sings"][..], "did you mean 'signs'"),
        (&["check", "signs", "signs"][..], ""),
        (&["profile", "malformed.rules"][..], "no operation 'tan'"),
        (
            &["import", "--syntax", "egglog", "one-false.rules"][..],
            "looks like a file of rules",
        ),
    ] {
        let output = rules(arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.success(), expected.is_empty(), "{message}");
        assert!(message.contains(expected), "{message}");
        assert!(!message.contains("panicked"), "{message}");
    }
}

#[test]
fn false_rules_are_not_used_whatever_they_look_like() {
    let check = rules(&["check", "holes.rules", "--json"]);
    assert_eq!(check.status.code(), Some(1));
    let found: serde_json::Value = serde_json::from_slice(&check.stdout).expect("JSON");
    for rule in found.as_array().expect("a list") {
        let verdict = if rule["rule"] == "fine" {
            "proved"
        } else {
            "FALSE"
        };
        assert_eq!(rule["verdict"], verdict, "{rule:#}");
        assert!(rule["verdict"] != "proved" || rule["equal_bits"].as_f64() > Some(0.0));
    }
    let input =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension/mbs_dirdyna_suspension.m");
    let output = Command::new(env!("CARGO_BIN_EXE_robovec-opt"))
        .arg(input)
        .args(["-passes=atomise,eqsat", "--rules", "holes.rules", "-stats"])
        .current_dir(file(""))
        .output()
        .expect("the program starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    let warnings = message.matches("is false").count();
    assert_eq!(warnings, 9, "{message}");
}

#[test]
fn theorems_of_others_are_not_called_unsound() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("theorems.egg");
    let import = |text: &str| {
        std::fs::write(&path, text).expect("written");
        let path = path.to_str().expect("a plain path");
        rules(&["import", "--syntax", "egglog", path])
    };
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let sum = "; sine-of-sum: angles\n(rewrite (Sin (Add a b)) \
               (Add (Mul (Sin a) (Cos b)) (Mul (Cos a) (Sin b))))\n";
    let output = import(sum);
    assert!(output.status.success(), "{}", both(&output));
    let shown = text(&output.stdout);
    assert!(shown.starts_with("rule sine-of-sum: sin(a + b)"), "{shown}");
    assert!(shown.contains("class=real-trig"), "{shown}");

    // True, but beyond the proof: a warning and a comment that says so.
    let open = "(rewrite (Add (Sqrt (Mul (Sub a (Num 1.0)) (Sub a (Num 1.0)))) \
                (Mul (Num 0.0) (Sqrt (Sub a (Num 2.0))))) (Sub a (Num 1.0)))\n";
    let output = import(&format!("{sum}{open}"));
    assert!(output.status.success(), "{}", both(&output));
    assert!(
        text(&output.stdout).contains("\n# not proved: rule egglog-2"),
        "{}",
        both(&output)
    );
    assert!(
        text(&output.stderr).contains("warning: the rule 'egglog-2'"),
        "{}",
        both(&output)
    );

    // A false one is an error; the others are written all the same.
    let output = import(&format!("{sum}(rewrite (Sub a b) (Sub b a))\n"));
    assert_eq!(output.status.code(), Some(1), "{}", both(&output));
    assert!(
        text(&output.stdout).contains("# false: rule egglog-2"),
        "{}",
        both(&output)
    );
    assert!(
        text(&output.stdout).contains("rule sine-of-sum"),
        "{}",
        both(&output)
    );
    assert!(text(&output.stderr).contains("error: the rule 'egglog-2' is false"));
}

#[test]
fn an_error_is_an_exit_code() {
    let suspension = "../../examples/suspension/mbs_dirdyna_suspension.m";
    for arguments in [
        &["check", "one-false.rules"][..],
        &["check", "proud.rules"],
        &["check", "malformed.rules"],
        &["check", "nothing.rules"],
        &["list", "nothing.rules"],
        &["list", "malformed.rules"],
        &["profile", "nothing.rules"],
        &["export", "--syntax", "herbie", "malformed.rules"],
        &["import", "--syntax", "herbie", "nothing.rkt"],
        &["find", "nothing.mbs"],
        &["find", "bogie", "--rules", "malformed.rules"],
        &["bench", "nothing.mbs"],
        &["bench", suspension, "--rules", "malformed.rules"],
        &["why", "NOTHING", suspension],
        &["why", "NOTHING", "nothing.m"],
        &["why-not", "a +", "a"],
        &["why-not", "a*b", "b*a", "--rules", "nothing.rules"],
        &["why-not", "a*b", "b*a", "--rules", "malformed.rules"],
    ] {
        let output = rules(arguments);
        assert!(!output.status.success(), "{arguments:?}: {}", both(&output));
        assert!(
            both(&output).contains("error: "),
            "{arguments:?}: {}",
            both(&output)
        );
    }
}

#[test]
fn why_not_proposes_the_class_that_is_proved() {
    let alone = ["--only", "--rules", "associativity"];
    for (question, trig, told) in [
        (
            ["sin(a)*sin(a)*b + cos(a)*cos(a)*b", "b"],
            true,
            "class=real-trig;",
        ),
        (["a*b + a*c", "a*(b + c)"], false, "class=real;"),
    ] {
        let mut arguments = vec!["why-not", question[0], question[1]];
        arguments.extend(alone);
        if trig {
            arguments.push("--trig");
        }
        let text = both(&rules(&arguments));
        assert!(text.contains("A rule that closes the gap:"), "{text}");
        assert!(text.contains(told), "{text}");
    }
    let question = ["why-not", "a*x*x + b*x*y + c*x*z", "x*(a*x + b*y + c*z)"];
    for nodes in ["10", "50"] {
        let text = both(&rules(&[&question[..], &["--nodes", nodes]].concat()));
        let told = format!("Not reached within {nodes} nodes and 10 rounds");
        assert!(text.contains(&told), "{text}");
    }
}

#[test]
fn factoring_is_found_again() {
    let known = ["signs", "commutativity", "associativity"];
    let mut arguments = vec![
        "find",
        "bogie",
        "--operations",
        "3",
        "--json",
        "--no-default-rules",
    ];
    for name in known {
        arguments.extend(["--rules", name]);
    }
    let output = rules(&arguments);
    assert!(output.status.success(), "{}", both(&output));
    let search: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let found = search["found"].as_array().expect("a list");
    let mut texts = found.iter().filter_map(|rule| rule["text"].as_str());
    let is_factoring = |text: &str| text.contains("b*a - c*a => (b - c)*a");
    assert!(texts.any(is_factoring), "{search:#}");
    assert_eq!(
        output.stdout,
        rules(&arguments).stdout,
        "the same every time"
    );
}
