//! The writer of Robotran's files: what it writes reads back as the function
//! it was, in every language, and compiles to the same numbers.

use robovec::generate::{FunctionKind, Request, generate};
use robovec::model::mbs::read_mbs;
use robovec::robotran::write::{WriteOptions, write};
use robovec::robotran::{Language, read};
use robovec_ir::parse::parse_module;
use robovec_ir::print::print_module;
use robovec_ir::verify::verify;
use robovec_ir::{
    Array, Assignment, Function, Input, Module, Name, Node, Operand, OperandKind, Output, Symbol,
    View, same_equations,
};
use robovec_passes::rewrite::lay_out;
use std::collections::HashMap;
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
    insta::glob!("write/*.rvir", |path| {
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
        let mut settings = insta::Settings::clone_current();
        let folder = path.parent().expect("files lie in folders");
        settings.set_snapshot_path(folder.join("snapshots"));
        settings.set_prepend_module_to_snapshot(false);
        settings.remove_snapshot_suffix();
        settings.set_omit_expression(true);
        settings.remove_input_file();
        settings.bind(|| insta::assert_snapshot!(name.into_owned(), text.trim_end()));
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
    if Command::new("gcc").arg("--version").output().is_err() {
        eprintln!("no gcc: the written C is not compiled");
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut files = Vec::new();
    equation_files(&root.join("examples/suspension"), &mut files);
    files.retain(|path| path.extension().is_some_and(|extension| extension != "c"));
    assert!(files.len() >= 14);
    for path in files {
        let module = read_file(&path).expect("a good file");
        let written = write(&module, Language::C, &WriteOptions::default()).expect("it is C");
        for (name, text) in &written {
            std::fs::write(folder.path().join(name), text).expect("a temporary file");
        }
        let compared = Command::new("bash")
            .arg(root.join("scripts/compare-with-gcc.sh"))
            .arg(folder.path().join(&written[0].0))
            .env("ROBOVEC", env!("CARGO_BIN_EXE_robovec"))
            .output()
            .expect("bash is there");
        let message = String::from_utf8_lossy(&compared.stderr);
        assert!(compared.status.success(), "{}: {message}", path.display());
    }
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
            let module = generate(&model, &Request::new(kind)).expect("it is a good model");
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
