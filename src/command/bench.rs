//! `robovec bench`: how fast the same function is in the hands of others.

use super::flags::{SEED, states, whole};
use super::{CommandFailure, generation, input, output, progress, subjects};
use crate::bench::contestant::{Contestant, ContestantFamily};
use crate::bench::{self, BenchOutcome, BenchQuestion, Compiler, own, peers, robotran, text};
use crate::files::TemporaryFolder;
use crate::generate::{Formulation, Options};
use crate::model::Model;
use crate::robotran::FunctionKind;
use clap::Args;
use clap::builder::PossibleValuesParser;
use robovec_ir::states::States;
use robovec_ir::{Module, View};
use std::path::{Path, PathBuf};

/// Times Robotran's file, robovec's C and other libraries on this computer, results compared first
#[derive(Args, Debug)]
pub(super) struct BenchArguments {
    /// Files of equations, models (.mbs) or built-in models (serial-23, bogie)
    #[arg(required = true)]
    subjects: Vec<String>,
    /// Model (.mbs) that a file of equations comes from
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// C compilers
    #[arg(long, value_delimiter = ',', default_value = "gcc")]
    compilers: Vec<String>,
    /// What others offer that takes part, where it is installed; 'none' for nothing
    #[arg(long, value_delimiter = ',', default_value = "loop,pinocchio,mujoco,casadi",
          value_parser = PossibleValuesParser::new(["none"].into_iter().chain(peers::NAMES)))]
    peers: Vec<String>,
    /// Operations up to which a function is compiled in one piece, as Robotran's is
    #[arg(long, default_value_t = 60_000, value_name = "OPERATIONS",
          add = whole(0, 100_000_000, "no function has more operations"))]
    largest: usize,
    /// Random states
    #[arg(long, default_value_t = 16,
          add = states(16, 1024))]
    states: u32,
    /// Seed of the states
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// Rounds in which everybody runs once
    #[arg(long, default_value_t = 5,
          add = whole(1, 100, "everybody runs in every round"))]
    rounds: u32,
    /// Time of everybody in a round, ms
    #[arg(long, default_value_t = 200,
          add = whole(1, 1000, "a round takes so long for everybody"))]
    milliseconds: u32,
    /// Flags with which all C is compiled, instead of those that suit each kind
    #[arg(long, allow_hyphen_values = true)]
    flags: Option<String>,
    /// Folder that keeps the programs, and bench.json
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub(super) fn run(arguments: &BenchArguments) -> Result<String, CommandFailure> {
    let temporary = TemporaryFolder::new()
        .map_err(|error| CommandFailure::plain(format!("no temporary folder: {error}")))?;
    let folder = arguments.output.as_deref().unwrap_or(temporary.path());
    let bar = progress::spinner();
    let mut text = String::new();
    let mut results = Vec::new();
    for subject in &arguments.subjects {
        let loaded = load(subject, arguments)?;
        let view = loaded.view();
        let states = States::new(arguments.seed);
        let question = BenchQuestion {
            name: loaded.name.clone(),
            view,
            model: loaded.model.as_ref(),
            states: &states,
            count: arguments.states.next_multiple_of(16),
            flags: arguments.flags.as_deref(),
        };
        let contestants = contestants(&question, &loaded, arguments)?;
        let outcomes = bench::bench(
            &question,
            &contestants,
            folder,
            arguments.rounds,
            arguments.milliseconds,
            &mut |what| bar.set_message(format!("{}: {what}", loaded.name)),
        )
        .map_err(|error| CommandFailure::plain(format!("{}: {error}", folder.display())))?;
        text += &text::text(&loaded.name, &outcomes);
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

/// What could take part and did not come to an end; others lack a library or
/// are too large.
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

/// What a subject is.
struct LoadedSubject {
    name: String,
    /// The file of equations; a model has none.
    file: Option<PathBuf>,
    module: Module,
    model: Option<Model>,
}

impl LoadedSubject {
    fn view(&self) -> View<'_> {
        View {
            tables: &self.module.tables,
            function: &self.module.functions[0],
        }
    }
}

fn load(subject: &str, arguments: &BenchArguments) -> Result<LoadedSubject, CommandFailure> {
    let (name, model) = subjects::named_model(subject)?;
    let path = Path::new(subject);
    if let Some(model) = model {
        let options = Options::default();
        let kinds = [FunctionKind::Dirdyna];
        let module = generation::functions(&model, &kinds, Formulation::default(), &options)?;
        return Ok(LoadedSubject {
            name,
            file: None,
            module,
            model: Some(model),
        });
    }
    let mut module = input::equations(path, None)?.module;
    if module.functions.len() != 1 {
        super::opt::select(&mut module, "dirdyna")?;
    }
    let model = match &arguments.model {
        Some(path) => Some(input::model(path)?.model),
        None => None,
    };
    Ok(LoadedSubject {
        name,
        file: Some(path.to_owned()),
        module,
        model,
    })
}

/// Everybody who takes part.
fn contestants(
    question: &BenchQuestion<'_>,
    loaded: &LoadedSubject,
    arguments: &BenchArguments,
) -> Result<Vec<Contestant>, CommandFailure> {
    let mut list = Vec::new();
    let compilers = arguments.compilers.iter();
    let (found, missing): (Vec<_>, Vec<_>) = compilers
        .map(|command| Compiler::find(command))
        .partition(Result::is_ok);
    let found: Vec<Compiler> = found.into_iter().flatten().collect();
    if found.is_empty() {
        return Err(CommandFailure::advised(
            format!(
                "none of the compilers is installed: {}",
                arguments.compilers.join(", ")
            ),
            missing.into_iter().filter_map(Result::err).collect(),
        ));
    }
    for compiler in &found {
        let c_file = loaded.file.as_ref();
        let c_file = c_file.filter(|path| path.extension().is_some_and(|name| name == "c"));
        let operations = own::operations(question.view);
        list.push(match c_file {
            _ if operations > arguments.largest => {
                robotran::missing(question, in_one_piece(operations))
            }
            Some(path) => robotran::file(question, compiler, path),
            None => robotran::printed(question, compiler, &loaded.module),
        });
    }
    let equations = BenchProgram {
        family: ContestantFamily::Equations,
        name: String::new(),
        module: loaded.module.clone(),
        passes: EQUATIONS,
    };
    equations.enter(question, &found, &mut list)?;
    let Some(model) = &loaded.model else {
        return Ok(list);
    };
    let options = Options {
        external_forces: false,
        ..Options::default()
    };
    for name in ["composite", "composite-base"] {
        let formulation = Formulation::from_name(name).expect("a formulation that there is");
        let kinds = [FunctionKind::Dirdyna];
        let program = BenchProgram {
            family: ContestantFamily::Model,
            name: format!("{name}, "),
            module: generation::functions(model, &kinds, formulation, &options)?,
            passes: MODEL,
        };
        program.enter(question, &found, &mut list)?;
    }
    // What CasADi prints is about as long as the shortest of ours.
    let shortest = list.iter().filter_map(|own| own.operations).min();
    let too_long = shortest
        .filter(|&operations| operations > arguments.largest)
        .map(in_one_piece);
    let found = peers::peers(question, model, &arguments.peers, too_long.as_deref());
    list.extend(found);
    Ok(list)
}

/// Why a function is not compiled.
fn in_one_piece(operations: usize) -> String {
    format!("one function of {operations} operations, which compilers need hours for (--largest)")
}

/// Equations that robovec writes as C in several ways.
struct BenchProgram {
    family: ContestantFamily,
    /// What stands before the name of the way.
    name: String,
    module: Module,
    /// What straight-line code goes through; loops are found in the equations
    /// as they are.
    passes: &'static str,
}

impl BenchProgram {
    fn enter(
        &self,
        question: &BenchQuestion<'_>,
        compilers: &[Compiler],
        list: &mut Vec<Contestant>,
    ) -> Result<(), CommandFailure> {
        let shorter = transformed(&self.module, self.passes)?;
        let ways: [(&str, own::ContestantMaker, &Module); 4] = [
            ("drop-in", robotran::drop_in, &shorter),
            ("straight-line", own::straight, &shorter),
            ("rolled", own::rolled, &self.module),
            ("batch", own::batch, &shorter),
        ];
        for compiler in compilers {
            for (way, contestant, module) in ways {
                let view = View {
                    tables: &module.tables,
                    function: &module.functions[0],
                };
                let name = format!("{}{way}", self.name);
                list.push(contestant(question, compiler, self.family, &name, view));
            }
        }
        Ok(())
    }
}

/// From the equations alone.
const EQUATIONS: &str = "$cpu";
/// From the model.
const MODEL: &str = "$cpu";

fn transformed(module: &Module, passes: &str) -> Result<Module, CommandFailure> {
    let pipeline = input::passes(passes)?;
    let mut module = module.clone();
    generation::transform(&mut module, &pipeline)?;
    Ok(module)
}
