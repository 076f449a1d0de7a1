//! FPCore: cores that are read, cores that are refused, and written cores that
//! read back as the same function.

use crate::support::files::{self, compare_with_record, each, name};
use crate::support::programs::{robovec, said, stderr};
use robovec::fpcore::{ReadCore, names, read};
use robovec_framework::manager::{self, Config};
use robovec_framework::scene::Scene;
use robovec_ir::print::print_module;
use robovec_ir::verify::verify;
use robovec_ir::{Machine, Module, View};
use robovec_passes::registry::REGISTRY;
use std::fmt::Write;
use std::path::Path;

/// Tries every file of good cores.
fn each_good(mut attempt: impl FnMut(&Path)) {
    each("tests/fpcore", &["fpcore"], &mut attempt);
    each("examples/rounding", &["fpcore"], attempt);
}

fn described(core: &ReadCore) -> String {
    let mut text = print_module(&core.module);
    for (array, _, [low, high]) in core.ranges.iter() {
        let _ = writeln!(text, "// {array} in [{low}, {high}]");
    }
    if let Some(format) = core.format {
        let _ = writeln!(text, "// computed in {format}");
    }
    text + &core.warnings.render_plain()
}

fn sound(module: &Module) {
    for function in &module.functions {
        let tables = &module.tables;
        assert_eq!(verify(View { tables, function }), [], "{}", function.name);
    }
}

#[test]
fn cores_become_functions() {
    each_good(|path| {
        let text = std::fs::read_to_string(path).expect("the file can be read");
        let file = name(path);
        let mut all = String::new();
        for core in names(&file, &text).expect("it holds cores") {
            let core = read(&file, &text, Some(&core))
                .unwrap_or_else(|report| panic!("{}", report.render_plain()));
            sound(&core.module);
            all += &described(&core);
            all.push('\n');
        }
        let records = files::tree("tests/fpcore/snapshots");
        compare_with_record(&records, &file, all.trim_end());
    });
}

fn folder(path: &Path) -> std::path::PathBuf {
    path.parent()
        .expect("files lie in folders")
        .join("snapshots")
}

#[test]
fn what_is_no_straight_line_core_is_refused_with_its_place() {
    each("tests/errors/fpcore", &["fpcore"], |path| {
        let text = std::fs::read_to_string(path).expect("the file can be read");
        let file = name(path);
        let report = read(&file, &text, None).expect_err("the file is bad");
        compare_with_record(&folder(path), &file, report.render_plain().trim_end());
    });
}

/// The module as FPCore, with ranges as the precondition.
fn written(module: &Module, core: &ReadCore) -> String {
    let mut module = module.clone();
    let pipeline = REGISTRY
        .pipeline("codegen{target=fpcore}")
        .expect("it exists");
    let machine = Machine::built_in("thesis").expect("it ships");
    let scene = Scene {
        ranges: core.ranges.clone(),
        ..Scene::default()
    };
    let mut log = std::io::sink();
    let mut config = Config::new(&machine, &mut log);
    config.scene = Some(&scene);
    let outcome = manager::run(&mut module, &pipeline, config).expect("it runs");
    outcome.artifacts[0].text.clone()
}

#[test]
fn written_cores_read_back_as_the_same_function() {
    let mut written_texts = String::new();
    each_good(|path| {
        let text = std::fs::read_to_string(path).expect("the file can be read");
        let file = name(path);
        for core in names(&file, &text).expect("it holds cores") {
            let core = read(&file, &text, Some(&core)).expect("it was read before");
            let once = written(&core.module, &core);
            let again = read("again", &once, None)
                .unwrap_or_else(|report| panic!("{once}\n{}", report.render_plain()));
            sound(&again.module);
            assert_eq!(again.ranges, core.ranges, "{once}");
            same_results(&core.module, &again.module);
            assert_eq!(written(&again.module, &again), once);
            written_texts += &once;
        }
    });
    assert!(written_texts.contains("jetEngine") && written_texts.contains(":pre"));
}

/// Both give the same bits at random states.
fn same_results(one: &Module, other: &Module) {
    use robovec_ir::evaluate::evaluate;
    use robovec_ir::states::States;
    use robovec_num::arithmetic::Binary64;
    let run = |module: &Module, state: u32| {
        let (tables, function) = (&module.tables, &module.functions[0]);
        let inputs = States::new(1).draw(View { tables, function }, state);
        let results: Vec<f64> = evaluate(function, &Binary64, &inputs);
        results.into_iter().map(f64::to_bits).collect::<Vec<_>>()
    };
    for state in 0..8 {
        assert_eq!(
            run(one, state),
            run(other, state),
            "{}",
            one.functions[0].name
        );
    }
}

