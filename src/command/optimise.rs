//! `robovec optimise`: the best program for a target.

use super::flags::{SEED, states, whole};
use super::output::result_files;
use super::{CommandFailure, input, output, progress, subjects};
use crate::bench::{Compiler, own};
use crate::explore::placing::with_counts;
use crate::explore::program::view;
use crate::explore::store::PointStore;
use crate::files::Replace;
use crate::generate::{GenerationRequest, generate};
use crate::model::Model;
use crate::optimise::start::{self, OptimisationStart};
use crate::optimise::{
    OptimisationQuestion, OptimisationTarget, Optimised, optimise, page, proof, text,
};
use crate::present::json::json_text;
use crate::robotran::FunctionKind;
use crate::robotran::drop_in::{DropInOptions, drop_in};
use crate::scene::{SceneFile, SceneSubject};
use clap::{Args, ValueEnum};
use robovec_codegen::c;
use robovec_framework::manager::{self, Config};
use robovec_framework::scene::Scene;
use robovec_ir::states::States;
use robovec_ir::{Machine, Module, Operation, print};
use robovec_passes::optimise::VariantClass;
use robovec_passes::registry::REGISTRY;
use std::fmt::Write;
use std::io;
use std::path::{Path, PathBuf};

/// Finds the best program for a target, proves it and writes it ready to use
#[derive(Args, Debug)]
pub(super) struct OptimiseArguments {
    /// Robotran file, robovec text, model (.mbs), scene (.scene.toml) or built-in model (serial-23)
    input: String,
    /// Model (.mbs) that a file of equations comes from: its other formulations are tried, too
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// What the program is for
    #[arg(
        long = "for",
        value_enum,
        default_value = "fpga",
        value_name = "TARGET"
    )]
    target: TargetName,
    /// Function of a model, or of a file with several
    #[arg(long)]
    function: Option<String>,
    /// Machine compiled for, a name or a .toml file; by default the scene's, else thesis
    #[arg(long)]
    machine: Option<String>,
    /// Adders and multipliers each; by default as in the machine
    #[arg(long, value_name = "N", add = whole(1, 4096, "a machine has elements of every kind"))]
    elements: Option<u32>,
    /// Scene that the function is needed for
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// What programs may rest on: equality over the reals alone, or also sin^2 + cos^2 = 1
    #[arg(long, value_enum, default_value = "real-trig")]
    class: ClassName,
    /// How far the search goes; more is never worse and takes as many times longer
    #[arg(long, default_value_t = 4, value_name = "N", add = whole(1, 10_000, "every effort takes as long as the first"))]
    effort: u32,
    /// Random states that errors are measured at; by default the more the smaller the function is
    #[arg(long, default_value_t = 0, hide_default_value = true, add = states(0, 100_000))]
    states: u32,
    /// Seed of the states
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// C compiler that times programs
    #[arg(long, default_value = "cc", value_name = "COMMAND")]
    compiler: String,
    /// Its flags
    #[arg(long, default_value = own::FLAGS, allow_hyphen_values = true)]
    flags: String,
    /// Folder for the program, optimise.html, .csv, .json and .svg
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Go on with the programs that an earlier run left in the folder
    #[arg(long, requires = "output")]
    resume: bool,
    /// Threads; as many as there are processors by default
    #[arg(long, value_name = "N", add = whole(1, 1024, "every thread takes memory of its own"))]
    jobs: Option<u32>,
    /// Replace files that robovec did not write
    #[arg(long, requires = "output")]
    force: bool,
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
enum TargetName {
    /// The shortest schedule on the machine; memory images and HDL
    Fpga,
    /// The least time of one evaluation in C, in the place of Robotran's file
    Cpu,
    /// The least time per state of C that evaluates several at once
    Batch,
}

#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
enum ClassName {
    /// Equality over the reals alone
    Real,
    /// And sin^2 + cos^2 = 1
    RealTrig,
}

/// What the user gave, read.
struct Given {
    name: String,
    starts: Vec<OptimisationStart>,
    /// Formulations that are not the function that came in, and why.
    left: Vec<(String, String)>,
    scene: Option<Scene>,
    /// The model that formulations are made from, as a word of a command.
    model: String,
}

