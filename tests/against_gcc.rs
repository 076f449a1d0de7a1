//! C as C: every construct gives the number that gcc gives, or is refused.
//!
//! The functions of `semantics/c.txt`, with the messages for refused ones; the
//! examples; and the examples changed at random. The same with Python, and with
//! Matlab where there is an Octave.

use crate::compiled::{
    Outcome, Subject, compare, compare_octave, compare_python, compare_within, has_gcc,
};
use crate::mutation::Mutator;
use crate::support::files::{compare_with_record, tree};
use robovec::robotran::{Language, read};
use std::path::{Path, PathBuf};

/// The functions of a file of `semantics`: `== name`, then the statements, or
/// the whole text of a file.
fn functions(file: &str, around: impl Fn(&str) -> String) -> Vec<(String, String)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/semantics");
    let text = std::fs::read_to_string(path.join(file)).expect("a file of the repository");
    let text = format!("\n{text}");
    let parts = text.split("\n== ").skip(1);
    let functions = parts.map(|part| {
        let (name, body) = part.split_once('\n').expect("a name on its line");
        let whole = ["void ", "static ", "double gain"]
            .iter()
            .any(|head| body.starts_with(head) && body.contains("MbsData *s"));
        let text = if whole { body.to_owned() } else { around(body) };
        (name.to_owned(), text)
    });
    functions.collect()
}

fn in_c(body: &str) -> String {
    format!(
        "void mbs_invdyna(double *Qq, MbsData *s, double tsim)\n{{\n\
         double *q = s->q, *qd = s->qd;\ndouble **dpt = s->dpt;\n{body}}}\n"
    )
}

fn in_matlab(body: &str) -> String {
    format!("function [Qq] = invdyna(s,tsim,usrfun)\nq = s.q;\n{body}")
}

fn in_python(body: &str) -> String {
    let body = body.replace('\n', "\n    ");
    format!(
        "from math import *\nfrom numpy import zeros\ndef invdyna(phi, s, tsim):\n    Qq = phi\n    q = s.q\n    {body}\n"
    )
}

/// Verdicts on every function of a file.
fn verdicts(functions: &[(String, String)], language: Language) -> String {
    let mut text = String::new();
    for (name, source) in functions {
        let verdict = match read("test", source.as_bytes(), Some(language)) {
            Ok(read) => format!("read\n{}", read.warnings.render_plain()),
            Err(error) => error.report.render_plain(),
        };
        text += &format!("== {name}\n{}\n\n", verdict.trim_end());
    }
    text
}

#[test]
fn every_construct_is_read_or_refused_with_its_place() {
    let folder = tree("tests/semantics");
    let c = functions("c.txt", in_c);
    assert!(c.len() > 120);
    compare_with_record(&folder, "c", &verdicts(&c, Language::C));
    let matlab = functions("matlab.txt", in_matlab);
    compare_with_record(&folder, "matlab", &verdicts(&matlab, Language::Matlab));
    let python = functions("python.txt", in_python);
    compare_with_record(&folder, "python", &verdicts(&python, Language::Python));
}

#[test]
fn constructs_of_c_give_the_numbers_of_gcc() {
    if !has_gcc() {
        return;
    }
    let subjects = named(functions("c.txt", in_c), "c");
    let counts = Counts::of(&subjects, &compare(&subjects, &[]));
    assert!(counts.equal >= 40 && counts.refused >= 60, "{counts:?}");
}

/// Number of files with each outcome.
#[derive(Default, Debug)]
struct Counts {
    equal: usize,
    refused: usize,
    only_read: usize,
    not_compared: usize,
}

impl Counts {
    /// Counts; a number that differs is a failure.
    fn of(subjects: &[Subject], outcomes: &[Outcome]) -> Counts {
        let mut counts = Counts::default();
        let mut different = Vec::new();
        for (subject, outcome) in subjects.iter().zip(outcomes) {
            match outcome {
                Outcome::Equal(_) => counts.equal += 1,
                Outcome::Refused(_) => counts.refused += 1,
                Outcome::OnlyRead => counts.only_read += 1,
                Outcome::NotCompared => counts.not_compared += 1,
                Outcome::Differs(difference) => {
                    different.push(format!("{}: {difference}\n{}", subject.name, subject.text));
                }
            }
        }
        println!("{counts:?}, {} differ", different.len());
        assert!(different.is_empty(), "{}", different.join("\n"));
        counts
    }
}

fn has(program: &str) -> bool {
    let found = std::process::Command::new(program)
        .arg("--version")
        .output()
        .is_ok();
    if !found {
        eprintln!("no {program}: nothing is compared with it");
    }
    found
}

