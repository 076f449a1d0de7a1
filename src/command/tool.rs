//! `robovec`: what can be done with equations and programs besides compiling
//! them.

use super::arguments::InputLanguage;
use super::generation::{self, GenArguments};
use super::model::{self, ModelArguments};
use super::{Failure, align, input, output, write};
use crate::evaluate_command::evaluate_at_states;
use crate::simulate::Program;
use clap::{Parser, Subcommand};
use robovec_ir::diagnostic::{Report, termcolor::ColorChoice};
use robovec_ir::{Module, View};
use robovec_passes::NumericClass;
use robovec_passes::check::check;
use std::ffi::OsString;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Evaluates, simulates and compares equations of multibody systems.
#[derive(Parser, Debug)]
#[command(name = "robovec", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Evaluate every function at the states of a file, in 64-bit floats
    Eval {
        /// Robotran file or robovec text
        file: PathBuf,
        /// Lines `name[indices] number`; a line `state` starts the next state
        #[arg(long, value_name = "FILE")]
        states: PathBuf,
        /// Language of the file; by default told by its name and content
        #[arg(long, value_enum)]
        language: Option<InputLanguage>,
    },
    /// Generate the equations of a model
    Gen(GenArguments),
    /// Summarise a model, or write one of a family
    Model(ModelArguments),
    /// Run memory images cycle by cycle on given inputs
    Simulate {
        /// Folder with the images and manifest.json that `codegen` wrote
        folder: PathBuf,
        /// Machine the images are for: a name or a .toml file
        #[arg(long, default_value = "thesis")]
        machine: String,
        /// One number per input element, in order of declaration
        #[arg(
            long,
            value_name = "NUMBERS",
            value_delimiter = ',',
            allow_hyphen_values = true
        )]
        inputs: Vec<f64>,
    },
    /// Compare the functions of two files as functions
    Check {
        /// The one file
        before: PathBuf,
        /// The other file
        after: PathBuf,
        /// Random points
        #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
        points: u32,
        /// Seed of the points
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Demand equal bits instead of equality over the real numbers
        #[arg(long)]
        exact: bool,
        /// Take sines and cosines as true ones: sin^2 + cos^2 = 1
        #[arg(long, conflicts_with = "exact")]
        circle: bool,
        /// Compare over all arrays and elements of either file; what one of
        /// them does not set is zero there
        #[arg(long)]
        align: bool,
    },
    Study(super::study::Arguments),
    /// Write equations as Robotran's C, Matlab or Python files
    Write(write::WriteArguments),
}

/// Runs the program.
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let arguments = Arguments::parse_from(arguments);
    let result = match &arguments.command {
        Command::Eval {
            file,
            states,
            language,
        } => eval(file, states, *language),
        Command::Gen(arguments) => generation::run(arguments),
        Command::Model(arguments) => model::run(arguments),
        Command::Simulate {
            folder,
            machine,
            inputs,
        } => simulate(folder, machine, inputs),
        Command::Check {
            before,
            after,
            points,
            seed,
            exact,
            circle,
            align,
        } => {
            let class = match (*exact, *circle) {
                (true, _) => NumericClass::Exact,
                (false, true) => NumericClass::RealTrig,
                (false, false) => NumericClass::Real,
            };
            compare((before, after), *align, *points, *seed, class)
        }
        Command::Study(arguments) => super::study::study(arguments),
        Command::Write(arguments) => write::run(arguments),
    };
    match result.and_then(|text| output::write_stdout(|stdout| stdout.write_all(text.as_bytes()))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.emit();
            ExitCode::FAILURE
        }
    }
}

pub(super) fn read_text(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path)
        .map_err(|error| Failure::plain(format!("cannot read {}: {error}", path.display())))
}

fn eval(file: &Path, states: &Path, language: Option<InputLanguage>) -> Result<String, Failure> {
    let input = input::equations(file, language)?;
    input
        .warnings
        .emit_to_stderr(ColorChoice::Auto)
        .unwrap_or_default();
    let text = read_text(states)?;
    evaluate_at_states(&input.module, &text).map_err(|diagnostics| {
        Failure(Report::of(&states.display().to_string(), text, diagnostics))
    })
}

fn simulate(folder: &Path, machine: &str, inputs: &[f64]) -> Result<String, Failure> {
    let machine = input::machine(machine)?;
    let listing = fs::read_dir(folder)
        .map_err(|error| Failure::plain(format!("cannot read {}: {error}", folder.display())))?;
    let mut files = Vec::new();
    for entry in listing.filter_map(Result::ok) {
        let path = entry.path();
        if path.is_file() {
            files.push((
                entry.file_name().to_string_lossy().into_owned(),
                read_text(&path)?,
            ));
        }
    }
    files.sort();
    let fail = |error: String| Failure::plain(format!("{}: {error}", folder.display()));
    let program = Program::load(&files, &machine).map_err(|error| fail(error.to_string()))?;
    let outputs = program
        .run(inputs)
        .map_err(|hazard| fail(hazard.to_string()))?;
    let mut text = String::new();
    for ((name, _), value) in program.outputs().zip(&outputs.values) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name} = {value:?}");
    }
    Ok(text)
}

/// Gives functions of the same name the same arrays.
fn align_modules(before: &mut Module, after: &mut Module) {
    for index in 0..before.functions.len() {
        let name = &before.functions[index].name;
        let Some(other) = after.functions.iter().position(|f| f.name == *name) else {
            continue;
        };
        let aligned = align::align(
            (&before.functions[index], &mut before.tables),
            (&after.functions[other], &mut after.tables),
        );
        (before.functions[index], after.functions[other]) = aligned;
    }
}

fn compare(
    (before, after): (&Path, &Path),
    align: bool,
    points: u32,
    seed: u64,
    class: NumericClass,
) -> Result<String, Failure> {
    let (mut before, mut after) = (
        input::equations(before, None)?,
        input::equations(after, None)?,
    );
    if align {
        align_modules(&mut before.module, &mut after.module);
    }
    let mut text = String::new();
    for function in &before.module.functions {
        let Some(other) = after.module.function(&function.name) else {
            return Err(Failure::plain(format!(
                "{} has no function '{}'",
                after.name, function.name
            )));
        };
        let verdict = check(
            View {
                tables: &before.module.tables,
                function,
            },
            View {
                tables: &after.module.tables,
                function: other,
            },
            class,
            points,
            seed,
        );
        if !verdict.holds() {
            return Err(Failure::plain(format!(
                "'{}' differs: {verdict}",
                function.name
            )));
        }
        // As above.
        let _ = writeln!(text, "{}: {verdict}", function.name);
    }
    Ok(text)
}
