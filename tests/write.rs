//! The writer of Robotran's files: what it writes reads back as the function
//! it was, in every language, and compiles to the same numbers.

use crate::compiled::{Outcome, Subject, compare, has_gcc};
use crate::support::files::{compare_with_record, each};
use robovec::generate::{GenerationRequest, generate};
use robovec::model::mbs::read_mbs;
use robovec::robotran::FunctionKind;
use robovec::robotran::write::{WriteOptions, write};
use robovec::robotran::{Language, read};
use robovec_codegen::c::{Options, Real, Signature as CSignature, Sines, files as c_files};
use robovec_framework::manager::{self, Config};
use robovec_framework::rewrite::lay_out;
use robovec_ir::count::Counts;
use robovec_ir::evaluate::evaluate;
use robovec_ir::parse::parse_module;
use robovec_ir::print::{print_module, print_output};
use robovec_ir::verify::verify;
use robovec_ir::{
    Array, Assignment, Function, Input, Machine, Module, Name, Node, Operand, OperandKind, Output,
    Symbol, View, same_equations,
};
use robovec_num::arithmetic::Binary64;
#[allow(dead_code)]
use robovec_passes::registry::REGISTRY;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::process::Command;

fn read_file(path: &Path) -> Option<Module> {
    let name = path.file_name()?.to_string_lossy().into_owned();
    let bytes = std::fs::read(path).ok()?;
    Some(read(&name, &bytes, None).ok()?.module)
}

/// Writes a module whose functions are of one kind and reads the result.
fn around(module: &Module, language: Language) -> Module {
    let files = match write(module, language, &WriteOptions::default()) {
        Ok(files) => files,
        Err(error) => panic!("{error}"),
    };
    let (name, text) = &files[0];
    match read(name, text.as_bytes(), None) {
        Ok(read) => read.module,
        Err(error) => panic!("{}\n{text}", error.report.render_plain()),
    }
}

/// What a language changes: what user functions are called, which of Python's
/// sensor files a function comes from, and names that no language accepts.
fn normalised(module: &Module) -> Module {
    let mut module = module.clone();
    for function in &mut module.functions {
        for call in &mut function.boundaries {
            let name = call.callee.replace("usrfun.user_", "user_");
            let name = name.replace("usrfun.", "user_");
            let name = name.replace("user_fext", "user_ExtForces");
            let name = name.replace("user_flink", "user_LinkForces");
            call.callee = name.replace("user_call_", "user_");
        }
        function.name = function.name.replace("gensensor", "sensor");
        for index in 0..function.nodes().len() {
            let value = robovec_ir::Value(index as u32);
            let name = function.node(value).name;
            if !name.is_none() && name.suffix > 0 {
                let text = name.display(&module.tables.symbols).replace('.', "_");
                let plain = Name::plain(module.tables.symbols.intern(&text));
                function.node_mut(value).name = plain;
            }
        }
    }
    module
}

/// The function with its arrays in order of their names: where Matlab must
/// return what C keeps in its structure, their order differs.
fn sorted(view: View<'_>) -> Function {
    let old = view.function;
    let mut new = Function::new(&old.name, old.level);
    new.boundaries = old.boundaries.clone();
    let by_name = |arrays: &[Array]| {
        let mut arrays = arrays.to_vec();
        arrays.sort_by_key(|array| view.tables.symbols.text(array.name));
        arrays
    };
    let inputs: HashMap<Symbol, u32> = by_name(old.inputs())
        .iter()
        .map(|array| (array.name, new.add_input(array.name, array.shape).offset))
        .collect();
    let outputs: HashMap<Symbol, u32> = by_name(old.outputs())
        .iter()
        .map(|array| (array.name, new.add_output(array.name, array.shape).offset))
        .collect();
    let mut moved = |operand: Operand| match operand.kind() {
        OperandKind::Input(input) => {
            let (array, _, _) = old.input_element(input);
            Input(inputs[&array.name] + input.0 - array.offset).into()
        }
        OperandKind::Constant(constant) => new.constant(old.constant_number(constant)).into(),
        OperandKind::Value(_) | OperandKind::None => operand,
    };
    let nodes: Vec<Node> = (old.nodes().iter())
        .map(|node| Node {
            operands: node.operands.map(&mut moved),
            ..*node
        })
        .collect();
    let assignments = (old.assignments.iter())
        .map(|assignment| {
            let (array, _, _) = old.output_element(assignment.output);
            Assignment {
                output: Output(outputs[&array.name] + assignment.output.0 - array.offset),
                operand: moved(assignment.operand),
                ..*assignment
            }
        })
        .collect();
    new.assignments = assignments;
    for node in nodes {
        new.push(node);
    }
    new.sort_assignments();
    lay_out(&new)
}

