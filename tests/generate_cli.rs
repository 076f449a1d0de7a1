//! `robovec gen` and `robovec-opt` on models, from the command line.

use crate::support::programs::{model, robovec, said};
use std::fs;
use std::path::Path;
use std::process::Command;

fn path(path: &Path) -> &str {
    path.to_str().expect("paths of tests are plain")
}

#[test]
fn the_text_reads_back_and_a_pipeline_runs_on_it() {
    let bogie = model("bogie.mbs");
    let text = said(&robovec(&["gen", path(&bogie), "--function", "all"]));
    let module = robovec_ir::parse::parse_module("stdout", &text).expect("it reads back");
    assert_eq!(robovec_ir::print::print_module(&module), text);
    assert!(module.function("dirdyna").is_some() && module.function("sensor_1").is_some());
    let short = said(&robovec(&[
        "gen",
        path(&bogie),
        "--passes",
        "atomise,cse,dce",
    ]));
    assert!(short.contains("function dirdyna atomic"));
}

#[test]
fn every_language_gets_its_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bogie = model("bogie.mbs");
    for (language, extension) in [("c", "c"), ("matlab", "m"), ("python", "py")] {
        let target = folder.path().join(language);
        let arguments = [
            "gen",
            path(&bogie),
            "--function",
            "all",
            "--language",
            language,
        ];
        let names = said(&robovec(&[&arguments[..], &["-o", path(&target)]].concat()));
        for kind in [
            "dirdyna",
            "invdyna",
            "link",
            "extforces",
            "sensor",
            "gensensor",
        ] {
            let file = target.join(format!("mbs_{kind}_bogie.{extension}"));
            assert!(names.contains(path(&file)), "{names}");
            assert!(fs::metadata(&file).is_ok_and(|file| file.len() > 1000));
        }
    }
}

#[test]
fn a_model_can_be_optimised_at_once() {
    let pendulum = model("double-pendulum.mbs");
    let opt = |function: &str| {
        Command::new(env!("CARGO_BIN_EXE_robovec-opt"))
            .args([
                path(&pendulum),
                "--function",
                function,
                "-passes=atomise,place",
            ])
            .output()
            .expect("the program starts")
    };
    assert!(said(&opt("dirdyna")).contains("function dirdyna placed"));
    assert!(said(&opt("sensor")).contains("function sensor_1 placed"));
    let output = opt("dirdina");
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        message.contains("functions of a model: dirdyna"),
        "{message}"
    );
}

/// A function without content in the model is an error, and a remark beside
/// others.
#[test]
fn what_the_model_has_not_is_not_empty_without_a_word() {
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/robots/arm.urdf");
    for (function, lacks) in [
        ("sensor", "sensors"),
        ("link", "links"),
        ("extforces", "external forces"),
        ("cons_hJ", "loops"),
        ("cons_jdqd", "loops"),
        ("loop_positions", "loops"),
        ("loop_velocities", "loops"),
    ] {
        let opt = Command::new(env!("CARGO_BIN_EXE_robovec-opt"))
            .args([path(&arm), "--function", function])
            .output()
            .expect("the program starts");
        for output in [robovec(&["gen", path(&arm), "--function", function]), opt] {
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(1), "{function}: {message}");
            assert!(output.stdout.is_empty());
            let expected = format!("'arm' has no {lacks}: {function} would be empty");
            assert!(message.contains(&expected), "{message}");
        }
    }
    let output = robovec(&["gen", path(&arm), "--function", "all"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let named = "no equations for cons_hJ, cons_jdqd, link, extforces, sensor";
    assert!(
        output.status.success() && message.contains(named),
        "{message}"
    );
}

#[test]
fn the_formulation_with_the_fewest_operations_is_one_of_them() {
    let bogie = model("bogie.mbs");
    let text = |formulation: &str, function: &str| {
        said(&robovec(&[
            "gen",
            path(&bogie),
            "--function",
            function,
            "--formulation",
            formulation,
            "--passes=$cpu",
        ]))
    };
    let length = |text: &str| text.lines().filter(|line| line.starts_with("  %")).count();
    for function in ["dirdyna", "accelred"] {
        let fewest = text("fewest", function);
        for formulation in ["recursive", "composite", "composite-base", "prefix-serial"] {
            let other = text(formulation, function);
            assert!(
                length(&fewest) <= length(&other),
                "{function}, {formulation}"
            );
        }
        assert!(length(&fewest) > 0);
    }
}

#[test]
fn a_bad_model_writes_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = fs::read_to_string(model("bogie.mbs")).expect("it ships");
    let bad = folder.path().join("bad.mbs");
    for (from, to) in [
        ("</mass>", "x</mass>"),
        ("<type>R2</type>", "<type>R9</type>"),
    ] {
        fs::write(&bad, text.replacen(from, to, 1)).expect("room for the model");
        let result = folder.path().join("result");
        for language in [&[][..], &["--language", "c"]] {
            let arguments = ["gen", path(&bad), "-o", path(&result)];
            let output = robovec(&[&arguments[..], language].concat());
            assert_eq!(output.status.code(), Some(1));
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(message.contains("bad.mbs:"), "{message}");
            assert!(!result.exists());
        }
    }
}

#[test]
fn equations_are_compared_in_numbers_and_by_proof() {
    let car = model("quarter-car.mbs");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let ours = folder.path().join("ours.rvir");
    let text = said(&robovec(&["gen", path(&car)]));
    fs::write(&ours, &text).expect("room for the equations");
    let theirs =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension/mbs_dirdyna_suspension.c");
    let files = [path(&theirs), path(&ours)];
    let check = |how: &[&str]| robovec(&[&["check"][..], &files, how].concat());
    let proof = said(&check(&["--circle", "--zeros", path(&car)]));
    let expected = "dirdyna: real-trig, equal at 8 points of two prime fields and at 80 states";
    assert!(proof.starts_with(expected), "{proof}");
    let numbers = said(&check(&["--model", path(&car)]));
    assert!(numbers.starts_with("dirdyna: within "), "{numbers}");

    // One sign in the equations is enough to fail either way.
    let wrong = text.replacen(" + ", " - ", 1);
    assert_ne!(wrong, text);
    fs::write(&ours, wrong).expect("room for the equations");
    for how in [["--zeros", path(&car)], ["--model", path(&car)]] {
        let output = check(&how);
        assert_eq!(output.status.code(), Some(1));
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(message.contains("'dirdyna' differs"), "{message}");
    }
}

#[test]
fn rows_that_say_what_others_say_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = fs::read_to_string(model("four-bar.mbs")).expect("the model is there");
    let start = text.find("    <ball>").expect("it has a cut");
    let end = text.find("  </cuts>").expect("its cuts end");
    let twin = text[start..end].replace("<name>Loop</name>", "<name>Twin</name>");
    let twice = text[..end].to_owned() + &twin + &text[end..];
    let file = folder.path().join("twice.mbs");
    fs::write(&file, twice).expect("a writable folder");
    let output = folder.path().join("out");
    let made = robovec(&["gen", path(&file), "--whole-step", "-o", path(&output)]);
    assert!(made.status.success(), "{}", said(&made));
    let told = String::from_utf8_lossy(&made.stderr);
    let named = told.matches("repeats other rows, and is left out").count();
    // A planar loop has two rows, here twice.
    assert_eq!(named, 2, "{told}");
    assert!(told.contains("(cut '"), "{told}");
}