#[test]
fn constructs_of_python_give_the_numbers_of_python() {
    if !has("python3") {
        return;
    }
    let subjects = named(functions("python.txt", in_python), "py");
    let counts = Counts::of(&subjects, &compare_python(&subjects));
    assert!(counts.equal >= 12 && counts.refused >= 20, "{counts:?}");
    let subjects = files(&examples(), "py");
    let counts = Counts::of(&subjects, &compare_python(&subjects));
    assert_eq!(counts.equal, subjects.len());
}

#[test]
fn constructs_of_matlab_give_the_numbers_of_octave() {
    if has("octave-cli") {
        let subjects = named(functions("matlab.txt", in_matlab), "m");
        let counts = Counts::of(&subjects, &compare_octave(&subjects));
        assert!(counts.equal >= 10 && counts.refused >= 20, "{counts:?}");
    }
}

#[test]
fn changed_examples_of_python_give_the_numbers_of_python_or_are_refused() {
    if has("python3") {
        let counts = mutants(2, 210, Language::Python);
        assert!(counts.equal > 20 && counts.refused > 20, "{counts:?}");
    }
}

fn named(functions: Vec<(String, String)>, extension: &str) -> Vec<Subject> {
    let subjects = functions.into_iter().map(|(name, text)| Subject {
        name: format!("{name}.{extension}"),
        text,
    });
    subjects.collect()
}

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension")
}

/// The files of a folder in a language.
fn files(folder: &Path, extension: &str) -> Vec<Subject> {
    let entries = std::fs::read_dir(folder).expect("a readable folder");
    let paths = entries.map(|entry| entry.expect("a readable folder").path());
    let mut paths: Vec<PathBuf> = paths
        .filter(|path| path.extension().is_some_and(|found| found == extension))
        .collect();
    paths.sort();
    paths.iter().map(|path| subject(path)).collect()
}

/// A file by its name.
fn subject(path: &Path) -> Subject {
    let bytes = std::fs::read(path).expect("a readable file");
    let name = path.file_name().expect("a file");
    Subject {
        name: name.to_string_lossy().into_owned(),
        text: String::from_utf8_lossy(&bytes).into_owned(),
    }
}

#[test]
fn examples_give_the_numbers_of_gcc() {
    if !has_gcc() {
        return;
    }
    let subjects = files(&examples(), "c");
    let counts = Counts::of(&subjects, &compare(&subjects, &[examples()]));
    assert_eq!(counts.equal, subjects.len());
}

/// Changes the examples at random and compares those that are still read.
fn mutants(seed: u64, count: usize, language: Language) -> Counts {
    let extension = if language == Language::C { "c" } else { "py" };
    let bases = files(&examples(), extension);
    let mut mutator = Mutator::new(seed);
    let subjects: Vec<Subject> = (0..count)
        .map(|index| {
            let base = &bases[index % bases.len()];
            Subject {
                name: base.name.clone(),
                text: mutator.mutant(&base.text, language),
            }
        })
        .collect();
    let outcomes = match language {
        Language::Python => compare_python(&subjects),
        Language::C | Language::Matlab => compare(&subjects, &[examples()]),
    };
    Counts::of(&subjects, &outcomes)
}

#[test]
fn changed_examples_give_the_numbers_of_gcc_or_are_refused() {
    if has_gcc() {
        let counts = mutants(1, 210, Language::C);
        assert!(counts.equal > 20 && counts.refused > 20, "{counts:?}");
    }
}

/// The same at length; `ROBOVEC_MUTANTS` gives their number.
#[test]
#[ignore = "takes minutes"]
fn many_changed_examples() {
    let count = std::env::var("ROBOVEC_MUTANTS").ok();
    let count = count.and_then(|text| text.parse().ok()).unwrap_or(3000);
    for seed in 0..count / 500 {
        mutants(1000 + seed, 500, Language::C);
        mutants(2000 + seed, 500, Language::Python);
    }
}

/// Files named in the environment, with their headers beside them.
#[test]
#[ignore = "compares the files that ROBOVEC_C_FILES names"]
fn files_elsewhere() {
    let Some(files) = std::env::var_os("ROBOVEC_C_FILES") else {
        return;
    };
    for path in std::env::split_paths(&files) {
        let folder = std::path::absolute(path.parent().unwrap_or(Path::new(".")));
        let outcome = &compare_within(400, &[subject(&path)], &[folder.expect("a folder")])[0];
        println!("{}: {outcome:?}", path.display());
        assert!(!matches!(outcome, Outcome::Differs(_)));
    }
}
