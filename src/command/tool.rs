//! `robovec`: what can be done with equations and programs besides compiling
//! them.

use super::accuracy::{self, AccuracyArguments};
use super::bench::{self, BenchArguments};
use super::compare::{self, CheckArguments};
use super::errors::{self, ErrorsArguments};
use super::eval::{self, EvalArguments};
use super::fit::{self, FitArguments};
use super::flags::{NUMBER, real, whole};
use super::front::{self, FrontArguments};
use super::generation::{self, GenArguments};
use super::model::{self, ModelArguments};
use super::neglect::{self, NeglectArguments};
use super::optimise::{self, OptimiseArguments};
use super::scene::{self, SceneArguments};
use super::sim::{self, SimArguments};
use super::standing::{self, EquilibriumArguments, ModalArguments};
use super::telling::{self, TellingArguments};
use super::{CommandFailure, flags, grammar, input, output, write};
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::env::CompleteEnv;
use robovec_io::files::{Replace, limited, set_force};
use robovec_io::process::{ProcessLimits, set_limits};
use robovec_io::sources::set_reading;
use robovec_model::urdf::{RobotBase, RobotReading};
use robovec_simulate::LoadedProgram;
use std::ffi::OsString;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Evaluates, simulates and compares equations of multibody systems.
#[derive(Parser, Debug)]
#[command(name = "robovec", version)]
struct ToolArguments {
    #[command(subcommand)]
    command: ToolCommand,
    #[command(flatten)]
    telling: TellingArguments,
    /// Replace files that robovec did not write
    #[arg(long, global = true)]
    force: bool,
    /// Time after which a compiler, a simulator of hardware, yosys or a program
    /// they made is stopped, s
    #[arg(long, global = true, value_name = "SECONDS", default_value_t = 1800,
          add = whole(1, MAX_SECONDS, "a tool that takes longer than a day has gone astray"))]
    tool_seconds: u64,
    /// Base of a robot (.urdf): fixed, or moving freely by x, y, z, yaw, pitch
    /// and roll
    #[arg(long, global = true, value_name = "fixed|floating", value_enum,
          default_value_t = BaseChoice::Fixed, hide_possible_values = true)]
    base: BaseChoice,
    /// Largest distance from a right angle at which an angle of a robot is
    /// taken as one, rad
    #[arg(long, global = true, value_name = "RADIANS", default_value_t = 0.0,
          add = real(0.0, 1e-3, "the robot would be another one"))]
    right_angles: f64,
}

/// The base of robots, as the command line names it.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum BaseChoice {
    Fixed,
    Floating,
}

/// A week.
const MAX_SECONDS: u64 = 7 * 24 * 3600;

/// The remedy for a tool that was stopped.
pub(super) const TIME_ADVICE: &str = "'--tool-seconds' gives tools more time or less";

#[derive(Subcommand, Debug)]
enum ToolCommand {
    /// Measure what every pass of a pipeline does to the rounding errors
    Accuracy(AccuracyArguments),
    Bench(BenchArguments),
    /// Find where a model stands still under its laws
    Equilibrium(EquilibriumArguments),
    Errors(ErrorsArguments),
    /// Print the script that makes a shell complete command lines
    Completion(super::manual::CompletionArguments),
    /// Evaluate functions at given or random states
    Eval(EvalArguments),
    Fit(FitArguments),
    Front(FrontArguments),
    /// Generate the equations of a model
    Gen(GenArguments),
    /// Find the modes of a model under its laws: frequencies, damping, shapes
    Modal(ModalArguments),
    /// Summarise a model, or write one of a family
    Model(ModelArguments),
    /// Write manual pages of both programs
    Manual(super::manual::ManualArguments),
    Neglect(NeglectArguments),
    /// Check a scene and tell what it means
    Scene(SceneArguments),
    /// Integrate a model in time
    Sim(SimArguments),
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
            allow_hyphen_values = true,
            add = NUMBER
        )]
        inputs: Vec<f64>,
    },
    /// Compare the functions of two files as functions
    Check(CheckArguments),
    Optimise(OptimiseArguments),
    Rtl(super::rtl::RtlArguments),
    Rules(super::rules::RulesArguments),
    Stress(super::stress::StressArguments),
    Study(super::study::StudyArguments),
    Sweep(super::sweep::SweepArguments),
    Synthesise(super::synthesise::SynthesiseArguments),
    /// Measure what series for sines and cosines do to the outputs
    Trig(super::trig::TrigArguments),
    View(super::view::ViewArguments),
    /// Write equations as Robotran's C, Matlab or Python files
    Write(write::WriteArguments),
}