fn assert_same(expected: &Module, found: &Module, what: &str) {
    let (expected, found) = (normalised(expected), normalised(found));
    assert_eq!(expected.functions.len(), found.functions.len(), "{what}");
    for (left, right) in expected.functions.iter().zip(&found.functions) {
        let (left, right) = (
            View {
                tables: &expected.tables,
                function: left,
            },
            View {
                tables: &found.tables,
                function: right,
            },
        );
        assert_eq!(verify(right), [], "{what}");
        let (sorted_left, sorted_right) = (sorted(left), sorted(right));
        let sorted_left = View {
            function: &sorted_left,
            ..left
        };
        let sorted_right = View {
            function: &sorted_right,
            ..right
        };
        if !same_equations(left, right) && !same_equations(sorted_left, sorted_right) {
            let without_places = |module: &Module| {
                let text = print_module(module);
                let lines = text
                    .lines()
                    .map(|line| line.split(" @").next().unwrap_or(line));
                lines
                    .filter(|line| !line.starts_with("source ") && !line.contains("meta "))
                    .collect::<Vec<_>>()
                    .join("\n")
            };
            let alone = |view: View<'_>, function: Function| Module {
                tables: view.tables.clone(),
                functions: vec![function],
            };
            let (before, after) = (alone(left, sorted(left)), alone(right, sorted(right)));
            let (before, after) = (without_places(&before), without_places(&after));
            for (left, right) in before.lines().zip(after.lines()) {
                assert_eq!(left, right, "{what}");
            }
            panic!("{what}: {} differs", left.function.name);
        }
    }
}

fn equation_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() {
            equation_files(&path, files);
            continue;
        }
        let name = path
            .file_name()
            .expect("an entry has a name")
            .to_string_lossy();
        let extension = name.rsplit('.').next().unwrap_or_default();
        if name.starts_with("mbs_") && ["c", "m", "py"].contains(&extension) {
            files.push(path);
        }
    }
    files.sort();
}

/// Every module of `tests/write` in every language, as it is written; each
/// must also read back.
#[test]
fn modules_become_files() {
    each("tests/write", &["rvir"], |path| {
        let source = std::fs::read_to_string(path).expect("a readable file");
        let name = path.file_name().expect("a file").to_string_lossy();
        let module = parse_module(&name, &source).expect("a well-formed test file");
        let mut text = String::new();
        for language in Language::ALL {
            let files = write(&module, language, &WriteOptions::default());
            for (name, content) in files.expect("it can be written") {
                text += &format!("==> {name} <==\n{content}\n");
            }
            around(&module, language);
        }
        let text = text.replace(env!("CARGO_PKG_VERSION"), "VERSION");
        let folder = path.parent().expect("files lie in folders");
        compare_with_record(&folder.join("snapshots"), &name, text.trim_end());
    });
}

#[test]
fn examples_read_back_in_every_language() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension");
    let mut files = Vec::new();
    equation_files(&root, &mut files);
    assert!(files.len() >= 21);
    for path in files {
        let module = read_file(&path).expect("a good file");
        for language in Language::ALL {
            let what = format!("{} in {language}", path.display());
            let once = around(&module, language);
            assert_same(&module, &once, &what);
            for other in Language::ALL {
                assert_same(
                    &module,
                    &around(&once, other),
                    &format!("{what}, then {other}"),
                );
            }
        }
    }
}