#[test]
fn deep_nesting_is_read_and_endless_nesting_refused() {
    let depth = 100_000;
    let (open, close) = ("(- ".repeat(depth), ")".repeat(depth));
    let core = read("deep", &format!("(FPCore f (x) {open}x{close})"), None).expect("it is good");
    assert_eq!(core.module.functions[0].nodes().len(), depth);
    let lets = "(let ([x (* x x)]) ".repeat(depth);
    let core = read("lets", &format!("(FPCore f (x) {lets}x{close})"), None).expect("it is good");
    assert_eq!(core.module.functions[0].nodes().len(), depth);
    sound(&core.module);
    let once = written(&core.module, &core);
    read("again", &once, None).expect("what was written is good");
    for text in ["(".repeat(depth), format!("(FPCore f (x) {open}"), close] {
        read("broken", &text, None).expect_err("it is broken");
    }
    let (ands, end) = ("(and ".repeat(depth), ")".repeat(depth));
    let text = format!("(FPCore f (x) :pre {ands}(<= 1 x 2){end} x)");
    assert_eq!(
        read("ands", &text, None)
            .expect("it is good")
            .ranges
            .iter()
            .count(),
        1
    );
}

/// Number of cores read from files beside the repository, which no test
/// requires: `ROBOVEC_FPCORES=folder`.
#[test]
#[ignore = "needs files that are not ours"]
fn cores_of_a_folder_are_read() {
    let Ok(folder) = std::env::var("ROBOVEC_FPCORES") else {
        return;
    };
    let (mut good, mut all) = (0, 0);
    for entry in std::fs::read_dir(folder).expect("it can be listed") {
        let path = entry.expect("it can be listed").path();
        let text = std::fs::read_to_string(&path).expect("it can be read");
        let file = name(&path);
        for core in names(&file, &text).expect("it holds cores") {
            all += 1;
            match read(&file, &text, Some(&core)) {
                Ok(core) => {
                    good += 1;
                    sound(&core.module);
                    let again = read("again", &written(&core.module, &core), None);
                    same_results(&core.module, &again.expect("it was written").module);
                }
                Err(report) => println!("{}", report.diagnostics()[0].message),
            }
        }
    }
    println!("{good} of {all} cores are read");
}

/// Every command that draws states, on a core whose root has a value in the
/// ranges of `:pre` alone, or reports the ranges it draws from.
#[test]
fn states_lie_in_the_ranges_of_a_core() {
    let run = |command: &str, core: &'static str| {
        let words = command.split(' ');
        let words: Vec<&str> = words
            .map(|word| if word == "CORE" { core } else { word })
            .collect();
        robovec(&words)
    };
    for command in [
        "eval CORE --states 20",
        "error CORE --blame --state 3",
        "error CORE --passes atomise",
        "error CORE",
    ] {
        let text = said(&run(command, "tests/fpcore/narrow.fpcore")).to_lowercase();
        assert!(
            !text.contains("nan") && !text.contains("inf"),
            "{command}: {text}"
        );
    }
    for command in [
        "explore CORE --elements 1 --states 20",
        "optimise CORE --effort 1",
        "explore CORE --passes atomise --adders 1 --multipliers 1 --couples 7-4",
    ] {
        let text = said(&run(command, "tests/fpcore/placed.fpcore"));
        assert!(
            text.contains(" random states in the given ranges"),
            "{command}: {text}"
        );
    }
    for command in [
        "bench CORE",
        "error CORE --series",
        "rules bench CORE",
        "rules find CORE",
    ] {
        let output = run(command, "tests/fpcore/narrow.fpcore");
        let told = stderr(&output);
        assert!(
            !output.status.success() && told.contains("':pre'"),
            "{command}: {told}"
        );
    }
}

/// 3e35 + 7 - 3e35 is 7: binary64 gives 0, and so does double-double.
#[test]
fn what_is_called_exact_is_certified() {
    let core = "tests/fpcore/lost.fpcore";
    let errors: serde_json::Value =
        serde_json::from_str(&said(&robovec(&["error", core, "--blame", "--json"])))
            .expect("it is JSON");
    let output = &errors[0]["outputs"][0];
    let known = ["exact", "certified", "computed", "error"].map(|key| output[key].clone());
    let known = serde_json::Value::from(known.to_vec());
    assert_eq!(known, serde_json::json!([7.0, true, 0.0, -7.0]));
    let text = said(&robovec(&["error", core, "--blame"]));
    assert!(
        text.contains("7.000000e0") && text.contains("no sigma"),
        "{text}"
    );
    let passes = said(&robovec(&["error", core, "--passes", "atomise,balance"]));
    assert!(
        !passes.contains("better") && !passes.contains("inf"),
        "{passes}"
    );
    let undefined = said(&robovec(&[
        "error",
        "tests/fpcore/undefined.rvir",
        "--blame",
    ]));
    assert!(
        undefined.contains("~inf") && undefined.contains("not certified"),
        "{undefined}"
    );
}
