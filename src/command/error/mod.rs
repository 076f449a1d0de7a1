//! `robovec error`: how exact results are, how inexact they can be, and why.
//!
//! One reader of subjects serves three questions: errors of outputs, also after
//! every pass ([`outputs`]), attribution and bounds ([`attribution`]), and the
//! effect of series for sines and cosines ([`series`]).

mod attribution;
mod outputs;
mod series;

use super::flags::{SEED, choice, states, whole};
use super::input;
use super::{CommandFailure, opt, output};
use attribution::AttributionArguments;
use clap::{ArgGroup, Args};
use outputs::MeasureArguments;
use robovec_framework::manager::{self, Config};
use robovec_framework::pipeline::Pipeline;
use robovec_framework::scene::Scene;
use robovec_io::sources::{EquationLanguage, ReadEquations};
use robovec_ir::diagnostic::{clip, suggestion};
use robovec_ir::print::print_output;
use robovec_ir::{Format, Machine, View};
use series::SeriesArguments;
use std::io;
use std::path::{Path, PathBuf};

/// Measure the rounding errors of every output, prove bounds, or find the
/// equations and passes that cause them
#[derive(Args, Debug)]
#[command(group = ArgGroup::new("attribution").args(["blame", "prove"]).multiple(true))]
pub(super) struct ErrorArguments {
    /// Files of equations, or models (.mbs, .urdf, .xml)
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Attribute the errors of one state to source equations
    #[arg(long, conflicts_with = "series")]
    blame: bool,
    /// Prove bounds of the errors: at one state, and for all states in the
    /// ranges of the inputs
    #[arg(long, conflicts_with = "series")]
    prove: bool,
    /// Measure the errors of series for sines and cosines
    #[arg(long, conflicts_with_all = ["scene", "outputs"])]
    series: bool,
    /// Passes to run first; without --blame, --prove or --series the errors
    /// after every pass are measured too
    #[arg(long, value_name = "PIPELINE")]
    passes: Option<String>,
    /// Language of the files, if their names do not show it
    #[arg(long = "input-language", alias = "language", value_name = "LANGUAGE",
        value_parser = choice(&input::LANGUAGES))]
    language: Option<EquationLanguage>,
    /// Only this function; of a model, the one to generate
    #[arg(long, value_name = "NAME")]
    function: Option<String>,
    /// Machine to compile for; the longest path is counted in its cycles
    #[arg(long, default_value = "thesis")]
    machine: String,
    /// Number formats, separated by commas; by default f32,f64, and with --blame, --prove or
    /// --series that of an FPCore, else f32
    #[arg(long = "number", aliases = ["format", "formats"], value_parser = formats)]
    formats: Option<FormatList>,
    /// Output arrays or elements: c, or M[1,2],c[3]; by default all, with --blame or --prove of
    /// large functions only scalars and vectors
    #[arg(long, value_name = "LIST")]
    outputs: Option<String>,
    /// Scene (.scene.toml) whose ranges states are drawn from
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Number of random states; by default more for smaller functions, 1 with
    /// --blame or --prove, 100 with --series
    #[arg(long, add = states(1, 1_000_000))]
    states: Option<u32>,
    /// Seed of the states
    #[arg(long, default_value_t = 1, add = SEED)]
    seed: u64,
    /// Rows shown: outputs with the largest errors, or the hottest equations [default: 20, of
    /// equations 12]
    #[arg(long, value_name = "N",
          add = whole(0, 1_000_000, "each is a line of the result"))]
    top: Option<usize>,
    #[command(flatten)]
    measure: MeasureArguments,
    /// Write JSON instead of text
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// Write CSV instead of text
    #[arg(long)]
    csv: bool,
    /// Folder for the results as .csv and .json, and as .svg for passes and
    /// series
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    // Last, since their headings hold for all that follow.
    #[command(flatten)]
    attribution: AttributionArguments,
    #[command(flatten)]
    of_series: SeriesArguments,
}

/// Formats in the order they were requested.
#[derive(Clone, Debug)]
struct FormatList(Vec<Format>);

impl ErrorArguments {
    /// The formats requested, else the usual ones.
    fn formats<'a>(&'a self, usual: &'a [Format]) -> &'a [Format] {
        match &self.formats {
            Some(list) => &list.0,
            None => usual,
        }
    }
}

/// Reads formats separated by commas.
fn formats(text: &str) -> Result<FormatList, String> {
    let parsed = split(text).map(|name| {
        let format = name.parse::<Format>();
        format.map_err(|error| format!("'{}': {error}", name.trim()))
    });
    parsed.collect::<Result<_, _>>().map(FormatList)
}

