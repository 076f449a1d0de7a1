//! The reader of Robotran's files: results for good files, messages for bad
//! ones, and no panic or hang for any text.

use crate::support::files::{self, each};
use robovec::robotran::{Language, Read, ReadError, read};
use robovec_ir::count::Counts;
use robovec_ir::parse::parse_module;
use robovec_ir::print::print_module;
use robovec_ir::verify::verify;
use robovec_ir::{Array, Module, Operation, Shape, View};
use robovec_num::random::Random;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The file's bytes, and its name without the folder, which may lie anywhere.
fn load(path: &Path) -> (String, Vec<u8>) {
    let name = path
        .file_name()
        .expect("glob gives files")
        .to_string_lossy();
    (
        name.into_owned(),
        std::fs::read(path).expect("glob gives readable files"),
    )
}

/// Compares with the recorded output for the file.
fn compare(path: &Path, text: &str) {
    let folder = path.parent().expect("files lie in folders");
    files::compare_with_record(
        &folder.join("snapshots"),
        &files::name(path),
        text.trim_end(),
    );
}

#[test]
fn files_become_modules() {
    each("tests/parse", &["c", "m", "py"], |path| {
        let (name, bytes) = load(path);
        let text = match read(&name, &bytes, None) {
            Ok(read) => print_module(&read.module) + "\n" + &read.warnings.render_plain(),
            Err(error) => panic!("{}", error.report.render_plain()),
        };
        compare(path, &text);
    });
}

#[test]
fn modules_keep_the_invariants_and_survive_their_text() {
    for path in example_files() {
        let (name, bytes) = load(&path);
        let module = read(&name, &bytes, None).expect("a good file").module;
        for function in &module.functions {
            let tables = &module.tables;
            assert_eq!(verify(View { tables, function }), [], "{name}");
        }
        let again = parse_module(&name, &print_module(&module)).expect("printed text is good");
        assert_eq!(again, module, "{name}");
    }
}

#[test]
fn bad_files_are_refused_with_places() {
    each("tests/errors/robotran", &["c", "m", "py", "txt"], |path| {
        let (name, bytes) = load(path);
        let error = read(&name, &bytes, None).expect_err("the file is bad");
        assert!(error.report.has_errors());
        compare(path, &error.report.render_plain());
    });
}

fn c_function(body: &str) -> String {
    format!("void mbs_invdyna(double *Qq, MbsData *s, double tsim)\n{{\n{body}\n}}\n")
}

fn read_text(text: &str, language: Language) -> Result<Read, ReadError> {
    read("test", text.as_bytes(), Some(language))
}

#[test]
fn deep_nesting_is_read() {
    let depth = 100_000;
    let sum = format!(
        "Qq[1] = {}q[1]+q[2]{};",
        "(".repeat(depth),
        ")".repeat(depth)
    );
    let read = read_text(&c_function(&sum), Language::C).expect("nesting is no error");
    assert_eq!(Counts::of(&read.module.functions[0]).operations, 1);
    let minuses = format!(
        "Qq[1] = q[1]*{}q[2];",
        "-(".repeat(depth) + "-q[3]" + &")".repeat(depth) + "*"
    );
    let read = read_text(&c_function(&minuses), Language::C).expect("nesting is no error");
    assert_eq!(Counts::of(&read.module.functions[0]).operations, depth + 3);
    assert!(print_module(&read.module).len() > depth);
}

#[test]
fn a_million_terms_are_read() {
    let terms = 1_000_000;
    let sum = format!("Qq[1] = q[1]{};", "+q[2]".repeat(terms - 1));
    let read = read_text(&c_function(&sum), Language::C).expect("a long sum is no error");
    assert_eq!(Counts::of(&read.module.functions[0]).operations, terms - 1);
}

#[test]
fn a_million_parentheses_are_refused() {
    for language in Language::ALL {
        for text in [
            "(", "a = (", "a(", "if (", "{", "[", "a = -", "/*", "\"", "%{\n", "def f(", "#if 0\n",
        ] {
            let text = text.repeat((1 << 20) / text.len());
            let error = read_text(&text, language).expect_err("no function");
            assert!(error.report.render_plain().len() < 100_000);
        }
    }
}

#[test]
fn hostile_structures_take_no_more_than_linear_time() {
    let head = "void mbs_sensor(MbsSensor *sens, MbsData *s, int isens)\n{\n";
    let switch = format!("{head}A1 = q[1];\nswitch(isens)\n{{\n");
    let repeated: [(&str, &str, &str); 9] = [
        (head, "{a=1;", ""),
        (head, "if(a){b=1;", ""),
        (head, "if(a){b=q[1000];}", "}"),
        (&switch, "case 1: case 2: P[1] = 1;\n", ""),
        (head, "#ifdef A\n", ""),
        (head, "#define AA s->b\n", "}"),
        ("", "void f(){a=q[1];}\n", ""),
        ("% \u{e9}\nfunction [c] = f(s)\n", "a = q(1);", "\n"),
        ("function [c] = f(s)\n", "a = s.a;", "\n"),
    ];
    for (before, piece, after) in repeated {
        let text = format!("{before}{}{after}", piece.repeat((1 << 20) / piece.len()));
        let start = std::time::Instant::now();
        let _ = read("hostile", text.as_bytes(), None);
        let elapsed = start.elapsed();
        assert!(elapsed.as_secs() < 20, "{piece}: {elapsed:?}");
    }
    let cases: String = (1..40_000)
        .map(|case| format!("case {case}: P[1] = A1; break;\n"))
        .collect();
    assert!(read_text(&format!("{switch}{cases}}}}}\n"), Language::C).is_err());
}

