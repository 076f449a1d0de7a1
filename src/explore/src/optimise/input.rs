//! The original function, measured as programs are: the reference for gains.

use super::measure::{self, ProgramFigures};
use super::processor::single;
use super::start::PreparedStarts;
use super::{OptimisationPoint, OptimisationQuestion, OptimisationTarget};
use crate::ExplorationProgress;
use crate::processor::{LARGEST, question as bench_question};
use crate::program::{ExplorationError, transformed_by, view};
use robovec_analysis::critical_path::critical_path;
use robovec_bench::contestant::{Contestant, ContestantFamily};
use robovec_bench::{BenchOutcome, BenchQuestion, Compiler, bench, own, robotran};
use robovec_cgen::superword::SuperwordLanes;
use robovec_error::yardstick::Yardstick;
use robovec_fpga::hardware;
use robovec_io::files::TemporaryFolder;
use robovec_ir::count::Counts;
use robovec_ir::{Level, Module};
use robovec_passes::optimise::search::schedule_size;
use robovec_schedule::schedule_bound;

/// Operations of one C function up to which compilers need no minutes.
const ONE_PIECE: usize = 60_000;

/// Rounds, and the time of a round, ms.
const ROUNDS: (u32, u32) = (8, 60);

/// The input as a point: placed unchanged, or its own C timed, and its errors.
pub(super) fn point(
    prepared: &PreparedStarts,
    question: &OptimisationQuestion<'_>,
    yardstick: &Yardstick,
    progress: ExplorationProgress<'_>,
) -> Result<OptimisationPoint, ExplorationError> {
    progress("measuring the input");
    let start = &*prepared.starts[0];
    let atomic = match view(start).function.level {
        Level::Equations => transformed_by(start, "atomise", question.machine, None)?,
        _ => start.clone(),
    };
    let function = view(&atomic).function;
    let errors = yardstick.errors(view(&atomic), measure::format(question))?;
    let mut point = OptimisationPoint {
        name: "as it came".to_owned(),
        operations: Counts::of(function).operations,
        path: critical_path(function, question.machine).asap_cycle,
        errors: Some([errors.normwise.median, errors.normwise.worst]),
        is_input: true,
        ..OptimisationPoint::default()
    };
    match (question.target, question.compiler) {
        (OptimisationTarget::Fpga, _) => {
            point.bound = schedule_bound(function, question.machine).ok();
            match schedule_size(function, question.machine) {
                Ok(size) => {
                    point.cycles = Some(size.cycles);
                    let clock = hardware::clock(question.machine);
                    point.microseconds = Some(clock.microseconds(size.cycles));
                    point.share = Some(super::share(size, question.machine));
                }
                Err(error) => point.remark = error.to_string(),
            }
        }
        (_, Some(compiler)) => {
            let figures = timed(start, question, compiler, progress);
            point.nanoseconds = figures.nanoseconds;
            point.code_bytes = figures.code_bytes;
            point.remark = figures.remark;
        }
        (_, None) => {}
    }
    Ok(point)
}

/// Time of the user's own C file, or of the equations as Robotran writes them
/// in C. Other equations, and those too long, are timed in robovec's C.
fn timed(
    start: &Module,
    question: &OptimisationQuestion<'_>,
    compiler: &Compiler,
    progress: ExplorationProgress<'_>,
) -> ProgramFigures {
    let asked = BenchQuestion {
        flags: Some(question.flags),
        ..bench_question(view(start), question.states)
    };
    let mut forms: Vec<(&str, Contestant)> = Vec::new();
    let operations = own::operations(view(start));
    if operations <= ONE_PIECE {
        let file = question.file;
        let file = file.map(|path| robotran::file(&asked, compiler, path));
        forms.extend(file.map(|file| ("the file as it is", file)));
        let printed = robotran::printed(&asked, compiler, start);
        forms.push(("as Robotran writes it", printed));
    }
    if operations <= LARGEST {
        let own = single(&own::ContestantPlan {
            question: &asked,
            compiler,
            family: ContestantFamily::Equations,
            name: "the same equations",
            view: view(start),
            superwords: SuperwordLanes::None,
        });
        forms.push(("the same equations in robovec's C", own));
    }
    let mut figures = ProgramFigures {
        remark: "too large to compile and time".to_owned(),
        ..ProgramFigures::default()
    };
    for (name, form) in forms {
        match outcome(&asked, &form, progress) {
            Ok(outcome) => {
                figures.nanoseconds = outcome.nanoseconds;
                figures.code_bytes = outcome.code_bytes;
                figures.remark = outcome.failure.unwrap_or_default();
            }
            Err(error) => figures.remark = error,
        }
        if figures.nanoseconds.is_some() {
            name.clone_into(&mut figures.remark);
            break;
        }
    }
    figures
}

/// The measurement of one form of the input.
fn outcome(
    asked: &BenchQuestion<'_>,
    form: &Contestant,
    progress: ExplorationProgress<'_>,
) -> Result<BenchOutcome, String> {
    let folder = TemporaryFolder::new().map_err(|error| format!("no temporary folder: {error}"))?;
    let (rounds, milliseconds) = ROUNDS;
    let outcomes = bench(
        asked,
        std::slice::from_ref(form),
        folder.path(),
        rounds,
        milliseconds,
        &mut |what| progress(what),
    )
    .map_err(|error| error.to_string())?;
    Ok(outcomes.into_iter().next().expect("one took part"))
}
