//! `robovec bench`: how fast the same function is in the hands of others.

use super::flags::{SEED, states, whole};
use super::{CommandFailure, generation, input, opt, output, progress, robot_bench, subjects};
use clap::Args;
use clap::builder::PossibleValuesParser;
use indicatif::ProgressBar;
use robovec_bench::contestant::{Contestant, ContestantFamily};
use robovec_bench::task::BenchTask;
use robovec_bench::{BenchOutcome, BenchQuestion, Compiler, own, peers, robotran, text};
use robovec_cgen::superword::SuperwordLanes;
use robovec_dynamics::generate::{Formulation, Options, contenders};
use robovec_error::yardstick::account::random_states;
use robovec_io::files::TemporaryFolder;
use robovec_ir::states::States;
use robovec_ir::{Module, View};
use robovec_model::Model;
use std::path::{Path, PathBuf};

/// Compare the results and times of Robotran's file, robovec's C and other
/// libraries on this computer
#[derive(Args, Debug)]
pub(super) struct BenchArguments {
    /// Files of equations, models (.mbs, .urdf, .xml) or built-in models (serial-23, bogie)
    #[arg(required_unless_present = "robots")]
    pub(super) subjects: Vec<String>,
    /// Print one table of all functions of robots (.urdf): C for one state and
    /// for many, in f64 and f32, cycles on an array, and the times of
    /// Pinocchio, CasADi and MuJoCo; without files, of the robots that ship
    /// with robovec
    #[arg(long, conflicts_with_all = ["model", "forces"])]
    pub(super) robots: bool,
    /// Model (.mbs, .urdf, .xml) that a file of equations comes from
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Function of a model, or of a file that has several [default: dirdyna]
    #[arg(long, value_name = "NAME",
          value_parser = PossibleValuesParser::new(BenchTask::ALL.map(BenchTask::name)))]
    pub(super) function: Option<String>,
    /// Apply random forces and torques to the bodies of a model, instead of
    /// none
    #[arg(long)]
    forces: bool,
    /// C compilers, with a row for each; by default the faster of gcc and clang
    /// is shown for every program
    #[arg(long, value_delimiter = ',')]
    compilers: Vec<String>,
    /// Other libraries to time, where they are installed; 'none' for none
    #[arg(long, value_delimiter = ',', default_values = peers::NAMES,
          value_parser = PossibleValuesParser::new(["none"].into_iter().chain(peers::NAMES)))]
    peers: Vec<String>,
    /// Maximum number of operations of a function that is compiled in one
    /// piece, as Robotran's is; in pieces ten times as many
    #[arg(long, default_value_t = 60_000, value_name = "OPERATIONS",
          add = whole(0, 100_000_000, "no function has more operations"))]
    pub(super) largest: usize,
    /// Random states
    #[arg(long, default_value_t = 16,
          add = states(16, 1024))]
    states: u32,
    /// Seed of the states
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// Number of rounds, in each of which every program runs once
    #[arg(long, default_value_t = 5,
          add = whole(1, 100, "every program runs in every round"))]
    rounds: u32,
    /// Time of each program in a round, ms
    #[arg(long, default_value_t = 200,
          add = whole(1, 1000, "every program takes this time in every round"))]
    milliseconds: u32,
    /// Flags for all C programs, instead of separate ones for each kind
    #[arg(long, allow_hyphen_values = true)]
    flags: Option<String>,
    /// Folder for the programs and bench.json
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

pub(super) fn run(arguments: &BenchArguments) -> Result<String, CommandFailure> {
    let temporary = TemporaryFolder::new()
        .map_err(|error| CommandFailure::plain(format!("no temporary folder: {error}")))?;
    let folder = arguments.output.as_deref().unwrap_or(temporary.path());
    let bar = progress::spinner();
    let mut text = String::new();
    let mut results = Vec::new();
    if arguments.robots {
        text += &robot_bench::run(arguments, folder, &bar, &mut results)?;
    }
    let subjects = arguments.subjects.iter().filter(|_| !arguments.robots);
    for subject in subjects {
        let loaded = load(subject, arguments)?;
        let outcomes = outcomes(&loaded, arguments, folder, &bar)?;
        let drawn = drawn(arguments);
        text += &text::text(&loaded.name, &drawn, &outcomes);
        text.push('\n');
        results.push((loaded.name, outcomes));
    }
    bar.finish_and_clear();
    let failed = failures(&results);
    if let Some(folder) = &arguments.output {
        let path = folder.join("bench.json");
        output::write_file(&path, |writer| {
            serde_json::to_writer_pretty(&mut *writer, &results).map_err(std::io::Error::other)
        })?;
    }
    if failed.is_empty() {
        return Ok(text);
    }
    output::write_stdout(|stdout| stdout.write_all(text.as_bytes()))?;
    Err(CommandFailure::advised("some programs failed", failed))
}