/// Matlab and Python, written as C and compiled, give the evaluator's numbers
/// bit for bit.
#[test]
fn written_c_compiles_to_the_same_numbers() {
    if !has_gcc() {
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut files = Vec::new();
    equation_files(&root.join("examples/suspension"), &mut files);
    files.retain(|path| path.extension().is_some_and(|extension| extension != "c"));
    assert!(files.len() >= 14);
    // Files of Matlab and Python have the same names in C.
    for language in ["m", "py"] {
        let mut subjects = Vec::new();
        for path in &files {
            if path
                .extension()
                .is_none_or(|extension| extension != language)
            {
                continue;
            }
            let module = read_file(path).expect("a good file");
            let written = write(&module, Language::C, &WriteOptions::default()).expect("it is C");
            for (name, text) in &written {
                std::fs::write(folder.path().join(name), text).expect("a temporary file");
            }
            let (name, text) = written[0].clone();
            subjects.push(Subject { name, text });
        }
        let headers = [folder.path().to_owned()];
        for (subject, outcome) in subjects.iter().zip(compare(&subjects, &headers)) {
            assert!(
                matches!(outcome, Outcome::Equal(_)),
                "{}: {outcome:?}",
                subject.name
            );
        }
    }
}

/// The C for processors reads back where it is one straight-line function,
/// and says what it is where it is not.
#[test]
fn c_for_processors_reads_back_or_says_why_not() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension");
    let straight = Options {
        sines: Sines::Library,
        ..Options::default()
    };
    let plain = Options {
        signature: CSignature::Plain,
        ..straight.clone()
    };
    let refused = [
        (Options::default(), "sines of this file as a loop"),
        (
            Options {
                part: 20,
                ..straight.clone()
            },
            "in several parts",
        ),
        (
            Options {
                real: Real::Float,
                ..plain.clone()
            },
            "another type than `double`",
        ),
    ];
    for kind in ["dirdyna", "invdyna", "cons_hJ", "cons_jdqd"] {
        let module = read_file(&root.join(format!("mbs_{kind}_suspension.m"))).expect("good");
        let view = View {
            tables: &module.tables,
            function: &module.functions[0],
        };
        let again = |options: &Options| {
            let [(name, text), _] = c_files(view, options).expect("it is C");
            read(&name, text.as_bytes(), None)
        };
        for options in [&straight, &plain] {
            let read =
                again(options).unwrap_or_else(|error| panic!("{}", error.report.render_plain()));
            let found = View {
                tables: &read.module.tables,
                function: &read.module.functions[0],
            };
            assert_eq!(numbers(view), numbers(found), "{kind}");
        }
        if kind == "dirdyna" {
            for (options, why) in &refused {
                let text = again(options)
                    .expect_err("it is refused")
                    .report
                    .render_plain();
                assert!(text.contains(why), "{text}");
            }
        }
    }
}

/// `robovec check` takes the C that robovec writes.
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

/// What a pipeline of exact passes makes of an example is written, read and
/// still the same function.
#[test]
fn optimised_equations_are_written() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension");
    let pipeline = REGISTRY
        .pipeline("atomise,fold,cse,dce,inline")
        .expect("a good pipeline");
    let machine = Machine::built_in("thesis").expect("it ships");
    let mut files = Vec::new();
    equation_files(&root, &mut files);
    for path in files {
        let original = read_file(&path).expect("a good file");
        let mut module = original.clone();
        let mut log = Vec::new();
        manager::run(&mut module, &pipeline, Config::new(&machine, &mut log)).expect("it runs");
        for language in Language::ALL {
            let again = around(&module, language);
            for (before, after) in original.functions.iter().zip(&again.functions) {
                let before = View {
                    tables: &original.tables,
                    function: before,
                };
                let after = View {
                    tables: &again.tables,
                    function: after,
                };
                assert!(
                    operations(after) <= operations(before),
                    "{}",
                    path.display()
                );
                assert_eq!(numbers(before), numbers(after), "{}", path.display());
            }
        }
    }
}

fn operations(view: View<'_>) -> usize {
    Counts::of(view.function).operations
}

/// The outputs' bits by name, zeros without their signs, where every input
/// has a number that depends on its name alone.
fn numbers(view: View<'_>) -> BTreeMap<String, u64> {
    let inputs: Vec<f64> = (0..view.function.input_len() as u32)
        .map(|input| number(&input_name(view, Input(input))))
        .collect();
    let results = evaluate(view.function, &Binary64, &inputs);
    let outputs = view.function.assignments.iter().zip(results);
    outputs
        .map(|(assignment, result)| {
            (
                print_output(view, assignment.output),
                (result + 0.0).to_bits(),
            )
        })
        .collect()
}

fn input_name(view: View<'_>, input: Input) -> String {
    let (array, indices, rank) = view.function.input_element(input);
    let name = view.tables.symbols.text(array.name);
    format!("{name}{:?}", &indices[..rank])
}

fn number(name: &str) -> f64 {
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325, mix);
    0.25 + (hash >> 40) as f64 / f64::from(1 << 24)
}

