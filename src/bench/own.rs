//! Robovec's C as contestants.

use super::Question;
use super::contestant::{Contestant, Family, RESULTS};
use super::functions::{inputs, outputs};
use super::harness::{self, Call};
use super::tools::{Compiler, Step};
use robovec_ir::View;
use robovec_ir::count::Counts;
use robovec_passes::codegen::batch;
use robovec_passes::codegen::c::{self, Real};
use robovec_passes::codegen::rolled::rolled_files;

/// The clock and the windows, shared by all programs.
pub(super) const BENCH_H: &str = include_str!("../../benches/peers/bench.h");

/// How generated C is compiled; loops at `-O3`.
pub const FLAGS: &str = "-O2 -march=native";

/// Operations of a function.
pub fn operations(view: View<'_>) -> usize {
    Counts::of(view.function).operations
}

/// The inputs of all states as a program reads them.
pub(super) fn input_bytes(question: &Question<'_>, view: View<'_>) -> Vec<u8> {
    let states = 0..question.count;
    states
        .flat_map(|state| inputs(view, question.model, question.states, state))
        .flat_map(f64::to_le_bytes)
        .collect()
}

/// A way to write a function in C.
pub type Way = fn(&Question<'_>, &Compiler, Family, &str, View<'_>) -> Contestant;

/// Straight-line C in bounded functions.
pub fn straight(
    question: &Question<'_>,
    compiler: &Compiler,
    family: Family,
    name: &str,
    view: View<'_>,
) -> Contestant {
    let options = c::Options {
        signature: c::Signature::Plain,
        ..c::Options::default()
    };
    let [source, header] = match c::files(view, &options) {
        Ok(files) => files,
        Err(error) => return missing(family, name, view, error.to_string()),
    };
    let function = source.0.trim_end_matches(".c").to_owned();
    program(
        question,
        compiler,
        (family, name),
        view,
        vec![source, header.clone()],
        &Call::Plain,
        &format!("#include \"{}\"", header.0),
        &function,
        FLAGS,
    )
}

/// C with loops found from recurrences.
pub fn rolled(
    question: &Question<'_>,
    compiler: &Compiler,
    family: Family,
    name: &str,
    view: View<'_>,
) -> Contestant {
    let files = match rolled_files(view, Real::Double) {
        Ok(rolled) => rolled.files,
        Err(difference) => {
            return missing(family, name, view, difference.to_string());
        }
    };
    let header = files.iter().find(|(name, _)| name.ends_with(".h"));
    let header = header.map_or_else(String::new, |(name, _)| name.clone());
    let function = header.trim_end_matches(".h").to_owned();
    program(
        question,
        compiler,
        (family, name),
        view,
        files.to_vec(),
        &Call::Plain,
        &format!("#include \"{header}\""),
        &function,
        "-O3 -march=native",
    )
}

/// C for eight states at once.
pub fn batch(
    question: &Question<'_>,
    compiler: &Compiler,
    family: Family,
    name: &str,
    view: View<'_>,
) -> Contestant {
    let options = batch::Options::default();
    let [source, header] = batch::batch_files(view, &options);
    let function = header.0.trim_end_matches("_batch.h").to_owned();
    let include = format!("#include \"{}\"", header.0);
    let call = Call::Batch(options.lanes, options.shared.clone());
    program(
        question,
        compiler,
        (family, name),
        view,
        vec![source, header],
        &call,
        &include,
        &function,
        FLAGS,
    )
}

pub(super) fn missing(family: Family, name: &str, view: View<'_>, message: String) -> Contestant {
    Contestant {
        name: name.to_owned(),
        family,
        remark: String::new(),
        operations: Some(operations(view)),
        lanes: 1,
        files: Vec::new(),
        steps: Vec::new(),
        arguments: Vec::new(),
        outputs: outputs(view),
        tolerance: 1e-12,
        missing: Some(message),
        shared: None,
    }
}

/// A program of generated files, of which all `.c` files are compiled.
#[allow(clippy::too_many_arguments)]
pub(super) fn program(
    question: &Question<'_>,
    compiler: &Compiler,
    (family, name): (Family, &str),
    view: View<'_>,
    generated: Vec<(String, String)>,
    call: &Call,
    header: &str,
    function: &str,
    flags: &str,
) -> Contestant {
    let command = &compiler.command;
    let mut steps = Vec::new();
    let mut objects = String::new();
    for (file, _) in &generated {
        if let Some(stem) = file.strip_suffix(".c") {
            let object = format!("{stem}.o");
            let step = Step::new(command, flags).with("-c").with(file.clone());
            steps.push(step.function(&object));
            objects = format!("{objects} {object}");
        }
    }
    steps.push(Step::new(
        command,
        &format!("-O2 -march=native -o program main.c {objects} -lm"),
    ));
    let lanes = call.lanes();
    let main = harness::main(view, call, header, function, question.count);
    let generated = generated.into_iter();
    let mut files: Vec<(String, Vec<u8>)> = generated
        .map(|(name, text)| (name, text.into_bytes()))
        .collect();
    files.push(("main.c".to_owned(), main.into_bytes()));
    files.push(("bench.h".to_owned(), BENCH_H.as_bytes().to_vec()));
    files.push(("inputs.bin".to_owned(), input_bytes(question, view)));
    Contestant {
        name: name.to_owned(),
        family,
        remark: format!("{command} {flags}"),
        operations: Some(operations(view)),
        lanes,
        files,
        steps,
        arguments: vec![RESULTS.to_owned()],
        outputs: outputs(view),
        tolerance: 1e-12,
        missing: None,
        shared: None,
    }
}
