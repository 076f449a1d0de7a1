//! Written equations compute the same numbers.

use super::{around, equation_files, read_file};
use crate::compiled::{Outcome, Subject, compare, has_gcc};
use robovec::robotran::Language;
use robovec::robotran::write::{WriteOptions, write};
use robovec_framework::manager::{self, Config};
use robovec_ir::count::Counts;
use robovec_ir::evaluate::evaluate;
use robovec_ir::print::print_output;
use robovec_ir::{Input, Machine, View};
use robovec_num::arithmetic::Binary64;
use robovec_passes::registry::REGISTRY;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

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

/// The outputs' bits by name, zeros without their signs, for inputs whose
/// numbers depend on their names alone.
pub(super) fn numbers(view: View<'_>) -> BTreeMap<String, u64> {
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

pub(super) fn number(name: &str) -> f64 {
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

/// An example after a pipeline of exact passes is written, read and still the
/// same function.
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