/// Written Python runs, and gives the evaluator's numbers.
#[test]
fn written_python_computes_the_same_numbers() {
    if Command::new("python3").arg("--version").output().is_err() {
        eprintln!("no python3: the written Python is not run");
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension");
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (kind, call) in [
        ("dirdyna", "dirdyna(out['M'], out['c'], s, 0.0)"),
        ("invdyna", "invdyna(out['Qq'], s, 0.0)"),
        ("cons_hJ", "cons_hJ(out['h'], out['Jac'], s)"),
        ("cons_jdqd", "cons_jdqd(out['Jdqd'], s)"),
    ] {
        let module = read_file(&root.join(format!("mbs_{kind}_suspension.c"))).expect("good");
        let view = View {
            tables: &module.tables,
            function: &module.functions[0],
        };
        let files = write(&module, Language::Python, &WriteOptions::default()).expect("Python");
        // Arrays that take one index or two, and a structure that holds them.
        let mut script = "import struct\nclass S: pass\ns = S()\nout = {}\n".to_owned();
        for array in view.function.inputs() {
            let name = module.tables.symbols.text(array.name);
            script += &format!("s.{name} = {{}}\n");
        }
        for array in view.function.outputs() {
            script += &format!("out['{}'] = {{}}\n", module.tables.symbols.text(array.name));
        }
        for input in 0..view.function.input_len() as u32 {
            let (array, indices, rank) = view.function.input_element(Input(input));
            let name = module.tables.symbols.text(array.name);
            let indices: Vec<String> = indices[..rank].iter().map(u32::to_string).collect();
            let number = number(&input_name(view, Input(input)));
            script += &format!("s.{name}[{}] = {number:?}\n", indices.join(","));
        }
        script += &files[0].1;
        script += &format!(
            "\n{call}\nfor name in out:\n  for at in sorted(out[name]):\n    \
             index = ','.join(map(str, at)) if isinstance(at, tuple) else str(at)\n    \
             bits = struct.unpack('<Q', struct.pack('<d', out[name][at] + 0.0))[0]\n    \
             print('%s[%s] %d' % (name, index, bits))\n"
        );
        let path = folder.path().join(format!("{kind}.py"));
        std::fs::write(&path, script).expect("a temporary file");
        let run = Command::new("python3")
            .arg(&path)
            .output()
            .expect("it runs");
        let errors = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "{kind}: {errors}");
        let found: BTreeMap<String, u64> = String::from_utf8_lossy(&run.stdout)
            .lines()
            .filter_map(|line| line.split_once(' '))
            .map(|(name, bits)| (name.to_owned(), bits.parse().expect("bits")))
            .collect();
        assert_eq!(found, numbers(view), "{kind}");
    }
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
        .arg("write")
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
        .arg("write")
        .arg(folder.path().join("mbs_cons_hJ_other.c"))
        .args(["--language", "c", "-o"])
        .arg(folder.path())
        .output()
        .expect("it runs");
    assert!(!over.status.success());
    assert!(String::from_utf8_lossy(&over.stderr).contains("would be overwritten"));
    let several = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("write")
        .arg(&input)
        .arg(input.with_file_name("mbs_link_suspension.py"))
        .args(["--language", "matlab", "-o"])
        .arg(folder.path())
        .output()
        .expect("it runs");
    assert_eq!(String::from_utf8_lossy(&several.stdout).lines().count(), 2);
    let refused = Command::new(env!("CARGO_BIN_EXE_robovec"))
        .arg("write")
        .arg(input.with_file_name("README.md"))
        .args(["--language", "matlab", "-o"])
        .arg(folder.path().join("none"))
        .output()
        .expect("it runs");
    assert!(!refused.status.success());
    assert!(!folder.path().join("none").exists());
}

/// The same for any other folder, which the environment names.
#[test]
fn files_elsewhere_read_back() {
    let Some(folder) = std::env::var_os("ROBOVEC_EQUATION_FILES") else {
        return;
    };
    let mut files = Vec::new();
    equation_files(Path::new(&folder), &mut files);
    let (mut count, mut failures) = (0, 0);
    for path in files {
        let Some(module) = read_file(&path) else {
            println!("not read: {}", path.display());
            continue;
        };
        for language in Language::ALL {
            let what = format!("{} in {language}", path.display());
            let result = std::panic::catch_unwind(|| {
                assert_same(&module, &around(&module, language), &what);
            });
            failures += usize::from(result.is_err());
        }
        count += 1;
    }
    println!("{count} files read back, {failures} differ");
    assert_eq!(failures, 0);
}

/// What the generator writes, a user drops in the place of Robotran's files:
/// our reader must find in them the very function that was generated.
#[test]
fn generated_functions_read_back_in_every_language() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    for name in [
        "double-pendulum",
        "four-bar",
        "slider-crank",
        "quarter-car",
        "bogie",
    ] {
        let bytes = std::fs::read(folder.join(name).with_extension("mbs")).expect("it ships");
        let model = read_mbs(name, &bytes).expect("it is a good model").model;
        for kind in FunctionKind::ALL {
            let module =
                generate(&model, &GenerationRequest::new(kind)).expect("it is a good model");
            // A model without sensors has no function of them.
            if module.functions.is_empty() {
                continue;
            }
            for language in Language::ALL {
                let what = format!("{} of {name} in {language}", kind.name());
                assert_same(&module, &around(&module, language), &what);
            }
        }
    }
}
