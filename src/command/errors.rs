//! `robovec errors`: how large errors are, can be, and where they come from.

use super::CommandFailure;
use super::arguments::InputLanguage;
use super::flags::{SEED, states, whole};
use super::input::{self, InputModule};
use clap::{Args, ValueEnum};
use robovec_analysis::interval::GivenData;
use robovec_analysis::stochastic;
use robovec_error::errors::{self, ErrorMethod, ErrorSettings, ErrorTable};
use robovec_framework::manager::{self, Config};
use robovec_framework::scene::Scene;
use robovec_io::sources;
use robovec_ir::diagnostic::{clip, did_you_mean};
use robovec_ir::print::print_output;
use robovec_ir::{Format, Function, View};
use std::io;
use std::path::PathBuf;

/// Tell how large rounding errors are, how large they can be, and which
/// equations they come from
#[derive(Args, Debug)]
pub(super) struct ErrorsArguments {
    /// File of equations, or model (.mbs, .urdf)
    file: PathBuf,
    /// Language of the file, if its name does not say it
    #[arg(long = "input-language", alias = "language", value_name = "LANGUAGE")]
    language: Option<InputLanguage>,
    /// Only this function; of a model, the one to generate
    #[arg(long, value_name = "NAME")]
    function: Option<String>,
    /// Pipeline to run first
    #[arg(long, value_name = "PIPELINE")]
    passes: Option<String>,
    /// Machine compiled for: a name or a .toml file
    #[arg(long, default_value = "thesis")]
    machine: String,
    /// Number format of the run: f32, f16, float(8,17), fixed(12,19) …; by
    /// default that of an FPCore, else f32
    #[arg(long = "number", alias = "format")]
    format: Option<String>,
    /// Output arrays or elements: c, or M[1,2],c[3]; by default all, of large
    /// functions only scalars and vectors
    #[arg(long, value_name = "LIST")]
    outputs: Option<String>,
    /// Estimates for every output; by default bound, predict and, where the
    /// format is narrow enough, stochastic
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_enum)]
    method: Option<Vec<ErrorMethod>>,
    /// Seed of the states
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// State of the table, counted from 0
    #[arg(long, default_value_t = 0,
          add = whole(0, 1_000_000_000, "states are drawn by their number"))]
    state: u32,
    /// States that the shares of equations are averaged over
    #[arg(long, default_value_t = 1, add = states(1, 10_000))]
    states: u32,
    /// Scene (.scene.toml) whose ranges states are drawn from
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Equations named as the hottest
    #[arg(long, default_value_t = 12,
          add = whole(0, 1_000_000, "every one is a line of the result"))]
    top: usize,
    /// Operations of a window, for the method interval
    #[arg(long, default_value_t = 1000,
          add = whole(1, 100_000, "intervals over more operations say nothing"))]
    window: u32,
    /// States from which ranges inside a function are assumed, for the method
    /// interval
    #[arg(long, default_value_t = 32,
          add = whole(1, 10_000, "the function is evaluated at every state, and all values are kept"))]
    samples: u32,
    /// Enclosures of a window at most, for the method interval: boxes into
    /// which ranges are cut
    #[arg(long, default_value_t = 2000,
          add = whole(1, 1_000_000, "all operations of the window are enclosed in every box"))]
    boxes: u32,
    /// Kind of inputs and literals for the method interval: numbers of the
    /// format, or real numbers that are rounded first
    #[arg(long, value_name = "WHAT", value_enum, default_value = "held")]
    data: GivenWord,
    /// Write JSON instead of text
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Write CSV instead of text: one line per output
    #[arg(long)]
    csv: bool,
}

/// Kind of inputs and literals before the run.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
enum GivenWord {
    /// Inputs are numbers of the format, literals of binary64
    Held,
    /// Inputs are real numbers, literals the decimals written
    Real,
}

/// The methods where none is named; the last one has formats it cannot sample.
const USUAL: [ErrorMethod; 3] = [
    ErrorMethod::Bound,
    ErrorMethod::Predict,
    ErrorMethod::Stochastic,
];

/// Maximum cost of differentiating all outputs, in values times outputs; where
/// it would be more, matrices are left out unless they are asked for.
const WORK: usize = 1 << 31;

