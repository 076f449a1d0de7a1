//! Texts beside the result: reports, histories, errors and help.

use super::{PIPELINE, SUSPENSION, example, opt, run};
use crate::support::programs::stderr;
use std::fs;
use std::process::Command;

#[test]
fn instruments_write_where_they_should() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let dumps = folder.path().join("dumps");
    let report = folder.path().join("report.json");
    let output = run(opt()
        .arg(example(SUSPENSION))
        .args([
            PIPELINE,
            "--print-changed=diff",
            "--time-passes",
            "--stats=json",
            "--report",
        ])
        .arg(&report)
        .arg("--dump-dir")
        .arg(&dumps));
    assert!(output.status.success(), "{}", stderr(&output));
    let index: serde_json::Value =
        serde_json::from_slice(&fs::read(dumps.join("index.json")).expect("an index"))
            .expect("JSON");
    let entries = index.as_array().expect("a list");
    assert_eq!(entries.len(), 7, "the start and six passes");
    for entry in entries {
        let file = dumps.join(entry["file"].as_str().expect("a name"));
        let text = fs::read_to_string(file).expect("a dump");
        assert!(robovec_ir::parse::parse_module("dump", &text).is_ok());
    }
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(&report).expect("a report")).expect("JSON");
    let function = &report["functions"][0];
    for name in [
        "name",
        "model",
        "level",
        "equations",
        "operations",
        "add_sub",
        "mul",
        "div",
        "sqrt",
        "sin_cos",
        "negations",
        "vectors",
        "asap",
        "asap_cycle",
        "number_y",
        "passes",
        "schedule",
        "error",
    ] {
        assert!(function.get(name).is_some(), "the report has no '{name}'");
    }
    for name in [
        "machine",
        "n_add",
        "n_multi",
        "cycles",
        "lower_bound",
        "time_us",
        "parallelisation_rate",
        "memory",
        "buffer",
    ] {
        assert!(
            function["schedule"].get(name).is_some(),
            "the schedule has no '{name}'"
        );
    }
    assert!(
        stderr(&output).contains("%"),
        "times and differences are on the standard error"
    );
}

#[test]
fn a_value_is_explained_from_its_equation_to_the_end() {
    let explain = |asked: &str| {
        run(opt()
            .arg(example(SUSPENSION))
            .args([PIPELINE, "--explain", asked]))
    };
    let output = explain("M[3,3]");
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for part in [
        "mbs_dirdyna_suspension.m:",
        "M[3,3] of 'dirdyna' comes from",
        "as read\n  M[3,3] = ",
        "\nbalance\n- ",
        "\nin the end\n  M[3,3] = ",
        " available at cycle ",
    ] {
        assert!(text.contains(part), "no '{part}' in\n{text}");
    }
    let output = explain("%AF34x");
    assert_eq!(output.status.code(), Some(1));
    let message = stderr(&output);
    assert!(message.contains("did you mean '%AF34'?"), "{message}");
}

