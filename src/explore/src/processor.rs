//! The time of the same functions on one core of a processor: the C of
//! `codegen`, compiled by the user's compiler and run on random states.
//!
//! These are measurements: they differ from run to run and are separate from
//! other results. [`contest`] is a bench among our own kinds of C;
//! [`compile_and_run`] times one function in any format.

use robovec_bench::contestant::{Contestant, ContestantFamily};
use robovec_bench::task::BenchTask;
use robovec_bench::{BenchOutcome, BenchQuestion, Compiler, bench, own};
use robovec_cgen::c::Real;
use robovec_cgen::superword::SuperwordLanes;
use robovec_io::files::TemporaryFolder;
use robovec_ir::View;
use robovec_ir::count::Counts;
use robovec_ir::states::States;
use std::fs;

/// Functions with more operations are not compiled unless requested: C
/// compilers take a second for some ten thousand operations.
pub const LARGEST: usize = 200_000;

/// Place where the states come from that programs are timed at.
const SEED: u64 = 1;
const STATES: u32 = 16;
/// Rounds, and the time of every program in a round, ms.
const ROUNDS: (u32, u32) = (3, 60);

/// The computer that measures.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Computer {
    /// Compiler and flags; empty when there is no compiler.
    pub compiler: String,
    /// The processor's name.
    pub processor: String,
}

impl Computer {
    /// This computer.
    pub fn this() -> Computer {
        let compiler = Compiler::find("cc").ok();
        let compiler = compiler.map(|compiler| format!("{} {}", compiler.version, own::FLAGS));
        let information = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = information
            .lines()
            .find(|line| line.starts_with("model name"));
        let name = name
            .and_then(|line| line.split_once(':'))
            .map(|(_, name)| name.trim());
        Computer {
            compiler: compiler.unwrap_or_default(),
            processor: name.unwrap_or("this computer").to_owned(),
        }
    }
}

/// Times of one function, ns.
#[derive(Clone, Copy, Default, PartialEq, Debug)]
pub struct ProcessorTimes {
    /// One evaluation by straight-line C.
    pub straight: Option<f64>,
    /// One evaluation by C with loops.
    pub rolled: Option<f64>,
    /// Per state, when eight are evaluated at once.
    pub batch: Option<f64>,
    /// Excess of one call in a thousand of the faster C over the median one.
    pub jitter: Option<f64>,
}

impl ProcessorTimes {
    /// The time of one evaluation by the faster C.
    pub fn single(&self) -> Option<f64> {
        let both = self.straight.into_iter().chain(self.rolled);
        both.min_by(f64::total_cmp)
    }
}

/// Times of C for processors, in binary64, with results compared with the
/// evaluator's. Loops are found in the order of `regular`; straight-line code
/// and batches are of `shorter`, the same function after passes or not.
///
/// # Errors
///
/// Reason for no time: no compiler, its message, or a wrong result.
pub fn contest(regular: View<'_>, shorter: View<'_>) -> Result<ProcessorTimes, String> {
    let folder = TemporaryFolder::new().map_err(|error| format!("no temporary folder: {error}"))?;
    let compiler = Compiler::find("cc")?;
    let states = States::new(SEED);
    let question = question(regular, &states);
    let ways: [(own::ContestantMaker, View<'_>); 3] = [
        (own::straight, shorter),
        (own::rolled, regular),
        (own::batch, shorter),
    ];
    let family = ContestantFamily::Equations;
    // What solves equations multiplies every rounding by their condition.
    let task = match Counts::of(regular.function).div {
        0 => BenchTask::Dirdyna,
        _ => BenchTask::Accelred,
    };
    let contestants = ways.map(|(way, view)| Contestant {
        tolerance: task.tolerance(family),
        ..way(&own::ContestantPlan {
            question: &question,
            compiler: &compiler,
            family,
            name: "C",
            view,
            superwords: SuperwordLanes::None,
        })
    });
    let (rounds, milliseconds) = ROUNDS;
    let quiet = &mut |_: &str| {};
    let outcomes = bench(
        &question,
        &contestants,
        folder.path(),
        rounds,
        milliseconds,
        quiet,
    )
    .map_err(|error| error.to_string())?;
    if let Some(failure) = outcomes.iter().find_map(|outcome| outcome.failure.clone()) {
        return Err(failure);
    }
    let [straight, rolled, batch] = outcomes.as_slice() else {
        unreachable!("every contestant has an outcome");
    };
    let time = |outcome: &BenchOutcome| outcome.nanoseconds.unwrap_or(f64::INFINITY);
    let faster = if time(rolled) < time(straight) {
        rolled
    } else {
        straight
    };
    Ok(ProcessorTimes {
        straight: straight.nanoseconds,
        rolled: rolled.nanoseconds,
        batch: batch.nanoseconds,
        jitter: faster.jitter,
    })
}

/// Question about the C of a function.
pub(crate) fn question<'a>(view: View<'a>, states: &'a States) -> BenchQuestion<'a> {
    BenchQuestion {
        name: "function".to_owned(),
        view,
        model: None,
        has_loads: false,
        states,
        count: STATES,
        flags: None,
    }
}

/// Time of one call of a function, ns: the smallest of many repetitions.
///
/// # Errors
///
/// The reason why there is no time: no compiler, or its message.
pub fn compile_and_run(view: View<'_>, real: Real) -> Result<f64, String> {
    let folder = TemporaryFolder::new().map_err(|error| format!("no temporary folder: {error}"))?;
    let compiler = Compiler::find("cc")?;
    let states = States::new(SEED);
    let question = question(view, &states);
    let contestant = own::exact(&question, &compiler, real);
    contestant.time(folder.path(), ROUNDS.1)
}
