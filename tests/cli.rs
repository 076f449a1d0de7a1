//! The programs as a user meets them: exit codes, messages, outputs that are
//! whole or absent, the same bytes every time.

use crate::support::programs::stderr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("examples")
        .join(name)
}

fn opt() -> Command {
    Command::new(env!("CARGO_BIN_EXE_robovec-opt"))
}

fn run(command: &mut Command) -> Output {
    command.output().expect("the program starts")
}

const SUSPENSION: &str = "suspension/mbs_dirdyna_suspension.m";
const PIPELINE: &str = "-passes=atomise,zero-removal,balance,cse,dce,place";

/// Runs on an input that is wrong: the exit code is 1, the message holds the
/// words, and nothing is written.
fn refused(input: &[u8], name: &str, arguments: &[&str], words: &[&str]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    fs::write(&path, input).expect("room for the input");
    let result = folder.path().join("result.rvir");
    let output = run(opt().arg(&path).args(arguments).arg("-o").arg(&result));
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{name}: {message}");
    for word in words {
        assert!(message.contains(word), "{name}: no '{word}' in\n{message}");
    }
    assert!(!message.contains("panicked"), "{message}");
    assert!(
        message.len() < 100_000,
        "{name}: a message of {} bytes",
        message.len()
    );
    assert!(output.stdout.is_empty());
    let left: Vec<_> = fs::read_dir(folder.path()).expect("the folder").collect();
    assert_eq!(left.len(), 1, "{name}: something half-written was left");
}

#[test]
fn the_main_job_prints_a_placed_program_and_a_report() {
    let output = run(opt()
        .arg(example(SUSPENSION))
        .args([PIPELINE, "--report", "-"]));
    assert!(output.status.success(), "{}", stderr(&output));
    let program = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(program.contains(" placed {"), "{program}");
    assert!(stderr(&output).contains("cycles"));
    let module = robovec_ir::parse::parse_module("stdout", &program).expect("it reads back");
    assert_eq!(robovec_ir::print::print_module(&module), program);
}

#[test]
fn results_do_not_depend_on_where_and_when() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut results = Vec::new();
    for directory in [Path::new(env!("CARGO_MANIFEST_DIR")), folder.path()] {
        for _ in 0..2 {
            let images = folder.path().join(format!("images{}", results.len()));
            let mut command = opt();
            command.current_dir(directory).arg(example(SUSPENSION));
            command
                .arg(format!("{PIPELINE},codegen"))
                .arg("-o")
                .arg(&images);
            let output = run(&mut command);
            assert!(output.status.success(), "{}", stderr(&output));
            let mut files: Vec<(String, Vec<u8>)> = fs::read_dir(&images)
                .expect("the images")
                .map(|entry| {
                    let entry = entry.expect("a readable folder");
                    let content = fs::read(entry.path()).expect("an image");
                    (entry.file_name().to_string_lossy().into_owned(), content)
                })
                .collect();
            files.sort();
            results.push(files);
        }
    }
    assert!(results[0].len() > 8);
    assert!(results.iter().all(|result| *result == results[0]));
}

#[cfg(unix)]
#[test]
fn a_pipe_is_written_into_and_not_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pipe = folder.path().join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status();
    assert!(
        made.is_ok_and(|status| status.success()),
        "mkfifo is part of every unix"
    );
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::read(pipe)
    });
    let output = run(opt().arg(example(SUSPENSION)).arg("-o").arg(&pipe));
    assert!(output.status.success(), "{}", stderr(&output));
    let text = reader.join().expect("no panic").expect("a readable pipe");
    assert!(text.starts_with(b"// robovec 1"));
    let kind = fs::metadata(&pipe).expect("still there").file_type();
    assert!(kind.is_fifo(), "the pipe is still a pipe");
}

#[test]
fn every_level_reads_back_and_goes_on_alike() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let stages = [
        "atomise",
        "zero-removal",
        "balance",
        "cse,dce",
        "asap-alap",
        "place",
        "asap-alap",
    ];
    let mut input = example(SUSPENSION);
    for (index, stage) in stages.iter().enumerate() {
        let result = folder.path().join(format!("{index}.rvir"));
        let output = run(opt()
            .arg(&input)
            .arg(format!("-passes={stage}"))
            .arg("-o")
            .arg(&result));
        assert!(output.status.success(), "{stage}: {}", stderr(&output));
        let again = run(opt().arg(&result));
        assert_eq!(
            again.stdout,
            fs::read(&result).expect("a result"),
            "{stage}"
        );
        input = result;
    }
    let whole = run(opt()
        .arg(example(SUSPENSION))
        .arg(format!("-passes={}", stages.join(","))));
    assert_eq!(
        whole.stdout,
        fs::read(input).expect("a result"),
        "pass by pass through files gives the same as in one go"
    );
}