#[test]
fn histories_are_printed_on_request_and_change_nothing_else() {
    let print = |arguments: &[&str]| {
        let output = run(opt().arg(example(SUSPENSION)).arg(PIPELINE).args(arguments));
        assert!(output.status.success(), "{}", stderr(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let text = print(&["--print-history"]);
    let mut module = robovec_ir::parse::parse_module("stdout", &text).expect("it reads back");
    assert_eq!(robovec_ir::print::print_module(&module), text);
    let histories = module.functions[0].histories.take().expect("as asked for");
    assert!(histories.steps().len() > 4);
    assert_eq!(robovec_ir::print::print_module(&module), print(&[]));
}

#[test]
fn errors_are_compared_before_and_after_every_pass() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let results = folder.path().join("results");
    let mut command = Command::new(env!("CARGO_BIN_EXE_robovec"));
    command.arg("error").arg(example(SUSPENSION));
    command.arg(example("models/quarter-car.mbs"));
    let output = run(command
        .args(["--passes", "$shorten", "--states", "32", "-o"])
        .arg(&results));
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for part in [
        "quarter-car: rounding errors",
        "(as read)",
        "balance",
        "(whole pipeline)",
    ] {
        assert!(text.contains(part), "no '{part}' in\n{text}");
    }
    let table = fs::read_to_string(results.join("passes.csv")).expect("it was asked for");
    let passes = table
        .lines()
        .filter(|line| line.contains(",balance,"))
        .count();
    assert_eq!(passes, 2, "{table}");
    let figure = fs::read_to_string(results.join("passes.svg")).expect("it was asked for");
    assert!(figure.starts_with("<svg") && figure.contains("as read"));
    let json = fs::read_to_string(results.join("passes.json")).expect("it was asked for");
    serde_json::from_str::<serde_json::Value>(&json).expect("it is JSON");

    let report = folder.path().join("report.json");
    let output = run(opt()
        .arg(example(SUSPENSION))
        .arg(PIPELINE)
        .arg("--report")
        .arg(&report));
    assert!(output.status.success(), "{}", stderr(&output));
    let json = fs::read_to_string(&report).expect("it was asked for");
    let json: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
    for pass in json["functions"][0]["passes"].as_array().expect("a list") {
        let relative = &pass["rounding"]["relative"];
        assert!(relative["before"]["median"].as_f64() > Some(0.1), "{pass}");
        assert_ne!(relative["trend"], "worse", "{pass}");
    }
}

#[test]
fn every_output_is_measured_in_any_format() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let model = example("models/quarter-car.mbs");
    let accuracy = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_robovec"));
        run(command.arg("error").arg(&model).args(arguments))
    };
    let results = folder.path().join("results");
    let output = accuracy(&[
        "--formats",
        "f32,float(8,17),f64",
        "--states",
        "24",
        "-o",
        results.to_str().expect("it is text"),
    ]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for part in ["reference certified", "float(8,17):", "condition", "M[1,1]"] {
        assert!(text.contains(part), "no '{part}' in\n{text}");
    }
    let json = fs::read_to_string(results.join("outputs.json")).expect("it was asked for");
    let lines: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
    let lines = lines.as_array().expect("a list");
    let worst = |format: &str| {
        let own = lines.iter().filter(|line| line["format"] == format);
        own.filter_map(|line| line["mixed"]["worst"].as_f64())
            .fold(0.0, f64::max)
    };
    // Each format has its own rounding, six bits and 29 bits apart.
    let ratio = worst("float(8,17)") / worst("f32");
    assert!((10.0..400.0).contains(&ratio), "{ratio}");
    let ratio = worst("f32") / worst("f64");
    assert!((1e7..1e11).contains(&ratio), "{ratio}");
    let csv = fs::read_to_string(results.join("outputs.csv")).expect("it was asked for");
    assert_eq!(csv.lines().count(), lines.len() + 1);

    // A state is printed so that the evaluator reads it.
    let state = accuracy(&["--print-state", "5"]);
    let file = folder.path().join("state.txt");
    fs::write(&file, &state.stdout).expect("the folder is there");
    let mut command = Command::new(env!("CARGO_BIN_EXE_robovec"));
    let output = run(command.arg("eval").arg(&model).arg("--states").arg(&file));
    assert!(output.status.success(), "{}", stderr(&output));

    let output = accuracy(&["--formats", "f31"]);
    assert!(!output.status.success() && stderr(&output).contains("expected a number format"));
}

#[test]
fn help_lists_what_there_is() {
    let passes = run(opt().arg("--list-passes"));
    let text = String::from_utf8_lossy(&passes.stdout).into_owned();
    for info in robovec_passes::registry::REGISTRY.passes {
        assert!(text.contains(info.name), "{} is not listed", info.name);
        let page = run(opt().args(["--help-pass", info.name]));
        assert!(page.status.success());
        assert!(!info.summary().is_empty());
    }
    assert_eq!(
        run(opt().args(["--help-pass", "balanse"])).status.code(),
        Some(1)
    );
    let script = run(opt().args(["--completion", "bash"]));
    assert!(String::from_utf8_lossy(&script.stdout).contains("robovec-opt"));
    let completed = run(opt()
        .env("COMPLETE", "bash")
        .env("_CLAP_COMPLETE_INDEX", "2")
        .env("_CLAP_IFS", "\n")
        .args(["--", "robovec-opt", "--passes", ""]));
    assert!(
        String::from_utf8_lossy(&completed.stdout).contains("balance"),
        "pass names are completed: {}",
        String::from_utf8_lossy(&completed.stdout)
    );
}

#[test]
fn errors_name_equations_with_their_places_and_refuse_what_they_cannot_do() {
    let errors = |arguments: &[&str]| {
        run(Command::new(env!("CARGO_BIN_EXE_robovec"))
            .args(["error", "--blame"])
            .arg(example(SUSPENSION))
            .args(arguments))
    };
    let output = errors(&["--outputs", "c,M[1,1]", "--states", "3"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for part in [
        "predicted",
        "M[1,1] ",
        "Heat: ",
        "mbs_dirdyna_suspension.m:",
    ] {
        assert!(text.contains(part), "no '{part}' in\n{text}");
    }
    for (arguments, message) in [
        ("--outputs M[9,9]", "has no output 'M[9,9]'"),
        ("--format f64 --method stochastic", "more than 40 bits"),
        ("--function nothing", "no function 'nothing'"),
    ] {
        let output = errors(&arguments.split(' ').collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(stderr(&output).contains(message), "{}", stderr(&output));
    }
}