/// Number of states: full vectors of all kinds.
fn count(arguments: &BenchArguments) -> u32 {
    arguments.states.next_multiple_of(16)
}

/// At which states results are compared, in words.
pub(super) fn drawn(arguments: &BenchArguments) -> String {
    random_states(count(arguments) as usize, arguments.seed, false)
}

/// Results of all who take part.
pub(super) fn outcomes(
    loaded: &LoadedSubject,
    arguments: &BenchArguments,
    folder: &Path,
    bar: &ProgressBar,
) -> Result<Vec<BenchOutcome>, CommandFailure> {
    let states = States::new(arguments.seed);
    let question = BenchQuestion {
        name: loaded.name.clone(),
        view: view(&loaded.module),
        model: loaded.model.as_ref(),
        has_loads: arguments.forces,
        states: &states,
        count: count(arguments),
        flags: arguments.flags.as_deref(),
    };
    let contestants = contestants(&question, loaded, arguments)?;
    let outcomes = robovec_bench::bench(
        &question,
        &contestants,
        folder,
        arguments.rounds,
        arguments.milliseconds,
        &mut |what| bar.set_message(format!("{}: {what}", loaded.name)),
    )
    .map_err(|error| CommandFailure::plain(format!("{}: {error}", folder.display())))?;
    Ok(if arguments.compilers.is_empty() {
        robovec_bench::by_the_better_compiler(outcomes)
    } else {
        outcomes
    })
}

/// Failures of those able to take part; others lack a library or are too large.
fn failures(results: &[(String, Vec<BenchOutcome>)]) -> Vec<String> {
    let mut failed = Vec::new();
    for (name, outcomes) in results {
        let outcomes = outcomes.iter().filter(|outcome| outcome.is_broken);
        failed.extend(outcomes.map(|outcome| {
            let reason = outcome.failure.as_deref().unwrap_or_default();
            format!("{name}, {}: {reason}", outcome.name)
        }));
    }
    failed
}

pub(super) struct LoadedSubject {
    pub(super) name: String,
    /// The file of equations; a model has none.
    pub(super) file: Option<PathBuf>,
    pub(super) module: Module,
    pub(super) model: Option<Model>,
    /// Task of the function, if a model gives it and peers support it.
    pub(super) task: Option<BenchTask>,
    /// Reason why the equations are not Robotran's, if they are not.
    pub(super) replaced: Option<String>,
}

fn load(subject: &str, arguments: &BenchArguments) -> Result<LoadedSubject, CommandFailure> {
    let (name, model) = subjects::named_model(subject)?;
    let path = Path::new(subject);
    let wanted = arguments.function.as_deref();
    if let Some(model) = model {
        let task = wanted.map_or_else(BenchTask::default, |name| {
            BenchTask::with_name(name).expect("the command line has checked the function")
        });
        let (module, replaced) = usual_equations(&model, task, arguments.largest)?;
        return Ok(LoadedSubject {
            name,
            file: None,
            module,
            model: Some(model),
            task: Some(task),
            replaced,
        });
    }
    let mut module = input::without_ranges(input::equations(path, None)?, "bench")?;
    if module.functions.len() != 1 || wanted.is_some() {
        opt::select(&mut module, wanted.unwrap_or(BenchTask::default().name()))?;
    }
    let model = match &arguments.model {
        Some(path) => Some(input::model(path)?.model),
        None => None,
    };
    Ok(LoadedSubject {
        name,
        file: Some(path.to_owned()),
        task: BenchTask::with_name(&module.functions[0].name),
        module,
        model,
        replaced: None,
    })
}