/// Runs the command.
pub(super) fn run(arguments: &OptimiseArguments) -> Result<String, CommandFailure> {
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(jobs) = arguments.jobs {
        pool = pool.num_threads(jobs as usize);
    }
    let pool = pool
        .build()
        .map_err(|error| CommandFailure::plain(format!("cannot start threads: {error}")))?;
    let mut given = given(arguments)?;
    if arguments.class == ClassName::Real {
        // Formulations rest on sin^2 + cos^2 = 1.
        given.starts.truncate(1);
        given.left.clear();
    }
    let given = given;
    let machine = machine(arguments, given.scene.as_ref())?;
    let store = match &arguments.output {
        None => None,
        Some(folder) => {
            output::make_folder(folder)?;
            let store = PointStore::open(&folder.join("points"), arguments.resume);
            Some(store.map_err(|error| {
                CommandFailure::plain(format!("cannot make the folder for points: {error}"))
            })?)
        }
    };
    let source = match &given.scene {
        Some(scene) => scene.states(arguments.seed),
        None => States::new(arguments.seed),
    };
    let operations = given.starts[0].module.functions[0].nodes().len();
    let compiler = Compiler::find(&arguments.compiler).ok();
    let question = OptimisationQuestion {
        target: match arguments.target {
            TargetName::Fpga => OptimisationTarget::Fpga,
            TargetName::Cpu => OptimisationTarget::Cpu,
            TargetName::Batch => OptimisationTarget::Batch,
        },
        machine: &machine,
        scene: given.scene.as_ref(),
        class: match arguments.class {
            ClassName::Real => VariantClass::Real,
            ClassName::RealTrig => VariantClass::RealTrig,
        },
        effort: arguments.effort,
        states: &source,
        count: match arguments.states {
            0 => robovec_analysis::rounding::usual_states(operations),
            count => count,
        },
        compiler: compiler.as_ref(),
        flags: &arguments.flags,
        store: store.as_ref(),
    };
    let bar = progress::spinner();
    let told = |what: &str| bar.set_message(what.to_owned());
    let found = pool.install(|| optimise(&given.starts, &question, &told));
    bar.finish_and_clear();
    let found =
        found.map_err(|error| CommandFailure::plain(format!("{}: {error}", arguments.input)))?;
    tell(arguments, &given, &question, &found)
}

/// Reads what the user named.
fn given(arguments: &OptimiseArguments) -> Result<Given, CommandFailure> {
    if let Some(scene) = &arguments.scene {
        return with_scene(arguments, input::scene(scene)?.scene);
    }
    if arguments.input.ends_with(".scene.toml") {
        return of_scene(arguments, input::scene(Path::new(&arguments.input))?);
    }
    equations(arguments, arguments.function.as_deref())
}

/// Equations for a scene that the user named beside them.
fn with_scene(arguments: &OptimiseArguments, scene: Scene) -> Result<Given, CommandFailure> {
    let wished = scene.function.clone();
    let function = arguments.function.clone().or(wished);
    let given = equations(arguments, function.as_deref())?;
    Ok(Given {
        scene: Some(scene),
        ..given
    })
}

/// What a scene is about.
fn of_scene(arguments: &OptimiseArguments, file: SceneFile) -> Result<Given, CommandFailure> {
    let mut module = file
        .module()
        .map_err(|error| CommandFailure::plain(format!("{}: {error}", arguments.input)))?;
    if module.functions.len() != 1 {
        super::opt::select(
            &mut module,
            arguments.function.as_deref().unwrap_or("dirdyna"),
        )?;
    }
    let (formulations, left) = match &file.subject {
        SceneSubject::Model(subject) => {
            start::formulations(&module, &subject.model, subject.function)
        }
        SceneSubject::Equations(_) => (Vec::new(), Vec::new()),
    };
    let mut starts = vec![OptimisationStart::given(module)];
    starts.extend(formulations);
    Ok(Given {
        name: input::stem(Path::new(arguments.input.trim_end_matches(".toml"))),
        starts,
        left,
        scene: Some(file.scene),
        model: String::new(),
    })
}

