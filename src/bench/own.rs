//! Robovec's C as contestants.

use super::BenchQuestion;
use super::contestant::{Contestant, ContestantFamily};
use super::functions::{inputs, outputs};
use super::harness::{self, Callee, CallingConvention};
use super::tools::{BuildStep, Compiler};
use robovec_codegen::batch;
use robovec_codegen::c::{self, Real, c_files};
use robovec_codegen::rolled::rolled_files;
use robovec_ir::View;
use robovec_ir::count::Counts;

/// The clock and the windows, shared by all programs.
pub(super) const BENCH_H: &str = include_str!("../../benches/peers/bench.h");

/// How generated C is compiled; loops at `-O3`.
pub const FLAGS: &str = "-O2 -march=native";

/// How C is compiled that gives the evaluator's results.
const EXACT: &str = "-std=c99 -O1 -ffp-contract=off";

/// Operations of a function.
pub fn operations(view: View<'_>) -> usize {
    Counts::of(view.function).operations
}

/// The inputs of all states as a program reads them.
pub(super) fn input_bytes(question: &BenchQuestion<'_>, view: View<'_>) -> Vec<u8> {
    let states = 0..question.count;
    states
        .flat_map(|state| inputs(question, view, state))
        .flat_map(f64::to_le_bytes)
        .collect()
}

/// A way to write a function in C.
pub type ContestantMaker =
    fn(&BenchQuestion<'_>, &Compiler, ContestantFamily, &str, View<'_>) -> Contestant;

/// Straight-line C in bounded functions.
pub fn straight(
    question: &BenchQuestion<'_>,
    compiler: &Compiler,
    family: ContestantFamily,
    name: &str,
    view: View<'_>,
) -> Contestant {
    let options = c::Options {
        signature: c::Signature::Plain,
        ..c::Options::default()
    };
    match c::files(view, &options) {
        Ok(files) => {
            Generated::plain(files, FLAGS).contestant(question, compiler, family, name, view)
        }
        Err(error) => missing(family, name, view, error.to_string()),
    }
}

/// Straight-line C with the evaluator's results, bit for bit.
pub fn exact(question: &BenchQuestion<'_>, compiler: &Compiler, real: Real) -> Contestant {
    let generated = Generated {
        real,
        ..Generated::plain(c_files(question.view, real), EXACT)
    };
    generated.contestant(
        question,
        compiler,
        ContestantFamily::Equations,
        "C",
        question.view,
    )
}

/// C with loops found from recurrences.
pub fn rolled(
    question: &BenchQuestion<'_>,
    compiler: &Compiler,
    family: ContestantFamily,
    name: &str,
    view: View<'_>,
) -> Contestant {
    match rolled_files(view, Real::Double) {
        Ok(rolled) => Generated::plain(rolled.files, "-O3 -march=native")
            .contestant(question, compiler, family, name, view),
        Err(difference) => missing(family, name, view, difference.to_string()),
    }
}

/// C for eight states at once, which lie side by side.
pub fn batch(
    question: &BenchQuestion<'_>,
    compiler: &Compiler,
    family: ContestantFamily,
    name: &str,
    view: View<'_>,
) -> Contestant {
    let options = batch::Options::default();
    let generated = Generated {
        call: CallingConvention::Batch(options.lanes, options.shared.clone()),
        ..Generated::plain(batch::batch_files(view, &options), FLAGS)
    };
    generated.contestant(question, compiler, family, name, view)
}

/// The same C for states that lie one after the other: one call for all of
/// them, which prepares what they share and copies each batch in and out.
pub fn batch_of_states(
    question: &BenchQuestion<'_>,
    compiler: &Compiler,
    family: ContestantFamily,
    name: &str,
    view: View<'_>,
) -> Contestant {
    let options = batch::Options::default();
    let generated = Generated {
        call: CallingConvention::States(question.count, options.shared.clone()),
        ..Generated::plain(batch::batch_files(view, &options), FLAGS)
    };
    Contestant {
        lanes: options.lanes,
        ..generated.contestant(question, compiler, family, name, view)
    }
}

/// A formulation that there are no equations of, and why.
pub fn refused(
    question: &BenchQuestion<'_>,
    family: ContestantFamily,
    name: &str,
    message: String,
) -> Contestant {
    Contestant {
        missing: Some(message),
        ..Contestant::named(name, family, outputs(question.view))
    }
}

pub(super) fn missing(
    family: ContestantFamily,
    name: &str,
    view: View<'_>,
    message: String,
) -> Contestant {
    Contestant {
        operations: Some(operations(view)),
        missing: Some(message),
        ..Contestant::named(name, family, outputs(view))
    }
}

/// A source and its header, and how they are used.
struct Generated<'a> {
    files: [(String, String); 2],
    call: CallingConvention,
    real: Real,
    flags: &'a str,
}

impl<'a> Generated<'a> {
    /// A function that computes in binary64 and takes its arrays one after the
    /// other.
    fn plain(files: [(String, String); 2], flags: &'a str) -> Generated<'a> {
        Generated {
            files,
            call: CallingConvention::Plain,
            real: Real::Double,
            flags,
        }
    }

    /// The program around the function.
    fn contestant(
        self,
        question: &BenchQuestion<'_>,
        compiler: &Compiler,
        family: ContestantFamily,
        name: &str,
        view: View<'_>,
    ) -> Contestant {
        let flags = question.flags.unwrap_or(self.flags);
        let (command, lanes) = (&compiler.command, self.call.lanes());
        let [(source, _), (header, _)] = &self.files;
        let stem = source.strip_suffix(".c").expect("the source comes first");
        let object = format!("{stem}.o");
        let compiled = BuildStep::new(command, flags)
            .with("-c")
            .with(source.clone());
        let linked = format!("-O2 -march=native -o program main.c {object} -lm");
        let steps = vec![compiled.function(&object), BuildStep::new(command, &linked)];
        let function = match self.call {
            CallingConvention::Batch(..) | CallingConvention::States(..) => {
                stem.trim_end_matches("_batch")
            }
            CallingConvention::Plain | CallingConvention::Robotran(_) => stem,
        };
        let callee = Callee {
            view,
            real: self.real,
            call: &self.call,
            header: &format!("#include \"{header}\""),
            name: function,
        };
        let main = harness::main(&callee, question.count);
        let files = self.files.into_iter();
        let mut files: Vec<(String, Vec<u8>)> = files
            .map(|(name, text)| (name, text.into_bytes()))
            .collect();
        files.push(("main.c".to_owned(), main.into_bytes()));
        files.push(("bench.h".to_owned(), BENCH_H.as_bytes().to_vec()));
        let data = vec![("inputs.bin".to_owned(), input_bytes(question, view))];
        Contestant {
            remark: format!("{command} {flags}"),
            operations: Some(operations(view)),
            lanes,
            files,
            data,
            steps,
            ..Contestant::named(name, family, outputs(view))
        }
    }
}
