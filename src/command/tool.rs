//! `robovec`: commands for equations and programs besides compiling them.

use super::arguments::normalise;
use super::bench::{self, BenchArguments};
use super::compare::{self, CheckArguments};
use super::error::{self, ErrorArguments};
use super::eval::{self, EvalArguments};
use super::explore::{self, ExploreArguments};
use super::fit::{self, FitArguments};
use super::flags::{real, whole};
use super::generation::{self, GenArguments};
use super::model::{self, ModelArguments};
use super::optimise::{self, OptimiseArguments};
use super::progress::{self, TellingArguments};
use super::sim::{self, SimCommand};
use super::{CommandFailure, flags, grammar, output};
use clap::{ArgMatches, Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::env::CompleteEnv;
use robovec_io::files::{Replace, set_force};
use robovec_io::process::{ProcessLimits, set_limits};
use robovec_io::sources::set_reading;
use robovec_model::robot::{RobotBase, RobotReading};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Optimises, checks, simulates and measures the equations of multibody
/// systems.
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
    /// Time limit for each compiler, simulator, yosys and compiled program, s
    #[arg(long, global = true, value_name = "SECONDS", default_value_t = 1800,
          add = whole(1, MAX_SECONDS, "a tool that takes longer than a day does not end"))]
    tool_seconds: u64,
}

// Reading of robots. No doc comment: it would become the commands' own.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robots (.urdf, .xml)")]
struct RobotArguments {
    /// Base of a robot: fixed, or moving freely by x, y, z, yaw, pitch and roll
    #[arg(long, global = true, value_name = "fixed|floating", value_enum,
          default_value_t = BaseChoice::Fixed, hide_possible_values = true)]
    base: BaseChoice,
    /// Angles of a robot within this distance of a right angle are taken as
    /// right angles, rad
    #[arg(long, global = true, value_name = "RADIANS", default_value_t = 0.0,
          add = real(0.0, 1e-3, "the robot would be a different one"))]
    right_angles: f64,
}

/// Commands that read no model.
const WITHOUT_MODELS: [&str; 4] = ["completion", "manual", "rules", "stress"];

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
    Bench(BenchArguments),
    /// Test whether two files compute the same functions
    Check(CheckArguments),
    /// Print the script that makes a shell complete command lines
    #[command(hide = true)]
    Completion(super::manual::CompletionArguments),
    Error(ErrorArguments),
    /// Evaluate functions at given or random states
    Eval(EvalArguments),
    Explore(Box<ExploreArguments>),
    Fit(FitArguments),
    Gen(GenArguments),
    /// Write manual pages of both programs
    #[command(hide = true)]
    Manual(super::manual::ManualArguments),
    /// Summarise a model, or write one of a family
    Model(ModelArguments),
    #[command(alias = "optimize")]
    Optimise(OptimiseArguments),
    Project(super::project::ProjectArguments),
    Rtl(super::rtl::RtlCommand),
    Rules(super::rules::RulesArguments),
    Sim(SimCommand),
    Stress(super::stress::StressArguments),
    View(super::view::ViewArguments),
}

/// The command line, with the limits of its numbers.
pub(crate) fn command() -> clap::Command {
    let tool = ToolArguments::command().mut_subcommands(|sub| {
        if WITHOUT_MODELS.contains(&sub.get_name()) {
            sub
        } else {
            RobotArguments::augment_args(sub)
        }
    });
    grammar::apply(flags::enforce(tool))
}

/// Runs the program.
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    CompleteEnv::with_factory(command).complete();
    let read = command().try_get_matches_from(normalise(arguments));
    let read = read.and_then(|matches| {
        let arguments = ToolArguments::from_arg_matches(&matches)?;
        Ok((matches, arguments))
    });
    let (matches, arguments) = match read {
        Ok(read) => read,
        Err(error) => grammar::former(error).exit(),
    };
    set_limits(ProcessLimits {
        time: Duration::from_secs(arguments.tool_seconds),
        ..ProcessLimits::USUAL
    });
    let robots = matches
        .subcommand()
        .filter(|(name, _)| !WITHOUT_MODELS.contains(name));
    if let Some((_, inner)) = robots {
        let robots = RobotArguments::from_arg_matches(inner).expect("added to these commands");
        set_reading(RobotReading {
            base: match robots.base {
                BaseChoice::Fixed => RobotBase::Fixed,
                BaseChoice::Floating => RobotBase::Floating,
            },
            right_angle: robots.right_angles,
        });
    }
    progress::set(arguments.telling);
    set_force(arguments.force);
    if let Err(failure) = refuse_foreign_outputs(&matches) {
        failure.emit();
        return ExitCode::FAILURE;
    }
    let start = Instant::now();
    let result = match &arguments.command {
        ToolCommand::Bench(arguments) => bench::run(arguments),
        ToolCommand::Check(arguments) => compare::run(arguments),
        ToolCommand::Completion(arguments) => super::manual::completion(arguments),
        ToolCommand::Error(arguments) => error::run(arguments),
        ToolCommand::Eval(arguments) => eval::run(arguments),
        ToolCommand::Explore(arguments) => explore::run(arguments),
        ToolCommand::Fit(arguments) => fit::run(arguments),
        ToolCommand::Gen(arguments) => generation::run(arguments),
        ToolCommand::Manual(arguments) => super::manual::manual(arguments),
        ToolCommand::Model(arguments) => model::run(arguments),
        ToolCommand::Optimise(arguments) => optimise::run(arguments),
        ToolCommand::Project(arguments) => super::project::run(arguments),
        ToolCommand::Rtl(arguments) => super::rtl::run(arguments),
        ToolCommand::Rules(arguments) => super::rules::run(arguments),
        ToolCommand::Sim(arguments) => sim::run(arguments),
        ToolCommand::Stress(arguments) => super::stress::run(arguments),
        ToolCommand::View(arguments) => super::view::run(arguments),
    };
    if progress::is_verbose() {
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
