//! `robovec accuracy`: what every pass does to the rounding errors.

use super::flags::{SEED, states};
use super::output::result_files;
use super::output_errors::{self, OutputArguments};
use super::{CommandFailure, input, output, progress};
use clap::Args;
use robovec_error::accuracy::{self, FunctionAccuracy, Options};
use robovec_present::json::json_text;
use std::path::PathBuf;

/// Arguments of `accuracy`.
#[derive(Args, Debug)]
pub(super) struct AccuracyArguments {
    /// Files of equations, or models (.mbs, .urdf)
    #[arg(required = true)]
    pub(super) files: Vec<PathBuf>,
    /// Pipeline whose passes are compared, by default $shorten; with
    /// --outputs run before anything is measured, by default none
    #[arg(long, value_name = "PIPELINE")]
    pub(super) passes: Option<String>,
    /// Machine compiled for: a name or a .toml file
    #[arg(long, default_value = "thesis")]
    pub(super) machine: String,
    /// Only this function; of a model, the one to generate
    #[arg(long, value_name = "NAME")]
    pub(super) function: Option<String>,
    /// Random states; by default the more the smaller the function is
    #[arg(long, default_value_t = 0, hide_default_value = true,
          add = states(0, 1_000_000))]
    pub(super) states: u32,
    /// Seed of the states
    #[arg(long, default_value_t = 1, add = SEED)]
    pub(super) seed: u64,
    /// Folder for accuracy.csv, accuracy.json and accuracy.svg; with --outputs
    /// for outputs.csv and outputs.json
    #[arg(short, long, value_name = "FOLDER")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) of_outputs: OutputArguments,
}

/// Runs the command.
pub(super) fn run(arguments: &AccuracyArguments) -> Result<String, CommandFailure> {
    if arguments.of_outputs.outputs {
        return output_errors::run(arguments);
    }
    let pipeline = input::passes(arguments.passes.as_deref().unwrap_or("$shorten"))?;
    let machine = input::machine(&arguments.machine)?;
    let bar = progress::bar(arguments.files.len(), "{pos}/{len} files, {msg}");
    let mut subjects: Vec<FunctionAccuracy> = Vec::new();
    let mut text = String::new();
    for path in &arguments.files {
        let function = arguments.function.as_deref();
        let mut read = input::equations_or_model(path, None, function)?;
        if let Some(wanted) = function {
            super::opt::select(&mut read.module, wanted)?;
        }
        let name = input::stem(path);
        let mut progress = |done: usize, total: usize, pass: &str| {
            bar.set_message(format!("{name}: {pass} ({done}/{total})"));
        };
        let scene = read.scene(None);
        let options = Options {
            states: arguments.states,
            seed: arguments.seed,
            scene: scene.as_ref(),
        };
        let module = &mut read.module;
        let measured =
            accuracy::measure(&name, module, &pipeline, &machine, options, &mut progress)
                .map_err(|error| CommandFailure::plain(format!("{}: {error}", path.display())))?;
        for subject in &measured {
            text += &accuracy::text(subject);
            text.push('\n');
        }
        subjects.extend(measured);
        bar.inc(1);
    }
    bar.finish_and_clear();
    if subjects.len() > 1 {
        text += &accuracy::summary(&subjects);
    }
    if let Some(folder) = &arguments.output {
        let table = accuracy::table(&subjects);
        let files = result_files(&table, json_text(&table), &accuracy::figure(&subjects));
        output::write_files(folder, &files)?;
    }
    Ok(text)
}
