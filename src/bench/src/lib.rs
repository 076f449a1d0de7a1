//! Comparison of the speed of a function with other libraries.
//!
//! A bench takes the equations of a function, or the model they come from, and
//! times in one run: Robotran's file unchanged, the C that robovec writes for
//! it, and, where they are installed, other tools that give the same function
//! of the same model. Every contestant is a separate program that reads states
//! from a file, writes its results to another and prints its least time;
//! results are compared before times are shown.
//!
//! States differ in positions, velocities, accelerations, forces of joints and
//! loads; parameters are the model's, or drawn once. Contestants run in
//! sequence in rounds, so that a busy minute of the computer affects all of
//! them. Times are processor times of the thread, and differ from run to run.

pub mod contestant;
mod functions;
mod harness;
pub mod own;
pub mod peers;
pub mod robotran;
pub mod task;
pub mod text;
mod tools;
mod tree;

use contestant::{Contestant, ContestantFamily};
use functions::ReferenceResults;
use robovec_error::yardstick::ErrorSpread;
use robovec_ir::View;
use robovec_ir::states::States;
use serde::Serialize;
use std::path::{Path, PathBuf};
pub use tools::Compiler;

use robovec_io::files::make_folder;
use robovec_model::Model;

/// Function and states that every program computes.
pub struct BenchQuestion<'a> {
    /// The name of the folder of its programs.
    pub name: String,
    /// The original function, which defines the correct results.
    pub view: View<'a>,
    /// The model, whose parameters are used and which peers need.
    pub model: Option<&'a Model>,
    /// True if loads on bodies of a model are drawn, else zero.
    pub has_loads: bool,
    /// Origin of the states.
    pub states: &'a States,
    /// Number of states: a multiple of 16.
    pub count: u32,
    /// The flags with which all C is compiled; `None`: those of each kind.
    pub flags: Option<&'a str>,
}

impl<'a> BenchQuestion<'a> {
    /// The flags with which C is compiled that these suit.
    fn flags_or(&self, usual: &'a str) -> &'a str {
        self.flags.unwrap_or(usual)
    }
}

/// Outcome of one contestant.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct BenchOutcome {
    /// Its name.
    pub name: String,
    /// Origin.
    pub family: ContestantFamily,
    /// Compiler and flags, version of a library.
    pub remark: String,
    /// Operations of the program, where that is known.
    pub operations: Option<usize>,
    /// States that are computed at once.
    pub lanes: u32,
    /// Processor time of compiling the function, s.
    pub compile_seconds: Option<f64>,
    /// Size of the compiled function's code, bytes.
    pub code_bytes: Option<u64>,
    /// Largest difference from the reference, over the array's largest element.
    pub difference: Option<f64>,
    /// Errors against exact results, relative to an array's largest element.
    pub errors: Option<ErrorSpread>,
    /// Least processor time per state, ns.
    pub nanoseconds: Option<f64>,
    /// Time by which one call in a thousand takes longer than the median one,
    /// ns: see [`contestant::RunTime::jitter`].
    pub jitter: Option<f64>,
    /// Reason why there is no time.
    pub failure: Option<String>,
    /// True when it could take part, and failed.
    pub is_broken: bool,
}

impl BenchOutcome {
    /// Time of a call, ns; infinite before the first.
    fn time(&self) -> f64 {
        self.nanoseconds.unwrap_or(f64::INFINITY)
    }
}

/// Called with a line of text before each step.
pub type BenchProgress<'a> = &'a mut dyn FnMut(&str);