#[test]
fn every_pass_is_checked_and_the_images_are_simulated() {
    for machine in ["thesis", "side-split", "ideal", "de10-nano"] {
        for count in [1, 4] {
            let output = run(opt().arg(example(SUSPENSION)).args([
                &format!("{PIPELINE}{{n_add={count} n_multi={count}}}"),
                "--check-each",
                "--simulate=3",
                "--machine",
                machine,
            ]));
            let message = stderr(&output);
            assert!(output.status.success(), "{machine}: {message}");
            assert!(message.contains("bit for bit"), "{machine}: {message}");
        }
    }
}

#[test]
fn machines_of_other_formats_are_simulated_bit_for_bit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let machine = folder.path().join("machine.toml");
    let table = "[number]\nexponent = 8\nmantissa = 23\nsubnormals = true\n";
    let thesis = include_str!("../machines/thesis.toml");
    assert!(thesis.contains(table));
    for format in ["float(8,17)", "float(11,51,flush)", "fixed(24,29)"] {
        let text = format!("number = \"{format}\"\n{}", thesis.replace(table, ""));
        fs::write(&machine, text).expect("a file");
        let output = run(opt()
            .arg(example(SUSPENSION))
            .args([
                &format!("{PIPELINE}{{n_add=2 n_multi=2}}"),
                "--simulate=3",
                "--machine",
            ])
            .arg(&machine));
        let message = stderr(&output);
        assert!(output.status.success(), "{format}: {message}");
        assert!(message.contains("bit for bit"), "{format}: {message}");
    }
    // Values that want another format have no images on this machine.
    let text = "function f atomic {\n in a\n out o\n %x = a*a as f16\n o = %x\n}\n";
    let source = folder.path().join("mixed.rvir");
    fs::write(&source, text).expect("a file");
    let output = run(opt().arg(&source).args(["-passes=place,codegen"]));
    assert!(!output.status.success());
    let message = stderr(&output);
    assert!(message.contains("'%x' is computed as f16"), "{message}");
}

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
        &["UTF-8"],
    );
    refused(&[b'('; 1 << 20], "a.rvir", &[], &["a.rvir:1:"]);
    let deep = format!("  o = {}x{}\n", "(".repeat(100_000), ")".repeat(99_999));
    refused(&body(&deep), "a.rvir", &[], &["a.rvir:", "^"]);
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

#[test]
fn a_million_terms_in_one_sum_are_balanced() {
    let terms: Vec<String> = (0..1_000_000)
        .map(|term| format!("x[{}]", 1 + term % 100))
        .collect();
    let text = format!(
        "function f equations {{\n  in x[1..100]\n  out o\n\n  o = {}\n}}\n",
        terms.join(" + ")
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("sum.rvir");
    fs::write(&path, text).expect("room for the input");
    let result = folder.path().join("result.rvir");
    let output = run(opt()
        .arg(&path)
        .args(["-passes=atomise,balance,asap-alap", "-o"])
        .arg(&result));
    assert!(output.status.success(), "{}", stderr(&output));
    let result = fs::read_to_string(&result).expect("a result");
    assert!(
        result.contains("{asap 20 "),
        "a tree of a million leaves is 20 deep"
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
    command.arg("accuracy").arg(example(SUSPENSION));
    command.arg(example("models/quarter-car.mbs"));
    let output = run(command.args(["--states", "32", "-o"]).arg(&results));
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
    let table = fs::read_to_string(results.join("accuracy.csv")).expect("it was asked for");
    let passes = table
        .lines()
        .filter(|line| line.contains(",balance,"))
        .count();
    assert_eq!(passes, 2, "{table}");
    let figure = fs::read_to_string(results.join("accuracy.svg")).expect("it was asked for");
    assert!(figure.starts_with("<svg") && figure.contains("as read"));
    let json = fs::read_to_string(results.join("accuracy.json")).expect("it was asked for");
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
        run(command.arg("accuracy").arg(&model).args(arguments))
    };
    let results = folder.path().join("results");
    let output = accuracy(&[
        "--outputs",
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
    let state = accuracy(&["--outputs", "--print-state", "5"]);
    let file = folder.path().join("state.txt");
    fs::write(&file, &state.stdout).expect("the folder is there");
    let mut command = Command::new(env!("CARGO_BIN_EXE_robovec"));
    let output = run(command.arg("eval").arg(&model).arg("--states").arg(&file));
    assert!(output.status.success(), "{}", stderr(&output));

    let output = accuracy(&["--outputs", "--formats", "f31"]);
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
            .arg("errors")
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
        (["--outputs", "M[9,9]"], "has no output 'M[9,9]'"),
        (["--format", "f31"], "expected a number format"),
        (["--format", "f64"], "more than 40 bits"),
        (["--function", "nothing"], "no function 'nothing'"),
    ] {
        let output = errors(&arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(stderr(&output).contains(message), "{}", stderr(&output));
    }
}
