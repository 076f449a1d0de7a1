//! File tests of passes: `tests/passes/PASS/*.rvir`.
//!
//! The first line of a file gives the pipeline: `// RUN: PIPELINE [MACHINE]`;
//! the machine is the last word, if it is the name of one that ships. A scene
//! beside it (`NAME.scene.toml` for `NAME.rvir`) is used. Every pass runs under
//! the verifier and the semantic check; the expected text is the function after
//! the pipeline, or the message when it must fail. Each folder is a separate
//! test, which names all files that fail.

use crate::support::files::{compare_with_record, each, name, tree};
use robovec::scene::SceneFile;
use robovec_framework::manager::{self, Config};
use robovec_ir::{Machine, parse, print};
use robovec_passes::registry::REGISTRY;
use std::fs;
use std::path::Path;

/// One test per folder of `tests/passes`.
macro_rules! folders {
    ($($test:ident $folder:literal)*) => {
        /// The folders that have a test.
        const TESTED: &[&str] = &[$($folder),*];

        $(
            #[test]
            fn $test() {
                files_of($folder);
            }
        )*
    };
}

folders! {
    accurate "accurate"
    accurate_roots "accurate-roots"
    accurate_trig "accurate-trig"
    asap_alap "asap-alap"
    atomise "atomise"
    balance "balance"
    codegen "codegen"
    composite "composite"
    cse "cse"
    dce "dce"
    differentiate "differentiate"
    eqsat "eqsat"
    factor "factor"
    fma "fma"
    fold "fold"
    inline "inline"
    interleave "interleave"
    lookahead "lookahead"
    meet "meet"
    mixed "mixed"
    optimise "optimise"
    pipeline "pipeline"
    place "place"
    recurrence "recurrence"
    specialise "specialise"
    swap "swap"
    trigonometry "trigonometry"
    zero_removal "zero-removal"
}

#[test]
fn every_folder_has_a_test() {
    let entries = fs::read_dir(tree("tests/passes")).expect("the folder of the file tests");
    let mut folders: Vec<String> = entries
        .map(|entry| name(&entry.expect("a readable folder").path()))
        .collect();
    folders.sort();
    assert_eq!(
        folders, TESTED,
        "tests/passes.rs lists them by the alphabet"
    );
}

/// Runs every file of a folder and compares the output with the text beside it.
fn files_of(folder: &str) {
    each(&format!("tests/passes/{folder}"), &["rvir"], |path| {
        let bytes = fs::read(path).expect("a readable file");
        let produced = produce(path, &String::from_utf8_lossy(&bytes));
        let beside = path.parent().expect("a file lies in a folder");
        compare_with_record(beside, &name(path), &produced);
    });
}

/// The words after `// RUN:` on the first line of a test file.
fn directive(text: &str) -> &str {
    let first = text.lines().next().unwrap_or("");
    first
        .trim_start_matches(['/', '%', '#', ' '])
        .strip_prefix("RUN:")
        .expect("the first line of a test file says what to run")
        .trim()
}

fn produce(path: &Path, text: &str) -> String {
    let directive = directive(text);
    let last = directive.rsplit_once(' ');
    let named = last.and_then(|(first, name)| Some((first, Machine::built_in(name)?)));
    let thesis = || Machine::built_in("thesis").expect("it ships");
    let (pipeline, machine) = named.unwrap_or_else(|| (directive, thesis()));
    let pipeline = match REGISTRY.pipeline(pipeline) {
        Ok(pipeline) => pipeline,
        Err(error) => return error.to_string(),
    };
    let name = name(path);
    let mut module = parse::parse_module(&name, text).expect("a well-formed test file");
    let scene = path.with_extension("scene.toml");
    let scene = scene.is_file().then(|| SceneFile::load(&scene));
    let scene = scene.map(|file| file.expect("a well-formed scene").scene);
    let mut log = Vec::new();
    let result = manager::run(
        &mut module,
        &pipeline,
        Config {
            check_each: Some(4),
            scene: scene.as_ref(),
            ..Config::new(&machine, &mut log)
        },
    );
    match result {
        Ok(outcome) => {
            let mut produced = print::print_module(&module);
            // The text must also say all there is to say.
            let again = parse::parse_module(&name, &produced).expect("printed text reads back");
            assert!(again == module, "the printed text differs");
            for artifact in outcome.artifacts {
                produced += &format!("\n==> {} <==\n{}", artifact.name, artifact.text);
            }
            produced + &String::from_utf8_lossy(&log)
        }
        Err(error) => format!("{error}\n"),
    }
}
