//! `robovec rtl simulate`: memory images run cycle by cycle.

use crate::command::flags::NUMBER;
use crate::command::{CommandFailure, input};
use clap::Args;
use robovec_io::files::limited;
use robovec_simulate::LoadedProgram;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

/// Arguments of `simulate`.
#[derive(Args, Debug)]
pub(super) struct ImageArguments {
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
        allow_hyphen_values = true,
        add = NUMBER
    )]
    inputs: Vec<f64>,
}

pub(super) fn run(arguments: &ImageArguments) -> Result<String, CommandFailure> {
    let folder = &arguments.folder;
    let machine = input::machine(&arguments.machine)?;
    let advised = |message: String| {
        let note = "'robovec-opt EQUATIONS --passes …,place,codegen -o FOLDER' writes one";
        CommandFailure::advised(message, vec![note.to_owned()])
    };
    if folder.is_file() {
        let message = format!(
            "{} is a file, not a folder of memory images",
            folder.display()
        );
        return Err(advised(message));
    }
    let listing = fs::read_dir(folder).map_err(|error| {
        CommandFailure::plain(format!("cannot read {}: {error}", folder.display()))
    })?;
    let mut files = Vec::new();
    for entry in listing.filter_map(Result::ok) {
        let path = entry.path();
        if path.is_file() {
            files.push((
                entry.file_name().to_string_lossy().into_owned(),
                input::text(&path, &limited::IMAGE)?,
            ));
        }
    }
    files.sort();
    let fail = |error: String| CommandFailure::plain(format!("{}: {error}", folder.display()));
    let program = LoadedProgram::load(&files, &machine)
        .map_err(|error| advised(format!("{}: {error}", folder.display())))?;
    let outputs = program
        .run(&arguments.inputs)
        .map_err(|hazard| fail(hazard.to_string()))?;
    let mut text = String::new();
    for ((name, _), value) in program.outputs().zip(&outputs.values) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name} = {value:?}");
    }
    Ok(text)
}
