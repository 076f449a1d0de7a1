//! Written equations read back as the same function.

use super::evaluated::numbers;
use super::same::assert_same;
use super::{around, equation_files, read_file};
use crate::support::files::{compare_with_record, each};
use robovec::generate::{GenerationRequest, generate};
use robovec::model::mbs::read_mbs;
use robovec::robotran::write::{WriteOptions, write};
use robovec::robotran::{FunctionKind, Language, read};
use robovec_cgen::c::{Options, Real, Signature as CSignature, Sines, files as c_files};
use robovec_ir::View;
use robovec_ir::parse::parse_module;
use std::path::Path;

/// Every module of `tests/write` in every language; each file must also read
/// back.
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

/// The C for processors reads back where it is one straight-line function, and
/// is otherwise identified in the message.
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

/// The same for any other folder, named in the environment.
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

/// Generated functions take the place of Robotran's files: our reader must find
/// in them the very function that was generated.
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