/// Equations of a file or a model, with the formulations of the model.
fn equations(
    arguments: &OptimiseArguments,
    function: Option<&str>,
) -> Result<Given, CommandFailure> {
    let (name, model) = subjects::named_model(&arguments.input)?;
    let wanted = function.unwrap_or("dirdyna");
    let (mut module, model, words) = match (model, &arguments.model) {
        (Some(_), Some(path)) => {
            let note = format!("leave '--model {}' out", path.display());
            let message = "the input is a model itself";
            return Err(CommandFailure::advised(message, vec![note]));
        }
        (Some(model), None) => {
            let kind = kind(wanted)?;
            let request = GenerationRequest::new(kind);
            let module = generate(&model, &request)
                .map_err(|error| CommandFailure::plain(format!("{}: {error}", arguments.input)))?;
            (module, Some(model), arguments.input.clone())
        }
        (None, path) => {
            let module = input::equations(Path::new(&arguments.input), None)?.module;
            let model: Option<Model> = match path {
                Some(path) => Some(input::model(path)?.model),
                None => None,
            };
            let words = path.as_ref().map(|path| path.display().to_string());
            (module, model, words.unwrap_or_default())
        }
    };
    if module.functions.len() != 1 {
        super::opt::select(&mut module, wanted)?;
    }
    if module.functions.len() != 1 {
        let names: Vec<&str> = module.functions.iter().map(|f| f.name.as_str()).collect();
        return Err(CommandFailure::advised(
            format!("'{wanted}' stands for {} functions", names.len()),
            vec![format!("name one: --function {}", names.join(", "))],
        ));
    }
    let (mut formulations, mut left) = (Vec::new(), Vec::new());
    if let (Some(model), Some(kind)) = (&model, FunctionKind::with_name(&module.functions[0].name))
    {
        (formulations, left) = start::formulations(&module, model, kind);
    }
    let mut starts = vec![OptimisationStart::given(module)];
    starts.append(&mut formulations);
    Ok(Given {
        name,
        starts,
        left,
        scene: None,
        model: words,
    })
}

fn kind(name: &str) -> Result<FunctionKind, CommandFailure> {
    FunctionKind::with_name(name).ok_or_else(|| {
        let names = FunctionKind::ALL.map(FunctionKind::name).join(", ");
        let message = format!("no function '{name}' is generated");
        CommandFailure::advised(message, vec![format!("functions of a model: {names}")])
    })
}

/// The machine, with the numbers of elements that are wanted.
fn machine(
    arguments: &OptimiseArguments,
    scene: Option<&Scene>,
) -> Result<Machine, CommandFailure> {
    let wished = scene.and_then(|scene| scene.machine.as_deref());
    let name = arguments.machine.as_deref().or(wished).unwrap_or("thesis");
    let machine = input::machine(name)?;
    Ok(match arguments.elements {
        None => machine,
        Some(count) => with_counts(
            &machine,
            &[(Operation::Add, count), (Operation::Mul, count)],
        ),
    })
}

