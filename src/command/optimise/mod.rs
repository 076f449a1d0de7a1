//! `robovec optimise`: the best program for a target.

mod given;
mod report;

use super::flags::{EFFORT, SEED, states, whole};
use super::shares::ShareArguments;
use super::{CommandFailure, input, output, progress};
use clap::Args;
use robovec_bench::{Compiler, robotran};
use robovec_explore::optimise::{
    MakerTally, OptimisationError, OptimisationQuestion, OptimisationTarget, optimise, search_share,
};
use robovec_explore::placing::with_elements;
use robovec_explore::share::SharedWork;
use robovec_framework::options::OptionValue;
use robovec_framework::scene::Scene;
use robovec_io::files::Replace;
use robovec_ir::Machine;
use robovec_ir::diagnostic::counted;
use robovec_passes::optimise::VariantClass;
use std::path::PathBuf;

/// Find the best program for a target, prove it equal to the input and write it
/// ready to use
#[derive(Args, Clone, Debug)]
pub(super) struct OptimiseArguments {
    /// Robotran file, robovec text, model (.mbs, .urdf, .xml), scene (.scene.toml) or built-in model (serial-23)
    input: String,
    /// Model (.mbs, .urdf, .xml) that a file of equations comes from: its other formulations are tried, too
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Target of the program
    #[arg(
        long = "for",
        value_enum,
        default_value = "fpga",
        value_name = "TARGET"
    )]
    target: OptimisationTarget,
    /// Function of a model, or of a file with several
    #[arg(long)]
    function: Option<String>,
    /// Machine to compile for: a name or a .toml file; by default the scene's,
    /// else solver for equations that divide and thesis for others
    #[arg(long)]
    machine: Option<String>,
    /// Number of adders, and of multipliers; by default as in the machine
    #[arg(long, value_name = "N", add = whole(1, 4096, "a machine has elements of every kind"))]
    elements: Option<u32>,
    /// Scene that describes the use of the function
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Meaning of equal: the same real number (real), or the same where sin^2 +
    /// cos^2 = 1 (real-trig)
    #[arg(long, default_value = "real-trig", value_name = "CLASS",
          value_parser = VariantClass::parse)]
    class: VariantClass,
    /// Effort of the search; twice the effort takes twice the time, and the
    /// result is never worse
    #[arg(long, default_value_t = 4, value_name = "N", add = EFFORT)]
    effort: u32,
    /// Number of random states for the errors; by default more for smaller
    /// functions
    #[arg(long, default_value_t = 0, hide_default_value = true, add = states(0, 100_000))]
    states: u32,
    /// Seed of the states
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// C compiler for the programs that are timed; with 'none' nothing is
    /// timed, and the program with the fewest operations wins
    #[arg(long, default_value = "cc", value_name = "COMMAND")]
    compiler: String,
    /// Its flags
    #[arg(long, default_value = robotran::FLAGS, allow_hyphen_values = true)]
    flags: String,
    /// Folder for the program, optimise.html, .csv, .json and .svg
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    shares: ShareArguments,
    /// Number of threads; by default the number of processors
    #[arg(long, value_name = "N", add = whole(1, 1024, "every thread takes memory"))]
    jobs: Option<u32>,
}

pub(super) fn run(arguments: &OptimiseArguments) -> Result<String, CommandFailure> {
    let folder = arguments.output.as_deref();
    output::refuse_foreign(folder, &[report::PROGRAM, report::START], Replace::Results)?;
    let pool = super::threads(arguments.jobs)?;
    let mut given = given::given(arguments)?;
    if arguments.class == VariantClass::Real {
        // Formulations rest on sin^2 + cos^2 = 1.
        given.starts.truncate(1);
        given.left.clear();
    }
    let given = given;
    let arguments = &OptimiseArguments {
        machine: wanted_machine(arguments, &given)?,
        ..arguments.clone()
    };
    let machine = machine(arguments, given.scene.as_ref())?;
    let store = arguments.shares.store(arguments.output.as_deref())?;
    let source = input::states(given.scene.as_ref(), arguments.seed);
    let operations = given.starts[0].module.functions[0].nodes().len();
    let is_timed = arguments.target != OptimisationTarget::Fpga && arguments.compiler != UNTIMED;
    let compiler = is_timed.then(|| Compiler::find(&arguments.compiler));
    let compiler = compiler
        .transpose()
        .map_err(|reason| CommandFailure::advised(reason, compiler_advice()))?;
    let question = OptimisationQuestion {
        target: arguments.target,
        machine: &machine,
        scene: given.scene.as_ref(),
        class: arguments.class,
        effort: arguments.effort,
        states: &source,
        count: match arguments.states {
            0 => robovec_analysis::rounding::usual_states(operations),
            count => count,
        },
        compiler: compiler.as_ref(),
        flags: &arguments.flags,
        file: given.file.as_deref(),
        work: SharedWork::new(store.as_ref(), arguments.shares.share()),
    };
    let bar = progress::spinner();
    let told = |what: &str| bar.set_message(what.to_owned());
    let failure = |error: OptimisationError| {
        let notes = match error {
            OptimisationError::Placement(_) => input::other_machine(),
            OptimisationError::Timing(_) => compiler_advice(),
            OptimisationError::Program(_) | OptimisationError::Proof(_) => Vec::new(),
        };
        CommandFailure::advised(format!("{}: {error}", arguments.input), notes)
    };
    if arguments.shares.shard.is_some() {
        let tally = pool.install(|| search_share(&given.starts, &question, &told));
        bar.finish_and_clear();
        let MakerTally { programs, found } = tally.map_err(failure)?;
        return Ok(format!(
            "{}, {found} of them found\n",
            counted(programs, "program")
        ));
    }
    let found = pool.install(|| optimise(&given.starts, &question, &told));
    bar.finish_and_clear();
    let found = found.map_err(failure)?;
    report::report(arguments, &given, &question, &found)
}

/// The word for no compiler.
const UNTIMED: &str = "none";

fn compiler_advice() -> Vec<String> {
    let advice = "'--compiler' names another C compiler and '--flags' its flags; with \
                  '--compiler none' operations decide";
    vec![advice.to_owned()]
}

/// Name of a machine requested or needed; `None` for the usual one.
fn wanted_machine(
    arguments: &OptimiseArguments,
    given: &given::GivenStarts,
) -> Result<Option<String>, CommandFailure> {
    let wished = given.scene.as_ref();
    let wished = wished.and_then(|scene| scene.machine.as_ref());
    if arguments.machine.is_some() || wished.is_some() {
        return Ok(arguments.machine.clone());
    }
    if arguments.target != OptimisationTarget::Fpga {
        return Ok(None);
    }
    let usual = input::usual_machine(&given.starts[0].module.functions[0])?;
    Ok((usual != input::USUAL_MACHINE).then(|| usual.to_owned()))
}

/// The machine, with the requested numbers of elements.
fn machine(
    arguments: &OptimiseArguments,
    scene: Option<&Scene>,
) -> Result<Machine, CommandFailure> {
    let machine = input::machine_for(arguments.machine.as_deref(), scene)?;
    Ok(match arguments.elements {
        None => machine,
        Some(count) => with_elements(&machine, [count; 2]),
    })
}