fn example_files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files: Vec<PathBuf> = ["examples/suspension", "examples/thesis", "tests/parse"]
        .iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).expect("the folder exists"))
        .map(|entry| entry.expect("readable folder").path())
        .filter(|path| {
            let extension = path.extension().and_then(|extension| extension.to_str());
            // A header declares temporaries and holds nothing to read.
            extension != Some("h") && extension.and_then(Language::from_extension).is_some()
        })
        .collect();
    files.sort();
    files
}

#[test]
fn truncated_files_do_not_panic() {
    for path in example_files() {
        let (name, bytes) = load(&path);
        let step = (bytes.len() / 150).max(1);
        for end in (0..bytes.len()).step_by(step) {
            let _ = read(&name, &bytes[..end], None);
        }
    }
}

#[test]
fn files_with_flipped_bits_do_not_panic() {
    let mut random = Random::new(1);
    for path in example_files() {
        let (name, bytes) = load(&path);
        for _ in 0..150 {
            let mut damaged = bytes.clone();
            for _ in 0..3 {
                let at = random.below(damaged.len());
                damaged[at] ^= 1 << random.below(8);
            }
            if let Ok(read) = read(&name, &damaged, None) {
                assert!(!print_module(&read.module).is_empty());
            }
        }
    }
}

#[test]
fn a_cut_example_is_an_error_wherever_a_function_is_open() {
    for path in example_files() {
        let (name, bytes) = load(&path);
        let text = String::from_utf8_lossy(&bytes);
        let complete = name.ends_with(".c") && text.contains("= ");
        if let Some(end) = text.rfind('}').filter(|_| complete) {
            let last = text[..end]
                .rfind(';')
                .expect("equations end with a semicolon");
            assert!(
                read(&name, text[..last].as_bytes(), None).is_err(),
                "{name}"
            );
        }
    }
}

#[test]
fn reading_is_deterministic() {
    for path in example_files() {
        let (name, bytes) = load(&path);
        let once = read(&name, &bytes, None).expect("a good file");
        let again = read(&name, &bytes, None).expect("a good file");
        assert_eq!(print_module(&once.module), print_module(&again.module));
        assert_eq!(once.module, again.module);
    }
}

/// The only function of a text, and the shapes of its inputs by name.
fn shapes(text: &str, language: Language) -> (Module, BTreeMap<String, Shape>) {
    let module = match read_text(text, language) {
        Ok(read) => read.module,
        Err(error) => panic!("{}", error.report.render_plain()),
    };
    let inputs = module.functions[0].inputs().iter();
    let name = |array: &Array| module.tables.symbols.text(array.name).to_owned();
    let shapes = inputs.map(|array| (name(array), array.shape)).collect();
    (module, shapes)
}

#[test]
fn extents_are_those_of_the_header_and_of_all_uses() {
    let header = "//\t==> Array extents : Z(7) l(3,5)\n";
    let text = header.to_owned() + &c_function("Qq[1] = l[2][3]*Z[2];");
    let (_, found) = shapes(&text, Language::C);
    assert_eq!(found["Z"], Shape::Vector(7));
    assert_eq!(found["l"], Shape::Matrix(3, 5));
    // A copy and its original begin as one input.
    let text = "function [Qq] = mbs_invdyna(s,tsim)\nfrc = s.frc;\n\
                Qq(1) = frc(1,2)+s.frc(2,5);\n";
    let (module, found) = shapes(text, Language::Matlab);
    assert_eq!(found["frc"], Shape::Matrix(3, 5));
    let printed = print_module(&module);
    assert!(printed.contains("frc[1,2] + frc[2,5]"), "{printed}");
}

#[test]
fn control_ends_cases_and_functions() {
    let text = c_function("Qq[1] = q[1];\nreturn;\nQq[2] = q[2];");
    let (module, _) = shapes(&text, Language::C);
    assert_eq!(module.functions[0].assignments.len(), 1);
    let text = "void mbs_sensor(MbsSensor *sens, MbsData *s, int isens)\n{\nswitch(isens)\n{\n\
                case 1:\n    sens->P[1] = s->q[1];\ncase 2:\n    sens->P[2] = s->q[2];\nbreak;\n\
                }\n}\n";
    let error = read_text(text, Language::C).expect_err("a case runs into the next one");
    let shown = error.report.render_plain();
    assert!(
        shown.contains("a case that runs into the next one"),
        "{shown}"
    );
}

#[test]
fn the_last_of_two_values_of_an_output_counts() {
    let text = c_function("Qq[1] = q[1];\nQq[1] = q[2]*2.0;");
    let (module, _) = shapes(&text, Language::C);
    let function = &module.functions[0];
    assert_eq!(function.assignments.len(), 1);
    let value = function.assignments[0].operand.value();
    let value = value.expect("it is computed");
    assert_eq!(function.node(value).operation, Operation::Mul);
}