/// Runs the command: the text for the standard output.
pub(super) fn run(arguments: &ErrorsArguments) -> Result<String, CommandFailure> {
    let scene = match &arguments.scene {
        Some(path) => Some(input::scene(path)?.scene),
        None => None,
    };
    let (input, scene) = read(arguments, scene)?;
    let format = format(arguments, &input)?;
    let states = input::states(scene.as_ref(), arguments.seed);
    let unsampled = stochastic::supports(format).err();
    let methods = match (&arguments.method, &unsampled) {
        (Some(methods), _) => methods.clone(),
        (None, None) => USUAL.to_vec(),
        (None, Some(_)) => USUAL[..2].to_vec(),
    };
    let module = input.module;
    let mut tables = Vec::new();
    for function in &module.functions {
        if !asked(arguments, function) {
            continue;
        }
        let view = View {
            tables: &module.tables,
            function,
        };
        let settings = ErrorSettings {
            format,
            states: states.clone(),
            state: arguments.state,
            blamed: arguments.states,
            methods: methods.clone(),
            outputs: chosen(view, arguments.outputs.as_deref())?,
            most_equations: arguments.top,
            window: arguments.window as usize,
            samples: arguments.samples,
            boxes: arguments.boxes as usize,
            data: match arguments.data {
                GivenWord::Held => GivenData::Held,
                GivenWord::Real => GivenData::Real,
            },
        };
        let table = ErrorTable::measure(view, &settings).map_err(|error| {
            let help = "leave it out: --method bound,predict".to_owned();
            CommandFailure::advised(format!("method stochastic: {error}"), vec![help])
        })?;
        tables.push(table);
    }
    if tables.is_empty() {
        let name = arguments.function.as_deref().unwrap_or_default();
        let names = module
            .functions
            .iter()
            .map(|function| function.name.as_str());
        let note = match did_you_mean(name, names) {
            Some(near) => vec![format!("did you mean '{near}'?")],
            None => Vec::new(),
        };
        let message = format!("there is no function '{}'", clip(name));
        return Err(CommandFailure::advised(message, note));
    }
    if arguments.json {
        return Ok(errors::json(&tables));
    }
    if arguments.csv {
        return Ok(errors::csv(&tables));
    }
    let texts: Vec<String> = tables.iter().map(errors::text).collect();
    let mut text = texts.join("\n");
    if let (None, Some(reason)) = (&arguments.method, unsampled) {
        text += &format!("\nno sigma: {reason}\n");
    }
    Ok(text)
}

/// True for the function asked for, and for all that a model has under its
/// name: `sensor` are `sensor_1`, `sensor_2` ….
fn asked(arguments: &ErrorsArguments, function: &Function) -> bool {
    let is_model = arguments.language.is_none() && sources::is_model_path(&arguments.file);
    arguments.function.as_ref().is_none_or(|name| {
        *name == function.name || is_model && function.name.starts_with(name.as_str())
    })
}

/// The format of the run.
fn format(arguments: &ErrorsArguments, input: &InputModule) -> Result<Format, CommandFailure> {
    let Some(text) = &arguments.format else {
        return Ok(input.format.unwrap_or(Format::BINARY32));
    };
    text.parse()
        .map_err(|error| CommandFailure::plain(format!("--number {}: {error}", clip(text))))
}

/// Reads the file and runs the pipeline for a scene, to which the file may add
/// ranges.
fn read(
    arguments: &ErrorsArguments,
    scene: Option<Scene>,
) -> Result<(InputModule, Option<Scene>), CommandFailure> {
    let function = arguments.function.as_deref();
    let mut read = input::equations_or_model(&arguments.file, arguments.language, function)?;
    let scene = read.scene(scene);
    if let Some(passes) = &arguments.passes {
        let pipeline = input::passes(passes)?;
        let machine = input::machine(&arguments.machine)?;
        let mut sink = io::sink();
        let config = Config {
            scene: scene.as_ref(),
            ..Config::new(&machine, &mut sink)
        };
        manager::run(&mut read.module, &pipeline, config)
            .map_err(|error| CommandFailure::plain(error.to_string()))?;
    }
    Ok((read, scene))
}

/// The assignments that a list of arrays and elements means.
fn chosen(view: View<'_>, list: Option<&str>) -> Result<Vec<usize>, CommandFailure> {
    let function = view.function;
    let all = 0..function.assignments.len();
    let Some(list) = list else {
        if all.len().saturating_mul(function.nodes().len()) <= WORK {
            return Ok(all.collect());
        }
        let is_vector = |&place: &usize| {
            let output = function.assignments[place].output;
            function.output_element(output).2 <= 1
        };
        let vectors: Vec<usize> = all.clone().filter(is_vector).collect();
        return Ok(if vectors.is_empty() {
            all.collect()
        } else {
            vectors
        });
    };
    let mut places = Vec::new();
    for name in split(list) {
        let before = places.len();
        places.extend(all.clone().filter(|&place| {
            let output = function.assignments[place].output;
            let (array, ..) = function.output_element(output);
            let array = view.tables.symbols.text(array.name);
            // Printing every element would be the dearer way on large arrays.
            array == name || name.starts_with(array) && print_output(view, output) == name
        }));
        if places.len() == before {
            return Err(unknown(view, function, &name));
        }
    }
    places.sort_unstable();
    places.dedup();
    Ok(places)
}

/// The parts of a list with commas, those inside brackets aside.
fn split(list: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut inside = false;
    for character in list.chars().filter(|character| !character.is_whitespace()) {
        match character {
            ',' if !inside => parts.push(String::new()),
            _ => {
                inside = match character {
                    '[' => true,
                    ']' => false,
                    _ => inside,
                };
                if let Some(part) = parts.last_mut() {
                    part.push(character);
                }
            }
        }
    }
    parts.retain(|part| !part.is_empty());
    parts
}

fn unknown(view: View<'_>, function: &Function, name: &str) -> CommandFailure {
    let arrays = function.outputs().iter();
    let arrays: Vec<&str> = arrays
        .map(|array| view.tables.symbols.text(array.name))
        .collect();
    let note = match did_you_mean(name, arrays.iter().copied()) {
        Some(near) => format!("did you mean '{near}'?"),
        None => format!("outputs: {}", clip(&arrays.join(", "))),
    };
    let message = format!("'{}' has no output '{}'", function.name, clip(name));
    CommandFailure::advised(message, vec![note])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_inside_brackets_do_not_separate() {
        assert_eq!(split("c, M[1, 2],Qq[3]"), ["c", "M[1,2]", "Qq[3]"]);
        assert_eq!(split(" ,"), [] as [String; 0]);
    }
}
