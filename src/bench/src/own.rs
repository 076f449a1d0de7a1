//! Robovec's C as contestants.

use super::BenchQuestion;
use super::contestant::{Contestant, ContestantFamily};
use super::functions::{inputs, outputs};
use super::harness::{self, Callee, CallingConvention};
use super::tools::{BuildStep, Compiler};
use robovec_cgen::batch;
use robovec_cgen::c::{self, Real, c_files};
use robovec_cgen::rolled::rolled_files;
use robovec_cgen::superword::SuperwordLanes;
use robovec_ir::View;
use robovec_ir::count::Counts;

/// The clock and the windows, shared by all programs.
pub(super) const BENCH_H: &str = include_str!("../peers/bench.h");

/// Way in which generated C is compiled; loops at `-O3`.
pub const FLAGS: &str = "-O2 -march=native";

/// Way in which C is compiled that gives the evaluator's results.
const EXACT: &str = "-std=c99 -O1 -ffp-contract=off";

/// Operations of a function.
pub fn operations(view: View<'_>) -> usize {
    Counts::of(view.function).operations
}

/// The inputs of all states in the format that a program reads.
fn input_bytes(question: &BenchQuestion<'_>, view: View<'_>) -> Vec<u8> {
    let states = 0..question.count;
    states
        .flat_map(|state| inputs(question, view, state))
        .flat_map(f64::to_le_bytes)
        .collect()
}

/// Plan of a contestant in C.
#[derive(Clone, Copy)]
pub struct ContestantPlan<'a> {
    /// The question of the bench.
    pub question: &'a BenchQuestion<'a>,
    /// The compiler of the bench.
    pub compiler: &'a Compiler,
    /// Origin of its equations.
    pub family: ContestantFamily,
    /// Its name.
    pub name: &'a str,
    /// Its equations.
    pub view: View<'a>,
    /// Vectors of its straight-line code.
    pub superwords: SuperwordLanes,
}

impl ContestantPlan<'_> {
    fn named(&self) -> Contestant {
        Contestant {
            operations: Some(operations(self.view)),
            ..Contestant::named(self.name, self.family, outputs(self.view))
        }
    }

    /// The contestant that cannot take part, and why.
    pub(super) fn missing(&self, message: String) -> Contestant {
        Contestant {
            missing: Some(message),
            ..self.named()
        }
    }

    /// The contestant with files of C, a main program and the command to build.
    pub(super) fn program(
        &self,
        callee: &Callee<'_>,
        mut files: Vec<(String, Vec<u8>)>,
        flags: &str,
        steps: Vec<BuildStep>,
    ) -> Contestant {
        let main = harness::main(callee, self.question.count);
        files.push(("main.c".to_owned(), main.into_bytes()));
        files.push(("bench.h".to_owned(), BENCH_H.as_bytes().to_vec()));
        let inputs = input_bytes(self.question, self.view);
        Contestant {
            remark: format!("{} {flags}", self.compiler.command),
            lanes: callee.call.lanes(),
            files,
            data: vec![("inputs.bin".to_owned(), inputs)],
            steps,
            ..self.named()
        }
    }
}

/// A way to write a function in C.
pub type ContestantMaker = fn(&ContestantPlan<'_>) -> Contestant;

/// Straight-line C in bounded functions.
pub fn straight(plan: &ContestantPlan<'_>) -> Contestant {
    let options = c::Options {
        signature: c::Signature::Plain,
        superwords: plan.superwords,
        ..c::Options::default()
    };
    match c::files(plan.view, &options) {
        Ok(files) => Generated::plain(files, FLAGS).contestant(plan),
        Err(error) => plan.missing(error.to_string()),
    }
}

/// The same with vectors for operations of equal structure.
pub fn superwords(plan: &ContestantPlan<'_>) -> Contestant {
    let superwords = SuperwordLanes::Auto;
    let options = c::Options {
        superwords,
        ..c::Options::default()
    };
    if c::vector_operations(plan.view.function, &options) == 0 {
        return plan.missing("too few operations have equal structure".to_owned());
    }
    straight(&ContestantPlan {
        superwords,
        ..*plan
    })
}

/// Straight-line C with the evaluator's results, bit for bit.
pub fn exact(question: &BenchQuestion<'_>, compiler: &Compiler, real: Real) -> Contestant {
    let generated = Generated {
        real,
        ..Generated::plain(c_files(question.view, real), EXACT)
    };
    generated.contestant(&ContestantPlan {
        question,
        compiler,
        family: ContestantFamily::Equations,
        name: "C",
        view: question.view,
        superwords: SuperwordLanes::None,
    })
}

/// C with loops found from recurrences.
pub fn rolled(plan: &ContestantPlan<'_>) -> Contestant {
    match rolled_files(plan.view, Real::Double) {
        Ok(rolled) => Generated::plain(rolled.files, "-O3 -march=native").contestant(plan),
        Err(difference) => plan.missing(difference.to_string()),
    }
}

/// C for eight states at once, side by side in memory.
pub fn batch(plan: &ContestantPlan<'_>) -> Contestant {
    let options = batch::Options::default();
    let generated = Generated {
        call: CallingConvention::Batch(options.lanes, options.shared.clone()),
        ..Generated::plain(batch::batch_files(plan.view, &options), FLAGS)
    };
    generated.contestant(plan)
}

/// C for sixteen states at once in binary32, in vectors of the same size.
pub fn batch_single(plan: &ContestantPlan<'_>) -> Contestant {
    let options = batch::Options {
        real: Real::Float,
        lanes: 16,
        ..batch::Options::default()
    };
    let generated = Generated {
        call: CallingConvention::Batch(options.lanes, options.shared.clone()),
        real: options.real,
        ..Generated::plain(batch::batch_files(plan.view, &options), FLAGS)
    };
    Contestant {
        coarseness: f64::from(f32::EPSILON) / f64::EPSILON,
        ..generated.contestant(plan)
    }
}

/// The same C for consecutive states: one call for all of them, which prepares
/// shared values and copies each batch in and out.
pub fn batch_of_states(plan: &ContestantPlan<'_>) -> Contestant {
    let options = batch::Options::default();
    let generated = Generated {
        call: CallingConvention::States(plan.question.count, options.shared.clone()),
        ..Generated::plain(batch::batch_files(plan.view, &options), FLAGS)
    };
    Contestant {
        lanes: options.lanes,
        ..generated.contestant(plan)
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

/// A source and its header, and their use.
struct Generated<'a> {
    files: [(String, String); 2],
    call: CallingConvention,
    real: Real,
    flags: &'a str,
}

impl<'a> Generated<'a> {
    /// A function in binary64 that takes its arrays one after the other.
    fn plain(files: [(String, String); 2], flags: &'a str) -> Generated<'a> {
        Generated {
            files,
            call: CallingConvention::Plain,
            real: Real::Double,
            flags,
        }
    }

    fn contestant(&self, plan: &ContestantPlan<'_>) -> Contestant {
        let flags = plan.question.flags_or(self.flags);
        let command = &plan.compiler.command;
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
            view: plan.view,
            real: self.real,
            call: &self.call,
            header: &format!("#include \"{header}\""),
            name: function,
        };
        let files = self.files.iter();
        let files = files.map(|(name, text)| (name.clone(), text.clone().into_bytes()));
        plan.program(&callee, files.collect(), flags, steps)
    }
}
