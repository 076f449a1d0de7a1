//! `robovec sim fmu`: a model with its laws as an FMU.

use super::{MovedModel, failure};
use crate::command::{CommandFailure, output, progress};
use clap::Args;
use robovec_dynamics::fmu::Fmu;
use robovec_dynamics::generate::{Options, fewest};
use robovec_io::files::TemporaryFolder;
use robovec_io::process::ProgramCall;
use robovec_ir::diagnostic::{clip, counted, suggestion};
use robovec_model::Model;
use robovec_robotran::FunctionKind;
use std::env::consts;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Flags of the compiler. Operations stay in the order of the equations.
const FLAGS: [&str; 5] = ["-O2", "-std=c99", "-fPIC", "-shared", "-ffp-contract=off"];

/// Arguments of `fmu`.
#[derive(Args, Debug)]
pub(super) struct FmuArguments {
    #[command(flatten)]
    subject: MovedModel,
    /// Recursion the accelerations come from [default: the one with the fewest
    /// operations]
    #[arg(long, value_parser = crate::command::generation::formulations())]
    formulation: Option<String>,
    /// Links of a robot whose motion is among the outputs
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    frames: Vec<String>,
    /// Command of the C compiler that makes the binary for this computer
    #[arg(long, default_value = "cc", value_name = "COMMAND")]
    compiler: String,
    /// FMU to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// Writes the FMU: a line about it.
pub(super) fn run(arguments: &FmuArguments) -> Result<String, CommandFailure> {
    let (mut model, laws) = arguments.subject.read()?;
    keep_frames(&mut model, &arguments.frames)?;
    let formulation = match &arguments.formulation {
        Some(name) => crate::command::generation::formulation(name),
        None => fewest(&model, FunctionKind::Accelred, &Options::default()),
    };
    let fmu = Fmu::new(&model, &laws, formulation).map_err(failure)?;
    let binary = match platform() {
        Some(platform) => compiled(arguments, &fmu)?.map(|binary| (platform, binary)),
        None => None,
    };
    if binary.is_none() {
        let _ = writeln!(
            progress::remarks(),
            "remark: '{}' does not run here, so the FMU has its C (sources) and no binary",
            arguments.compiler
        );
    }
    let archive = archive(&fmu, binary.as_ref())
        .map_err(|error| CommandFailure::plain(format!("the archive cannot be made: {error}")))?;
    output::write_file(&arguments.output, |writer| writer.write_all(&archive))?;
    let [states, inputs, parameters, outputs] = fmu.counts;
    Ok(format!(
        "{}: {}, {}, {}, {}\n",
        arguments.output.display(),
        counted(states, "state"),
        counted(inputs, "input"),
        counted(parameters, "parameter"),
        counted(outputs, "output"),
    ))
}

/// Leaves only frames of some names in a model.
fn keep_frames(model: &mut Model, names: &[String]) -> Result<(), CommandFailure> {
    let known = || model.frames.iter().map(|frame| frame.name.as_str());
    let missing = names
        .iter()
        .find(|name| !known().any(|known| known == *name));
    if let Some(name) = missing {
        let notes = suggestion(name, known());
        let error = format!("the model has no link '{}'", clip(name));
        return Err(CommandFailure::advised(error, notes.into_iter().collect()));
    }
    model.frames.retain(|frame| names.contains(&frame.name));
    Ok(())
}

/// Folder and extension of binaries for this computer, as FMI names them.
fn platform() -> Option<(&'static str, &'static str)> {
    match (consts::ARCH, consts::OS) {
        ("x86_64", "linux") => Some(("x86_64-linux", "so")),
        ("aarch64", "linux") => Some(("aarch64-linux", "so")),
        ("x86_64", "macos") => Some(("x86_64-darwin", "dylib")),
        ("aarch64", "macos") => Some(("aarch64-darwin", "dylib")),
        _ => None,
    }
}

/// The library of the C; `None` without a compiler.
fn compiled(arguments: &FmuArguments, fmu: &Fmu) -> Result<Option<Vec<u8>>, CommandFailure> {
    let command = &arguments.compiler;
    if ProgramCall::version(command, "--version").run().is_err() {
        return Ok(None);
    }
    let failed = |reason: String| CommandFailure::plain(reason);
    let folder = TemporaryFolder::new().map_err(|error| failed(error.to_string()))?;
    let place = folder.path();
    let path = format!("sources/{}.c", fmu.identifier);
    let mut files = fmu.files.iter();
    let (_, source) = files.find(|(name, _)| *name == path).expect("an FMU has C");
    write(&place.join("fmu.c"), source)?;
    let call = ProgramCall::new(command).folder(place).arguments(FLAGS);
    let run = call.arguments(["fmu.c", "-o", "fmu.so", "-lm"]).run();
    let run = run.map_err(|error| failed(error.to_string()))?;
    if !run.status.success() {
        let messages = run.messages();
        let line = messages.lines().find(|line| line.contains("error"));
        return Err(failed(format!(
            "'{command}': {}",
            line.unwrap_or("it failed")
        )));
    }
    let library = std::fs::read(place.join("fmu.so"));
    library.map(Some).map_err(|error| failed(error.to_string()))
}

fn write(path: &Path, text: &str) -> Result<(), CommandFailure> {
    output::write_file(path, |writer| writer.write_all(text.as_bytes()))
}

/// The archive, with fixed times: the same model gives the same bytes.
fn archive(fmu: &Fmu, binary: Option<&((&str, &str), Vec<u8>)>) -> io::Result<Vec<u8>> {
    let mut writer = ZipWriter::new(io::Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (name, text) in &fmu.files {
        writer.start_file(name.as_str(), options)?;
        writer.write_all(text.as_bytes())?;
    }
    if let Some(((folder, extension), bytes)) = binary {
        let name = format!("binaries/{folder}/{}.{extension}", fmu.identifier);
        writer.start_file(name, options)?;
        writer.write_all(bytes)?;
    }
    Ok(writer.finish()?.into_inner())
}