/// Writes what was found, and says what it is.
fn tell(
    arguments: &OptimiseArguments,
    given: &Given,
    question: &OptimisationQuestion<'_>,
    found: &Optimised,
) -> Result<String, CommandFailure> {
    let facts = facts(given, question, found);
    let commands = commands(arguments, given, found);
    let mut text = format!("{}\n\n{facts}", text::table(found));
    let Some(folder) = &arguments.output else {
        text += &format!("\nto make it again:\n{commands}");
        return Ok(text);
    };
    let mut files = program_files(question, found)?;
    files.push(("commands.txt".to_owned(), commands.clone()));
    if found.start != 0 {
        let start = print::print_module(&given.starts[found.start].module);
        files.push((START.to_owned(), start));
    }
    let table = text::points_table(found);
    let figure = text::figure(found);
    files.extend(result_files(&table, json_text(&found.points), &figure));
    files.push((
        "optimise.html".to_owned(),
        page::page(&given.name, found, &facts, &commands),
    ));
    let replace = output::forced(arguments.force, Replace::Results);
    for (name, content) in files.iter().filter(|(name, _)| !name.contains('/')) {
        let path = folder.join(name);
        output::write_over(&path, replace, |writer| {
            writer.write_all(content.as_bytes())
        })?;
    }
    for part in [HARDWARE, IMAGES] {
        let inside = files.iter().filter_map(|(name, content)| {
            let name = name.strip_prefix(part)?.strip_prefix('/')?;
            Some((name, content.as_str()))
        });
        let inside: Vec<(&str, &str)> = inside.collect();
        if !inside.is_empty() {
            // Most files of hardware are the same for every machine and bear
            // no mark.
            output::write_folder(&folder.join(part), &inside, Replace::Anything)?;
        }
    }
    // Writing to a string cannot fail.
    let _ = writeln!(text, "\nwritten to {}:", folder.display());
    let mut names: Vec<&str> = files
        .iter()
        .map(|(name, _)| name.split_inclusive('/').next().unwrap_or(name))
        .collect();
    names.dedup();
    for name in names {
        let _ = writeln!(text, "  {name}");
    }
    Ok(text)
}

/// The name of the file with the equations that the best program starts from,
/// where they are not those that came in.
const START: &str = "start.rvir";

/// What was taken and what is known of it.
fn facts(given: &Given, question: &OptimisationQuestion<'_>, found: &Optimised) -> String {
    let best = &found.points[found.best];
    let mut text = format!("{}: {}\n", given.name, best.name);
    let mut line = |line: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{line}");
    };
    if let (Some(cycles), Some(bound)) = (best.cycles, best.bound) {
        let machine = question.machine;
        let time = f64::from(cycles) / machine.clock_mhz;
        line(format!(
            "{cycles} cycles on {}, {time:.2} us at {} MHz",
            elements(machine),
            machine.clock_mhz
        ));
        line(match cycles == bound {
            true => "no schedule of these operations on this machine is shorter".to_owned(),
            false => format!(
                "the proved bound for these operations on this machine is {bound}: {:.1} % less",
                100.0 * f64::from(cycles - bound) / f64::from(cycles)
            ),
        });
    }
    if let Some(time) = best.nanoseconds {
        let compiler = question.compiler.map(|compiler| compiler.version.as_str());
        line(format!(
            "{time:.0} ns per state by {} {}",
            compiler.unwrap_or_default(),
            question.flags
        ));
    }
    line(format!(
        "errors in {}: median {:.1e}, worst normwise {:.1e} ({} states)",
        found.format, found.errors.relative.median, found.errors.normwise.worst, question.count
    ));
    line(format!("proved against the input: {}", found.proof));
    for (name, reason) in &given.left {
        line(format!("formulation {name} was left out: {reason}"));
    }
    text
}

/// The machine with its numbers of elements.
fn elements(machine: &Machine) -> String {
    let kinds = machine.elements.iter();
    let kinds: Vec<String> = kinds
        .map(|kind| format!("{} {}", kind.count, kind.kind))
        .collect();
    format!("{} ({})", machine.name, kinds.join(", "))
}