/// Robotran's equations of a model; if too long, the shortest ones and why.
pub(super) fn usual_equations(
    model: &Model,
    task: BenchTask,
    largest: usize,
) -> Result<(Module, Option<String>), CommandFailure> {
    let options = Options::default();
    let formulation = Formulation::default();
    let usual = generation::functions(model, &[task.kind()], formulation, &options);
    let why = match &usual {
        Ok(module) if length(module) <= largest.saturating_mul(PIECES) => {
            return usual.map(|module| (module, None));
        }
        Ok(module) => too_long(length(module)),
        Err(_) => "the generator does not write them (robovec gen gives the reason)".to_owned(),
    };
    let found = contenders(model, task.kind(), task.formulations(), &options);
    let shortest = found.possible.into_iter().min_by_key(|one| one.operations);
    match shortest {
        Some(shortest) => Ok((shortest.module, Some(why))),
        None => usual.map(|module| (module, None)),
    }
}

/// Everybody who takes part.
fn contestants(
    question: &BenchQuestion<'_>,
    loaded: &LoadedSubject,
    arguments: &BenchArguments,
) -> Result<Vec<Contestant>, CommandFailure> {
    let found = compilers(arguments)?;
    let mut list = Vec::new();
    let ways = if arguments.robots { ROBOT_WAYS } else { WAYS };
    match &loaded.replaced {
        _ if arguments.robots => {}
        None => from_equations(question, loaded, arguments.largest, &found, &mut list)?,
        Some(why) => {
            list.push(robotran::missing(question, why.clone()));
            list.push(not_compiled(question, why.clone()));
        }
    }
    if let (Some(model), Some(task)) = (&loaded.model, loaded.task) {
        from_model(question, model, task, (&found, ways), &mut list)?;
        // What CasADi prints is about as long as the shortest of ours.
        let shortest = list.iter().filter_map(|own| own.operations).min();
        let too_long = shortest
            .filter(|&operations| operations > arguments.largest)
            .map(in_one_piece);
        let names = &arguments.peers;
        let found = peers::peers(question, model, task, names, too_long.as_deref());
        list.extend(found);
    }
    if let Some(task) = loaded.task {
        for contestant in &mut list {
            let rounding = task.tolerance(contestant.family) * contestant.coarseness;
            // No result is right of which a tenth is wrong.
            contestant.tolerance = rounding.min(0.1);
        }
    }
    Ok(list)
}

/// Enters Robotran's file and the C that is written for the same equations.
fn from_equations(
    question: &BenchQuestion<'_>,
    loaded: &LoadedSubject,
    largest: usize,
    compilers: &[Compiler],
    list: &mut Vec<Contestant>,
) -> Result<(), CommandFailure> {
    for compiler in compilers {
        let c_file = loaded.file.as_ref();
        let c_file = c_file.filter(|path| path.extension().is_some_and(|name| name == "c"));
        let operations = own::operations(question.view);
        list.push(match c_file {
            _ if operations > largest => robotran::missing(question, in_one_piece(operations)),
            Some(path) => robotran::file(question, compiler, path),
            None => robotran::printed(question, compiler, &loaded.module),
        });
    }
    let operations = own::operations(question.view);
    if operations > largest.saturating_mul(PIECES) {
        list.push(not_compiled(question, too_long(operations)));
        return Ok(());
    }
    let equations = BenchProgram::new(
        ContestantFamily::Equations,
        String::new(),
        loaded.module.clone(),
    )?;
    equations.enter(question, (compilers, WAYS), list);
    Ok(())
}

/// The compilers of which the better one is taken for every program.
const USUAL_COMPILERS: [&str; 2] = ["gcc", "clang"];

fn compilers(arguments: &BenchArguments) -> Result<Vec<Compiler>, CommandFailure> {
    let compilers = arguments.compilers.iter();
    let found = if arguments.compilers.is_empty() {
        let usual = USUAL_COMPILERS.map(Compiler::find);
        if usual.iter().any(Result::is_ok) {
            Ok(usual.into_iter().flatten().collect())
        } else {
            usual.into_iter().collect()
        }
    } else {
        compilers.map(|command| Compiler::find(command)).collect()
    };
    let note = "'--compilers' names the compilers to use".to_owned();
    found.map_err(|reason: String| CommandFailure::advised(reason, vec![note]))
}

/// Number of formulations of a model that take part.
pub(super) const FORMULATIONS: usize = 2;

