//! `robovec eval`: outputs of functions at given or random states.

use super::flags::{SEED, choice, states};
use super::{CommandFailure, generation, input};
use crate::evaluate_command::{self, NumberSystem, ResultFormat, evaluate_at_states};
use clap::Args;
use robovec_dynamics::generate::Options;
use robovec_io::files::limited;
use robovec_io::sources::{self, EquationLanguage};
use robovec_ir::Module;
use robovec_ir::diagnostic::{Report, clip};
use robovec_ir::states::States;
use robovec_model::Model;
use robovec_robotran::FunctionKind;
use std::path::PathBuf;

/// Arguments of `eval`.
#[derive(Args, Debug)]
pub(super) struct EvalArguments {
    /// Robotran file, robovec text, or model (.mbs, .urdf, .xml)
    file: PathBuf,
    /// Number of random states, in ranges that suit the inputs (angles, masses,
    /// ...); or a file of lines `name[indices] number`, in which a line `state`
    /// starts the next state
    #[arg(long, required_unless_present = "random", value_parser = given_states)]
    states: Option<GivenStates>,
    /// The same as --states N
    #[arg(long, value_name = "N", conflicts_with = "states", hide = true,
          add = states(1, 1_000_000))]
    random: Option<u32>,
    /// Seed of the random states
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// Model (.mbs, .urdf, .xml) for the parameters that the states do not give; by
    /// default FILE, if it is a model
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Functions, separated by commas; by default all of a file of equations,
    /// and dirdyna of a model
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    function: Vec<String>,
    /// Recursion that generates a model's equations
    #[arg(long, default_value = "recursive",
          value_parser = generation::formulations())]
    formulation: String,
    /// Numbers: a format (f16, bf16, f32, f64, float(8,17), float(8,17,flush),
    /// fixed(12,19)), double-double, field (a prime field), or a number of bits
    #[arg(long, value_name = "KIND", default_value = "f64")]
    number: NumberSystem,
    /// Way in which the result is written: see --json and --csv
    #[arg(long, value_enum, default_value_t, hide = true)]
    format: ResultFormat,
    /// Write JSON instead of lines
    #[arg(long, conflicts_with_all = ["csv", "hexadecimal"])]
    json: bool,
    /// Write CSV instead of lines
    #[arg(long, conflicts_with = "hexadecimal")]
    csv: bool,
    /// Write floats in hexadecimal, as C's `%a`
    #[arg(long)]
    hexadecimal: bool,
    /// Language of the file; by default found from its name and content
    #[arg(long = "input-language", alias = "language", value_parser = choice(&input::LANGUAGES))]
    language: Option<EquationLanguage>,
}

/// States from the command line.
#[derive(Clone, Debug)]
enum GivenStates {
    Random(u32),
    File(PathBuf),
}

fn given_states(text: &str) -> Result<GivenStates, String> {
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return Ok(GivenStates::File(text.into()));
    }
    let count = states(1, 1_000_000).0.read_whole(text)?;
    Ok(GivenStates::Random(count as u32))
}

pub(super) fn run(arguments: &EvalArguments) -> Result<String, CommandFailure> {
    let own = sources::is_model_path(&arguments.file);
    let model_path = arguments.model.as_deref();
    let model_path = model_path.or(own.then_some(arguments.file.as_path()));
    // A model whose functions are evaluated is told of as equations are.
    let kind = own.then_some(FunctionKind::Dirdyna);
    let model = model_path.map(|path| input::model_for(path, kind));
    let model = model.transpose()?.map(|read| read.model);
    let (module, drawn) = match &model {
        Some(model) if own => (generated(arguments, model)?, States::new(arguments.seed)),
        _ => read(arguments)?,
    };
    let (file, count) = match &arguments.states {
        Some(GivenStates::File(path)) => (Some(path.as_path()), None),
        Some(GivenStates::Random(count)) => (None, Some(*count)),
        None => (None, arguments.random),
    };
    let text = file
        .map(|path| input::text(path, &limited::STATES))
        .transpose()?;
    let states = match (&text, count) {
        (Some(text), _) => evaluate_command::StateSource::Text(text),
        (None, count) => evaluate_command::StateSource::Random {
            count: count.unwrap_or(1),
            states: &drawn,
        },
    };
    let request = evaluate_command::EvaluationRequest {
        module: &module,
        model: model.as_ref(),
        states,
        number: arguments.number,
        format: match arguments.format {
            _ if arguments.hexadecimal => ResultFormat::Hexadecimal,
            _ if arguments.json => ResultFormat::Json,
            _ if arguments.csv => ResultFormat::Csv,
            format => format,
        },
    };
    evaluate_at_states(&request).map_err(|diagnostics| {
        // Only a file of states can be wrong.
        let (name, text) = file.zip(text.clone()).expect("states of a file");
        CommandFailure(Report::of(&name.display().to_string(), text, diagnostics))
    })
}

fn generated(arguments: &EvalArguments, model: &Model) -> Result<Module, CommandFailure> {
    let kind = |name: &String| {
        FunctionKind::from_name(name).ok_or_else(|| {
            let known = FunctionKind::ALL.map(FunctionKind::name);
            unknown(name, &known)
        })
    };
    let mut kinds: Vec<FunctionKind> = arguments
        .function
        .iter()
        .map(kind)
        .collect::<Result<_, _>>()?;
    if kinds.is_empty() {
        kinds.push(FunctionKind::Dirdyna);
    }
    let formulation = generation::formulation(&arguments.formulation);
    generation::functions(model, &kinds, formulation, &Options::default())
}

/// The functions of a file of equations, and random states of them.
fn read(arguments: &EvalArguments) -> Result<(Module, States), CommandFailure> {
    let input = input::equations_of(
        &arguments.file,
        arguments.language,
        arguments.function.first().map(String::as_str),
    )?;
    let states = input::states(input::scene_of(&input, None).as_ref(), arguments.seed);
    let mut module = input.module;
    let asked = &arguments.function;
    if let Some(name) = asked.iter().find(|name| module.function(name).is_none()) {
        let known = module
            .functions
            .iter()
            .map(|function| function.name.as_str());
        return Err(unknown(name, &known.collect::<Vec<_>>()));
    }
    if !asked.is_empty() {
        module
            .functions
            .retain(|function| asked.contains(&function.name));
    }
    Ok((module, states))
}

fn unknown(name: &str, known: &[&str]) -> CommandFailure {
    CommandFailure::advised(
        format!("there is no function '{}'", clip(name)),
        vec![format!("functions: {}", known.join(", "))],
    )
}