/// The commands that make the program again.
fn commands(arguments: &OptimiseArguments, given: &Given, found: &Optimised) -> String {
    let best = &found.points[found.best];
    let mut text = String::new();
    let input = match found.start {
        0 => arguments.input.clone(),
        start => {
            let recipe = &given.starts[start].recipe;
            if !given.model.is_empty() && !recipe.is_empty() {
                // Writing to a string cannot fail.
                let _ = writeln!(text, "robovec gen {} {recipe} -o {START}", given.model);
            }
            START.to_owned()
        }
    };
    let mut words = vec!["robovec-opt".to_owned(), input];
    if let (Some(name), 0) = (&arguments.function, found.start) {
        words.push(format!("--function {name}"));
    }
    if let Some(name) = &arguments.machine {
        words.push(format!("--machine {name}"));
    }
    if let Some(path) = &arguments.scene {
        words.push(format!("--scene {}", path.display()));
    } else if found.start != 0 && given.scene.is_some() {
        words.push(format!("--scene {}", arguments.input));
    }
    let mut passes = best.passes.clone();
    if arguments.target == TargetName::Fpga {
        passes += &match arguments.elements {
            None => ",place".to_owned(),
            Some(count) => format!(",place{{n_add={count} n_multi={count}}}"),
        };
    }
    words.push(format!("'-passes={passes}'"));
    words.push(format!("-o {PROGRAM}"));
    let _ = writeln!(text, "{}", words.join(" "));
    text += &match arguments.target {
        TargetName::Fpga => {
            let machine = arguments.machine.as_deref();
            let machine = machine.map_or_else(String::new, |name| format!(" --machine {name}"));
            format!("robovec-opt {PROGRAM}{machine} '-passes=codegen{{target=rtl}}' -o rtl\n")
        }
        TargetName::Cpu => format!("robovec write {PROGRAM} --language c --bounded -o .\n"),
        TargetName::Batch => {
            format!("robovec-opt {PROGRAM} '-passes=codegen{{target=batch}}' -o .\n")
        }
    };
    text
}

/// The name of the program's file.
const PROGRAM: &str = "program.rvir";

/// Folders for hardware, and for memory images alone.
const HARDWARE: &str = "rtl";
const IMAGES: &str = "images";

/// The program, ready to use.
fn program_files(
    question: &OptimisationQuestion<'_>,
    found: &Optimised,
) -> Result<Vec<(String, String)>, CommandFailure> {
    let fail = |error: &dyn std::fmt::Display| CommandFailure::plain(error.to_string());
    match question.target {
        OptimisationTarget::Fpga => {
            let placed = proof::finished(&found.program, "place", question);
            let placed = placed.map_err(|error| fail(&error))?;
            let mut files = vec![(PROGRAM.to_owned(), print::print_module(&placed))];
            for (target, folder) in [("rtl", HARDWARE), ("mif", IMAGES)] {
                match artifacts(&placed, &format!("codegen{{target={target}}}"), question) {
                    Ok(made) => {
                        let made = made.into_iter();
                        files.extend(made.map(|(name, text)| (format!("{folder}/{name}"), text)));
                        break;
                    }
                    // What hardware cannot be written for still has images.
                    Err(_) if target == "rtl" => {}
                    Err(error) => return Err(error),
                }
            }
            Ok(files)
        }
        OptimisationTarget::Cpu => {
            let program = print::print_module(&found.program);
            let mut files = match drop_in(&found.program, &DropInOptions::default()) {
                Ok(files) => files,
                // A function that is none of Robotran's has arrays of its own.
                Err(_) => plain_c(&found.program)?,
            };
            files.push((PROGRAM.to_owned(), program));
            Ok(files)
        }
        OptimisationTarget::Batch => {
            let mut files = artifacts(&found.program, "codegen{target=batch}", question)?;
            files.push((PROGRAM.to_owned(), print::print_module(&found.program)));
            Ok(files)
        }
    }
}

/// A function in C that takes its arrays one after the other.
fn plain_c(module: &Module) -> Result<Vec<(String, String)>, CommandFailure> {
    let options = c::Options {
        signature: c::Signature::Plain,
        ..c::Options::default()
    };
    let files = c::files(view(module), &options);
    let files = files.map_err(|error| CommandFailure::plain(error.to_string()))?;
    Ok(files.to_vec())
}

/// Files that a pipeline makes of a module.
fn artifacts(
    module: &Module,
    passes: &str,
    question: &OptimisationQuestion<'_>,
) -> Result<Vec<(String, String)>, CommandFailure> {
    let pipeline = REGISTRY
        .pipeline(passes)
        .expect("codegen has these targets");
    let mut module = module.clone();
    let mut log = io::sink();
    let config = Config {
        scene: question.scene,
        ..Config::new(question.machine, &mut log)
    };
    let outcome = manager::run(&mut module, &pipeline, config)
        .map_err(|error| CommandFailure::plain(error.to_string()))?;
    let files = outcome.artifacts.into_iter();
    Ok(files.map(|file| (file.name, file.text)).collect())
}