/// Builds all contestants, compares their results, and times them in rounds of
/// `milliseconds` each. `folder` takes the programs; those that read the model
/// as data are built there once, for all models.
pub fn bench(
    question: &BenchQuestion<'_>,
    contestants: &[Contestant],
    folder: &Path,
    rounds: u32,
    milliseconds: u32,
    progress: BenchProgress<'_>,
) -> std::io::Result<Vec<BenchOutcome>> {
    // Programs are run from their own folders.
    let folder = &std::path::absolute(folder)?;
    let reference = ReferenceResults::new(question);
    let mut entered: Vec<Option<(BenchOutcome, PathBuf)>> = vec![None; contestants.len()];
    // What compiles quickly comes first: peers of unknown size last.
    let mut order: Vec<usize> = (0..contestants.len()).collect();
    order.sort_by_key(|&index| {
        let operations = contestants[index].operations;
        (operations.is_none(), operations)
    });
    for index in order {
        let contestant = &contestants[index];
        progress(&format!("building {}", contestant.name));
        let place = match &contestant.shared {
            Some(name) => folder.join(name),
            None => folder.join(&question.name).join(contestant.content()),
        };
        make_folder(&place)?;
        contestant.write(&place)?;
        let mut outcome = BenchOutcome {
            name: contestant.name.clone(),
            family: contestant.family,
            remark: contestant.remark.clone(),
            operations: contestant.operations,
            lanes: contestant.lanes,
            compile_seconds: None,
            code_bytes: None,
            difference: None,
            errors: None,
            nanoseconds: None,
            jitter: None,
            failure: contestant.missing.clone(),
            is_broken: false,
        };
        if outcome.failure.is_none()
            && let Err(message) = first_run(contestant, &place, &reference, &mut outcome)
        {
            outcome.failure = Some(message);
            outcome.is_broken = true;
        }
        entered[index] = Some((outcome, place));
    }
    let entered = entered.into_iter().flatten();
    let (mut outcomes, programs): (Vec<BenchOutcome>, Vec<PathBuf>) = entered.unzip();
    assert_eq!(
        outcomes.len(),
        contestants.len(),
        "every contestant has entered"
    );
    for round in 0..rounds {
        for ((contestant, outcome), place) in contestants.iter().zip(&mut outcomes).zip(&programs) {
            if outcome.failure.is_some() {
                continue;
            }
            progress(&format!(
                "round {} of {rounds}: {}",
                round + 1,
                contestant.name
            ));
            match contestant.run(place, milliseconds) {
                Ok(time) => {
                    outcome.nanoseconds = Some(outcome.time().min(time.least));
                    let jitters = outcome.jitter.into_iter().chain(time.jitter);
                    outcome.jitter = jitters.max_by(f64::total_cmp);
                }
                Err(message) => {
                    outcome.failure = Some(message);
                    outcome.is_broken = true;
                }
            }
        }
    }
    Ok(outcomes)
}

/// Of every program by several compilers the fastest one, in the first's place.
pub fn by_the_better_compiler(outcomes: Vec<BenchOutcome>) -> Vec<BenchOutcome> {
    let mut best: Vec<BenchOutcome> = Vec::with_capacity(outcomes.len());
    for outcome in outcomes {
        let same = |known: &&mut BenchOutcome| {
            (known.family, &known.name) == (outcome.family, &outcome.name)
        };
        match best.iter_mut().find(same) {
            None => best.push(outcome),
            Some(known) if outcome.time() < known.time() => *known = outcome,
            Some(_) => {}
        }
    }
    best
}

/// Compiles, runs once and compares.
fn first_run(
    contestant: &Contestant,
    place: &Path,
    reference: &ReferenceResults<'_>,
    outcome: &mut BenchOutcome,
) -> Result<(), String> {
    let built = contestant.build(place)?;
    outcome.compile_seconds = built.seconds;
    outcome.code_bytes = built.code_bytes;
    contestant.run(place, 0)?;
    let results = contestant.results(place, reference.states())?;
    let (difference, key) = reference.difference(&contestant.outputs, &results)?;
    outcome.difference = Some(difference);
    outcome.errors = Some(reference.errors(&contestant.outputs, &results));
    if difference <= contestant.tolerance {
        return Ok(());
    }
    let key = key.expect("a difference is that of an output");
    Err(format!(
        "another result: {key} differs by {difference:.1e} of the largest element"
    ))
}
