//! C that takes the place of Robotran's: compiled without a warning, called
//! as MBsysC calls it, against the evaluator.

use crate::compiled::has_gcc;
use robovec::generate::{GenerationRequest, generate};
use robovec::model::mbs::read_mbs;
use robovec::robotran::FunctionKind;
use robovec_cgen::c::{
    Options, Real, Signature, Sines, StatementOrder, TrialState, files, function_name,
    minimal_data, trial_main,
};
use robovec_framework::manager::{self, Config};
use robovec_ir::states::States;
use robovec_ir::{Machine, Module, View};
use robovec_passes::registry::REGISTRY;
use std::path::Path;
use std::process::{Command, Output};

const FLAGS: [&str; 5] = ["-std=gnu99", "-O1", "-Wall", "-Wextra", "-Werror"];

/// Compiles and runs the trial of a function.
fn run(view: View<'_>, options: &Options, trial: &TrialState, argument: &str) -> Output {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files = files(view, options).expect("it has a signature");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("a temporary file");
    };
    for (name, text) in &files {
        write(name, text);
    }
    let (data, text) = minimal_data([view]);
    write(&data, &text);
    let name = function_name(view, options);
    write("main.c", &trial_main(view, options, &[&name], trial));
    // The header stands on its own and agrees with the source.
    let header = format!(
        "#include \"{0}\"\n#include \"{1}\"\n",
        files[1].0, files[0].0
    );
    write("with_header.c", &header);
    let compiled = Command::new("gcc")
        .current_dir(folder.path())
        .args(FLAGS)
        .args(["-o", "program", "main.c", "with_header.c", "-lm"])
        .output()
        .expect("gcc is there");
    let messages = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{messages}");
    let mut program = Command::new(folder.path().join("program"));
    program.arg(argument).output().expect("it runs")
}

fn generated(model: &str, kind: FunctionKind, passes: &str) -> Module {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let bytes = std::fs::read(root.join(model).with_extension("mbs")).expect("it ships");
    let model = read_mbs(model, &bytes).expect("it is a good model").model;
    let mut module = generate(&model, &GenerationRequest::new(kind)).expect("it is a good model");
    let pipeline = REGISTRY.pipeline(passes).expect("a good pipeline");
    let machine = Machine::built_in("thesis").expect("it ships");
    let mut log = Vec::new();
    manager::run(&mut module, &pipeline, Config::new(&machine, &mut log)).expect("it runs");
    module
}

fn agrees(module: &Module, options: &Options, tolerance: f64) {
    for function in &module.functions {
        let view = View {
            tables: &module.tables,
            function,
        };
        let mut inputs = States::new(5).draw(view, 0);
        // Angles that the loop cannot reduce go to the library.
        if let Some(last) = inputs.first_mut() {
            *last = 1e7;
        }
        let mut trial = TrialState::new(view, inputs, tolerance);
        let output = run(view, options, &trial, "");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{}: {text}", function.name);
        // A trial that is wrong is found out.
        if options.part == 500 {
            trial.expected[0] += 1.0 + trial.expected[0].abs();
            let output = run(view, options, &trial, "print");
            assert_eq!(output.status.code(), Some(1), "{}", function.name);
        }
    }
}

#[test]
fn functions_of_models_agree_with_the_evaluator() {
    if !has_gcc() {
        return;
    }
    let options = Options::default();
    for kind in [
        FunctionKind::Dirdyna,
        FunctionKind::Invdyna,
        FunctionKind::ConsHJ,
        FunctionKind::ConsJdqd,
        FunctionKind::Accelred,
    ] {
        agrees(&generated("four-bar", kind, "$cpu"), &options, 1e-12);
    }
    let many_parts = Options {
        part: 60,
        ..Options::default()
    };
    let bogie = generated("bogie", FunctionKind::Dirdyna, "$cpu");
    agrees(&bogie, &many_parts, 1e-12);
    let trees = generated("bogie", FunctionKind::Dirdyna, "$cpu,inline");
    agrees(&trees, &many_parts, 1e-12);
    let float = Options {
        real: Real::Float,
        ..many_parts.clone()
    };
    agrees(&bogie, &float, 1e-4);
    let library = Options {
        sines: Sines::Library,
        order: StatementOrder::Program,
        ..many_parts.clone()
    };
    agrees(&bogie, &library, 1e-12);
    let plain = Options {
        signature: Signature::Plain,
        ..many_parts.clone()
    };
    agrees(&bogie, &plain, 1e-12);
    // A project of before 2015 has other names for the same things.
    let mut old = bogie.clone();
    let structure = ("structure".to_owned(), "MBSdataStruct".to_owned());
    old.functions[0].metadata.push(structure);
    let view = View {
        tables: &old.tables,
        function: &old.functions[0],
    };
    assert_eq!(function_name(view, &many_parts), "dirdyna");
    agrees(&old, &many_parts, 1e-12);
}

/// Where an array is both input and output, no element is overwritten before it
/// is read.
#[test]
fn forces_that_are_added_to_are_read_first() {
    if !has_gcc() {
        return;
    }
    let text = "function extforces equations {\n  in q[1..2]\n  in frc[1..3,1..2]\n  in trq[1..3,1..2]\n  \
                out frc[1..3,1..2]\n  out trq[1..3,1..2]\n\n  %x = q[1]*frc[1,1]\n\n  \
                frc[1,1] = frc[1,2]\n  frc[1,2] = frc[1,1] + %x\n  frc[2,1] = frc[1,1]\n  \
                trq[3,2] = frc[2,1]*%x\n  trq[2,1] = trq[3,2]\n}\n";
    let module = robovec_ir::parse::parse_module("test", text).expect("well-formed");
    for part in [1, 500] {
        let options = Options {
            part,
            ..Options::default()
        };
        agrees(&module, &options, 1e-15);
    }
}