/// The parts of a list with commas, those inside brackets aside.
fn split(list: &str) -> impl Iterator<Item = &str> {
    let mut depth = 0u32;
    list.split(move |character: char| {
        match character {
            '(' | '[' => depth += 1,
            ')' | ']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        character == ',' && depth == 0
    })
}

/// Answer to a question, in the forms it can be had in.
struct ErrorAnswer {
    text: String,
    csv: String,
    json: String,
    /// Files for `-o`: name and text.
    files: Vec<(String, String)>,
}

pub(super) fn run(arguments: &ErrorArguments) -> Result<String, CommandFailure> {
    let setting = ErrorSetting::read(arguments)?;
    let answer = if arguments.series {
        series::run(arguments, &setting)?
    } else if arguments.blame || arguments.prove {
        attribution::run(arguments, &setting)?
    } else {
        outputs::run(arguments, &setting)?
    };
    if let Some(folder) = &arguments.output {
        output::write_files(folder, &answer.files)?;
    }
    Ok(if arguments.json {
        answer.json
    } else if arguments.csv {
        answer.csv
    } else {
        answer.text
    })
}

/// Machine, passes and scene of all files.
struct ErrorSetting {
    machine: Machine,
    pipeline: Pipeline,
    scene: Option<Scene>,
}

struct ErrorSubject {
    name: String,
    read: ReadEquations,
    /// The scene, with ranges that the file gives.
    scene: Option<Scene>,
}

impl ErrorSetting {
    fn read(arguments: &ErrorArguments) -> Result<ErrorSetting, CommandFailure> {
        let scene = arguments.scene.as_deref().map(input::scene).transpose()?;
        Ok(ErrorSetting {
            machine: input::machine(&arguments.machine)?,
            pipeline: input::passes_or_empty(arguments.passes.as_deref())?,
            scene: scene.map(|file| file.scene),
        })
    }

    /// Reads a file: the functions requested, before any pass.
    fn subject(
        &self,
        arguments: &ErrorArguments,
        path: &Path,
    ) -> Result<ErrorSubject, CommandFailure> {
        let function = arguments.function.as_deref();
        let mut read = input::equations_or_model(path, arguments.language, function)?;
        if let Some(wanted) = function {
            opt::select(&mut read.module, wanted)?;
        }
        Ok(ErrorSubject {
            name: input::stem(path),
            scene: input::scene_of(&read, self.scene.clone()),
            read,
        })
    }

    /// Runs the passes over a subject; their remarks are not printed here.
    fn transform(&self, subject: &mut ErrorSubject) -> Result<(), CommandFailure> {
        let mut log = io::sink();
        let config = Config {
            scene: subject.scene.as_ref(),
            ..Config::new(&self.machine, &mut log)
        };
        let run = manager::run(&mut subject.read.module, &self.pipeline, config);
        run.map_err(|error| subject.failure(&error.to_string()))?;
        Ok(())
    }
}

impl ErrorSubject {
    fn failure(&self, error: &str) -> CommandFailure {
        CommandFailure::plain(format!("{}: {error}", self.read.path.display()))
    }

    /// The functions, each with the name that results bear.
    fn functions(&self) -> impl Iterator<Item = (String, View<'_>)> {
        let module = &self.read.module;
        module.functions.iter().map(move |function| {
            let name = match module.functions.len() {
                1 => self.name.clone(),
                _ => format!("{} {}", self.name, function.name),
            };
            let tables = &module.tables;
            (name, View { tables, function })
        })
    }
}

/// The assignments that a list of arrays and elements names, in their order.
fn chosen(view: View<'_>, list: &str) -> Result<Vec<usize>, CommandFailure> {
    let function = view.function;
    let mut places = Vec::new();
    for name in split(list) {
        let name: String = name.chars().filter(|c| !c.is_whitespace()).collect();
        let before = places.len();
        places.extend((0..function.assignments.len()).filter(|&place| {
            let output = function.assignments[place].output;
            let (array, ..) = function.output_element(output);
            let array = view.tables.symbols.text(array.name);
            // Printing every element would be the dearer way on large arrays.
            array == name || name.starts_with(array) && print_output(view, output) == name
        }));
        if places.len() == before {
            return Err(unknown(view, &name));
        }
    }
    places.sort_unstable();
    places.dedup();
    Ok(places)
}

fn unknown(view: View<'_>, name: &str) -> CommandFailure {
    let arrays = view.function.outputs().iter();
    let arrays: Vec<&str> = arrays
        .map(|array| view.tables.symbols.text(array.name))
        .collect();
    let note = suggestion(name, arrays.iter().copied())
        .unwrap_or_else(|| format!("outputs: {}", clip(&arrays.join(", "))));
    let message = format!("'{}' has no output '{}'", view.function.name, clip(name));
    CommandFailure::advised(message, vec![note])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_inside_brackets_do_not_separate() {
        let FormatList(found) =
            formats("f32, float(8,17) ,fixed(12,19)").expect("they are formats");
        let names: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(names, ["f32", "float(8,17)", "fixed(12,19)"]);
        for text in ["", "f32,,f64", "float(8", "f32)"] {
            assert!(formats(text).is_err(), "{text}");
        }
        let parts: Vec<&str> = split("c,M[1, 2],Qq[3]").collect();
        assert_eq!(parts, ["c", "M[1, 2]", "Qq[3]"]);
    }
}
