//! File tests of passes: `tests/passes/PASS/*.rvir`.
//!
//! The first line of a file says what to run: `// RUN: PIPELINE [MACHINE]`; the
//! machine is the last word, if it is the name of one that ships. A scene beside
//! it (`NAME.scene.toml` for `NAME.rvir`) is used.
//! Every pass runs under the verifier and the semantic check; the expected
//! text is the function after the pipeline, or the message when it must fail.

mod support;

use robovec::scene::SceneFile;
use robovec_ir::{Machine, parse, print};
use robovec_passes::manager::{self, Config};
use robovec_passes::pipeline;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    support::run("passes", &["rvir"], produce)
}

fn produce(path: &Path, text: &str) -> String {
    let directive = support::directive(text).trim();
    let last = directive.rsplit_once(' ');
    let named = last.and_then(|(first, name)| Some((first, Machine::built_in(name)?)));
    let thesis = || Machine::built_in("thesis").expect("it ships");
    let (pipeline, machine) = named.unwrap_or_else(|| (directive, thesis()));
    let pipeline = match pipeline::parse(pipeline) {
        Ok(pipeline) => pipeline,
        Err(error) => return error.to_string(),
    };
    let name = path.file_name().expect("a file").to_string_lossy();
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
            assert!(again == module, "the printed text says something else");
            for artifact in outcome.artifacts {
                produced += &format!("\n==> {} <==\n{}", artifact.name, artifact.text);
            }
            produced + &String::from_utf8_lossy(&log)
        }
        Err(error) => format!("{error}\n"),
    }
}
