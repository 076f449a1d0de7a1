//! The writer of Robotran's files: what it writes reads back as the function
//! it was, in every language, and compiles to the same numbers.

use robovec::generate::{FunctionKind, Request, generate};
use robovec::model::mbs::read_mbs;
use robovec::robotran::write::{WriteOptions, write};
use robovec::robotran::{Language, read};
use robovec_ir::print::print_module;
use robovec_ir::verify::verify;
use robovec_ir::{Module, Name, View, same_equations};
use std::path::{Path, PathBuf};

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
            let name = call.callee.replace("usrfun.", "user_");
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
        if !same_equations(left, right) {
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
            let (before, after) = (without_places(&expected), without_places(&found));
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

/// The same for any other folder, which the environment names.
#[test]
fn files_elsewhere_read_back() {
    let Some(folder) = std::env::var_os("ROBOVEC_EQUATION_FILES") else {
        return;
    };
    let mut files = Vec::new();
    equation_files(Path::new(&folder), &mut files);
    let mut count = 0;
    for path in files {
        let Some(module) = read_file(&path) else {
            println!("not read: {}", path.display());
            continue;
        };
        for language in Language::ALL {
            let what = format!("{} in {language}", path.display());
            assert_same(&module, &around(&module, language), &what);
        }
        count += 1;
    }
    println!("{count} files read back");
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