/// The command line, with the limits of its numbers.
pub(crate) fn command() -> clap::Command {
    grammar::apply(flags::enforce(ToolArguments::command()))
}

/// Runs the program.
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    CompleteEnv::with_factory(command).complete();
    let matches = command().get_matches_from(arguments);
    let arguments = match ToolArguments::from_arg_matches(&matches) {
        Ok(arguments) => arguments,
        Err(error) => error.exit(),
    };
    set_limits(ProcessLimits {
        time: Duration::from_secs(arguments.tool_seconds),
        ..ProcessLimits::USUAL
    });
    set_reading(RobotReading {
        base: match arguments.base {
            BaseChoice::Fixed => RobotBase::Fixed,
            BaseChoice::Floating => RobotBase::Floating,
        },
        right_angle: arguments.right_angles,
    });
    telling::set(arguments.telling);
    set_force(arguments.force);
    if let Err(failure) = refuse_foreign_outputs(&matches) {
        failure.emit();
        return ExitCode::FAILURE;
    }
    let start = Instant::now();
    let result = match &arguments.command {
        ToolCommand::Accuracy(arguments) => accuracy::run(arguments),
        ToolCommand::Bench(arguments) => bench::run(arguments),
        ToolCommand::Equilibrium(arguments) => standing::equilibrium(arguments),
        ToolCommand::Errors(arguments) => errors::run(arguments),
        ToolCommand::Eval(arguments) => eval::run(arguments),
        ToolCommand::Fit(arguments) => fit::run(arguments),
        ToolCommand::Front(arguments) => front::run(arguments),
        ToolCommand::Gen(arguments) => generation::run(arguments),
        ToolCommand::Modal(arguments) => standing::modal(arguments),
        ToolCommand::Manual(arguments) => super::manual::manual(arguments),
        ToolCommand::Completion(arguments) => super::manual::completion(arguments),
        ToolCommand::Model(arguments) => model::run(arguments),
        ToolCommand::Neglect(arguments) => neglect::run(arguments),
        ToolCommand::Scene(arguments) => scene::run(arguments),
        ToolCommand::Sim(arguments) => sim::run(arguments),
        ToolCommand::Simulate {
            folder,
            machine,
            inputs,
        } => simulate(folder, machine, inputs),
        ToolCommand::Check(arguments) => compare::run(arguments),
        ToolCommand::Optimise(arguments) => optimise::run(arguments),
        ToolCommand::Rtl(arguments) => super::rtl::run(arguments),
        ToolCommand::Rules(arguments) => super::rules::run(arguments),
        ToolCommand::Stress(arguments) => super::stress::run(arguments),
        ToolCommand::Study(arguments) => super::study::study(arguments),
        ToolCommand::Sweep(arguments) => super::sweep::run(arguments),
        ToolCommand::Synthesise(arguments) => super::synthesise::run(arguments),
        ToolCommand::Trig(arguments) => super::trig::run(arguments),
        ToolCommand::View(arguments) => super::view::run(arguments),
        ToolCommand::Write(arguments) => write::run(arguments),
    };
    if telling::is_verbose() {
        eprintln!("{:.1} s", start.elapsed().as_secs_f64());
    }
    match result.and_then(|text| output::write_stdout(|stdout| stdout.write_all(text.as_bytes()))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.emit();
            ExitCode::FAILURE
        }
    }
}

/// Refuses, before any work, files that results may not replace.
fn refuse_foreign_outputs(matches: &ArgMatches) -> Result<(), CommandFailure> {
    let Some((_, inner)) = matches.subcommand() else {
        let outputs = ["output", "plot", "events", "dot", "trace"];
        let path = |id| matches.try_get_one::<PathBuf>(id).ok().flatten();
        for path in outputs.into_iter().filter_map(path) {
            output::refuse_foreign(Some(path), &[""], Replace::Results)?;
        }
        return Ok(());
    };
    refuse_foreign_outputs(inner)
}

fn simulate(folder: &Path, machine: &str, inputs: &[f64]) -> Result<String, CommandFailure> {
    let machine = input::machine(machine)?;
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
        .run(inputs)
        .map_err(|hazard| fail(hazard.to_string()))?;
    let mut text = String::new();
    for ((name, _), value) in program.outputs().zip(&outputs.values) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name} = {value:?}");
    }
    Ok(text)
}