/// Enters the formulations of the fewest operations, and names absent ones.
fn from_model(
    question: &BenchQuestion<'_>,
    model: &Model,
    task: BenchTask,
    means: BenchMeans<'_>,
    list: &mut Vec<Contestant>,
) -> Result<(), CommandFailure> {
    let options = Options {
        external_forces: question.has_loads,
        ..Options::default()
    };
    let found = contenders(model, task.kind(), task.formulations(), &options);
    let programs = found.possible.into_iter().map(|contender| {
        let name = format!("{}, ", contender.formulation.name());
        BenchProgram::new(ContestantFamily::Model, name, contender.module)
    });
    let mut programs: Vec<BenchProgram> = programs.collect::<Result<_, _>>()?;
    programs.sort_by_key(|program| length(&program.shorter));
    for program in programs.iter().take(FORMULATIONS) {
        program.enter(question, means, list);
    }
    for (formulation, why) in found.refused {
        let (family, name) = (ContestantFamily::Model, formulation.name());
        list.push(own::refused(question, family, name, why.to_string()));
    }
    Ok(())
}

/// Operations of a module of one function.
fn length(module: &Module) -> usize {
    own::operations(view(module))
}

fn view(module: &Module) -> View<'_> {
    module.tables.view(&module.functions[0])
}

/// Reason why a function is not compiled.
fn in_one_piece(operations: usize) -> String {
    format!("one function of {operations} operations, which compilers need hours for (--largest)")
}

/// Maximum size of a function compiled in pieces, relative to a whole one.
const PIECES: usize = 10;

/// The result for unchanged equations whose C is left out.
fn not_compiled(question: &BenchQuestion<'_>, why: String) -> Contestant {
    own::refused(question, ContestantFamily::Equations, "C of them", why)
}

/// Reason why equations are not compiled at all.
fn too_long(operations: usize) -> String {
    format!(
        "{operations} operations, which compilers need many minutes for also in pieces (--largest)"
    )
}

/// Equations that robovec writes as C in several ways.
struct BenchProgram {
    family: ContestantFamily,
    /// Text before the name of the way.
    name: String,
    /// The unchanged equations, in which loops are found.
    module: Module,
    /// After the passes for straight-line code.
    shorter: Module,
}

impl BenchProgram {
    fn new(
        family: ContestantFamily,
        name: String,
        module: Module,
    ) -> Result<BenchProgram, CommandFailure> {
        let mut shorter = module.clone();
        // That a pass finds nothing to do is of no interest to a bench, which
        // gives it what the pass is not made for.
        let mut remarks = std::io::sink();
        generation::transform_remarking(&mut shorter, &input::passes(PASSES)?, &mut remarks)?;
        Ok(BenchProgram {
            family,
            name,
            module,
            shorter,
        })
    }

    fn enter(
        &self,
        question: &BenchQuestion<'_>,
        (compilers, ways): BenchMeans<'_>,
        list: &mut Vec<Contestant>,
    ) {
        for compiler in compilers {
            for &(way, contestant) in ways {
                let name = format!("{}{way}", self.name);
                let module = match way {
                    ROLLED => &self.module,
                    _ => &self.shorter,
                };
                list.push(contestant(&own::ContestantPlan {
                    question,
                    compiler,
                    family: self.family,
                    name: &name,
                    view: view(module),
                    superwords: SuperwordLanes::None,
                }));
            }
        }
    }
}

/// Compilers, and the ways to write C by name.
type BenchMeans<'a> = (&'a [Compiler], &'a [(&'static str, own::ContestantMaker)]);

/// The variant with loops found in the unchanged equations.
const ROLLED: &str = "rolled";

/// All ways to write equations as C.
const WAYS: &[(&str, own::ContestantMaker)] = &[
    ("drop-in", robotran::drop_in),
    ("straight-line", own::straight),
    ("superwords", own::superwords),
    (ROLLED, own::rolled),
    ("batch", own::batch),
    ("batch, array of states", own::batch_of_states),
];

/// The variants in which robots are compared.
const ROBOT_WAYS: &[(&str, own::ContestantMaker)] = &[
    ("straight-line", own::straight),
    ("batch", own::batch),
    (robot_bench::SINGLE, own::batch_single),
];

/// Passes that shorten straight-line code for processors.
const PASSES: &str = "$cpu";