/// The command writes all that is needed to try a file alone, and the program
/// compares it with Robotran's own.
#[test]
fn the_command_writes_files_that_compile() {
    if !has_gcc() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension");
    let written = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("gen")
        .arg(examples.join("mbs_dirdyna_suspension.c"))
        .args([
            "--language",
            "c",
            "--bounded",
            "--test-main",
            "--rivals",
            "robotrans_own",
        ])
        .args(["--passes", "$cpu", "-o"])
        .arg(folder.path())
        .output()
        .expect("it runs");
    let message = String::from_utf8_lossy(&written.stderr);
    assert!(written.status.success(), "{message}");
    let names = String::from_utf8_lossy(&written.stdout).into_owned();
    let stem = "mbs_dirdyna_suspension";
    for name in ["_test.c", ".c", ".h"] {
        assert!(names.contains(&format!("{stem}{name}")), "{names}");
    }
    let compile = |arguments: &[&str]| {
        let compiled = Command::new("gcc")
            .current_dir(folder.path())
            .args(arguments)
            .output()
            .expect("gcc is there");
        let message = String::from_utf8_lossy(&compiled.stderr);
        assert!(compiled.status.success(), "{message}");
    };
    let own = examples.join(stem).with_extension("c");
    let own = own.to_string_lossy();
    compile(&[
        "-Dmbs_dirdyna=robotrans_own",
        "-I.",
        "-c",
        &own,
        "-o",
        "own.o",
    ]);
    compile(&[
        &format!("{stem}.c"),
        &format!("{stem}_test.c"),
        "own.o",
        "-o",
        "try",
        "-lm",
    ]);
    let tried = Command::new(folder.path().join("try"))
        .output()
        .expect("it runs");
    let text = String::from_utf8_lossy(&tried.stdout);
    assert!(tried.status.success(), "{text}");
    assert!(text.contains("robotrans_own off by") && text.contains("mbs_dirdyna off by"));
    let refused = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("gen")
        .arg(examples.join("mbs_dirdyna_suspension.c"))
        .args(["--language", "python", "--bounded", "-o"])
        .arg(folder.path())
        .output()
        .expect("it runs");
    assert!(!refused.status.success());
}

#[test]
fn what_has_no_signature_is_refused() {
    let refusal = |text: &str| {
        let module = robovec_ir::parse::parse_module("test", text).expect("well-formed");
        let view = View {
            tables: &module.tables,
            function: &module.functions[0],
        };
        let error = files(view, &Options::default()).expect_err("it has no signature");
        error.to_string()
    };
    let body = "{\n  in q[1..2]\n  out Qq[1..1]\n\n  Qq[1] = q[1]\n}\n";
    assert!(refusal(&format!("function energy equations {body}")).contains("energy"));
    assert!(refusal(&format!("function sensor_1 equations {body}")).contains("sensor"));
    let part = "function accelred_part_1 equations {\n  meta kind \"accelred\"\n  meta part \"1 of 2\"\n}\n";
    assert!(refusal(part).contains("part"));
    let named =
        "function invdyna equations {\n  in while[1..2]\n  out Qq[1..1]\n\n  Qq[1] = while[1]\n}\n";
    assert!(refusal(named).contains("while"));
    let scalar = "function invdyna equations {\n  in q[1..2]\n  out energy\n\n  energy = q[1]\n}\n";
    assert!(refusal(scalar).contains("energy"));
    let call = "function link equations {\n  in F1\n  out Z1\n  call \"user_LinkForces\"(\"Z1\") -> \"F1\"\n\n  Z1 = 1.0\n}\n";
    assert!(refusal(call).contains("user_LinkForces"));
}

/// Angles of every size, and those whose sine or cosine nearly vanishes: the
/// loop is within two units in the last place of the evaluator's library, which
/// has its own error.
#[test]
fn the_loop_of_sines_is_as_exact_as_a_library() {
    if !has_gcc() {
        return;
    }
    let count = 1200u32;
    let mut text = format!(
        "function waves equations {{\n  in q[1..{count}]\n  out s[1..{count}]\n  out c[1..{count}]\n\n"
    );
    for (array, function) in [("s", "sin"), ("c", "cos")] {
        for index in 1..=count {
            text += &format!("  {array}[{index}] = {function}(q[{index}])\n");
        }
    }
    text += "}\n";
    let module = robovec_ir::parse::parse_module("test", &text).expect("well-formed");
    let view = View {
        tables: &module.tables,
        function: &module.functions[0],
    };
    let angle = |index: u32| {
        let step = f64::from(index) * 0.618_033_988_749_895;
        match index % 5 {
            0 => (step - step.floor()) * 1.6 - 0.8,
            1 => step * 0.05 - 18.0,
            2 => (step - 370.0) * 1e3,
            3 => f64::from(index) * std::f64::consts::FRAC_PI_2,
            _ => f64::from(index * 173) * std::f64::consts::FRAC_PI_4,
        }
    };
    let inputs: Vec<f64> = (0..count).map(angle).collect();
    let options = Options {
        signature: Signature::Plain,
        ..Options::default()
    };
    let trial = TrialState::new(view, inputs, 1e-15);
    let output = run(view, &options, &trial, "print");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut seen = 0;
    for line in text.lines().filter(|line| line.contains('[')) {
        let numbers: Vec<f64> = (line.split_whitespace())
            .filter_map(|word| word.parse().ok())
            .collect();
        if let [found, expected] = numbers[..] {
            let off = (found - expected).abs();
            assert!(off <= 2.0 * f64::EPSILON * expected.abs(), "{line}");
            seen += 1;
        }
    }
    assert_eq!(seen, 2 * count);
}
